#pragma once
// One plan, played through from happening to happening.

#include <optional>
#include <string>
#include <vector>

#include "planner/validator/footprint.h"
#include "planner/validator/validator.h"

namespace cxlab::planner {

/// Something that happens at once.
struct Happening {
  enum class Kind { kOutside, kStart, kInstant, kEnd };
  Nanos time = 0;
  Kind kind = Kind::kOutside;
  int step = -1;                        ///< index in the plan
  const OutsideEvent* event = nullptr;  ///< of kOutside
};

class Execution {
 public:
  Execution(const Validator& validator, const Plan& plan, const ValidateOptions& options);

  Expected<Verdict> run();

 private:
  /// An effect at the end of a running step: the frames for which it was enabled at the start.
  struct Pending {
    const Effect* effect;
    std::vector<Frame> frames;
  };
  struct Running {
    Frame frame;
    std::vector<Pending> pending;
  };
  struct Recent {
    Happening happening;
    Footprint footprint;
  };
  /// What happened, for explanations.
  struct Record {
    Happening happening;
    std::vector<Change> by_step;

    const std::vector<Change>& changes() const { return happening.event ? happening.event->changes : by_step; }
  };

  bool lay_out();
  bool pass(Nanos from, Nanos to);
  std::optional<double> look_to_break(const Condition& condition, Frame& frame, int step, double length);
  bool hold_over_all(int step, double length);
  void drop_pending(int step, double length);
  bool happen(std::size_t first, std::size_t last);
  bool conditions_of(const Happening& happening);
  bool duration_of(const Happening& happening);
  bool collect(const Happening& happening, std::vector<Change>& changes);
  void enable_pending(int step);
  bool set_rates();
  bool check_interference(std::size_t first, std::size_t last);
  Footprint footprint_of(const Happening& happening, const std::vector<Change>& changes);
  bool check_goal();

  const Action& action_of(int step) const { return domain_.actions[plan_[step].action]; }
  double duration_of_step(int step) const { return to_seconds(ends_[step] - starts_[step]); }
  bool holds(const Condition& condition, int step) {
    return evaluator_.holds(condition, running_[step].frame, state_, duration_of_step(step));
  }

  // Explanations (explanation.cpp).
  bool fail(Violation violation);
  bool fail_condition(int step, const Condition& condition, const char* when, double time);
  bool fail_effect(int step, const Effect& effect, double time);
  bool fail_interference(const Happening& earlier, const Happening& later, const std::string& what);
  const Condition& failing_part(const Condition& condition, Frame& frame, double duration) const;
  void explain(const Condition& part, const Frame& frame, Violation& violation, double duration) const;
  void explain_fact(const Condition& atom, const Frame& frame, bool wanted, Violation& violation) const;
  void explain_numbers(const Condition& part, const Frame& frame, Violation& violation, double duration) const;
  std::optional<Happening> next_change(const Fact& fact, Effect::Kind makes) const;
  std::string advice_for_fact(const Fact& fact, const std::string& text, bool wanted, const Happening* spoiler,
                              const Violation& violation) const;
  std::string describe(const Happening& happening) const;
  std::string describe_step(int step) const;

  const Validator& validator_;
  const Evaluator& evaluator_;
  const Domain& domain_;
  const Problem& problem_;
  const Plan& plan_;
  ValidateOptions options_;
  Nanos epsilon_;
  State state_;
  ById<Nanos> starts_, ends_;
  std::vector<Happening> happenings_;  ///< by time
  std::size_t current_ = 0;            ///< first happening of the group that is played
  ById<Running> running_;              ///< by step
  std::vector<int> active_;            ///< steps that run now
  std::vector<Recent> recent_;         ///< less than epsilon ago
  std::vector<Record> records_;
  Nanos end_ = 0;
  Verdict verdict_;
};

}  // namespace cxlab::planner
