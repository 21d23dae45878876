#pragma once
// A verb of the command line: adds its options and, when it was given, what is to be done.

#include <CLI/CLI.hpp>
#include <functional>

namespace ugoki::cli {

/// What the program does after its arguments were understood. @return exit status: 0 done, 1 failed
using Action = std::function<int()>;

void add_new_verb(CLI::App& app, Action& action);
void add_import_verb(CLI::App& app, Action& action);
void add_db_verb(CLI::App& app, Action& action);
void add_info_verb(CLI::App& app, Action& action);
void add_run_verb(CLI::App& app, Action& action);
void add_judge_verb(CLI::App& app, Action& action);
void add_lsi_verb(CLI::App& app, Action& action);
void add_circuit_verb(CLI::App& app, Action& action);
void add_mechanism_verb(CLI::App& app, Action& action);
void add_convert_verb(CLI::App& app, Action& action);
void add_motion_verb(CLI::App& app, Action& action);
void add_retarget_verb(CLI::App& app, Action& action);
/// `studio`, and the hidden `interpret` that the studio starts for itself.
void add_studio_verb(CLI::App& app, Action& action);

}  // namespace ugoki::cli
