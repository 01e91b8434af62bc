#pragma once
// Stand-ins for the world: action servers and services that answer as the story says, and ears on topics.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/random.h"
#include "cx/bus/bus.h"
#include "cx/run/parts.h"

namespace cxlab::testing {

/// What a goal says on its way.
struct Feedback {
  SimTime after{};   ///< counts as `Outcome::takes` does
  std::string data;  ///< fields, YAML
  int line = 0;
};

/// How one goal or call ends.
struct Outcome {
  enum class Kind { kSucceed, kFail, kReject, kNever };
  Kind kind = Kind::kSucceed;
  SimTime takes{};     ///< counts from the tick that takes it
  SimTime longest{};   ///< more than `takes`: chance decides between the two
  std::string result;  ///< fields of the result or response, YAML; `success` follows the kind where it is not given
  int line = 0;
  std::vector<Feedback> feedback = {};  ///< in order of time; of goals only

  /// Everything comes later by this.
  void delay(SimTime by) {
    takes += by;
    longest += by;
    for (Feedback& one : feedback) one.after += by;
  }
};

/// A goal or request that was sent before the moment at which facts are given, and is not over then.
struct UnderWay {
  std::string handle;  ///< of the client, as `given` has it: "<Pointer-C-0x10a2>"; empty: the answer to it comes later
  std::string id;      ///< of the goal, as `given` has it; the number of the request
  int line = 0;
};

/// An action server or a service. The k-th goal or call meets the k-th outcome, later ones the last. The first outcomes
/// belong to what is in progress when the story begins.
struct StandIn {
  bool action = true;
  std::string name, type;
  std::vector<Outcome> outcomes;
  std::string file;
  int line = 0;
  std::vector<UnderWay> under_way = {};
  std::int64_t next_id = 0;  ///< number of the agent's next request to the service; 0: as it comes
};

/// What chance does to goals, or to the calls of a service.
struct Fault {
  std::string name;        ///< of the action or service; empty: of all actions
  double probability = 0;  ///< of each goal or call
  std::int64_t most = 0;   ///< how often it strikes at most; 0: no limit
  Outcome outcome;         ///< instead of that of the stand-in
};

/// A goal, call or message that reached a stand-in.
struct Heard {
  enum class Kind { kGoal, kCall, kTopic };
  Kind kind{};
  SimTime t{};
  std::string name;     ///< action, service or topic
  std::string content;  ///< YAML
};

class StandIns final : public Server {
 public:
  /// Chance draws from streams of the seed, one for each fault and each stand-in.
  StandIns(bus::Bus& bus, RecordSink& sink, std::uint64_t seed, std::vector<Fault> faults = {});
  ~StandIns() override;

  /// These faults instead of those before; nothing is served yet.
  void expect(std::vector<Fault> faults);
  /// Serves from now on; a stand-in of that name is replaced (goals that it has taken end as it said).
  Status add(const StandIn& stand_in);
  Status listen(const std::string& topic, const std::string& type, const std::string& file, int line);
  Status publish(const std::string& topic, const std::string& type, const std::string& data, const std::string& file,
                 int line);

  /// Whether a message, service or action has that name.
  bool has_type(const std::string& type) const;
  // Whether content (YAML) fits its type; errors have file and line.
  std::vector<Error> check(const StandIn& stand_in) const;
  /// A message, or a part of one.
  Status check_message(const std::string& topic, const std::string& type, const std::string& content,
                       const std::string& file, int line) const;
  /// A goal of the stand-in, or a part of one. A type that does not exist is no error here: `check` reports it.
  Status check_goal(const StandIn& stand_in, const std::string& content, const std::string& file, int line) const;

  /// The oldest goal that this action has taken and not ended ends now, in that way (succeed, fail); false if there is
  /// none.
  Expected<bool> end_goal(const std::string& action, const Outcome& outcome);

  /// Ends what is due.
  Status sense(SimTime now) override;
  /// Takes what was sent.
  Status act(SimTime now) override;
  SimTime next_due() const override;
  const std::vector<Heard>& heard() const { return heard_; }
  /// Where nobody else uses that topic, service or action: the name of another one that somebody uses, from
  /// which it differs by a slip of the finger; empty if there is none. `unserved`: only a name that nobody serves.
  std::string meant_by(bus::NameKind kind, const std::string& name, bool unserved) const;
  /// Topics that rules publish.
  std::vector<std::string> published() const;

 private:
  struct Served;
  struct Ending;
  struct Answer;
  std::vector<Error> read_types(Served& server) const;
  Expected<bus::Message> read_message(const std::string& topic, const std::string& type, const std::string& content,
                                      const std::string& file, int line) const;
  std::vector<Answer> answers_of(const Served& server, const std::vector<Outcome>& outcomes,
                                 std::vector<Error>& errors) const;
  const Answer& answer(Served& server);
  RandomStream& chance(const std::string& name);
  SimTime duration(const Served& server, const Outcome& outcome);
  void on_goal(Served& server, const bus::Delivery& goal);
  void on_call(Served& server, const bus::Delivery& request);
  /// Whether one of them is another participant.
  bool has_other(const std::vector<bus::ParticipantId>& those) const;

  bus::Bus& bus_;
  bus::ParticipantId self_;
  std::uint64_t seed_;
  std::vector<Fault> faults_;
  std::vector<std::int64_t> struck_;  // how often each fault has
  std::map<std::string, RandomStream> chances_;
  std::map<std::string, std::unique_ptr<Served>> servers_;
  std::map<std::string, bus::EndpointId> publishers_, ears_;
  std::vector<Ending> endings_;  // in order of arrival
  std::vector<Heard> heard_;
};

}  // namespace cxlab::testing
