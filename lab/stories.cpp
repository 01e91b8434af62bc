#include "lab/stories.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <list>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/process.h"
#include "cx/base/servant.h"
#include "cx/testing/story.h"
#include "lab/page.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

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

/// From the process that played the story.
std::string to_line(const PlayedStory& p) {
  Json rules = Json::array(), bad;
  for (const auto& r : p.result.rules) rules.push_back({r.file, r.rule, r.line, r.fired, r.activated});
  if (const auto& error = p.result.bad)
    bad = {{"kind", static_cast<int>(error->kind)},
           {"message", error->message},
           {"file", error->file},
           {"line", error->line}};
  const Json line{{"failures", p.result.failures},
                  {"notes", p.result.notes},
                  {"sim_time_s", p.result.sim_time_s},
                  {"wall_s", p.wall_s},
                  {"rules", rules},
                  {"bad", bad}};
  return json_text(line);
}

/// Whether the text is the whole result of the story.
bool read_line(const std::string& text, PlayedStory& p) {
  try {
    const Json line = parse_json(text);
    testing::StoryResult result;
    result.failures = line.at("failures").get<std::vector<std::string>>();
    result.notes = line.at("notes").get<std::vector<std::string>>();
    result.sim_time_s = line.at("sim_time_s").get<double>();
    for (const auto& r : line.at("rules")) result.rules.push_back({r.at(0), r.at(1), r.at(2), r.at(3), r.at(4)});
    if (const auto& bad = line.at("bad"); !bad.is_null())
      result.bad = Error{
          static_cast<ErrorKind>(bad.at("kind").get<int>()), bad.at("message"), bad.at("file"), bad.at("line"), {}};
    p.wall_s = line.at("wall_s").get<double>();
    p.result = std::move(result);
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

/// A process that plays one story, and its end of a pipe with what it has said so far.
struct Player {
  std::size_t story;
  Descriptor results;
  Process process;
  std::string said = {};
};

Expected<Player> start_player(std::size_t index, PlayedStory& story, const testing::StorySetup& setup) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return resource_error(std::string("cannot make a pipe: ") + std::strerror(errno));
  Descriptor from(ends[0]), to(ends[1]);
  auto process = Process::fork({}, [&] {
    play(story, setup);
    const std::string line = to_line(story);
    for (std::size_t done = 0; done < line.size();) {
      const ssize_t n = write(to.number(), line.data() + done, line.size() - done);
      if (n < 0 && errno != EINTR) return static_cast<int>(ErrorKind::kResource);
      if (n > 0) done += static_cast<std::size_t>(n);
    }
    return 0;
  });
  if (!process) return process.error();
  return Player{index, std::move(from), *std::move(process)};
}

/// Takes what is there; false once the process has closed its end, as it does when it ends.
bool hear(Player& player) {
  char bytes[1 << 14];
  const ssize_t n = read(player.results.number(), bytes, sizeof bytes);
  if (n > 0) player.said.append(bytes, static_cast<std::size_t>(n));
  return n > 0 || (n < 0 && errno == EINTR);
}

void take_result(Player& player, PlayedStory& story) {
  const int code = player.process.wait();
  if (code == 0 && read_line(player.said, story)) return;
  const std::string how =
      code > 128 ? "a signal (" + std::to_string(code - 128) + ")" : "exit code " + std::to_string(code);
  story.result = {};
  story.result.failures.push_back(story.spec.file + ':' + std::to_string(story.spec.line) +
                                  ": the process that played this story ended with " + how +
                                  " before the story did; the other stories were played");
}

/// Each story in a process of its own, so that one that brings the process down fails alone, and reaches nothing but
/// its own files.
Status play_in_processes(std::vector<PlayedStory>& stories, const testing::StorySetup& setup, std::size_t jobs,
                         const Host& host) {
  std::list<Player> players;
  for (std::size_t next = 0; next < stories.size() || !players.empty();) {
    if (host.stopped()) return {};
    while (next < stories.size() && players.size() < jobs) {
      auto player = start_player(next, stories[next], setup);
      if (!player) return player.error();
      players.push_back(*std::move(player));
      ++next;
    }
    std::vector<pollfd> ends;
    for (const Player& player : players) ends.push_back({player.results.number(), POLLIN, 0});
    constexpr int kLookAtHost = 100;  // ms
    if (poll(ends.data(), ends.size(), kLookAtHost) <= 0) continue;
    auto end = ends.begin();
    for (auto player = players.begin(); player != players.end();) {
      const bool ready = (end++)->revents != 0;
      if (!ready || hear(*player)) {
        ++player;
        continue;
      }
      take_result(*player, stories[player->story]);
      player = players.erase(player);
    }
  }
  return {};
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
  testing::StorySetup confined = setup;
  if (kPlaysBehindWalls) confined.confine = [](const Wall& wall) { (void)raise_wall(wall); };
  return play_in_processes(stories, confined, static_cast<std::size_t>(std::max(jobs, 1)), host);
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
  Json cases = Json::array();
  int failures = 0, errors = 0;
  double total = 0;
  for (const PlayedStory& p : stories) {
    failures += !p.result.bad && !p.result.passed();
    errors += p.result.bad.has_value();
    total += p.wall_s;
    Json messages = Json::array();
    for (const std::string& c : p.complaints()) messages.push_back(for_xml(c));
    cases.push_back({{"file", for_xml(p.spec.file)},
                     {"name", for_xml(p.spec.name)},
                     {"wall_s", p.wall_s},
                     {"word", p.result.bad ? "error" : "failure"},
                     {"messages", messages}});
  }
  const Json report = {{"stories", cases}, {"failures", failures}, {"errors", errors}, {"wall_s", total}};
  return render_page("junit.xml", json_text(report));
}

std::string to_json(const Coverage& coverage) {
  Json rows = Json::array();
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
