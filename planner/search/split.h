#pragma once
// Actions that must overlap: a task in which some actions are cut into a beginning and an end, and the check that a
// sequence of those can be given times.
//
// Between its beginning and its end an action is running, a fact that only its own parts touch. A sequence of parts is
// a plan if no condition over all is broken in between and the temporal network of its happenings has a solution.

#include <optional>
#include <vector>

#include "planner/schedule/stn.h"
#include "planner/search/lazy_search.h"

namespace cxlab::planner {

/// Whether other actions may need this action to run. This is so if it makes something true only while it runs, or if
/// its end or its duration needs what its beginning does not.
bool is_envelope(const GroundTask& task, const GroundAction& action);
/// Whether an action can be cut: not if its end remembers its beginning or numbers change all along.
bool can_be_cut(const GroundTask& task, const GroundAction& action);

struct SplitTask {
  enum class Part : std::uint8_t { kWhole, kBegin, kEnd };
  struct Origin {
    int action;
    Part part;
  };
  GroundTask task;                  ///< facts of the original first, with the same numbers
  ById<Origin> origins;             ///< by action of `task`
  ById<std::pair<int, int>> parts;  ///< by action of the original: its beginning or the whole, and its end or -1
};

/// Cuts the actions that are marked.
SplitTask split(const GroundTask& task, const std::vector<char>& cut);

/// Whether effects read how long the action lasts.
bool reads_duration(const GroundAction& action);

/// A task without times, in which every action with a duration is two: its beginning and its end. An action that has
/// begun once may end at any time, and often. With `hold`, its end asks for its condition over all.
GroundTask loosened(const GroundTask& task, bool hold);
/// How often an action ends that has begun in an untimed task.
enum class Ends : std::uint8_t {
  kOften,    ///< any time: enough where what is removed does not count
  kAsBegun,  ///< once, and before the goal; if it began again while it was running, the last of its parts is an end
};
/// The same without conditions over all, as a proof: it has every plan as a sequence, and more, so what cannot be
/// reached there cannot be reached. Nothing if an action cannot be cut.
std::optional<GroundTask> untimed(const GroundTask& task, Ends ends);

/// A plan with overlaps: steps, and their happenings in an order in which they are right.
struct SplitPoint {
  enum class Kind : std::uint8_t { kBegin, kEnd, kEvent };
  Kind kind = Kind::kBegin;
  int step = -1;  ///< of kBegin and kEnd; the number of the event of kEvent
};
struct Concurrent {
  struct Step {
    int action = -1;  ///< of the original task
    DurationRange range;
  };
  ById<Step> steps;
  std::vector<SplitPoint> order;
};

/// The plan that a sequence of the split task stands for; `simulator` is of the split task.
Concurrent to_plan(const SplitTask& split, const GroundTask& original, const Simulator& simulator,
                   const Sequence& path);

/// Accepts the sequences of a split task that can be given times.
class SplitCheck : public PathCheck {
 public:
  /// `simulator` is of the split task.
  SplitCheck(const SplitTask& split, const GroundTask& original, const Simulator& simulator, const Touches& touches);

  bool accepts(const Sequence& path, const Word* state) override;
  /// How long each running action has run by the time of the last happening, roughly.
  Word signature() const override { return signature_; }
  bool accepts_goal(const Sequence& path) override;
  std::int64_t take_work() override { return stn_.take_work(); }

 private:
  /// After a step of the path: what the next one needs to know.
  struct Level {
    SequenceStep step;
    PackedState state;
    std::vector<std::pair<int, int>> open;  ///< running actions and their steps
    int points = 0;                         ///< of the network
  };

  bool append(const SequenceStep& step);

  const SplitTask& split_;
  const GroundTask& original_;
  const Simulator& simulator_;
  Stn stn_;                    ///< of the path looked at last
  std::vector<Level> levels_;  ///< of its steps; the first is the start
  std::size_t depth_ = 0;      ///< how many it has
  Word signature_ = 0;
};

/// The sequence of parts of a sequence of whole actions.
Sequence to_parts(const SplitTask& split, const Sequence& whole);

/// The temporal network of a plan; `solve` has not been called.
void fill(Stn& stn, const Concurrent& plan);

}  // namespace cxlab::planner
