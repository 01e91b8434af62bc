#include "lab/scene_answer.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "cx/base/number_text.h"
#include "scenarios/question.h"

namespace cxlab::lab {

namespace {

Json list_of(const sim::Vec3& vector) { return {vector.x(), vector.y(), vector.z()}; }

Json json_of(const Entity& entity, const Scene& scene) {
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

}  // namespace

Expected<SceneAnswer> SceneAnswer::choose(Scene scene, const std::string& what) {
  SceneAnswer answer(std::move(scene), what.empty());
  answer.chosen_.t = answer.all_.t;
  std::vector<std::string> words;
  for (const Entity& entity : answer.all_.entities) {
    if (what.empty() || entity.name == what || entity.kind == what) answer.chosen_.entities.push_back(entity);
    for (const std::string& word : {entity.name, entity.kind})
      if (std::ranges::find(words, word) == words.end()) words.push_back(word);
  }
  if (!what.empty() && answer.chosen_.entities.empty())
    return usage_error("there is no entity, and no kind of entities, called '" + what + "' at " +
                       time_text(answer.all_.t) + did_you_mean(what, words));
  return answer;
}

Table SceneAnswer::table() const {
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
  for (const Entity& entity : chosen_.entities) {
    if (entity.state.empty() && all_wanted_) continue;
    const sim::Pose3 pose = all_.in_world(entity);
    const auto number = [](double value) {
      TableCell cell(value);
      cell.shown = fixed_text(value == 0 ? 0 : value, 3);  // no -0
      return cell;
    };
    const Entity* carrier = entity.carried_by ? all_.find(*entity.carried_by) : nullptr;
    std::string carried = carrier ? carrier->name : "";
    if (!entity.place.empty()) (carried += carried.empty() ? "" : " ") += "(" + entity.place + ")";
    table.rows.push_back({entity.kind, entity.name, number(pose.position.x()), number(pose.position.y()),
                          number(pose.position.z()), number(pose.yaw()), TableCell(std::move(carried)), entity.state});
  }
  return table;
}

std::string SceneAnswer::text(const std::string& command, std::size_t width) const {
  const Table shown = table();
  std::string out = table_text(shown, width);
  const std::size_t left_out = chosen_.entities.size() - shown.rows.size();
  if (left_out == 0) return out;
  std::vector<std::string> kinds;
  for (const Entity& entity : chosen_.entities)
    if (entity.state.empty() && std::ranges::find(kinds, entity.kind) == kinds.end()) kinds.push_back(entity.kind);
  return out + '\n' + std::to_string(left_out) + " more without a state: " + command + " KIND lists them (" +
         some_of(kinds) + ")\n";
}

Expected<Json> scene_json(Run::SceneAt seen, const std::string& what) {
  Json json{{"at_s", to_seconds(seen.scene.t)}};
  if (seen.cut_off) json["cut_off"] = true;
  const auto asked = SceneAnswer::choose(std::move(seen.scene), what);
  if (!asked) return asked.error();
  json["entities"] = asked->json();
  return json;
}

Expected<std::string> scene_text(Run::SceneAt seen, const std::string& what) {
  const std::string at = "at " + time_text(seen.scene.t) + (seen.cut_off ? ", where the scene is cut off" : "");
  const auto asked = SceneAnswer::choose(std::move(seen.scene), what);
  if (!asked) return asked.error();
  return at + ":\n" + asked->text("scene");
}

Json SceneAnswer::json() const {
  Json list = Json::array();
  for (const Entity& entity : chosen_.entities) list.push_back(json_of(entity, all_));
  return list;
}

}  // namespace cxlab::lab
