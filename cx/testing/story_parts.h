#pragma once
// What a story does to an agent, as parts of an episode: its own (cx/testing/play.h), or a run with a world of kind
// `story` (scenarios/story).

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/executive/run_control.h"
#include "cx/explain/pattern.h"
#include "cx/run/parts.h"
#include "cx/testing/stand_ins.h"
#include "cx/testing/story.h"

namespace cxlab::testing {

/// Names of globals that stories define begin so.
inline constexpr std::string_view kGlobalOfStory = "of-story-";
/// "?*of-story-goal-2*"
std::string global_of_story(const std::string& what, std::size_t number);

/// The last tick that may be played.
SimTime end_of(const StorySpec& spec);

/// A configuration of one environment, `main`, with the rule files of the story.
Expected<std::string> config_for_rules(const StorySpec& spec);

/// Why CLIPS objects to a fact or pattern of a story: with the names and values that would be right, where these are
/// known, otherwise in the words of CLIPS.
std::string plain_objection(const explain::Pattern& pattern, const RuleEngine& engine, const std::string& of_clips);

/// Stand-ins serve, and topics are listened to. Returns the mistakes of the story in names of types and fields, and in
/// values of fields.
std::vector<Error> set_up(StandIns& stand_ins, const StorySpec& spec);

/// Does the steps that other nodes see: messages, and stand-ins that answer otherwise from then on.
class StorySteps final : public Server {
 public:
  /// Both outlive this.
  StorySteps(const StorySpec& spec, StandIns& stand_ins) : spec_(&spec), stand_ins_(stand_ins) {}
  /// Another story, before the first step.
  void play(const StorySpec& spec) { spec_ = &spec; }
  Status sense(SimTime now) override;
  Status act(SimTime) override { return {}; }
  SimTime next_due() const override;

 private:
  const StorySpec* spec_;
  StandIns& stand_ins_;
  std::size_t next_ = 0;
};

/// Asserts and retracts the facts of a story in the environment that the story looks at, each at its time. It acts when
/// messages have become facts and before any rule fires. It sends running goals at the first tick, and no rule fires
/// until the facts are given.
class StoryFacts final : public cx::RunControl {
 public:
  /// It outlives this.
  explicit StoryFacts(const StorySpec& spec) : spec_(&spec) {}
  /// Another story, before the first tick.
  void play(const StorySpec& spec) { spec_ = &spec; }
  Status stop_at(cx::Environment& environment, const cx::ControlPlace& place) override;
  bool before_each_firing() const override { return false; }

 private:
  /// A running goal.
  struct Sent {
    const StandIn* server;
    const UnderWay* goal;
    std::string handle;  ///< the global that has it
    /// The prefix of the binding through which the agent's client of the action was opened. Empty: the generic plugin.
    std::string binding = {};
    std::string named(const std::string& suffix) const { return (binding.empty() ? "ros-msgs" : binding) + suffix; }
  };
  Status send_goals(cx::Environment& environment);
  Status send_requests(cx::Environment& environment, const StandIn& server);
  Status number_requests(cx::Environment& environment, const StandIn& server, const std::string& number,
                         int line) const;
  Status send(cx::Environment& environment, const std::string& global, const std::string& created,
              const std::string& sent, const std::string& destroy, int line) const;
  Status begin(cx::Environment& environment);
  Status evaluate(cx::Environment& environment, const Line& text) const;
  Status hold(cx::Environment& environment) const;
  Status answer(cx::Environment& environment) const;
  std::string with_pointers(const std::string& fact) const;
  Status give_all(cx::Environment& environment);
  Status give(cx::Environment& environment, const GivenFact& fact);
  Status take(cx::Environment& environment, const Step& step) const;

  const StorySpec* spec_;
  std::string environment_;  // its stream; empty: not known yet
  bool begun_ = false, given_ = false, answered_ = false;
  std::vector<Sent> sent_;
  std::size_t requests_ = 0;                                // sent at the beginning
  std::vector<std::pair<std::string, std::string>> named_;  // words for facts that were given, and their globals
  std::size_t next_ = 0;
};

}  // namespace cxlab::testing
