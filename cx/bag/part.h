#pragma once
// The part of a bag that belongs to one topic, service or action, and how it reaches the bus. Only for bag_server.cpp
// and the parts.

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cx/bag/recording.h"
#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/bus/cdr.h"

namespace cxlab::bag {

/// What all parts share.
struct Playing {
  bus::Bus& bus;
  std::function<void(bool warning, const std::string& text)> log;
  bus::ParticipantId self{};
  std::vector<bus::ParticipantId> beside = {};  ///< whose messages come in addition to those of the bag: stimuli
  std::vector<std::string> warnings = {};       ///< for the result
  SimTime first{};                              ///< of the recording, since 1970
  std::uint64_t turn = 0;                       ///< counts the ticks in which the bag is played

  void warn(const std::string& text) {
    log(true, text);
    warnings.push_back(text);
  }
  /// Agents join after the bag; the world and nodes beside it before.
  bool is_agent(bus::ParticipantId p) const { return p > self; }
};

/// Who answers under the name of a service or an action in this run, and thus what the bag does there.
enum class Role {
  kServer,  ///< nobody else: the bag answers what agents ask, as in the recording
  kClient,  ///< an agent: the bag asks what was asked in the recording
  kNone     ///< the world or a node; or an agent, which asks itself
};

class Part {
 public:
  Part(Playing& playing, std::string name) : playing_(playing), name_(std::move(name)) {}
  virtual ~Part() = default;
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  const std::string& name() const { return name_; }
  virtual const char* noun() const = 0;  ///< "topic", "service", "action"
  /// Joins the bus where it must be there before agents are; kInput if the name has another type.
  virtual Status open() { return {}; }
  /// Whether it is played as things stand now; else why not.
  virtual std::string why_left_out() = 0;
  /// A message of that topic of the bag, whose time has come. kInput if its bytes are not those of its type.
  virtual Status take(const Topic& topic, std::string_view bytes) = 0;
  /// One from before the moment at which playing starts, of a topic that keeps its last message.
  virtual void hold(std::string_view) {}
  /// Once a tick, after all messages.
  virtual Status tend() { return {}; }
  /// Adds what the run has left open so far.
  virtual void open_ends(std::vector<std::string>&) const {}

 protected:
  /// Reports that it is left out, once.
  void note_left_out(const std::string& why) {
    if (noted_) return;
    noted_ = true;
    playing_.log(false, name_ + " is left out from now on: " + why);
  }
  Role role_of(bus::NameKind kind, std::string& why) const;
  void keep_quiet() { noted_ = true; }
  friend class BagServer;

  Playing& playing_;
  std::string name_;

 private:
  bool noted_ = false;
};

/// Which types of the events of a service are used: those of the server where they were recorded, because only they
/// are of all clients; else those of the client.
struct EventKinds {
  std::uint8_t request = 0, response = 3;
  bool has_requests = false, has_responses = false;
  explicit EventKinds(std::uint8_t mask = 0);
  /// Whether requests come from the client and responses from the server, or the other way round. The two may number
  /// the same request differently (ros2/rmw#357), so only the order tells which response belongs to it.
  bool of_two_sides() const { return (request == 0) != (response == 3); }
};

/// The head of a service event; the readers are called with what was sent, where it is there.
struct ServiceEvent {
  std::uint8_t kind = 0;
  std::string client;  ///< 16 bytes
  std::int64_t number = 0;
  bool has_request = false, has_response = false;
};
using ReadPart = std::function<void(bus::CdrReader&)>;
Expected<ServiceEvent> read_service_event(std::string_view bytes, const ReadPart& request, const ReadPart& response);

std::unique_ptr<Part> make_topic_part(Playing& playing, const std::string& name, const bus::MessageType& type, bool own,
                                      bool latched);
std::unique_ptr<Part> make_service_part(Playing& playing, const std::string& name, const bus::ServiceType& type,
                                        std::uint8_t events);

/// What the bag has of an action.
struct ActionTopics {
  bool feedback = false, status = false;
  std::uint8_t send_goal = 0, get_result = 0, cancel_goal = 0;  ///< events
};
std::unique_ptr<Part> make_action_part(Playing& playing, const std::string& name, const bus::ActionType& type,
                                       const ActionTopics& topics);

// The ends of the names of an action's topics.
inline constexpr std::string_view kFeedbackTopic = "/_action/feedback", kStatusTopic = "/_action/status",
                                  kSendGoalEvents = "/_action/send_goal/_service_event",
                                  kGetResultEvents = "/_action/get_result/_service_event",
                                  kCancelGoalEvents = "/_action/cancel_goal/_service_event";

}  // namespace cxlab::bag
