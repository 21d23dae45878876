// The program `ugoki`: each verb of the command line has a file of its own.

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include "output.h"
#include "ugoki/base/printable.h"
#include "verb.h"

namespace {

/// Exit status of the program after an action: 1, with an error message, if the output could not be written.
int finish(int status) {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  const std::string why = errno != 0 ? std::string(" (") + std::strerror(errno) + ")" : std::string();
  return ugoki::cli::print_error({ugoki::ErrorCode::io, "standard output", "The output could not be written" + why + ".",
                                  "Check the disk and the limit of the file size (`ulimit -f`), then run the command again."},
                                 false);
}

/// Checks that no option with a number was given as NaN: comparisons with the limits of an option's range do not exclude NaN.
void refuse_nan(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_type_name().find("FLOAT") == std::string::npos) continue;
    for (const std::string& value : option->results())
      if (std::isnan(std::strtod(value.c_str(), nullptr)))
        throw CLI::ValidationError(option->get_name(), "Value " + value + " is not a number");
  }
  for (const CLI::App* verb : app.get_subcommands()) refuse_nan(*verb);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace ugoki::cli;
  std::signal(SIGXFSZ, SIG_IGN);  // a file above the size limit is then reported as the error EFBIG
  CLI::App app("Physically natural motion of people, animals and any other linked mechanism.", "ugoki");
  app.set_version_flag("--version", "ugoki 0.1.0");
  app.require_subcommand(1);
  app.footer("`ugoki VERB --help` describes a verb, with an example.");
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return ugoki::printable(error.what()) + "\nRun with --help for more information.\n";
  });
  const Verb program(app);
  Action action;
  add_studio_verb(program, action);
  add_new_verb(program, action);
  add_import_verb(program, action);
  add_db_verb(program, action);
  add_info_verb(program, action);
  add_run_verb(program, action);
  add_export_verb(program, action);
  add_bake_verb(program, action);
  add_judge_verb(program, action);
  add_correct_verb(program, action);
  add_gait_verb(program, action);
  add_lsi_verb(program, action);
  add_circuit_verb(program, action);
  add_mechanism_verb(program, action);
  add_convert_verb(program, action);
  add_motion_verb(program, action);
  add_retarget_verb(program, action);
  try {
    app.parse(argc, argv);
    refuse_nan(app);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? finish(0) : 2;
  }
  try {
    return action ? finish(action()) : 2;
  } catch (const std::bad_alloc&) {
    return print_error({ugoki::ErrorCode::range, "ugoki", "Not enough memory.", "Process less data at once, or close other programs."},
                       false);
  }
}
