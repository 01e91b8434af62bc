#include "lab/stories.h"

#include <algorithm>
#include <set>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "lab/golden.h"
#include "lab/page.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

/// By file the names of stories that are asked for; none: all.
using Places = std::map<fs::path, std::set<std::string>>;

Expected<Places> find_files(const std::vector<std::string>& paths) {
  Places out;
  std::set<fs::path> whole;
  for (const std::string& path : paths) {
    const std::size_t colons = path.find("::");
    if (colons != std::string::npos && !path_exists(path) && is_file(path.substr(0, colons))) {
      out[path.substr(0, colons)].insert(path.substr(colons + 2));
      continue;
    }
    if (!path_exists(path)) return input_error("there is no such file or folder", path);
    if (!is_folder(path)) {
      whole.emplace(path);
      continue;
    }
    std::error_code error;
    for (fs::recursive_directory_iterator it(path, error), end; !error && it != end; it.increment(error)) {
      const std::string name = it->path().filename().string();
      if (it->is_directory(error)) {
        if (name.starts_with('.')) it.disable_recursion_pending();
      } else if (name.ends_with(kStoryEnding)) {
        whole.insert(it->path().lexically_normal());
      }
    }
    if (error) return resource_error(error.message(), path);
  }
  for (const fs::path& file : whole) out[file].clear();
  if (out.empty()) return input_error("there is no *.story.yaml in " + paths.front());
  return out;
}

std::vector<std::string> names_of(const std::vector<testing::StorySpec>& specs) {
  std::vector<std::string> names;
  for (const testing::StorySpec& spec : specs) names.push_back(spec.name);
  return names;
}

/// XML has no way to write most control characters, nor U+FFFE and U+FFFF.
std::string for_xml(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') c = '?';
  for (const std::string_view no_character : {"\xef\xbf\xbe", "\xef\xbf\xbf"})
    for (std::size_t at = text.find(no_character); at != std::string::npos; at = text.find(no_character, at))
      text.replace(at, no_character.size(), "?");
  return text;
}

}  // namespace

std::vector<std::string> PlayedStory::complaints() const {
  std::vector<std::string> out = result.failures;
  if (result.bad) out.insert(out.begin(), result.bad->text());
  if (!passed() && seeds_played > 1)
    out.push_back("seed " + std::to_string(seed) + " is the smallest of " + std::to_string(failed_seeds.size()) +
                  " that fail, of " + std::to_string(seeds_played));
  return out;
}

Expected<std::vector<fs::path>> story_files(const std::vector<std::string>& paths) {
  const auto places = find_files(paths);
  if (!places) return places.error();
  std::vector<fs::path> out;
  for (const auto& [file, names] : *places) out.push_back(file);
  return out;
}

Expected<std::vector<PlayedStory>> read_stories(const std::vector<std::string>& paths) {
  auto places = find_files(paths);
  if (!places) return places.error();
  std::vector<PlayedStory> out;
  for (const auto& [file, names] : *places) {
    std::vector<Error> further;
    auto specs = testing::read_stories(file, &further);
    if (!specs) {
      PlayedStory& bad = out.emplace_back();
      bad.unreadable = true;
      bad.spec.file = file.string();
      bad.spec.name = file.filename().string();
      bad.result.bad = specs.error();
      if (file.string().ends_with(kStoryEnding))
        for (const Error& error : further) bad.result.failures.push_back(error.text());
      else
        bad.result.bad->message = "this is no story file, whose name ends with .story.yaml: " + specs.error().message;
      continue;
    }
    for (const std::string& name : names)
      if (std::ranges::count(*specs, name, &testing::StorySpec::name) == 0)
        return usage_error("there is no story '" + name + '\'' + did_you_mean(name, names_of(*specs)), file.string());
    for (testing::StorySpec& spec : *specs)
      if (names.empty() || names.contains(spec.name)) out.push_back({std::move(spec)});
  }
  return out;
}

void accept_golden_runs(std::vector<PlayedStory>& stories, const Host& host) {
  std::set<std::filesystem::path> accepted;  // several stories may play one run
  for (PlayedStory& story : stories) {
    if (!story.result.differs) continue;
    if (accepted.insert(story.spec.golden).second)
      if (Status s = accept_golden(story.spec, host); !s) {
        accepted.erase(story.spec.golden);
        story.result.failures.push_back(s.error().text());
        continue;
      }
    story.accepted = true;
  }
}

explain::Coverage coverage_of(const std::vector<PlayedStory>& stories) {
  explain::Coverage all;
  for (const PlayedStory& story : stories) all.add(story.result.coverage);
  return all;
}

std::vector<std::string> notes_on_coverage(const std::vector<PlayedStory>& stories) {
  std::vector<std::string> out;
  for (const PlayedStory& p : stories)
    if (p.untold > 0)
      out.push_back(p.spec.file + ": " + p.spec.name + ": what its rules did is not counted" +
                    (p.seeds_played > 1
                         ? " for " + std::to_string(p.untold) + " of " + std::to_string(p.seeds_played) + " seeds"
                         : "") +
                    (p.late ? ", because it took longer than --patience" : ", because its process was ended"));
  return out;
}

Expected<std::string> to_junit(const std::vector<PlayedStory>& stories, bool printed) {
  Json cases = Json::array();
  int failures = 0, errors = 0;
  double total = 0;
  for (const PlayedStory& p : stories) {
    if (!p.played) continue;
    failures += !p.result.bad && !p.passed();
    errors += p.result.bad.has_value();
    total += p.wall_s;
    Json messages = Json::array();
    if (!p.accepted)
      for (const std::string& c : p.complaints()) messages.push_back(for_xml(c));
    std::string output;
    if (printed)
      for (const std::string& line : p.result.printed) output += for_xml(line) + '\n';
    cases.push_back({{"file", for_xml(p.spec.file)},
                     {"name", for_xml(p.spec.name)},
                     {"wall_s", p.wall_s},
                     {"word", p.result.bad ? "error" : "failure"},
                     {"messages", messages},
                     {"printed", output}});
  }
  const Json report = {{"stories", cases}, {"failures", failures}, {"errors", errors}, {"wall_s", total}};
  return render_page("junit.xml", json_text(report));
}

}  // namespace cxlab::lab
