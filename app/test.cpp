// cxlab test: plays stories, regression tests of rules.

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "app/arguments.h"
#include "app/command.h"
#include "app/markup.h"
#include "cx/testing/story_file.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;
using testing::StoryResult;
using testing::StorySpec;

struct TestOptions {
  std::vector<std::string> paths;
  std::string junit, coverage;
  lab::PackageOptions packages;
  int jobs = 1;
  bool json = false;
};

/// One story and how it went.
struct Played {
  StorySpec spec;
  StoryResult result;
  double wall_s = 0;
};

Expected<std::vector<fs::path>> find_files(const std::vector<std::string>& paths) {
  std::vector<fs::path> out;
  for (const std::string& path : paths) {
    std::error_code error;
    if (!fs::exists(path, error)) return input_error("there is no such file or folder", path);
    if (!fs::is_directory(path)) {
      out.emplace_back(path);
      continue;
    }
    for (fs::recursive_directory_iterator it(path, error), end; !error && it != end; it.increment(error))
      if (it->is_regular_file() && it->path().filename().string().ends_with(".story.yaml"))
        out.push_back(it->path().lexically_normal());
    if (error) return resource_error(error.message(), path);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  if (out.empty()) return input_error("there is no *.story.yaml in " + paths.front());
  return out;
}

void play(Played& played, const testing::StorySetup& setup) {
  const auto start = std::chrono::steady_clock::now();
  played.result = testing::run_story(played.spec, setup);
  played.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

nlohmann::json to_json(const Played& p) {
  nlohmann::json rules = nlohmann::json::array();
  for (const auto& r : p.result.rules) rules.push_back({r.file, r.rule, r.line, r.fired, r.activated});
  nlohmann::json bad;
  if (p.result.bad)
    bad = {{"kind", static_cast<int>(p.result.bad->kind)},
           {"message", p.result.bad->message},
           {"file", p.result.bad->file},
           {"line", p.result.bad->line}};
  return {{"failures", p.result.failures},
          {"notes", p.result.notes},
          {"sim_time_s", p.result.sim_time_s},
          {"wall_s", p.wall_s},
          {"rules", rules},
          {"bad", bad}};
}

void from_json(const nlohmann::json& j, Played& p) {
  p.result.failures = j["failures"].get<std::vector<std::string>>();
  p.result.notes = j["notes"].get<std::vector<std::string>>();
  p.result.sim_time_s = j["sim_time_s"];
  p.wall_s = j["wall_s"];
  for (const auto& r : j["rules"]) p.result.rules.push_back({r[0], r[1], r[2], r[3], r[4]});
  if (const auto& bad = j["bad"]; !bad.is_null())
    p.result.bad = Error{static_cast<ErrorKind>(bad["kind"].get<int>()), bad["message"], bad["file"], bad["line"], {}};
}

/// Every `jobs`-th story in a process of its own; each story's result is one line of JSON on a pipe.
Status play_in_processes(std::vector<Played>& stories, const testing::StorySetup& setup, int jobs) {
  struct Worker {
    pid_t pid;
    std::FILE* results;
  };
  std::vector<Worker> workers;
  for (int job = 0; job < jobs; ++job) {
    int ends[2];
    if (pipe(ends) != 0) return resource_error("cannot make a pipe");
    std::fflush(nullptr);
    const pid_t pid = fork();
    if (pid < 0) return resource_error("cannot start a process");
    if (pid == 0) {
      close(ends[0]);
      std::FILE* out = fdopen(ends[1], "w");
      for (std::size_t i = static_cast<std::size_t>(job); i < stories.size(); i += static_cast<std::size_t>(jobs)) {
        play(stories[i], setup);
        const std::string line = to_json(stories[i]).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
        std::fprintf(out, "%zu %s\n", i, line.c_str());
        std::fflush(out);
      }
      std::_Exit(0);
    }
    close(ends[1]);
    workers.push_back({pid, fdopen(ends[0], "r")});
  }
  std::vector<bool> told(stories.size(), false);
  for (const Worker& worker : workers) {
    char* line = nullptr;
    std::size_t size = 0;
    while (getline(&line, &size, worker.results) > 0) {
      char* rest = nullptr;
      const std::size_t i = std::strtoul(line, &rest, 10);
      from_json(nlohmann::json::parse(rest), stories[i]);
      told[i] = true;
    }
    std::free(line);
    std::fclose(worker.results);
    waitpid(worker.pid, nullptr, 0);
  }
  for (std::size_t i = 0; i < stories.size(); ++i)
    if (!told[i])
      stories[i].result.failures.push_back(stories[i].spec.file +
                                           ": the process that played this story ended before it");
  return {};
}

/// XML has no way to write most control characters.
std::string xml(const std::string& text) {
  std::string out = escape(text);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') c = '?';
  return out;
}

std::vector<std::string> complaints(const Played& p) {
  std::vector<std::string> out = p.result.failures;
  if (p.result.bad) out.insert(out.begin(), p.result.bad->text());
  return out;
}

std::string to_junit(const std::vector<Played>& stories) {
  std::string cases;
  int failures = 0, errors = 0;
  double total = 0;
  char time[32];
  for (const Played& p : stories) {
    failures += !p.result.bad && !p.result.passed();
    errors += p.result.bad.has_value();
    total += p.wall_s;
    std::snprintf(time, sizeof time, "%.3f", p.wall_s);
    cases +=
        "  <testcase classname=\"" + xml(p.spec.file) + "\" name=\"" + xml(p.spec.name) + "\" time=\"" + time + "\">";
    const char* word = p.result.bad ? "error" : "failure";
    for (const std::string& c : complaints(p)) cases += std::string("\n    <") + word + " message=\"" + xml(c) + "\"/>";
    cases += "</testcase>\n";
  }
  std::snprintf(time, sizeof time, "%.3f", total);
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"cxlab\" tests=\"" +
         std::to_string(stories.size()) + "\" failures=\"" + std::to_string(failures) + "\" errors=\"" +
         std::to_string(errors) + "\" time=\"" + time + "\">\n" + cases + "</testsuite>\n";
}

/// What became of a rule in all stories.
struct Covered {
  long fired = 0, activated = 0;
  const char* state() const {
    return fired > 0 ? "fired" : activated > 0 ? "activated but never fired" : "never matched";
  }
};
/// By file, then by line and name.
using Coverage = std::map<std::string, std::map<std::pair<int, std::string>, Covered>>;

Coverage coverage_of(const std::vector<Played>& stories) {
  Coverage files;
  for (const Played& p : stories)
    for (const auto& r : p.result.rules) {
      Covered& covered = files[r.file][{r.line, r.rule}];
      covered.fired += r.fired;
      covered.activated += r.activated;
    }
  return files;
}

/// Rules as functions of lcov; its branches say whether each was activated and whether it fired.
std::string to_lcov(const Coverage& files) {
  std::string out;
  for (const auto& [file, rules] : files) {
    out += "TN:\nSF:" + file + '\n';
    std::size_t hit = 0, branches = 0;
    for (const auto& [rule, covered] : rules) out += "FN:" + std::to_string(rule.first) + ',' + rule.second + '\n';
    for (const auto& [rule, covered] : rules) {
      out += "FNDA:" + std::to_string(covered.fired) + ',' + rule.second + '\n';
      hit += covered.fired > 0;
    }
    out += "FNF:" + std::to_string(rules.size()) + "\nFNH:" + std::to_string(hit) + '\n';
    for (const auto& [rule, covered] : rules) {
      out += "BRDA:" + std::to_string(rule.first) + ",0,0," + std::to_string(covered.activated) + '\n';
      out += "BRDA:" + std::to_string(rule.first) + ",0,1," + std::to_string(covered.fired) + '\n';
      branches += (covered.activated > 0) + (covered.fired > 0);
    }
    out += "BRF:" + std::to_string(2 * rules.size()) + "\nBRH:" + std::to_string(branches) + '\n';
    for (const auto& [rule, covered] : rules)
      out += "DA:" + std::to_string(rule.first) + ',' + std::to_string(covered.fired) + '\n';
    out += "LF:" + std::to_string(rules.size()) + "\nLH:" + std::to_string(hit) + "\nend_of_record\n";
  }
  return out;
}

void print(const Coverage& files) {
  std::map<std::string, int> counts;
  for (const auto& [file, rules] : files)
    for (const auto& [rule, covered] : rules) {
      ++counts[covered.state()];
      if (covered.fired == 0)
        std::printf("%s:%d: %s: %s\n", file.c_str(), rule.first, rule.second.c_str(), covered.state());
    }
  std::printf("rules: %d fired, %d activated but never fired, %d never matched\n", counts["fired"],
              counts["activated but never fired"], counts["never matched"]);
}

nlohmann::json to_json(const Coverage& files) {
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& [file, rules] : files)
    for (const auto& [rule, covered] : rules)
      rows.push_back({{"file", file},
                      {"line", rule.first},
                      {"rule", rule.second},
                      {"state", covered.state()},
                      {"fired", covered.fired},
                      {"activated", covered.activated}});
  return rows;
}

Status write(const std::string& file, const std::string& text) {
  if (file.empty()) return {};
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) return resource_error("cannot write this file", file);
  return {};
}

