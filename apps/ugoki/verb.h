#pragma once
// Verbs of the command line. add_NAME_verb() declares a verb with its options; parsing the verb sets the action to run.
// The parser is CLI11. Its headers add 4 to 8 s to the compilation of a source, so only verb.cpp and main.cpp include them: the verbs use these handles.

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace ugoki::cli {

/// Action of the program, run after its arguments were parsed. @return exit status: 0 success, 1 failure
using Action = std::function<int()>;

/// Check of an option's value.
class Check {
 public:
  /// @param refuse gives the message for a bad value, and "" for a good one  @param type shown in the help, for example "*.fbx"
  explicit Check(std::function<std::string(const std::string&)> refuse, const std::string& type = "");
  explicit Check(const CLI::Validator& validator);
  [[nodiscard]] const CLI::Validator& validator() const { return *validator_; }

 private:
  std::shared_ptr<const CLI::Validator> validator_;
};

/// The value is a number from `min` to `max`.
[[nodiscard]] Check range(double min, double max);
[[nodiscard]] Check range(int min, int max);
/// As range(), but the message shows small limits, such as 1e-09, instead of 0.000000.
[[nodiscard]] Check number_from(double min, double max);
[[nodiscard]] Check not_negative();
[[nodiscard]] Check one_of(std::initializer_list<const char*> words);
[[nodiscard]] Check one_of(std::initializer_list<int> numbers);

/// Handle of an option. Its functions return the handle, so that calls can be chained.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option required() const;
  Option check(const Check& check) const;
  /// Shows the value of the variable as the default.
  Option capture_default_str() const;
  /// Character that separates the values of one argument.
  Option delimiter(char c) const;
  /// Number of values; `max` < 0: any number.
  Option expected(int count) const;
  Option expected(int min, int max) const;
  /// Heading of the help; "" hides the option.
  Option group(const std::string& name) const;
  Option type_name(const std::string& name) const;
  Option needs(Option other) const;
  Option excludes(Option other) const;
  /// True if the command line contains the option. Known when the verb's callback runs.
  [[nodiscard]] bool given() const;

 private:
  CLI::Option* option_;
};

/// Handle of a verb, or of the program.
class Verb {
 public:
  explicit Verb(CLI::App& app) : app_(&app) {}
  /// Declares an option that sets `value`: std::string, a number, or several of these (the types are listed in verb.cpp). @param names
  /// "-o,--out", or "name" of a positional argument
  template <typename T>
  Option add_option(const std::string& names, T& value, const std::string& help) const;
  /// Declares an option whose value only its check uses.
  Option add_option(const std::string& names, const std::string& help) const;
  Option add_flag(const std::string& names, bool& value, const std::string& help) const;
  [[nodiscard]] Verb add_subcommand(const std::string& name, const std::string& help) const;
  void require_subcommand(int count) const;
  /// Text at the end of the help.
  void footer(const std::string& text) const;
  /// Heading of the help of the verb's parent; "" hides the verb.
  Verb group(const std::string& name) const;
  /// True if the command line contains a verb of this verb. Known when its callback runs.
  [[nodiscard]] bool has_parsed_verb() const;
  /// Function that runs when the verb was parsed. It can call refuse().
  void callback(std::function<void()> function) const;

 private:
  CLI::App* app_;
};

/// Ends the parsing with an error: the name of the option or verb, and why it is refused.
[[noreturn]] void refuse(const std::string& name, const std::string& why);

void add_new_verb(Verb app, Action& action);
void add_import_verb(Verb app, Action& action);
void add_db_verb(Verb app, Action& action);
void add_info_verb(Verb app, Action& action);
void add_run_verb(Verb app, Action& action);
void add_export_verb(Verb app, Action& action);
void add_bake_verb(Verb app, Action& action);
void add_judge_verb(Verb app, Action& action);
void add_correct_verb(Verb app, Action& action);
void add_gait_verb(Verb app, Action& action);
void add_lsi_verb(Verb app, Action& action);
void add_circuit_verb(Verb app, Action& action);
void add_mechanism_verb(Verb app, Action& action);
void add_convert_verb(Verb app, Action& action);
void add_motion_verb(Verb app, Action& action);
void add_retarget_verb(Verb app, Action& action);
/// `studio`, and the hidden verb `interpret`, which the studio starts as a child process to run content.
void add_studio_verb(Verb app, Action& action);

}  // namespace ugoki::cli
