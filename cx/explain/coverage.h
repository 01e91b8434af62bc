#pragma once
// Which rules fired, how far their conditions got, and which deffunctions were called: what tests of rules reach.
//
//   Coverage all;
//   for (...) all.add(coverage_of(engine.counts()));     // seeds, stories, environments, runs
//   std::fputs(text_of(all).c_str(), stdout);

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cx/engine/rule_counts.h"

namespace cxlab::explain {

struct Coverage {
  /// A condition of a rule; the parts of `and`, `or` and `logical` each by itself.
  struct Condition {
    int number = 0;  ///< of the rule's conditions, from 1
    int line = 0;
    std::size_t begin = 0, end = 0;  ///< of its characters in the text of the rule
    std::string text;

    template <class Keys>
    void fields(Keys& keys) {
      keys.required("number", number);
      keys.required("line", line);
      keys.required("begin", begin);
      keys.required("end", end);
      keys.required("text", text);
    }
  };
  /// One way through the `or` conditions of a rule.
  struct Way {
    std::vector<std::size_t> conditions;  ///< their places in `Rule::conditions`
    std::vector<std::int64_t> passed;     ///< partial matches that got past each of them

    template <class Keys>
    void fields(Keys& keys) {
      keys.required("conditions", conditions);
      keys.required("passed", passed);
    }
  };
  struct Rule {
    std::string file, name, text;  ///< the name with a module other than MAIN
    int line = 0;
    std::int64_t activated = 0, fired = 0;
    std::vector<Condition> conditions;
    std::vector<Way> ways;  ///< none: CLIPS has made something else of the conditions, which are not counted

    /// "fired", "activated but never fired", "never matched"
    const char* state() const;
    /// How many partial matches got past a condition, in all ways that it is on.
    std::int64_t passed(std::size_t condition) const;
    bool counts_conditions() const { return !ways.empty(); }
    /// For a rule that never matched: the place of the condition that nothing got past, on the way that got furthest.
    /// The number of conditions if the rule matched, or this place is unknown.
    std::size_t failed_at() const;

    template <class Keys>
    void fields(Keys& keys) {
      keys.required("file", file);
      keys.required("rule", name);
      keys.required("text", text);
      keys.required("line", line);
      keys.required("activated", activated);
      keys.required("fired", fired);
      keys.required("conditions", conditions);
      keys.required("ways", ways);
    }
  };
  struct Function {
    std::string file, name, text;
    int line = 0;
    std::int64_t calls = 0;

    template <class Keys>
    void fields(Keys& keys) {
      keys.required("file", file);
      keys.required("function", name);
      keys.required("text", text);
      keys.required("line", line);
      keys.required("calls", calls);
    }
  };

  std::vector<Rule> rules;          ///< by file, line and name; a rule of which there were two texts is there twice
  std::vector<Function> functions;  ///< likewise

  void add(const Coverage& other);

  struct Share {
    std::size_t covered = 0, all = 0;
    /// None of nothing.
    std::optional<double> percent() const {
      return all == 0 ? std::nullopt : std::optional(100.0 * static_cast<double>(covered) / static_cast<double>(all));
    }
  };
  Share fired() const;       ///< rules that fired
  Share conditions() const;  ///< conditions that a partial match got past
  Share called() const;      ///< deffunctions that were called

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("rules", rules);
    keys.required("functions", functions);
  }
};

/// The coverage of the rules and functions that were read from files. `name` gives the name of a file from the one that
/// the engine knows.
Coverage coverage_of(const EngineCounts& counts, const std::function<std::string(const std::string&)>& name);

/// The conditions that a join of CLIPS stands for; number 0 where they are not known.
struct JoinLabel {
  int number = 0;  ///< of the first of them in the rule, from 1
  int line = 0;
  std::string text;
};
/// The labels of each join of each disjunct.
std::vector<std::vector<JoinLabel>> join_labels(const RuleCounts& rule);

/// A line for each rule that never fired, each condition of others that nothing got past, and each function that nobody
/// called; then the sums.
std::string text_of(const Coverage& coverage);

}  // namespace cxlab::explain
