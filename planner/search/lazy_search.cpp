#include "planner/search/lazy_search.h"

#include <algorithm>

#include "planner/search/bucket_queue.h"

namespace cxlab::planner {

namespace {

constexpr int kBoost = 1000;  ///< turns that preferred queues get when an estimate has become better

std::uint64_t hash_words(const Word* words, int count, Word last) {
  std::uint64_t hash = std::uint64_t{0x9e3779b97f4a7c15};
  const auto add = [&hash](Word word) {
    hash = (hash ^ word) * std::uint64_t{0xff51afd7ed558ccd};
    hash ^= hash >> 32;
  };
  for (int i = 0; i < count; ++i) add(words[i]);
  add(last);
  return hash;
}

/// States that have been made, each with how it was reached. They differ by their first words and their last one.
class Nodes {
 public:
  struct Node {
    int parent = -1;
    int action = -1;
    Micros duration = 0;
    int next_event = 0;
  };

  Nodes(int state_words, int significant_words, int landmark_words)
      : state_words_(state_words),
        significant_words_(significant_words),
        landmark_words_(landmark_words),
        slots_(1024, -1) {}

  const Word* state(int node) const { return &states_[std::int64_t{node} * state_words_]; }
  Word* reached(int node) { return landmark_words_ ? &reached_[std::int64_t{node} * landmark_words_] : nullptr; }
  const Node& operator[](int node) const { return nodes_[node]; }
  int size() const { return static_cast<int>(nodes_.size()); }
  std::size_t words() const { return states_.size() + reached_.size() + nodes_.size() * 4; }

  /// The new node, or -1 if the state is known with this event to come.
  int add(const Word* state, const Word* reached, const Node& node) {
    if (2 * nodes_.size() >= slots_.size()) grow();
    int& entry = slots_[slot(state, node.next_event)];
    if (entry >= 0) return -1;
    entry = size();
    states_.insert(states_.end(), state, state + state_words_);
    if (landmark_words_) reached_.insert(reached_.end(), reached, reached + landmark_words_);
    nodes_.push_back(node);
    return entry;
  }

 private:
  bool is_same(const Word* a, const Word* b) const {
    return a[state_words_ - 1] == b[state_words_ - 1] && std::equal(a, a + significant_words_, b);
  }
  std::size_t slot(const Word* state, int next_event) const {
    const std::size_t mask = slots_.size() - 1;
    const Word last = state[state_words_ - 1];
    for (std::size_t at = (hash_words(state, significant_words_, last) +
                           static_cast<std::uint64_t>(next_event) * std::uint64_t{0x51ed27}) &
                          mask;
         ; at = (at + 1) & mask) {
      const int node = slots_[at];
      if (node < 0 || (nodes_[node].next_event == next_event && is_same(state, this->state(node)))) return at;
    }
  }
  void grow() {
    slots_.assign(2 * slots_.size(), -1);
    for (int node = 0; node < size(); ++node) slots_[slot(state(node), nodes_[node].next_event)] = node;
  }

  int state_words_, significant_words_, landmark_words_;
  ById<Word> states_, reached_;
  ById<Node> nodes_;
  std::vector<int> slots_;
};

/// Steps to try.
struct Entry {
  int parent;
  int action;
};
struct Queue : BucketQueue<Entry> {
  int priority = 0;  ///< queues take turns: the smallest is next
};

enum { kPlain, kPlainPreferred, kMarks, kMarksPreferred, kQueues };

}  // namespace

bool EventCheck::accepts(const Sequence& path, const Word*) {
  timeline_.clear();
  acts_ = std::ranges::any_of(path, [](const SequenceStep& step) { return !is_event(step); });
  for (const SequenceStep& step : path)
    if (is_event(step) ? !timeline_.append_event() : timeline_.append(step.action, step.duration) == Timeline::kNever)
      return false;
  return true;
}

bool EventCheck::accepts_goal(const Sequence& path) {
  return accepts(path, nullptr) && (acts_ || path.empty()) && timeline_.finish();
}

/// What a search has done so far.
struct LazySearch::Progress {
  Progress(const Simulator& simulator, const RelaxedTask& relaxed, const Landmarks& landmarks, const LazyOptions& how)
      : options(how),
        landmark_words(landmarks.words()),
        random(how.seed, "planner lazy search"),
        heuristic(simulator, relaxed),
        nodes(simulator.words() + 1, simulator.significant_words(), landmark_words) {}

