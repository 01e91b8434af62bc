#pragma once
// Search over orders of happenings (starts, ends and events), with a zone of times for each. It is complete for numbers
// that are linear in time, and it ends if the number of different moments is finite. It is for small problems in which
// the order of whole actions says too little.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "planner/happenings/moment.h"
#include "planner/search/bucket_queue.h"
#include "planner/search/clock.h"
#include "planner/search/split.h"

namespace cxlab::planner {

/// A plan that was found.
struct HappeningPlan {
  std::vector<ClockStep> steps;       ///< with the earliest times
  std::optional<Concurrent> partial;  ///< the same as orderings, where these are enough to keep it right
};

class HappeningSearch {
 public:
  struct Options {
    Moments::Options moments;
    bool all_numbers = false;  ///< also moments that differ in numbers that only the metric reads are different
    std::size_t most_words = std::size_t{1} << 27;
  };
  HappeningSearch(const GroundTask& task, const Simulator& simulator, Budget& budget, const Options& options);

  /// Searches until a slice of the budget ends; the next call continues there. Calls `accept` with each plan that ends
  /// before `before`, until it returns true; `before` needs Moments::Options::keep_origin.
  SearchEnd run(Micros before, const std::function<bool(const HappeningPlan&)>& accept);
  /// Whether every order that could be a plan has been followed or will be, but for more copies at once.
  bool complete() const { return moments_.complete(); }
  /// Whether some order was left out because too many copies of one action would run at once.
  bool capped() const { return moments_.capped(); }

 private:
  struct Node {
    Moment moment;
    int parent = -1;
    Happening happening;
    Moments::Signs signs;
    int starts = 0;
    bool expanded = false;
  };

  bool add(Node node, Micros before, const std::function<bool(const HappeningPlan&)>& accept);
  std::vector<Word> key(const Moment& moment) const;
  int estimate(const Moment& moment);
  bool too_late(const Moment& moment, Micros before) const;
  std::optional<HappeningPlan> plan_of(const Node& node) const;

  const GroundTask& task_;
  const Simulator& simulator_;
  Budget& budget_;
  const Options options_;
  Moments moments_;
  LooseEstimate loose_;
  RelaxedHeuristic heuristic_;
  std::int64_t reported_ = 0;
  ById<Node> nodes_;
  std::map<std::vector<Word>, std::vector<Zone>> known_;
  BucketQueue<int> near_, short_;  ///< nodes by how near the goal seems, and by that and the actions so far
  std::uint64_t turn_ = 0;
  std::size_t words_ = 0;
  bool begun_ = false;
};

}  // namespace cxlab::planner
