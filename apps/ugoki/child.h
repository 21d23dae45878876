#pragma once
// Programs that `ugoki export` calls: browser, ffmpeg, Blender.

#include <sys/types.h>

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::cli {

/// The first of these programs on $PATH, or the given path.
[[nodiscard]] Result<std::string> find_program(const std::string& given, std::initializer_list<const char*> names, const char* remedy);

/// A child process, optionally with a pipe to its standard input. Ended by the destructor.
class Child {
 public:
  /// @param log file for the output of the program
  [[nodiscard]] static Result<std::unique_ptr<Child>> start(const std::vector<std::string>& words, bool pipe_input, const std::string& log);
  Child() = default;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  /// Writes all bytes. @return false if the program does not read any more
  [[nodiscard]] bool write(std::string_view bytes) const;
  void close_input();
  [[nodiscard]] bool ended();
  /// Waits for the end. @return whether the program reported success
  [[nodiscard]] bool wait();
  /// Exit status of the program; -1: it still runs, or was ended by a signal.
  [[nodiscard]] int status() const { return status_; }

 private:
  pid_t pid_ = -1;
  int input_ = -1;
  int status_ = -1;
};

/// A temporary folder that is removed with all its files.
struct Scratch {
  std::filesystem::path folder;
  Scratch() = default;
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch();
};
/// Makes a temporary folder. @param prefix begins its name
[[nodiscard]] Result<std::unique_ptr<Scratch>> make_scratch(const char* prefix);

/// The last 400 bytes of a log as a sentence that begins with a blank; empty if there are none.
[[nodiscard]] std::string tail_of(const std::filesystem::path& log);

}  // namespace ugoki::cli
