#pragma once
// What one environment of a recorded run knows at a moment, in the words of a story.

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cx/executive/environment.h"
#include "lab/moment_exchanges.h"

namespace cxlab::cx {
class MessageStore;
}

namespace cxlab::lab {

/// In quotes of YAML, on one line.
std::string yaml_quoted(const std::string& text);

/// Whether it points to a fact or message.
bool has_pointer(const std::string& fact);

/// Whether its template allows its values: those that rules compute are not checked.
bool has_allowed_values(const std::string& fact, const RuleEngine& engine);

class MomentFacts {
 public:
  /// Before the first tick: what the story's agent knows and has by itself.
  void begin(const RuleEngine& engine);
  /// A record of the environment, up to the moment.
  void hear(const JournalRecord& record);
  /// At the moment.
  void read(cx::Environment& environment, const MomentExchanges& exchanges);

  /// Items of `given` and `calls`.
  std::string given() const;
  std::string calls() const;
  /// The things that the story lacks, and why.
  const std::vector<std::string>& lost() const { return lost_; }
  /// The facts that are given, as they were.
  std::vector<std::string> texts() const;

  /// Whether a plugin has a client of that action, and the generic plugin one of that service: a story sends goals and
  /// requests through them.
  bool has_action_client(const std::string& name) const;
  bool has_client(const std::string& service) const;
  /// The name of an action or service as the facts of the plugin have it, by which rules find their client.
  std::string as_written(const std::string& name) const;

 private:
  struct Given {
    std::string text;        // as CLIPS prints it
    std::string name;        // "<Fact-12>"
    std::string expression;  // that asserts it
    bool is_named;           // the expression has to be evaluated, or a later fact points to this one
  };
  std::vector<FactCopy> in_order(std::vector<FactCopy> facts) const;
  bool has_open(const std::string& begin, const std::string& name) const;
  std::string with_messages(const FactCopy& fact, std::string text, const cx::MessageStore& store);
  std::string what_it_lacks(const std::string& fact, const std::vector<std::string>& handles);
  void read_global(const std::string& global, const Value& value, cx::Environment& environment);
  void note_next_symbol(RuleEngine& engine);

  std::map<std::string, std::string> at_the_start_;  // globals with values, and facts
  std::map<std::int64_t, std::uint64_t> changed_;    // by number of the fact: the last record that changed it
  std::vector<Given> given_;
  std::vector<std::string> of_plugin_;                   // facts of the generic plugin
  std::vector<std::string> bound_;                       // actions of which a binding has a client
  std::map<Handle, std::vector<std::string>> messages_;  // calls that make a message for a global
  std::vector<std::string> globals_;                     // calls that set or define them
  std::string setgen_;
  std::vector<std::string> lost_;
};

}  // namespace cxlab::lab
