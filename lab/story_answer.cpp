#include "lab/story_answer.h"

#include <unistd.h>

#include <optional>
#include <set>

#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "lab/json_fields.h"

namespace cxlab::lab {

namespace {

/// The result that the text is, if it is a whole one.
std::optional<testing::StoryResult> read_story_answer(const std::string& text) {
  try {
    const Json line = parse_json(text);
    testing::StoryResult result;
    result.failures = line.at("failures").get<std::vector<std::string>>();
    result.notes = line.at("notes").get<std::vector<std::string>>();
    result.sim_time_s = line.at("sim_time_s").get<double>();
    if (!read_fields(line.at("coverage"), result.coverage)) return std::nullopt;
    if (const auto& bad = line.at("bad"); !bad.is_null())
      result.bad = Error{
          static_cast<ErrorKind>(bad.at("kind").get<int>()), bad.at("message"), bad.at("file"), bad.at("line"), {}};
    result.differs = line.at("differs").get<bool>();
    result.printed = line.at("printed").get<std::vector<std::string>>();
    result.files = line.at("files").get<std::vector<std::string>>();
    return result;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

/// The result for a process that ended without an answer: only its story fails.
testing::StoryResult answer_left_unsaid(const testing::StorySpec& spec, const StoryEnd& end) {
  testing::StoryResult result;
  const std::string how =
      end.code > 128 ? "a signal (" + std::to_string(end.code - 128) + ")" : "exit code " + std::to_string(end.code);
  result.failures.push_back(spec.file + ':' + std::to_string(spec.line) +
                            (end.late ? ": the story has not ended after " + general_text(end.patience_s, 6) +
                                            " s of wall time (--patience); the other stories were played"
                                      : ": the process that played this story ended with " + how +
                                            " before the story did; the other stories were played"));
  return result;
}

}  // namespace

std::string story_answer(const testing::StoryResult& result) {
  Json bad;
  explain::Coverage coverage = result.coverage;
  if (const auto& error = result.bad)
    bad = {{"kind", static_cast<int>(error->kind)},
           {"message", error->message},
           {"file", error->file},
           {"line", error->line}};
  const Json line{{"failures", result.failures},
                  {"notes", result.notes},
                  {"sim_time_s", result.sim_time_s},
                  {"coverage", JsonWriter::json(coverage)},
                  {"bad", bad},
                  {"differs", result.differs},
                  {"printed", result.printed},
                  {"files", result.files}};
  return json_text(line);
}

void add_answer(PlayedStory& story, std::uint64_t seed, const StoryEnd& end) {
  auto told = end.code == 0 && !end.late ? read_story_answer(end.said) : std::nullopt;
  story.late |= end.late;
  story.untold += !told;
  testing::StoryResult result = told ? *std::move(told) : answer_left_unsaid(story.spec, end);
  explain::Coverage coverage = std::move(story.result.coverage);
  std::set<std::string> files(story.result.files.begin(), story.result.files.end());
  coverage.add(result.coverage);
  files.insert(result.files.begin(), result.files.end());
  const bool tells = story.seeds_played == 0 ||
                     (result.passed() ? story.passed() && seed > story.seed : story.passed() || seed < story.seed);
  if (!result.passed()) story.failed_seeds.insert(seed);
  ++story.seeds_played;
  if (tells) {
    story.seed = seed;
    story.result = std::move(result);
  }
  story.result.coverage = std::move(coverage);
  story.result.files.assign(files.begin(), files.end());
}

}  // namespace cxlab::lab
