#include "lab/failed_stories.h"

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/journal/run_folder.h"
#include "lab/state_folder.h"
#include "lab/stories.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

namespace {

fs::path memory_file() {
  const fs::path folder = state_folder();
  return folder.empty() ? folder : folder / "failed_stories.json";
}

std::pair<std::string, std::string> key_of(const PlayedStory& story) {
  return {fs::absolute(story.spec.file).lexically_normal().string(), story.spec.name};
}

}  // namespace

FailedStories FailedStories::remembered() {
  FailedStories out;
  const fs::path file = memory_file();
  if (file.empty() || !is_file(file)) return out;
  auto text = read_file(file);
  if (!text) return out;
  try {
    const Json json = parse_json(*text);
    for (const Json& story : json.at("failed")) out.failed_.emplace(story.at("file"), story.at("story"));
    out.text_ = *std::move(text);
  } catch (const Json::exception&) {
    out.failed_.clear();
  }
  return out;
}

bool FailedStories::has(const PlayedStory& story) const { return failed_.contains(key_of(story)); }

void FailedStories::note(const std::vector<PlayedStory>& played) {
  std::erase_if(failed_, [](const auto& story) { return !is_file(story.first); });
  for (const PlayedStory& story : played)
    if (story.played) failed_.erase(key_of(story));
  for (const PlayedStory& story : played)  // of several of one name it is enough that one failed
    if (story.played && !story.passed() && !story.unreadable) failed_.insert(key_of(story));
}

Status FailedStories::save() const {
  Json list = Json::array();
  for (const auto& [file, story] : failed_) list.push_back({{"file", file}, {"story", story}});
  const std::string text = json_text(Json{{"failed", list}}, 1) + '\n';
  const fs::path file = memory_file();
  if (file.empty() || text == text_ || (list.empty() && text_.empty())) return {};
  if (Status s = make_folder(file.parent_path()); !s) return s;
  return replace_file(file, text);
}

}  // namespace cxlab::lab
