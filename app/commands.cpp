#include "app/command.h"
#include "app/exit_codes.h"
#include "app/program.h"

namespace cxlab::app {

namespace {

Status add_commands(CLI::App& app, Action& action) {
  app.footer(exit_codes_line());
  add_run(app, action);
  add_attach(app, action);
  add_ask(app, action);
  add_view(app, action);
  add_replay(app, action);
  add_rerun(app, action);
  add_env(app, action);
  add_render(app, action);
  add_facts(app, action);
  add_agenda(app, action);
  add_globals(app, action);
  add_firings(app, action);
  add_why(app, action);
  add_why_not(app, action);
  add_rules(app, action);
  add_scene(app, action);
  add_diff(app, action);
  add_check(app, action);
  add_coverage(app, action);
  add_profile(app, action);
  add_export(app, action);
  add_validate(app, action);
  add_list(app, action);
  add_doc(app, action);
  add_test(app, action);
  add_mutate(app, action);
  add_bench(app, action);
  add_plan(app, action);
  add_new(app, action);
  add_doctor(app, action);
  add_help(app, action);
  add_completion(app, action);
  add_man(app, action);
  return add_world_questions(app, action);
}

}  // namespace

int run_program(int argc, char** argv, const Catalogue& catalogue) {
  return run_commands(argc, argv, catalogue, add_commands);
}

}  // namespace cxlab::app
