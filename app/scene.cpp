// cxlab scene: what there was to see in the world of a recorded run.

#include <cstdio>
#include <memory>
#include <optional>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/base/json.h"
#include "lab/run.h"
#include "lab/scene_answer.h"
#include "scenarios/question.h"

namespace cxlab::app {

namespace {

struct SceneOptions {
  std::string run, what;
  std::optional<double> at;
  bool json = false;
};

int show(const SceneOptions& options) {
  const auto run = open_run(options.run);
  if (!run) return fail(run.error());
  auto found = run->scene(options.at ? std::optional(from_seconds(*options.at)) : std::nullopt);
  if (!found) return fail(lab::about_option(found.error(), "--at"));
  if (options.json) {
    const auto json = lab::scene_json(*std::move(found), options.what);
    if (!json) return fail(json.error());
    std::printf("%s\n", json_text(*json, 2).c_str());
    return 0;
  }
  const SimTime t = found->scene.t;
  const auto asked = lab::SceneAnswer::choose(std::move(found->scene), options.what);
  if (!asked) return fail(asked.error());
  std::printf("at %s%s:\n%s", time_text(t).c_str(), found->cut_off ? run->cut_off_text("scene").c_str() : "",
              asked->text("cxlab scene RUN", line_width()).c_str());
  return 0;
}

}  // namespace

void add_scene(CLI::App& app, Action& action) {
  auto options = std::make_shared<SceneOptions>();
  CLI::App* command = app.add_subcommand(
      "scene", "List the entities of a recorded run at a time: what stood, moved or was carried where, and its state");
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_option("what", options->what, "Only the entity of this name, or those of this kind (default: all)");
  time_option(command->add_option("--at", options->at, "Time: 312.4, 5:12 or 5:12.4 (default: the end of the run)"));
  command->add_flag("--json", options->json, "Prints the answer as JSON");
  command->footer(
      "Examples:\n  cxlab scene runs/game-1 --at 5:12\n  cxlab scene runs/game-1 piece --at 5:12\n"
      "  cxlab scene runs/game-1 robot2 --json");
  command->callback([options, &action] { action = [options] { return show(*options); }; });
}

}  // namespace cxlab::app
