#pragma once
// Where the rules of a recorded run spend their time: they are played again twice, once with a clock at each join,
// firing and call.

#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "cx/base/time.h"
#include "lab/host.h"
#include "lab/run.h"

namespace cxlab::lab {

struct Profile {
  struct Join {
    int number = 0, line = 0;   ///< of the first of its conditions
    std::string text;           ///< of its conditions
    std::int64_t passed = 0;    ///< partial matches that got through
    std::int64_t compared = 0;  ///< pairs of a partial match and a fact that were tried
    std::int64_t held = 0;      ///< partial matches that are through at the end
    std::size_t sharers = 1;    ///< rules that have it; its time is divided among them
    double s = 0;

    template <class Keys>
    void fields(Keys& keys) {
      keys.required("condition", number);
      keys.required("line", line);
      keys.required("text", text);
      keys.required("passed", passed);
      keys.required("compared", compared);
      keys.required("held", held);
      keys.required("rules_with_it", sharers);
      keys.required("s", s);
    }
  };
  struct Rule {
    std::string environment, name, file;
    int line = 0;
    std::int64_t fired = 0, activated = 0;
    double s = 0;  ///< all of it
    double matching_s = 0, acting_s = 0, agenda_s = 0;
    std::vector<Join> joins;  ///< in order; of a rule with `or` those of one way after the other

    template <class Keys>
    void fields(Keys& keys) {
      keys.required("environment", environment);
      keys.required("rule", name);
      keys.required("file", file);
      keys.required("line", line);
      keys.required("fired", fired);
      keys.required("activated", activated);
      keys.required("s", s);
      keys.required("matching_s", matching_s);
      keys.required("acting_s", acting_s);
      keys.required("agenda_s", agenda_s);
      keys.required("joins", joins);
    }
  };
  struct Function {
    std::string environment, name, file;
    int line = 0;
    std::int64_t calls = 0;
    double s = 0;  ///< without the functions that it calls and the matching that it causes

    template <class Keys>
    void fields(Keys& keys) {
      keys.required("environment", environment);
      keys.required("function", name);
      keys.required("file", file);
      keys.required("line", line);
      keys.required("calls", calls);
      keys.required("s", s);
    }
  };
  struct Span {
    std::string environment, kind, name;
    double begin_s = 0, end_s = 0;
    double t_s = 0;              ///< simulated
    std::string condition = {};  ///< of matching: the one that took longest, if it is known

    template <class Keys>
    void fields(Keys& keys) {
      keys.required("environment", environment);
      keys.required("kind", kind);
      keys.required("name", name);
      keys.required("begin_s", begin_s);
      keys.required("end_s", end_s);
      keys.required("t_s", t_s);
      keys.unless_empty("condition", condition);
    }
  };

  double at_s = 0;                  ///< simulated time up to which it was played
  bool cut_off = false;             ///< the log ends before that
  double plain_s = 0;               ///< CPU time of the replay without profiling
  double profiled_s = 0;            ///< CPU time of the replay with it
  double reads = 0;                 ///< of the clock; what they cost has been taken off all times
  double elsewhere_s = 0;           ///< the rest of `plain_s`, outside of the rules that are asked for
  std::vector<Rule> rules;          ///< the slowest first
  std::vector<Function> functions;  ///< the slowest first
  std::vector<Span> spans;          ///< in the order in which they end
  std::int64_t spans_left_out = 0;

  /// 0 if it is too small to be measured.
  double read_cost_s() const { return reads > 0 ? std::max(0.0, profiled_s - plain_s) / reads : 0; }

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("at_s", at_s);
    keys.required("cut_off", cut_off);
    keys.required("plain_s", plain_s);
    keys.required("profiled_s", profiled_s);
    keys.required("clock_reads", reads);
    keys.required("elsewhere_s", elsewhere_s);
    keys.required("rules", rules);
    keys.required("functions", functions);
    keys.unless_empty("spans", spans);
    keys("spans_left_out", spans_left_out);
  }
};

/// Plays the run twice in copies of this process, up to `at` or its end. `environment`: only this one; empty: all.
Expected<Profile> profile_of(const Run& run, std::optional<SimTime> at, const std::string& environment, bool spans,
                             const Host& host);

/// Tables of the slowest rules, joins and functions, `most` of each, with what profiling itself costs.
std::string text_of(const Profile& profile, std::size_t most);
Json json_of(const Profile& profile);
/// A page that asks for nothing else.
Expected<std::string> to_page(const Profile& profile, const std::string& title);
/// As Perfetto and chrome://tracing read it: firings, calls and matching along the time of the replay.
std::string to_trace(const Profile& profile);

}  // namespace cxlab::lab
