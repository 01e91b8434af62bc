// Takes out of a written story what does not happen in it.

#include <algorithm>
#include <set>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "lab/story_of_moment.h"

namespace cxlab::lab {

namespace {

/// The lines of this file that the texts name first: "FILE:12: ...".
std::set<int> lines_named(const std::vector<std::string>& texts, const std::string& file) {
  std::set<int> lines;
  for (const std::string& text : texts) {
    if (!text.starts_with(file + ':')) continue;
    const std::size_t begin = file.size() + 1, end = text.find(':', begin);
    if (const auto line = read_number<int>(text.substr(begin, end - begin))) lines.insert(*line);
  }
  return lines;
}

/// Whether this line expects a goal or a message of the agent.
bool is_message(const std::string& expectation) {
  return expectation.starts_with("{goal: ") || expectation.starts_with("{published: ");
}

}  // namespace

Status keep_what_holds(WrittenStory& story, const std::filesystem::path& file, const StoryPlan& plan,
                       const Host& host) {
  const int all = story.expectations;
  std::vector<std::string> dropped_lines;
  while (true) {
    if (Status s = replace_file(file, story.text); !s) return s;
    auto stories = read_stories({file.string()});
    if (!stories) return stories.error();
    if (Status s = play_stories(*stories, plan, host); !s || host.stopped()) return s;
    const PlayedStory& played = stories->front();
    if (played.passed()) break;
    if (played.unreadable) return *played.result.bad;
    std::string kept;
    int number = 0, dropped = 0;
    bool in_expect = false;
    const std::set<int> wrong = lines_named(played.complaints(), file.string());
    for (std::size_t begin = 0, end; begin < story.text.size(); begin = end + 1) {
      end = story.text.find('\n', begin);
      const std::string line = story.text.substr(begin, end - begin);
      in_expect = in_expect || line == "  expect:";
      if (wrong.contains(++number) && in_expect) {
        ++dropped;
        dropped_lines.push_back(line.substr(line.find_first_not_of(" -")));
      } else {
        kept += line + '\n';
      }
    }
    if (dropped == 0) return negative("the story does not play like the run: " + played.complaints().front());
    story.text = kept;
    story.expectations -= dropped;
    if (story.expectations == 0)
      return negative(
          "nothing that happened in the run happens in the story: choose another time (--at), at which fewer "
          "actions run");
  }
  constexpr std::size_t kMostListed = 8;
  if (!dropped_lines.empty())
    story.notes.push_back(std::to_string(dropped_lines.size()) + " of " + std::to_string(all) +
                          " things that happened in the run do not happen in the story, and are not expected:");
  for (std::size_t i = 0; i < std::min(kMostListed, dropped_lines.size()); ++i)
    story.notes.push_back("  " + dropped_lines[i]);
  if (dropped_lines.size() > kMostListed)
    story.notes.push_back("  and " + std::to_string(dropped_lines.size() - kMostListed) + " more");
  if (story.text.find("\n    - {goal: ") == std::string::npos &&
      story.text.find("\n    - {published: ") == std::string::npos)
    story.notes.push_back(
        std::ranges::any_of(dropped_lines, is_message)
            ? "it expects rules and facts only: what the agent asked of skills and published in the run is among what "
              "does not happen in the story"
            : "it expects rules and facts only, for the agent asked for no skill and published nothing in these "
              "seconds; a longer --for or another --at shows more");
  return {};
}

}  // namespace cxlab::lab
