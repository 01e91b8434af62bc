#pragma once
// The way into an environment for threads of a plugin. Their requests wait in a queue that the environment reads when
// it perceives. Each request is then a delivery on the bus like any other, so it is in the input log and replays.
//
//   gate_ = environment->open_gate(name());  // in clips_env_init
//   auto fact = gate_->assert_fact("(scan)").get();  // on the plugin's thread: waits for the tick
//
// A run with a gate is not deterministic.

#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"
#include "cx/engine/value.h"

namespace cxlab::cx {

class Environment;

class ThreadGate {
 public:
  /// The answer to a request, available after the tick. It may be dropped without waiting.
  using Answer = std::future<Expected<Value>>;
  /// At most so many requests wait for a tick; more are answered with an error at once.
  static constexpr std::size_t kMostWaiting = 10'000;

  // --- For any thread but the episode's, where the answer is an error: use the environment itself there. Once the
  // plugin is unloaded all answers are errors, those that wait included.
  Answer assert_fact(const std::string& fact);  ///< "(hello (a 1))": its index
  Answer retract(std::int64_t index);           ///< TRUE, FALSE if there is no such fact
  Answer call(const std::string& expression);   ///< "(f 1 2)" of rules or plugins: its value
  Answer publish(const std::string& topic, const std::string& type, const std::string& yaml);  ///< void

  // --- For the environment
  ThreadGate(Environment& environment, std::string owner, std::string topic);
  ~ThreadGate();
  ThreadGate(const ThreadGate&) = delete;
  ThreadGate& operator=(const ThreadGate&) = delete;
  Status open();
  const std::string& owner() const { return owner_; }
  /// Posts the waiting requests on the bus.
  void hand_over();
  /// Answers all requests with an error, those that wait and later ones.
  void close();

 private:
  struct Request {
    std::uint64_t id = 0;
    std::string verb, text, type, content;
  };
  Answer ask(Request request);
  void carry_out(const bus::Delivery& delivery);
  Expected<Value> do_verb(const bus::MessageView& request);
  Status publish_now(const std::string& topic, const std::string& type, const std::string& yaml);

  Environment& environment_;
  const std::string owner_, topic_;
  const bus::MessageType* type_ = nullptr;
  bus::ParticipantId node_{};
  bus::EndpointId out_{}, in_{};
  std::map<std::pair<std::string, std::string>, bus::EndpointId>
      publishers_;  // of the environment, for `publish`: by topic and type

  std::mutex mutex_;  // guards what follows
  bool open_ = false;
  std::uint64_t last_id_ = 0;
  std::vector<Request> waiting_;
  std::map<std::uint64_t, std::promise<Expected<Value>>> asked_;
};

}  // namespace cxlab::cx
