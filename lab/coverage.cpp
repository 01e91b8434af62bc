#include "lab/coverage.h"

#include <algorithm>
#include <set>
#include <vector>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "lab/page.h"
#include "lab/table_text.h"

namespace cxlab::lab {

namespace {

using explain::Coverage;

struct FileCoverage {
  std::vector<const Coverage::Rule*> rules;
  std::vector<const Coverage::Function*> functions;
};

std::map<std::string, FileCoverage> by_file(const Coverage& coverage) {
  std::map<std::string, FileCoverage> files;
  for (const Coverage::Rule& rule : coverage.rules) files[rule.file].rules.push_back(&rule);
  for (const Coverage::Function& function : coverage.functions) files[function.file].functions.push_back(&function);
  return files;
}

Json json_of_share(const Coverage::Share& share) {
  const auto percent = share.percent();
  return {{"covered", share.covered}, {"all", share.all}, {"percent", percent ? Json(*percent) : Json()}};
}

Json json_of_rule(const Coverage::Rule& rule) {
  Json conditions = Json::array();
  for (std::size_t i = 0; i < rule.conditions.size(); ++i) {
    const Coverage::Condition& condition = rule.conditions[i];
    conditions.push_back({{"condition", condition.number},
                          {"line", condition.line},
                          {"text", condition.text},
                          {"passed", rule.counts_conditions() ? Json(rule.passed(i)) : Json()}});
  }
  Json json{{"file", rule.file},   {"line", rule.line},           {"rule", rule.name},       {"state", rule.state()},
            {"fired", rule.fired}, {"activated", rule.activated}, {"conditions", conditions}};
  const std::size_t failed = rule.failed_at();
  json["failed_at"] = failed < rule.conditions.size() ? Json(failed) : Json();
  return json;
}

/// How often each line with a condition was passed: of several conditions that begin there the least.
std::map<int, std::int64_t> passed_lines(const FileCoverage& file) {
  std::map<int, std::int64_t> lines;
  for (const Coverage::Rule* rule : file.rules)
    for (std::size_t i = 0; rule->counts_conditions() && i < rule->conditions.size(); ++i) {
      const std::int64_t passed = rule->passed(i);
      const auto [line, fresh] = lines.emplace(rule->conditions[i].line, passed);
      if (!fresh) line->second = std::min(line->second, passed);
    }
  return lines;
}

// --- The page

/// Characters of a file that are shown in one way. Those of an inner part are within those of its rule.
struct Part {
  std::size_t begin = 0, end = 0;
  const char* kind = "";
  std::string title;
};

std::string times(std::int64_t n, const char* done) {
  return std::string(done) + ' ' + (n == 1 ? "once" : std::to_string(n) + " times");
}

/// Where `text` stands in a file that has it in that line.
std::size_t place_of(const std::string& source, const std::vector<std::size_t>& lines, int line,
                     const std::string& text) {
  if (line < 1 || static_cast<std::size_t>(line) > lines.size()) return source.npos;
  const std::size_t begin = lines[static_cast<std::size_t>(line) - 1];
  const std::size_t end =
      static_cast<std::size_t>(line) < lines.size() ? lines[static_cast<std::size_t>(line)] : source.size();
  const std::size_t found = source.find(text, begin);
  return found < end ? found : source.npos;
}

/// The name of a construct, the second word of its text.
Part name_part(const std::string& text, std::size_t at, const char* kind, std::string title) {
  const std::size_t begin = std::min(text.find_first_of(" \t\r\n"), text.size());
  const std::size_t name = std::min(text.find_first_not_of(" \t\r\n", begin), text.size());
  const std::size_t end = std::min(text.find_first_of(" \t\r\n\"()", name), text.size());
  return {at + name, at + end, kind, std::move(title)};
}

std::vector<Part> parts_of(const FileCoverage& file, const std::string& source, const std::vector<std::size_t>& lines) {
  std::vector<Part> parts;
  for (const Coverage::Rule* rule : file.rules) {
    const std::size_t at = place_of(source, lines, rule->line, rule->text);
    if (at == source.npos) continue;
    const char* kind = rule->fired > 0 ? "hit" : rule->activated > 0 ? "half" : "miss";
    parts.push_back(
        name_part(rule->text, at, kind,
                  rule->name + ": " + times(rule->activated, "activated") + ", " + times(rule->fired, "fired")));
    for (std::size_t i = 0; i < rule->conditions.size(); ++i) {
      const Coverage::Condition& condition = rule->conditions[i];
      const std::int64_t passed = rule->counts_conditions() ? rule->passed(i) : 0;
      parts.push_back({at + condition.begin, at + condition.end,
                       !rule->counts_conditions() ? ""
                       : passed > 0               ? "hit"
                                                  : "miss",
                       "condition " + std::to_string(condition.number) + " of " + rule->name + ": " +
                           (rule->counts_conditions() ? times(passed, "passed") : "not counted")});
    }
    const std::size_t arrow = rule->text.find("=>", rule->conditions.empty() ? 0 : rule->conditions.back().end);
    if (arrow != std::string::npos && rule->fired == 0)
      parts.push_back({at + arrow, at + rule->text.size(), kind, rule->name + " never fired"});
  }
  for (const Coverage::Function* function : file.functions)
    if (const std::size_t at = place_of(source, lines, function->line, function->text); at != source.npos)
      parts.push_back(name_part(function->text, at, function->calls > 0 ? "hit" : "miss",
                                function->name + ": " + times(function->calls, "called")));
  std::ranges::sort(parts, {}, &Part::begin);
  // If two parts overlap, the first one counts: a file may define a construct twice.
  std::size_t end = 0;
  std::erase_if(parts, [&](const Part& part) {
    const bool overlaps = part.begin < end || part.end > source.size();
    if (!overlaps) end = part.end;
    return overlaps;
  });
  return parts;
}

std::map<int, std::int64_t> numbers_of(const FileCoverage& file) {
  std::map<int, std::int64_t> numbers = passed_lines(file);
  for (const Coverage::Function* function : file.functions) numbers[function->line] = function->calls;
  for (const Coverage::Rule* rule : file.rules) numbers[rule->line] = rule->fired;
  return numbers;
}

Json lines_of(const FileCoverage& file, const std::string& source) {
  std::vector<std::size_t> begins{0};
  for (std::size_t i = 0; i < source.size(); ++i)
    if (source[i] == '\n' && i + 1 < source.size()) begins.push_back(i + 1);
  const std::vector<Part> parts = parts_of(file, source, begins);
  const std::map<int, std::int64_t> numbers = numbers_of(file);
  Json lines = Json::array();
  auto part = parts.begin();
  for (std::size_t n = 0; n < begins.size(); ++n) {
    std::size_t at = begins[n];
    std::size_t end = n + 1 < begins.size() ? begins[n + 1] : source.size();
    while (end > at && (source[end - 1] == '\n' || source[end - 1] == '\r')) --end;
    Json texts = Json::array();
    const auto add = [&](std::size_t to, const char* kind, const std::string& title) {
      to = std::min(to, end);
      if (to <= at) return;
      texts.push_back({{"text", source.substr(at, to - at)}, {"kind", kind}, {"title", title}});
      at = to;
    };
    while (part != parts.end() && part->begin < end) {
      add(part->begin, "", "");
      add(part->end, part->kind, part->title);
      if (part->end > end) break;
      ++part;
    }
    add(end, "", "");
    Json line{{"number", n + 1}, {"parts", std::move(texts)}};
    if (const auto number = numbers.find(static_cast<int>(n) + 1); number != numbers.end())
      line["count"] = number->second;
    lines.push_back(std::move(line));
  }
  return lines;
}

Json gaps_of(const FileCoverage& file) {
  Json gaps = Json::array();
  const auto add = [&](int line, const std::string& name, const char* kind, const std::string& text) {
    gaps.push_back({{"line", line}, {"name", name}, {"kind", kind}, {"text", text}});
  };
  for (const Coverage::Rule* rule : file.rules) {
    const std::size_t failed = rule->failed_at();
    if (failed < rule->conditions.size())
      add(rule->line, rule->name, "miss",
          "never matched: nothing got past condition " + std::to_string(rule->conditions[failed].number) + ", " +
              rule->conditions[failed].text);
    else if (rule->fired == 0)
      add(rule->line, rule->name, rule->activated > 0 ? "half" : "miss", rule->state());
    for (std::size_t i = 0; rule->activated > 0 && rule->counts_conditions() && i < rule->conditions.size(); ++i)
      if (rule->passed(i) == 0)
        add(rule->conditions[i].line, rule->name, "miss",
            "nothing got past condition " + std::to_string(rule->conditions[i].number) + ", " +
                rule->conditions[i].text);
  }
  for (const Coverage::Function* function : file.functions)
    if (function->calls == 0) add(function->line, function->name, "miss", "never called");
  return gaps;
}

Coverage coverage_of_file(const FileCoverage& file) {
  Coverage coverage;
  for (const Coverage::Rule* rule : file.rules) coverage.rules.push_back(*rule);
  for (const Coverage::Function* function : file.functions) coverage.functions.push_back(*function);
  return coverage;
}

Json totals_of(const Coverage& coverage) {
  return {{"rules", json_of_share(coverage.fired())},
          {"conditions", json_of_share(coverage.conditions())},
          {"functions", json_of_share(coverage.called())}};
}

}  // namespace

void read_sources(const Coverage& coverage, Sources& sources) {
  for (const auto& [name, file] : by_file(coverage)) {
    if (sources.contains(name) || !std::filesystem::path(name).is_absolute()) continue;
    if (auto text = read_file(name)) sources.emplace(name, *std::move(text));
  }
}

std::vector<std::string> notes_on_places(const Coverage& coverage, const Sources& sources, const Places& places) {
  constexpr std::size_t kNamed = 3;
  std::vector<std::string> lost, changed, notes;
  for (const auto& [name, file] : by_file(coverage)) {
    const auto place = places.find(name);
    const auto then = sources.find(name);
    if (place == places.end()) {
      if (!std::filesystem::path(name).is_absolute()) lost.push_back(name);
    } else if (const auto now = read_file(place->second); now && then != sources.end() && *now != then->second) {
      changed.push_back(place->second);
    }
  }
  if (!lost.empty())
    notes.push_back("the lcov counts name " + count_text(lost.size(), "file") +
                    " that genhtml will not find: " + some_of(lost, kNamed) +
                    "; bring the package back to the folder that the run had, or use --html, which shows the copies of "
                    "the run");
  if (!changed.empty())
    notes.push_back("the lcov counts are of lines as the run read them, but " + count_text(changed.size(), "file") +
                    (changed.size() == 1 ? " has" : " have") + " changed since then: " + some_of(changed, kNamed) +
                    "; --html shows the copies of the run");
  return notes;
}

Json json_of(const Coverage& coverage) {
  Json rules = Json::array(), functions = Json::array();
  for (const Coverage::Rule& rule : coverage.rules) rules.push_back(json_of_rule(rule));
  for (const Coverage::Function& function : coverage.functions)
    functions.push_back(
        {{"file", function.file}, {"line", function.line}, {"function", function.name}, {"calls", function.calls}});
  return {{"rules", std::move(rules)}, {"functions", std::move(functions)}, {"totals", totals_of(coverage)}};
}

std::string to_lcov(const Coverage& coverage, const Places& places) {
  std::string out;
  for (const auto& [name, file] : by_file(coverage)) {
    struct Called {
      int line = 0;
      std::string name;
      std::int64_t calls = 0;
    };
    std::vector<Called> called;
    std::map<std::string, int> uses;
    for (const Coverage::Rule* rule : file.rules) called.push_back({rule->line, rule->name, rule->fired});
    for (const Coverage::Function* function : file.functions)
      called.push_back({function->line, function->name, function->calls});
    std::ranges::stable_sort(called, {}, &Called::line);
    for (const Called& one : called) ++uses[one.name];
    std::set<std::string> names;  // each must be another
    for (Called& one : called) {
      if (uses[one.name] > 1) one.name += ':' + std::to_string(one.line);
      while (!names.insert(one.name).second) one.name += '\'';
    }

    std::map<int, std::int64_t> lines = passed_lines(file);
    std::set<int> of_rules;
    for (const Coverage::Rule* rule : file.rules) {
      std::int64_t& hits = lines[rule->line];
      hits = (of_rules.insert(rule->line).second ? 0 : hits) + rule->activated;
    }
    for (const Coverage::Function* function : file.functions)
      if (!of_rules.contains(function->line)) lines[function->line] = 0;
    for (const Coverage::Function* function : file.functions) lines[function->line] += function->calls;

    const auto place = places.find(name);
    out += "TN:\nSF:" + (place == places.end() ? name : place->second) + '\n';
    for (const Called& one : called) out += "FN:" + std::to_string(one.line) + ',' + one.name + '\n';
    for (const Called& one : called) out += "FNDA:" + std::to_string(one.calls) + ',' + one.name + '\n';
    const auto hit = std::ranges::count_if(called, [](const Called& one) { return one.calls > 0; });
    out += "FNF:" + std::to_string(called.size()) + "\nFNH:" + std::to_string(hit) + '\n';

    std::map<int, int> blocks;
    std::size_t taken = 0;
    for (const Coverage::Rule* rule : file.rules) {
      const std::string block = std::to_string(rule->line) + ',' + std::to_string(blocks[rule->line]++);
      const bool matched = rule->activated > 0;
      out += "BRDA:" + block + ",0," + (matched ? std::to_string(rule->activated) : "-") + '\n';
      out += "BRDA:" + block + ",1," + (matched ? std::to_string(rule->fired) : "-") + '\n';
      taken += (rule->activated > 0 ? 1u : 0u) + (rule->fired > 0 ? 1u : 0u);
    }
    out += "BRF:" + std::to_string(2 * file.rules.size()) + "\nBRH:" + std::to_string(taken) + '\n';

    for (const auto& [line, hits] : lines) out += "DA:" + std::to_string(line) + ',' + std::to_string(hits) + '\n';
    const auto lines_hit = std::ranges::count_if(lines, [](const auto& line) { return line.second > 0; });
    out += "LF:" + std::to_string(lines.size()) + "\nLH:" + std::to_string(lines_hit) + "\nend_of_record\n";
  }
  return out;
}

Expected<std::string> to_page(const Coverage& coverage, const Sources& sources, const std::string& title) {
  Json files = Json::array();
  for (const auto& [name, file] : by_file(coverage)) {
    Json json{{"name", name}, {"totals", totals_of(coverage_of_file(file))}, {"gaps", gaps_of(file)}};
    const auto source = sources.find(name);
    json["lines"] = source == sources.end() ? Json::array() : lines_of(file, source->second);
    files.push_back(std::move(json));
  }
  return render_page("coverage.html",
                     json_text(Json{{"title", title}, {"totals", totals_of(coverage)}, {"files", std::move(files)}}));
}

Status write_reports(const Coverage& coverage, const CoverageOptions& options, Sources sources, const Places& places,
                     const std::string& title) {
  if (!options.lcov.empty())
    if (Status s = write_output(options.lcov, to_lcov(coverage, places)); !s) return s;
  if (options.page.empty()) return {};
  read_sources(coverage, sources);
  const auto page = to_page(coverage, sources, title);
  return page ? write_output(options.page, *page) : page.error();
}

Status check_share(const Coverage& coverage, const CoverageOptions& options) {
  if (!options.fail_under) return {};
  const Coverage::Share fired = coverage.fired();
  const auto percent = fired.percent();
  if (!percent) return negative("--fail-under: no rule was read, so there is no percentage of rules that fired");
  if (*percent >= *options.fail_under) return {};
  return negative(std::to_string(fired.covered) + " of " + std::to_string(fired.all) + " rules fired, " +
                  fixed_text(*percent, 1) + " %; --fail-under expects at least " +
                  general_text(*options.fail_under, 6) + " %");
}

}  // namespace cxlab::lab
