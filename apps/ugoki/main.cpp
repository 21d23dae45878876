// The program `ugoki`: each verb of the command line has a file of its own.

#include <new>

#include "output.h"
#include "verb.h"

int main(int argc, char** argv) {
  using namespace ugoki::cli;
  CLI::App app("Physically natural motion of people, animals and any other linked mechanism.", "ugoki");
  app.set_version_flag("--version", "ugoki 0.1.0");
  app.require_subcommand(1);
  app.footer("`ugoki VERB --help` describes a verb, with an example.");
  Action action;
  add_studio_verb(app, action);
  add_new_verb(app, action);
  add_import_verb(app, action);
  add_db_verb(app, action);
  add_info_verb(app, action);
  add_run_verb(app, action);
  add_judge_verb(app, action);
  add_lsi_verb(app, action);
  add_circuit_verb(app, action);
  add_mechanism_verb(app, action);
  add_convert_verb(app, action);
  add_motion_verb(app, action);
  add_retarget_verb(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return action ? action() : 2;
  } catch (const std::bad_alloc&) {
    return print_error({ugoki::ErrorCode::range, "ugoki", "Not enough memory.", "Process less data at once, or close other programs."},
                       false);
  }
}
