#pragma once
// Verbs of the command line. add_NAME_verb() declares a verb with its options; parsing the verb sets the action to run.

#include <CLI/CLI.hpp>
#include <functional>

namespace ugoki::cli {

/// Action of the program, run after its arguments were parsed. @return exit status: 0 success, 1 failure
using Action = std::function<int()>;

/// Check of an option's number. Unlike CLI::Range, its message shows small limits, such as 1e-09, instead of 0.000000.
[[nodiscard]] CLI::Validator number_from(double min, double max);

void add_new_verb(CLI::App& app, Action& action);
void add_import_verb(CLI::App& app, Action& action);
void add_db_verb(CLI::App& app, Action& action);
void add_info_verb(CLI::App& app, Action& action);
void add_run_verb(CLI::App& app, Action& action);
void add_export_verb(CLI::App& app, Action& action);
void add_bake_verb(CLI::App& app, Action& action);
void add_judge_verb(CLI::App& app, Action& action);
void add_correct_verb(CLI::App& app, Action& action);
void add_gait_verb(CLI::App& app, Action& action);
void add_lsi_verb(CLI::App& app, Action& action);
void add_circuit_verb(CLI::App& app, Action& action);
void add_mechanism_verb(CLI::App& app, Action& action);
void add_convert_verb(CLI::App& app, Action& action);
void add_motion_verb(CLI::App& app, Action& action);
void add_retarget_verb(CLI::App& app, Action& action);
/// `studio`, and the hidden verb `interpret`, which the studio starts as a child process to run content.
void add_studio_verb(CLI::App& app, Action& action);

}  // namespace ugoki::cli
