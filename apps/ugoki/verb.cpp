#include "verb.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "ugoki/base/number.h"

namespace ugoki::cli {

Check::Check(std::function<std::string(const std::string&)> refuse, const std::string& type)
    : Check(CLI::Validator([refuse = std::move(refuse)](std::string& text) { return refuse(text); }, type)) {}
Check::Check(const CLI::Validator& validator) : validator_(std::make_shared<CLI::Validator>(validator)) {}

Check range(double min, double max) { return Check(CLI::Range(min, max)); }
Check range(int min, int max) { return Check(CLI::Range(min, max)); }
Check number_from(double min, double max) {
  const std::string limits = to_text(min) + " to " + to_text(max);
  return Check(
      [=](const std::string& text) {
        const std::optional<double> x = parse_double(text);
        return x && *x >= min && *x <= max ? std::string() : "Value " + text + " is not a number from " + limits;
      },
      "from " + limits);
}
Check not_negative() { return Check(CLI::NonNegativeNumber); }
Check one_of(std::initializer_list<const char*> words) {
  return Check(CLI::IsMember(std::vector<std::string>(words.begin(), words.end())));
}
Check one_of(std::initializer_list<int> numbers) { return Check(CLI::IsMember(numbers)); }

Option Option::required() const { return Option(option_->required()); }
Option Option::check(const Check& check) const { return Option(option_->check(check.validator())); }
Option Option::capture_default_str() const { return Option(option_->capture_default_str()); }
Option Option::delimiter(char c) const { return Option(option_->delimiter(c)); }
Option Option::expected(int count) const { return Option(option_->expected(count)); }
Option Option::expected(int min, int max) const { return Option(option_->expected(min, max)); }
Option Option::group(const std::string& name) const { return Option(option_->group(name)); }
Option Option::type_name(const std::string& name) const { return Option(option_->type_name(name)); }
Option Option::needs(Option other) const { return Option(option_->needs(other.option_)); }
Option Option::excludes(Option other) const { return Option(option_->excludes(other.option_)); }
bool Option::given() const { return option_->count() > 0; }

template <typename T>
Option Verb::add_option(const std::string& names, T& value, const std::string& help) const {
  return Option(app_->add_option(names, value, help));
}
// Types of the variables that options set.
using Triple = std::array<double, 3>;
using Points = std::vector<std::pair<double, double>>;
template Option Verb::add_option(const std::string&, double&, const std::string&) const;
template Option Verb::add_option(const std::string&, int&, const std::string&) const;
template Option Verb::add_option(const std::string&, std::uint16_t&, const std::string&) const;
template Option Verb::add_option(const std::string&, std::size_t&, const std::string&) const;
template Option Verb::add_option(const std::string&, std::string&, const std::string&) const;
template Option Verb::add_option(const std::string&, Triple&, const std::string&) const;
template Option Verb::add_option(const std::string&, std::vector<double>&, const std::string&) const;
template Option Verb::add_option(const std::string&, std::vector<int>&, const std::string&) const;
template Option Verb::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Option Verb::add_option(const std::string&, Points&, const std::string&) const;

Option Verb::add_option(const std::string& names, const std::string& help) const { return Option(app_->add_option(names, help)); }
Option Verb::add_flag(const std::string& names, bool& value, const std::string& help) const {
  return Option(app_->add_flag(names, value, help));
}
Verb Verb::add_subcommand(const std::string& name, const std::string& help) const { return Verb(*app_->add_subcommand(name, help)); }
void Verb::require_subcommand(int count) const { app_->require_subcommand(count); }
void Verb::footer(const std::string& text) const { app_->footer(text); }
Verb Verb::group(const std::string& name) const { return Verb(*app_->group(name)); }
bool Verb::has_parsed_verb() const { return !app_->get_subcommands().empty(); }
void Verb::callback(std::function<void()> function) const { app_->callback(std::move(function)); }

void refuse(const std::string& name, const std::string& why) { throw CLI::ValidationError(name, why); }

}  // namespace ugoki::cli
