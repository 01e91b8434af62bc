#pragma once
// Plays the rules of a story: a manager on a bus of its own, stand-ins for what its agent uses, and the loop.

#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cx/base/scratch_folder.h"
#include "cx/executive/environment_manager.h"
#include "cx/executive/log_router.h"
#include "cx/explain/history.h"
#include "cx/journal/journal.h"
#include "cx/run/loop.h"
#include "cx/testing/stand_ins.h"
#include "cx/testing/story.h"
#include "cx/testing/story_parts.h"

namespace cxlab::testing {

inline constexpr std::size_t kMostLines = 1000;  ///< of the log of a story

/// "1.5 s"
std::string seconds(SimTime t);

class Play final : private Server, private cx::LogSink {
 public:
  /// Both outlive this. `each_tick`: also those at which nothing is due.
  Play(const StorySpec& spec, const StorySetup& setup, bool each_tick);
  Play(const Play&) = delete;
  Play& operator=(const Play&) = delete;

  /// Packages, configuration and stand-ins: an error is a mistake of the story, and so are `mistakes_in_messages`.
  Status prepare();
  /// What the story reaches of the machine from now on.
  Wall wall() const;
  /// Activation. Errors of kind kInput are mistakes in rule files or the configuration.
  Status begin();
  /// Deactivates the agent and removes it.
  Status end();
  /// Removes the agent as it is.
  void leave();
  /// The coverage of the removed agent.
  const explain::Coverage& coverage() const { return coverage_; }
  /// After `begin`: all that is still to come is that of another story of the same agent (`same_agent`).
  void go_on_as(const StorySpec& spec);
  /// At once; `line` is that of the story.
  Status assert_fact(const std::string& text, int line);
  /// An error at a line of the story.
  Error at(int line, const std::string& what) const { return input_error(what, spec_->file, line); }

  Loop& loop() { return *loop_; }
  StandIns& stand_ins() { return stand_ins_; }
  const StandIns& stand_ins() const { return stand_ins_; }
  cx::EnvironmentManager& manager() { return *manager_; }
  /// The engine of the environment that the story looks at.
  RuleEngine& engine() const { return environment_->engine(); }
  const explain::History& history() const { return *history_; }
  const explain::History& history_of(const RuleEngine& engine) {
    return histories_.of(journal_.stream_name(engine.stream()));
  }
  /// Types and fields of the story that do not exist; it must not be played then.
  const std::vector<Error>& mistakes_in_messages() const { return mistakes_in_messages_; }
  /// What plugins cleaned up at the end: it was left open.
  const std::vector<std::string>& left_open() const { return left_open_; }
  /// Parameters of the story that nothing had read at the end, with their lines.
  const std::vector<std::string>& unread() const { return unread_; }
  /// Lines of the agent's log, but for those for debugging: the last `kMostLines`.
  std::vector<std::string> printed() const { return {printed_.begin(), printed_.end()}; }
  /// Files that were read so far, and rule files and configuration that the story names.
  std::vector<std::string> files() const { return {files_.begin(), files_.end()}; }
  const StorySpec& spec() const { return *spec_; }

 private:
  Status sense(SimTime) override { return {}; }
  Status act(SimTime) override { return {}; }
  SimTime next_due() const override { return each_tick_ ? SimTime::zero() : kNever; }
  void line(const cx::LogLine& line) override;
  void note_file(const std::filesystem::path& file);
  Expected<std::filesystem::path> config_file();
  Status find_environment();

  const StorySpec* spec_;
  const StorySetup& setup_;
  const bool each_tick_;
  LimitsInUse limits_;
  std::vector<Error> mistakes_in_messages_;
  std::vector<std::string> left_open_, unread_;
  std::deque<std::string> printed_;
  std::set<std::string> files_;
  explain::Coverage coverage_;
  std::unique_ptr<ScratchFolder> scratch_;
  explain::Histories histories_;
  const explain::History* history_ = nullptr;  // of `environment_`
  Journal journal_;
  bus::Registry registry_;
  bus::Bus bus_{registry_, journal_};
  StandIns stand_ins_{bus_, journal_, spec_->seed, spec_->faults};
  StorySteps steps_{*spec_, stand_ins_};
  StoryFacts facts_{*spec_};
  std::unique_ptr<cx::EnvironmentManager> manager_;
  cx::Environment* environment_ = nullptr;
  std::optional<Loop> loop_;
};

}  // namespace cxlab::testing
