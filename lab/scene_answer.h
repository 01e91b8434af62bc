#pragma once
// What people and programs read of a scene: `cxlab scene`, and `scene` of `cxlab attach`.

#include <cstddef>
#include <string>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "lab/run.h"
#include "lab/table_text.h"
#include "scenarios/scene.h"

namespace cxlab::lab {

/// The entities of a scene that somebody asks for.
class SceneAnswer {
 public:
  /// `what`: the name of an entity, a kind of entities, or nothing for all. A name that the scene does not know is a
  /// usage error with the nearest one.
  static Expected<SceneAnswer> choose(Scene scene, const std::string& what);

  /// A table. Where all were asked for, those without a state are only counted; `command` is how to ask for more.
  std::string text(const std::string& command, std::size_t width = kTableWidth) const;
  /// A list with an object for each entity, with its pose in the world and as its carrier sees it.
  Json json() const;

 private:
  SceneAnswer(Scene all, bool all_wanted) : all_(std::move(all)), all_wanted_(all_wanted) {}
  Table table() const;

  Scene all_, chosen_;
  bool all_wanted_;
};

/// What `scene` of `cxlab attach` says.
Expected<std::string> scene_text(Run::SceneAt seen, const std::string& what);
/// What `cxlab scene --json` says.
Expected<Json> scene_json(Run::SceneAt seen, const std::string& what);

}  // namespace cxlab::lab