  LazyOptions options;
  int landmark_words;
  RandomStream random;
  RelaxedHeuristic heuristic;
  Nodes nodes;  // the last word is the signature
  std::vector<Queue> queues = std::vector<Queue>(kQueues);
  int best_plain = std::numeric_limits<int>::max(), best_marks = best_plain;
  std::int64_t reported = 0;
  PackedState state;
  std::vector<Word> reached;
  int node = -1;  ///< made and not yet looked at
};

LazySearch::LazySearch(const Simulator& simulator, const RelaxedTask& relaxed, const Landmarks& landmarks,
                       const PackedState& start, const LazyOptions& options, PathCheck* check)
    : simulator_(simulator),
      landmarks_(landmarks),
      check_(check),
      progress_(std::make_unique<Progress>(simulator, relaxed, landmarks, options)) {
  Progress& p = *progress_;
  if (options.cost_noise > 0) p.heuristic.scatter_costs(p.random, options.cost_noise);
  p.state = start;
  p.state.push_back(0);
  p.reached.resize(static_cast<std::size_t>(p.landmark_words), 0);
  if (p.landmark_words) landmarks_.mark(p.state.data(), p.reached.data());
  p.node = p.nodes.add(p.state.data(), p.reached.data(), {});
}

LazySearch::~LazySearch() = default;

SearchEnd LazySearch::run(Budget& budget, Sequence& found) {
  auto& [options, landmark_words, random, heuristic, nodes, queues, best_plain, best_marks, reported, state, reached,
         node] = *progress_;
  const int words = simulator_.words();
  const int events = static_cast<int>(simulator_.task().events.size());
  const auto path = [&nodes = nodes](int to) {
    Sequence steps;
    for (int at = to; nodes[at].parent >= 0; at = nodes[at].parent)
      steps.push_back({nodes[at].action, nodes[at].duration});
    std::ranges::reverse(steps);
    return steps;
  };
  const auto spend_check = [&] { budget.spend(Work::kTimes, check_->take_work()); };
  std::vector<int> order, preferred;
  for (;;) {
    if (node >= 0) {
      const int next_event = nodes[node].next_event;
      if (simulator_.is_lasting_goal(state.data(), next_event)) {
        found = path(node);
        if (!check_) return SearchEnd::kFound;
        const bool accepted = check_->accepts_goal(found);
        spend_check();
        if (accepted) return SearchEnd::kFound;
      }
      const int estimate = heuristic.evaluate(state.data(), next_event);
      budget.spend(Work::kReach, heuristic.work() - reported);
      reported = heuristic.work();
      if (estimate != RelaxedHeuristic::kDeadEnd) {
        const int marks = landmark_words ? landmarks_.remaining(state.data(), nodes.reached(node)) : 0;
        bool better = false;
        if (estimate < best_plain) {
          best_plain = estimate;
          better = true;
        }
        if (landmark_words && marks < best_marks) {
          best_marks = marks;
          better = true;
        }
        if (better) {
          queues[kPlainPreferred].priority -= kBoost;
          queues[kMarksPreferred].priority -= landmark_words ? kBoost : 0;
        }
        order = heuristic.applicable();
        preferred = heuristic.preferred();
        if (next_event < events) {
          order.push_back(-2 - next_event);
          if (std::ranges::any_of(heuristic.relaxed_plan(), [](int a) { return a <= -2; }))
            preferred.push_back(-2 - next_event);
        }
        if (options.seed != 0) {
          random.shuffle(order);
          random.shuffle(preferred);
        }
        for (const int action : order) {
          queues[kPlain].push(estimate, {node, action});
          if (landmark_words) queues[kMarks].push(marks, {node, action});
        }
        for (const int action : preferred) {
          queues[kPlainPreferred].push(estimate, {node, action});
          if (landmark_words) queues[kMarksPreferred].push(marks, {node, action});
        }
      }
    }
    node = -1;
    if (budget.slice_over()) return SearchEnd::kBudget;
    std::size_t waiting = 0;
    for (const Queue& queue : queues) waiting += queue.size();
    if (nodes.words() + waiting > options.most_words) return SearchEnd::kMemory;
    Queue* next = nullptr;
    for (Queue& queue : queues)
      if (!queue.empty() && (!next || queue.priority < next->priority)) next = &queue;
    if (!next) return SearchEnd::kExhausted;
    ++next->priority;
    const Entry entry =
        options.random_choice > 0 && random.chance(options.random_choice) ? next->pop_any(random) : next->pop();
    state.assign(nodes.state(entry.parent), nodes.state(entry.parent) + words + 1);
    budget.spend(Work::kNode, 1);
    Nodes::Node made{entry.parent, entry.action, 0, nodes[entry.parent].next_event};
    if (entry.action <= -2) {
      simulator_.apply_event(-2 - entry.action, state.data());
      ++made.next_event;
    } else if (!simulator_.apply(entry.action, state.data(), made.duration)) {
      continue;
    }
    if (check_) {
      Sequence steps = path(entry.parent);
      steps.push_back({made.action, made.duration});
      budget.spend(Work::kSchedule, static_cast<std::int64_t>(steps.size()));
      const bool accepted = check_->accepts(steps, state.data());
      spend_check();
      if (!accepted) continue;
      state.back() = check_->signature();
    }
    if (landmark_words) {
      std::copy(nodes.reached(entry.parent), nodes.reached(entry.parent) + landmark_words, reached.begin());
      landmarks_.mark(state.data(), reached.data());
    }
    node = nodes.add(state.data(), reached.data(), made);
  }
}

}  // namespace cxlab::planner
