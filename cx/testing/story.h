#pragma once
// Stories: regression tests of rules without a world, in simulated time (docs/reference/stories.md).
//
//   StorySpec spec;  spec.rules = {"agent.clp"};  spec.given = {{"(robot (name \"R1\"))"}};  ...
//   StoryResult result = run_story(spec, setup);

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/engine/limits.h"
#include "cx/explain/coverage.h"
#include "cx/node/parameters.h"
#include "cx/testing/stand_ins.h"
#include "cx/wall/wall.h"

namespace cxlab::testing {

inline constexpr SimTime kTick = std::chrono::milliseconds(20);  ///< of stories that name no other

/// A text of the story file and the line on which it stands.
struct Line {
  std::string text;
  int line = 0;
};

/// A fact at the start.
struct GivenFact {
  std::string text;
  int line = 0;
  std::string as = {};  ///< the word by which later facts point to it: "<Fact-12>"
};

/// Something that happens at a time.
struct Step {
  enum class Verb { kAssert, kRetract, kPublish, kStandIn };
  SimTime at{};
  Verb verb{};
  std::string text;        ///< fact, pattern or topic
  std::string type, data;  ///< of a message
  StandIn stand_in;
  int line = 0;
};

/// Something that must hold, between `after` and `until` or at one time.
struct Expectation {
  enum class Kind { kFact, kNoFact, kFires, kNotFires, kGoal, kPublished };
  Kind kind{};
  std::string text;    ///< pattern, rule, action or topic
  std::string type;    ///< of a topic
  std::string fields;  ///< YAML that goal or message must contain
  int count = 1;       ///< at least so often (fires, goal, published)
  SimTime after{};
  SimTime until = kNever;  ///< kNever: the end of the story
  bool at = false;         ///< facts: as they are at the end of tick `until`
  int line = 0;
};

struct StorySpec {
  std::string name, file;
  int line = 0;
  std::filesystem::path config;  ///< of the CX; empty: `rules` with executive and ros_msgs
  std::vector<std::filesystem::path> rules;
  std::vector<cx::GivenParameter> params;  ///< instead of those of `config`
  std::map<std::string, std::filesystem::path> packages;
  std::string environment;  ///< empty = the first
  std::uint64_t seed = 1;
  std::vector<std::uint64_t> seeds;  ///< with each of which it must hold; empty: `seed` alone
  std::vector<GivenFact> given;
  SimTime tick = kTick;
  SimTime begins{};              ///< time of the first tick
  SimTime given_at{};            ///< when facts are given: not before `begins`
  bool moment = false;           ///< at `given_at` only the facts of `given` exist, and the activations that they cause
                                 ///< count as fired
  std::vector<Line> calls;       ///< expressions, evaluated before facts are given
  std::filesystem::path golden;  ///< a recorded run: nothing else is given, and it must go as it went then
  std::vector<StandIn> stand_ins;
  std::vector<Fault> faults;
  std::vector<Step> steps;
  std::vector<Expectation> expect;
  SimTime end{};                ///< zero: the latest time that is named
  bool leaves_nothing = false;  ///< what its agent leaves open at the end is a failure, not a note
};

struct StorySetup {
  std::filesystem::path interfaces;                  ///< folder of packages of definitions
  bool coverage = false;                             ///< count what rules do
  std::map<std::string, std::string> packages = {};  ///< beside those that a story names, which win
  Limits limits = {};                                ///< of the rules of each story
  std::map<std::string, std::string> own_packages =
      {};                       ///< of cxlab: have the files that packages of the same name lack
  bool patterns_known = false;  ///< the stories have been played before with the same templates
  /// Files whose content is that of others; both are absolute and without "." and "..".
  std::map<std::filesystem::path, std::filesystem::path> instead = {};
  /// Called before the first rule is read, with what the story reaches of the machine from then on; may be none.
  std::function<void(const Wall&)> confine = {};
};

struct StoryResult {
  std::vector<std::string> failures;  ///< `file:line: what was expected, by when, what was there`
  std::vector<std::string> notes;     ///< what was left open at the end, and parameters that nothing read
  std::vector<std::string> printed;   ///< lines of the agent's log, but for those for debugging; the last 1000
  std::vector<std::string> files;     ///< that were read for it, absolute; of one that is missing its name alone
  /// The story itself, or a file that it names, cannot be used; `failures` has further reasons.
  std::optional<Error> bad;
  bool differs = false;        ///< of a golden run: the failures are what goes otherwise
  double sim_time_s = 0;       ///< from when the facts are given
  explain::Coverage coverage;  ///< of all its environments, with `StorySetup::coverage`
  bool passed() const { return failures.empty() && !bad; }
};

/// Reads the stories of a file (docs/reference/stories.md); paths in it are relative to it. The error is the first of
/// those that are found; `further` gets the others.
Expected<std::vector<StorySpec>> read_stories(const std::filesystem::path& file, std::vector<Error>* further = nullptr);
/// Plays the story in a manager of its own.
StoryResult run_story(const StorySpec& spec, const StorySetup& setup);

/// The agent of a story, and nothing of the story: it is played for one tick.
StorySpec agent_of(StorySpec spec);

/// Whether one agent that is loaded can play either: only what is given, happens and is expected differs.
bool same_agent(const StorySpec& one, const StorySpec& other);

/// An agent that is loaded once for many stories. Each is played in a copy of this process:
///
///   Stage stage(first, setup);
///   for (const StorySpec& spec : stories) if (fork() == 0) tell(stage.play(spec));
class Stage {
 public:
  /// Loads the agent of the story; `setup.confine` is called before.
  Stage(const StorySpec& of, const StorySetup& setup);
  ~Stage();
  /// Once: a story with `same_agent`. It goes as in `run_story`.
  StoryResult play(const StorySpec& story);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cxlab::testing
