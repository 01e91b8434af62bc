#include "lab/manifest.h"

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "lab/file_names.h"
#include "lab/json_fields.h"

namespace cxlab::lab {

std::vector<Shares> Manifest::shares() const {
  std::vector<Shares> all;
  for (const Agent& agent : agents) all.push_back(agent.packages);
  return all;
}

namespace {

namespace fs = std::filesystem;

/// Calls `change` with each name of a file that is named from the scenario's folder.
template <class Change>
void for_each_name(Manifest& manifest, Change change) {
  for (std::string& prefix : manifest.spec.prefixes) change(prefix);
  for (Manifest::Agent& agent : manifest.agents)
    for (auto& [package, share] : agent.packages) change(share);
  for (auto& [key, file] : manifest.world_files) change(file);
  if (const auto file = manifest.bag.find("file"); file != manifest.bag.end()) change(file->second);
}

/// The absolute name of what is called so from the folder.
std::string absolute_name(const fs::path& folder, const std::string& name) {
  const fs::path path = (folder / name).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).string();
}

/// An absolute name becomes one from the folder, where that gives the same again.
void shorten(const fs::path& folder, std::string& name) {
  if (!folder.is_absolute() || !fs::path(name).is_absolute()) return;
  const std::string from_there = name_from(folder, name);
  if (absolute_name(folder, from_there) == name) name = from_there;
}

void lengthen(const fs::path& folder, std::string& name) {
  if (folder.is_absolute() && !name.empty() && fs::path(name).is_relative()) name = absolute_name(folder, name);
}

}  // namespace

std::string Manifest::to_json() const {
  Manifest manifest = *this;
  lengthen(out, manifest.folder);
  const fs::path home = manifest.scenario_file().parent_path();
  for_each_name(manifest, [&](std::string& name) { shorten(home, name); });
  shorten(manifest.folder, manifest.scenario);
  shorten(out, manifest.folder);
  return json_text(JsonWriter::json(manifest), 2) + '\n';
}

Expected<Manifest> Manifest::read(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "manifest.json";
  Manifest manifest;
  if (auto json = read_json(file); !json)
    return json.error();
  else if (Status s = read_fields(*json, manifest); !s)
    return input_error("not the manifest of a run: " + s.error().message, file.string());
  name_copies(manifest.spec.what_if);
  lengthen(manifest.out, manifest.folder);
  const fs::path home = manifest.scenario_file().parent_path();
  for_each_name(manifest, [&](std::string& name) { lengthen(home, name); });
  return manifest;
}

}  // namespace cxlab::lab
