#include "lab/manifest.h"

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "lab/json_fields.h"

namespace cxlab::lab {

std::vector<Shares> Manifest::shares() const {
  std::vector<Shares> all;
  for (const Agent& agent : agents) all.push_back(agent.packages);
  return all;
}

std::string Manifest::to_json() const {
  Manifest manifest = *this;
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
  return manifest;
}

}  // namespace cxlab::lab
