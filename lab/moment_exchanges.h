#pragma once
// The goals and requests of one environment of a recorded run, and the answers that they met.

#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/bus/bus.h"
#include "cx/journal/journal_record.h"

namespace cxlab::lab {

/// A goal or request, and how it ended. Messages are JSON.
struct Exchange {
  std::string id;  ///< of the goal, or the number of the request
  SimTime sent{};
  std::optional<SimTime> ended = {};
  std::string outcome = "never", result = {};                  ///< as in a story
  std::vector<std::pair<SimTime, std::string>> feedback = {};  ///< after the moment
  std::string handle = {};                                     ///< of a goal that was accepted before the moment
};

/// The name as rules write it, with a slash before it: what an environment with that node sent has the name on the bus.
std::string name_in_rules(const JournalRecord& record, const bus::NodeName& node);
/// The message below that key of a record, as JSON; empty if there is none.
std::string message_of(const JournalRecord& record, const char* key);

class MomentExchanges {
 public:
  /// Those of one action or service, in order of sending, without those that ended by the moment.
  using List = std::list<Exchange>;
  using ByName = std::map<std::string, List>;

  /// Reads the answers that the environment of that stream took, which is one of that node. `hear` follows.
  static Expected<MomentExchanges> read(const std::filesystem::path& inputs, std::string_view stream,
                                        const bus::NodeName& node, SimTime moment);

  /// Takes the records of the environment in their order. Whether it is an answer.
  bool hear(const JournalRecord& record);

  const ByName& actions() const { return actions_; }
  const ByName& services() const { return services_; }
  bool is_under_way(const Exchange& one) const { return one.sent <= moment_; }
  bool any_under_way(const List& list) const;
  /// The number of the next request to that service at the moment.
  std::int64_t next_request(const std::string& service) const;
  /// Actions and services that rules found without a server after the moment, and when first.
  const std::map<std::string, SimTime>& without_server() const { return without_server_; }
  /// The fact with `?` in the place of ids of goals, which are others in a story.
  std::string without_ids(std::string fact) const;

 private:
  /// What the bus knows of an answer, and its record in the journal does not say.
  struct Logged {
    std::string id;  ///< as in `Exchange`
    bool accepted = false;
    bus::GoalStatus status{};
  };

  void sent(const JournalRecord& record);
  bool answered(const JournalRecord& record);
  void accepted(const JournalRecord& record);
  void looked(const JournalRecord& record);

  bus::NodeName node_;
  SimTime moment_{};
  std::map<std::pair<std::string, std::uint64_t>, Logged> logged_;  // by the record of the post
  ByName actions_, services_;
  std::map<std::string, std::int64_t> next_;  // number of a request
  std::map<std::string, SimTime> without_server_;
  Exchange* accepted_ = nullptr;  // its handle is in the fact that comes next
};

}  // namespace cxlab::lab
