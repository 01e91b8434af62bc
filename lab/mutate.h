#pragma once
// How well the stories of an agent bite: its rules are changed one by one (lab/mutants.h), and the stories are played.
//
//   auto subject = mutation_subject("my_agent", shipped());
//   auto mutation = Mutation::prepare(*std::move(subject), {}, plan);
//   auto result = mutation->play({.mutants = 200, .seed = 1});

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "lab/host.h"
#include "lab/mutants.h"
#include "lab/statistics/statistics.h"
#include "lab/stories.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {

struct MutationSubject {
  std::vector<PlayedStory> stories;        ///< but for golden runs, which any change of a rule kills
  std::vector<std::filesystem::path> own;  ///< absolute; rule files in these folders are changed
  std::size_t golden = 0;                  ///< golden runs that were left out
};
/// Finds the stories to play. `agent` is a folder or file of stories (as in `read_stories`), a configuration, or a
/// scenario. For the last two, they are the stories in the packages of its agents that play these configurations.
Expected<MutationSubject> mutation_subject(const std::string& agent, const Catalogue& catalogue);

enum class Fate {
  kSurvived,  ///< all stories pass
  kKilled,    ///< a story fails
  kTimedOut,  ///< a story does not end
};
const char* to_string(Fate fate);

struct PlayedMutant {
  std::size_t mutant = 0;  ///< index in `Mutation::mutants()`
  Fate fate{};
  std::string killer;     ///< FILE::NAME of the first story that failed
  std::string complaint;  ///< its first one
  bool operator==(const PlayedMutant&) const = default;
};

struct MutationProgress {
  std::size_t done = 0, total = 0, playing = 0, survived = 0;
  std::optional<double> seconds_left;
};

struct MutationDraw {
  std::size_t mutants = 0;  ///< that are played; 0: all
  std::uint64_t seed = 1;   ///< of the draw
  double time_limit_s = 0;  ///< after so many s of the clock on the wall no mutant is begun; 0: no limit
  std::function<void(const MutationProgress&)> progress = {};  ///< called several times a second
};

struct MutationResult {
  std::vector<PlayedMutant> played;  ///< by file and place
  std::size_t not_loaded = 0;        ///< changes whose rules do not load; others were drawn instead
  std::size_t wanted = 0;            ///< mutants that were to be played; fewer were if time was short
  bool all = false;                  ///< all mutants that exist were played

  std::size_t count(Fate fate) const;
  /// The share of mutants that died; 1 where there is none.
  double score() const;
  /// 95 %; none where all mutants were played, or none.
  std::optional<statistics::Interval> interval() const;
};

class Mutation {
 public:
  /// Plays the stories as they are: the error is of kind kNo where one fails. `files`: only those and those in these
  /// folders are changed, unless it is empty. `plan`: setup, jobs, and `patience_s`, which if it is 0 follows from the
  /// time that the stories take.
  static Expected<Mutation> prepare(MutationSubject subject, const std::vector<std::string>& files, StoryPlan plan,
                                    const Host& host = {});

  /// Loads each agent and plays no story: for `mutants`, `find`, `file_of` and `place_of` alone.
  static Expected<Mutation> load(MutationSubject subject, const std::vector<std::string>& files, StoryPlan plan,
                                 const Host& host = {});

  const std::vector<PlayedStory>& stories() const { return subject_.stories; }
  double stories_s() const { return stories_s_; }  ///< they took of the clock on the wall
  std::size_t golden() const { return subject_.golden; }
  std::size_t files() const;  ///< that are changed
  const std::vector<Mutant>& mutants() const { return mutants_; }
  const RuleText& file_of(const Mutant& mutant) const { return texts_[mutant.file]; }
  /// As a person names it from here.
  std::string place_of(const Mutant& mutant) const;
  /// The mutant of this id; kUsage if there is none.
  Expected<std::size_t> find(const std::string& id) const;
  /// Stories in which a rule fires that is changed, or uses what is changed.
  std::vector<std::string> reached_by(const Mutant& mutant) const;

  /// Plays mutants that are drawn, `plan.jobs` at a time. The same draw gives the same result, whatever the jobs are,
  /// but for its time limit and a stop.
  Expected<MutationResult> play(const MutationDraw& draw, const Host& host = {}) const;
  /// Plays one mutant with all stories that it can make fail. kInput if its rules do not load.
  Expected<std::vector<PlayedStory>> play_one(const Mutant& mutant, const Host& host = {}) const;

 private:
  friend class MutantPlayer;
  /// What a rule did in a story.
  struct Use {
    std::size_t story = 0;
    std::string file;
    long fired = 0, activated = 0;
  };

  Mutation() = default;
  Status read_files(const std::vector<std::string>& files);
  /// The stories that can notice the change, the likely ones first; at least one.
  std::vector<std::size_t> stories_for(const Mutant& mutant) const;
  /// By story: how often rules that are changed, or use what is changed, have fired and were activated.
  std::map<std::size_t, std::pair<long, long>> uses_of(const Mutant& mutant) const;
  /// Plays these stories with the file of the mutant, which is written below `folder`.
  Expected<std::vector<PlayedStory>> play(const Mutant& mutant, const std::filesystem::path& folder, bool all,
                                          const Host& host) const;

  MutationSubject subject_;
  StoryPlan plan_;
  double stories_s_ = 0;
  std::vector<RuleText> texts_;
  std::vector<std::filesystem::path> paths_;  // of `texts_`
  std::vector<Mutant> mutants_;
  std::map<std::string, std::vector<Use>> uses_;       // by rule, without module
  std::vector<long> firings_;                          // by story
  std::vector<std::set<std::filesystem::path>> read_;  // by story
};

}  // namespace cxlab::lab
