#include "lab/stories.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "cx/base/file.h"
#include "cx/base/json_text.h"
#include "cx/base/process.h"
#include "cx/base/scratch_folder.h"
#include "cx/testing/story.h"
#include "lab/page.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Expected<std::vector<fs::path>> find_files(const std::vector<std::string>& paths) {
  std::vector<fs::path> out;
  for (const std::string& path : paths) {
    std::error_code error;
    if (!fs::exists(path, error)) return input_error("there is no such file or folder", path);
    if (!is_folder(path)) {
      out.emplace_back(path);
      continue;
    }
    for (fs::recursive_directory_iterator it(path, error), end; !error && it != end; it.increment(error))
      if (!it->is_directory(error) && it->path().filename().string().ends_with(".story.yaml"))
        out.push_back(it->path().lexically_normal());
    if (error) return resource_error(error.message(), path);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  if (out.empty()) return input_error("there is no *.story.yaml in " + paths.front());
  return out;
}

void play(PlayedStory& story, const testing::StorySetup& setup) {
  const auto start = std::chrono::steady_clock::now();
  story.result = testing::run_story(story.spec, setup);
  story.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// From the process that played the story, as one line.
std::string to_line(std::size_t index, const PlayedStory& p) {
  json rules = json::array(), bad;
  for (const auto& r : p.result.rules) rules.push_back({r.file, r.rule, r.line, r.fired, r.activated});
  if (const auto& error = p.result.bad)
    bad = {{"kind", static_cast<int>(error->kind)},
           {"message", error->message},
           {"file", error->file},
           {"line", error->line}};
  const json line{{"story", index},
                  {"failures", p.result.failures},
                  {"notes", p.result.notes},
                  {"sim_time_s", p.result.sim_time_s},
                  {"wall_s", p.wall_s},
                  {"rules", rules},
                  {"bad", bad}};
  return json_text(line) + '\n';
}

void read_line(const json& line, PlayedStory& p) {
  p.result.failures = line["failures"].get<std::vector<std::string>>();
  p.result.notes = line["notes"].get<std::vector<std::string>>();
  p.result.sim_time_s = line["sim_time_s"];
  p.wall_s = line["wall_s"];
  for (const auto& r : line["rules"]) p.result.rules.push_back({r[0], r[1], r[2], r[3], r[4]});
  if (const auto& bad = line["bad"]; !bad.is_null())
    p.result.bad = Error{static_cast<ErrorKind>(bad["kind"].get<int>()), bad["message"], bad["file"], bad["line"], {}};
}

/// Every `jobs`-th story in a process of its own, whose results go through a file.
Status play_in_processes(std::vector<PlayedStory>& stories, const testing::StorySetup& setup, std::size_t jobs,
                         const Host& host) {
  auto scratch = ScratchFolder::create();
  if (!scratch) return scratch.error();
  std::vector<Process> workers;
  const auto results_of = [&](std::size_t job) { return (*scratch)->path() / std::to_string(job); };
  for (std::size_t job = 0; job < jobs; ++job) {
    auto worker = Process::fork({}, [&] {
      std::ofstream results(results_of(job), std::ios::binary);
      for (std::size_t i = job; i < stories.size(); i += jobs) {
        play(stories[i], setup);
        results << to_line(i, stories[i]) << std::flush;
      }
      return 0;
    });
    if (!worker) return worker.error();
    workers.push_back(*std::move(worker));
  }
  std::vector<bool> played(stories.size(), false);
  for (std::size_t job = 0; job < jobs; ++job) {
    while (!workers[job].wait_for(0.1))
      if (host.stopped()) return {};
    std::ifstream results(results_of(job));
    for (std::string text; std::getline(results, text);) {
      const json line = json::parse(text, nullptr, /*allow_exceptions=*/false);
      if (line.is_discarded()) continue;  // cut off
      const std::size_t i = line["story"];
      read_line(line, stories[i]);
      played[i] = true;
    }
  }
  for (std::size_t i = 0; i < stories.size(); ++i)
    if (!played[i])
      stories[i].result.failures.push_back(stories[i].spec.file +
                                           ": the process that played this story ended before it");
  return {};
}

/// XML has no way to write most control characters.
std::string for_xml(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') c = '?';
  return text;
}

}  // namespace

std::vector<std::string> PlayedStory::complaints() const {
  std::vector<std::string> out = result.failures;
  if (result.bad) out.insert(out.begin(), result.bad->text());
  return out;
}

Expected<std::vector<PlayedStory>> read_stories(const std::vector<std::string>& paths) {
  auto files = find_files(paths);
  if (!files) return files.error();
  std::vector<PlayedStory> out;
  for (const fs::path& file : *files) {
    auto specs = testing::read_stories(file);
    if (!specs) return specs.error();
    for (testing::StorySpec& spec : *specs) out.push_back({std::move(spec), {}, 0});
  }
  return out;
}

Status play_stories(std::vector<PlayedStory>& stories, const testing::StorySetup& setup, int jobs, const Host& host) {
  if (jobs > 1) return play_in_processes(stories, setup, static_cast<std::size_t>(jobs), host);
  for (PlayedStory& story : stories)
    if (!host.stopped()) play(story, setup);
  return {};
}

const char* CoveredRule::state() const {
  return fired > 0 ? "fired" : activated > 0 ? "activated but never fired" : "never matched";
}

Coverage coverage_of(const std::vector<PlayedStory>& stories) {
  Coverage files;
  for (const PlayedStory& p : stories)
    for (const auto& r : p.result.rules) {
      CoveredRule& covered = files[r.file][{r.line, r.rule}];
      covered.fired += r.fired;
      covered.activated += r.activated;
    }
  return files;
}

Expected<std::string> to_junit(const std::vector<PlayedStory>& stories) {
  nlohmann::json cases = nlohmann::json::array();
  int failures = 0, errors = 0;
  double total = 0;
  for (const PlayedStory& p : stories) {
    failures += !p.result.bad && !p.result.passed();
    errors += p.result.bad.has_value();
    total += p.wall_s;
    nlohmann::json messages = nlohmann::json::array();
    for (const std::string& c : p.complaints()) messages.push_back(for_xml(c));
    cases.push_back({{"file", for_xml(p.spec.file)},
                     {"name", for_xml(p.spec.name)},
                     {"wall_s", p.wall_s},
                     {"word", p.result.bad ? "error" : "failure"},
                     {"messages", messages}});
  }
  const nlohmann::json report = {{"stories", cases}, {"failures", failures}, {"errors", errors}, {"wall_s", total}};
  return render_page("junit.xml", json_text(report));
}

std::string to_json(const Coverage& coverage) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& [file, rules] : coverage)
    for (const auto& [rule, covered] : rules)
      rows.push_back({{"file", file},
                      {"line", rule.first},
                      {"rule", rule.second},
                      {"state", covered.state()},
                      {"fired", covered.fired},
                      {"activated", covered.activated}});
  return json_text(rows);
}

Expected<std::string> to_lcov(const Coverage& coverage) {
  return render_page("lcov.info", "{\"rules\": " + to_json(coverage) + '}');
}

}  // namespace cxlab::lab
