#pragma once
// Child processes of `ugoki export`: browser, ffmpeg and Blender.

#include <sys/types.h>

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::cli {

/// Returns the given path, or if it is empty, the path of the first of the named programs that is found on $PATH.
[[nodiscard]] Result<std::string> find_program(const std::string& given, std::initializer_list<const char*> names, const char* remedy);

/// A child process, optionally with a pipe to its standard input. The destructor ends the process.
class Child {
 public:
  /// @param words path of the program and its arguments @param log file to which the output of the program is appended
  /// @param variables names and values of environment variables, added to those of this program
  [[nodiscard]] static Result<std::unique_ptr<Child>> start(const std::vector<std::string>& words, bool pipe_input, const std::string& log,
                                                            const std::vector<std::pair<const char*, std::string>>& variables = {});
  Child() = default;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  /// Writes all bytes to the program's standard input. @return false if the program no longer reads
  [[nodiscard]] bool write(std::string_view bytes) const;
  void close_input();
  [[nodiscard]] bool ended();
  /// Closes the pipe and waits until the program ends or the user presses Ctrl+C. @return true if the program ended with status 0
  [[nodiscard]] bool wait();
  /// Exit status of the program; -1 while the program runs, and if a signal ended it.
  [[nodiscard]] int status() const { return status_; }

 private:
  pid_t pid_ = -1;
  int input_ = -1;
  int status_ = -1;
};

/// Returns the last 400 bytes of a log as a sentence that can be appended to an error message; empty if the log is empty.
[[nodiscard]] std::string tail_of(const std::filesystem::path& log);

}  // namespace ugoki::cli
