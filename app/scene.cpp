// cxlab scene: what there was to see in the world of a recorded run.

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "app/arguments.h"
#include "app/command.h"
#include "app/table.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "lab/run.h"
#include "scenarios/scene_log.h"

namespace cxlab::app {

namespace {

struct SceneOptions {
  std::string run, what;
  std::optional<double> at;
  bool json = false;
};

Json list_of(const sim::Vec3& vector) { return {vector.x(), vector.y(), vector.z()}; }

Json json_of_entity(const Entity& entity, const Scene& scene) {
  const sim::Pose3 pose = scene.in_world(entity);
  Json look = Json::array();
  if (const auto solids = solids_of(entity.look))
    for (const Solid& solid : *solids) {
      const std::string text = look_of({&solid, 1});
      look.push_back({{"shape", text.substr(0, text.find(' '))},
                      {"size", solid.size},
                      {"at", solid.at},
                      {"colour", text.substr(text.find('#'), 7)},
                      {"blinks", solid.blinks}});
    }
  return {
      {"id", entity.id},
      {"kind", entity.kind},
      {"name", entity.name},
      {"state", entity.state},
      {"x", pose.position.x()},
      {"y", pose.position.y()},
      {"z", pose.position.z()},
      {"yaw", pose.yaw()},
      {"rotation", list_of(pose.rotation)},
      {"carried_by", entity.carried_by ? Json(*entity.carried_by) : Json()},
      {"place", entity.place},
      {"seen_from_carrier", {{"position", list_of(entity.pose.position)}, {"rotation", list_of(entity.pose.rotation)}}},
      {"look", std::move(look)}};
}

/// The one of that name, or all of that kind; without a word all.
Expected<Scene> chosen(const Scene& scene, const std::string& what) {
  if (what.empty()) return scene;
  Scene out{scene.t, {}};
  std::vector<std::string> words;
  for (const Entity& entity : scene.entities) {
    if (entity.name == what || entity.kind == what) out.entities.push_back(entity);
    for (const std::string& word : {entity.name, entity.kind})
      if (std::ranges::find(words, word) == words.end()) words.push_back(word);
  }
  if (!out.entities.empty()) return out;
  return usage_error("there is no entity, and no kind of entities, called '" + what + "' at " + time_text(scene.t) +
                     did_you_mean(what, words));
}

Table table_of(const Scene& all, const Scene& chosen, bool without_state) {
  using Kind = Column::Kind;
  Table table{"entities",
              "",
              {{"kind", "kind"},
               {"name", "name"},
               {"x", "x (m)", Kind::kNumber},
               {"y", "y (m)", Kind::kNumber},
               {"z", "z (m)", Kind::kNumber},
               {"yaw", "yaw (rad)", Kind::kNumber},
               {"carried_by", "carried by"},
               {"state", "state"}},
              {}};
  for (const Entity& entity : chosen.entities) {
    if (entity.state.empty() && !without_state) continue;
    const sim::Pose3 pose = all.in_world(entity);
    const auto number = [](double value) {
      TableCell cell(value);
      cell.shown = fixed_text(value == 0 ? 0 : value, 3);  // no -0
      return cell;
    };
    const Entity* carrier = entity.carried_by ? all.find(*entity.carried_by) : nullptr;
    std::string carried = carrier ? carrier->name : "";
    if (!entity.place.empty()) (carried += carried.empty() ? "" : " ") += "(" + entity.place + ")";
    table.rows.push_back({entity.kind, entity.name, number(pose.position.x()), number(pose.position.y()),
                          number(pose.position.z()), number(pose.yaw()), TableCell(std::move(carried)), entity.state});
  }
  return table;
}

int show(const SceneOptions& options) {
  const auto run = lab::Run::open(options.run, catalogue());
  if (!run) return fail(run.error());
  auto scenes = run->scenes();
  if (!scenes) return fail(scenes.error());
  const SimTime end = run->finished ? std::max(run->sim_time, scenes->end()) : scenes->end();
  const SimTime at = options.at ? from_seconds(*options.at) : end;
  if (run->finished && at > end)
    return fail(usage_error("--at: the run ended at " + general_text(to_seconds(end), 9) + " s"));
  const bool cut_off = at > scenes->end() || (!run->finished && at == end);
  if (run->finished && cut_off && !scenes->status()) return fail(scenes->status().error());
  const SimTime t = std::min(at, scenes->end());
  const auto scene = scenes->at(t);
  if (!scene) return fail(scene.error());
  const auto asked = chosen(*scene, options.what);
  if (!asked) return fail(asked.error());
  if (options.json) {
    Json json{{"at_s", to_seconds(t)}};
    if (cut_off) json["cut_off"] = true;
    json["entities"] = Json::array();
    for (const Entity& entity : asked->entities) json["entities"].push_back(json_of_entity(entity, *scene));
    std::printf("%s\n", json_text(json, 2).c_str());
    return 0;
  }
  const Table table = table_of(*scene, *asked, !options.what.empty());
  std::printf("at %s%s:\n%s", time_text(t).c_str(), cut_off ? ", where the scene of the run is cut off" : "",
              table_text(table).c_str());
  std::vector<std::string> kinds;
  for (const Entity& entity : asked->entities)
    if (entity.state.empty() && std::ranges::find(kinds, entity.kind) == kinds.end()) kinds.push_back(entity.kind);
  if (const std::size_t left_out = asked->entities.size() - table.rows.size(); left_out > 0)
    std::printf("\n%zu more without a state: cxlab scene RUN KIND lists them (%s)\n", left_out,
                some_of(kinds, kinds.size()).c_str());
  return 0;
}

}  // namespace

void add_scene(CLI::App& app, Action& action) {
  auto options = std::make_shared<SceneOptions>();
  CLI::App* command = app.add_subcommand(
      "scene", "Lists what there was to see in a recorded run: what stood, moved or was carried where, and its state");
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_option("what", options->what, "Only the entity of this name, or those of this kind (default: all)");
  time_option(command->add_option("--at", options->at, "When: 312.4, 5:12 or 5:12.4 (default: the end of the run)"));
  command->add_flag("--json", options->json, "The answer as JSON");
  command->footer(
      "Examples:\n  cxlab scene runs/game-1 --at 5:12\n  cxlab scene runs/game-1 piece --at 5:12\n"
      "  cxlab scene runs/game-1 robot2 --json");
  command->callback([options, &action] { action = [options] { return show(*options); }; });
}

}  // namespace cxlab::app