void print(const Played& p) {
  std::printf("%s  %s: %s (%.0f ms, %.6g s simulated)\n", p.result.passed() ? "ok    " : "FAILED", p.spec.file.c_str(),
              p.spec.name.c_str(), p.wall_s * 1e3, p.result.sim_time_s);
  for (const std::string& c : complaints(p)) std::printf("  %s\n", c.c_str());
  for (const std::string& note : p.result.notes) std::printf("  note: %s\n", note.c_str());
}

int test(const TestOptions& options) {
  auto files = find_files(options.paths.empty() ? std::vector<std::string>{"."} : options.paths);
  if (!files) return fail(files.error());
  std::vector<Played> stories;
  for (const fs::path& file : *files) {
    auto specs = testing::read_stories(file);
    if (!specs) return fail(specs.error());
    for (StorySpec& spec : *specs) stories.push_back({std::move(spec), {}, 0});
  }
  auto packages = lab::find_packages(options.packages);
  if (!packages) return fail(packages.error());
  const testing::StorySetup setup{find_share().interfaces, !options.coverage.empty(), *std::move(packages)};
  if (options.jobs > 1) {
    if (Status s = play_in_processes(stories, setup, options.jobs); !s) return fail(s.error());
  } else {
    for (Played& story : stories) play(story, setup);
  }
  std::size_t passed = 0;
  bool bad = false;
  nlohmann::json rows = nlohmann::json::array();
  for (const Played& p : stories) {
    passed += p.result.passed();
    bad |= p.result.bad.has_value();
    if (!options.json) print(p);
    rows.push_back({{"file", p.spec.file},
                    {"story", p.spec.name},
                    {"passed", p.result.passed()},
                    {"failures", complaints(p)},
                    {"notes", p.result.notes},
                    {"wall_s", p.wall_s},
                    {"sim_time_s", p.result.sim_time_s}});
  }
  const Coverage coverage = coverage_of(stories);
  nlohmann::json report{{"passed", passed}, {"failed", stories.size() - passed}, {"stories", rows}};
  if (setup.coverage) report["rules"] = to_json(coverage);
  if (setup.coverage && !options.json) print(coverage);
  if (options.json)
    std::printf("%s\n", report.dump(2).c_str());
  else
    std::printf("%zu passed, %zu failed\n", passed, stories.size() - passed);
  if (Status s = write(options.junit, to_junit(stories)); !s) return fail(s.error());
  if (Status s = write(options.coverage, to_lcov(coverage)); !s) return fail(s.error());
  if (bad) return static_cast<int>(ErrorKind::kInput);
  return passed == stories.size() ? 0 : static_cast<int>(ErrorKind::kNo);
}

}  // namespace

void add_test(CLI::App& app, Action& action) {
  auto options = std::make_shared<TestOptions>();
  CLI::App* command = app.add_subcommand("test", "Plays stories: regression tests of rules (docs/testing.md)");
  command->footer("Example:\n  cxlab test scenarios/rcll/agent/stories --junit report.xml");
  command->add_option("paths", options->paths, "Story files, or folders with *.story.yaml (default: this folder)");
  add_package_options(*command, options->packages);
  command->add_option("--junit", options->junit, "Writes a JUnit report");
  command->add_option("--coverage", options->coverage,
                      "Says which rules fired, were only activated, or never matched; writes the counts as lcov");
  command->add_option("-j", options->jobs, "Processes")->check(CLI::Range(1, 256));
  command->add_flag("--json", options->json, "Prints JSON");
  command->callback([options, &action] { action = [options] { return test(*options); }; });
}

}  // namespace cxlab::app
