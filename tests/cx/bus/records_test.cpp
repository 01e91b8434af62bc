// All that the bus records and delivers, in one exchange between an environment and a robot.

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "cx/journal/record_bytes.h"
#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

/// Writes what is delivered: the kind by its place in DeliveryKind, then every part that is not as in a new Delivery,
/// goals by the order of their sending.
class RecordsTest : public BusTest {
 protected:
  Handler hears(const std::string& who) {
    return [this, who](const Delivery& d) { log_.push_back(who + ' ' + text_of(d)); };
  }
  std::string text_of(const Delivery& d) {
    std::ostringstream out;
    out << static_cast<int>(d.kind) << " from " << static_cast<unsigned>(d.from) << " seq " << d.sequence;
    if (d.request_id != 0) out << " request " << d.request_id;
    if (d.goal != GoalId{}) out << " goal " << number(d.goal);
    if (d.accepted) out << " accepted";
    if (d.status != GoalStatus{}) out << " status " << static_cast<int>(d.status);
    if (d.return_code != 0) out << " code " << static_cast<int>(d.return_code);
    if (d.stamp == kNever)
      out << " stamp never";
    else if (d.stamp != SimTime{})
      out << " stamp " << d.stamp.count();
    for (const auto& [goal, at] : d.goals_canceling) out << " cancels " << number(goal) << '@' << at.count();
    if (d.message) out << ' ' << d.message->view().to_string();
    out << " by " << sink_.names()[static_cast<std::size_t>(d.cause.stream)] << ':' << d.cause.n;
    return out.str();
  }
  std::string number(const GoalId& goal) const {
    const auto at = std::ranges::find(goals_, goal);
    return at == goals_.end() ? "?" : "G" + std::to_string(at - goals_.begin() + 1);
  }
  GoalId send(EndpointId client) {
    static constexpr RecordRef kCause{StreamId{0}, 0};
    Message goal(*fibonacci_->goal);
    goal->set("order", 3);
    goals_.push_back(bus_.send_goal(client, std::make_shared<Message>(goal), {&kCause, 1}));
    return goals_.back();
  }
  /// The records since the last call, a line each: the stream, ms, the data, causes.
  std::vector<std::string> recorded() {
    std::vector<std::string> lines;
    for (const KeptRecords::Record& r : sink_.all()) {
      EXPECT_EQ(r.kind, RecordKind::kBus);
      std::string line =
          sink_.names()[static_cast<std::size_t>(r.stream)] + ' ' + std::to_string(r.t.count() / 1000000) + ' ';
      EXPECT_TRUE(append_json(r.data, line).ok());
      for (std::size_t i = 0; i < goals_.size(); ++i)
        for (std::size_t at; (at = line.find(to_string(goals_[i]))) != std::string::npos;)
          line.replace(at, 32, "G" + std::to_string(i + 1));
      for (const RecordRef& cause : r.causes)
        line += ' ' + sink_.names()[static_cast<std::size_t>(cause.stream)] + ':' + std::to_string(cause.n);
      lines.push_back(std::move(line));
    }
    sink_.forget();
    return lines;
  }

  std::vector<GoalId> goals_;
};

using Lines = std::vector<std::string>;

TEST_F(RecordsTest, OfTopicsAndServices) {
  const auto env = environment("env"), robot = node("robot");
  const auto out = advertise(robot, "t");
  const auto in = *bus_.subscribe(env, "t", *string_, hears("env"));
  EndpointId service{};
  service = *bus_.serve(robot, "switch", *set_bool_, [&](const Delivery& d) {
    log_.push_back("robot " + text_of(d));
    EXPECT_TRUE(bus_.respond(service, d, blank(*set_bool_->response)));
    EXPECT_FALSE(bus_.respond(service, d, blank(*set_bool_->response)));
  });
  const auto client = *bus_.create_client(env, "switch", *set_bool_, hears("env"));
  tick();
  const RecordRef cause{StreamId{1}, 1};
  EXPECT_EQ(recorded(), (Lines{R"(env 0 {"op":"join","name":"/env"})", R"(robot 0 {"op":"join","name":"/robot"})",
                               R"(robot 0 {"op":"advertise","name":"/t","type":"std_msgs/msg/String"})",
                               R"(env 0 {"op":"subscribe","name":"/t","type":"std_msgs/msg/String"})",
                               R"(robot 0 {"op":"serve","name":"/switch","type":"std_srvs/srv/SetBool"})",
                               R"(env 0 {"op":"client","name":"/switch","type":"std_srvs/srv/SetBool"})"}));
  bus_.publish(out, text("hello"), {&cause, 1});
  EXPECT_EQ(bus_.call(client, blank(*set_bool_->request), {&cause, 1}), 1u);
  EXPECT_EQ(bus_.call(client, blank(*set_bool_->request)), 2u);
  bus_.deliver(robot);
  tick();
  bus_.deliver(env);
  EXPECT_EQ(taken(), (Lines{R"(robot 3 from 0 seq 1 request 1 {data: false} by env:3)",
                            R"(robot 3 from 0 seq 2 request 2 {data: false} by env:4)",
                            R"(env 0 from 1 seq 2 request 1 {success: false, message: ""} by robot:4)",
                            R"(env 0 from 1 seq 3 request 2 {success: false, message: ""} by robot:5)",
                            R"(env 8 from 1 seq 1 {data: "hello"} by robot:3)"}));
  EXPECT_EQ(
      recorded(),
      (Lines{
          R"(robot 20 {"op":"publish","name":"/t","seq":1,"msg":{"data":"hello"}} robot:1)",
          R"(env 20 {"op":"call","name":"/switch","seq":1,"id":1,"request":{"data":false}} robot:1)",
          R"(env 20 {"op":"call","name":"/switch","seq":2,"id":2,"request":{"data":false}})",
          R"(robot 20 {"op":"respond","name":"/switch","seq":2,"id":1,"response":{"success":false,"message":""}} env:3)",
          R"(robot 20 {"op":"respond","name":"/switch","seq":3,"id":2,"response":{"success":false,"message":""}} env:4)"}));
  bus_.remove(in);
  bus_.leave(robot);
  bus_.leave(robot);
  EXPECT_EQ(recorded(),
            (Lines{R"(env 40 {"op":"remove","name":"/t"})", R"(robot 40 {"op":"remove","name":"/t"})",
                   R"(robot 40 {"op":"remove","name":"/switch"})", R"(robot 40 {"op":"leave","name":"/robot"})"}));
}

TEST_F(RecordsTest, OfActions) {
  const auto env = environment("env"), robot = node("robot");
  const auto client =
      *bus_.create_action_client(env, "fib", *fibonacci_, {hears("env"), hears("env"), hears("env"), hears("env")});
  std::vector<Delivery> cancels;
  const auto server = *bus_.serve_action(robot, "fib", *fibonacci_, {hears("robot"), [&](const Delivery& d) {
                                                                       log_.push_back("robot " + text_of(d));
                                                                       cancels.push_back(d);
                                                                     }});
  tick();
  recorded();
  const auto both = [&] {
    bus_.deliver(robot);
    bus_.deliver(env);
  };
  const GoalId first = send(client), second = send(client), third = send(client);
  both();
  EXPECT_TRUE(bus_.answer_goal(server, first, GoalAnswer::kAccept));
  EXPECT_TRUE(bus_.answer_goal(server, third, GoalAnswer::kReject));
  tick();
  EXPECT_TRUE(bus_.answer_goal(server, second, GoalAnswer::kDefer));
  EXPECT_TRUE(bus_.execute(server, second));
  EXPECT_TRUE(bus_.publish_feedback(server, first, blank(*fibonacci_->feedback)));
  both();
  EXPECT_EQ(taken(), (Lines{R"(robot 4 from 0 seq 1 goal G1 {order: 3} by env:2)",
                            R"(robot 4 from 0 seq 2 goal G2 {order: 3} by env:3)",
                            R"(robot 4 from 0 seq 3 goal G3 {order: 3} by env:4)",
                            R"(env 1 from 1 seq 1 goal G1 accepted status 2 stamp 20000000 by robot:2)",
                            R"(env 1 from 1 seq 2 goal G3 by robot:3)",
                            R"(env 1 from 1 seq 3 goal G2 accepted status 1 stamp 40000000 by robot:4)",
                            R"(env 6 from 1 seq 4 goal G1 status 2 {sequence: []} by robot:6)"}));
  EXPECT_EQ(
      recorded(),
      (Lines{R"(env 20 {"op":"goal","name":"/fib","seq":1,"goal_id":"G1","goal":{"order":3}} env:0)",
             R"(env 20 {"op":"goal","name":"/fib","seq":2,"goal_id":"G2","goal":{"order":3}} env:0)",
             R"(env 20 {"op":"goal","name":"/fib","seq":3,"goal_id":"G3","goal":{"order":3}} env:0)",
             R"(robot 20 {"op":"accept","name":"/fib","seq":1,"goal_id":"G1"} env:2)",
             R"(robot 20 {"op":"reject","name":"/fib","seq":2,"goal_id":"G3"} env:4)",
             R"(robot 40 {"op":"accept","name":"/fib","seq":3,"goal_id":"G2"} env:3)",
             R"(robot 40 {"op":"execute","name":"/fib","goal_id":"G2"} env:3)",
             R"(robot 40 {"op":"feedback","name":"/fib","seq":4,"goal_id":"G1","feedback":{"sequence":[]}} env:2)"}));

  const RecordRef cause{StreamId{0}, 1};
  bus_.cancel_goal(client, third, {&cause, 1});
  bus_.cancel_goal(client, second, {&cause, 1});
  both();
  ASSERT_EQ(cancels.size(), 1u);
  EXPECT_TRUE(bus_.answer_cancel(server, cancels[0], false));
  bus_.cancel_goals_before(client, SimTime{20'000'000}, {&cause, 1});
  tick();
  both();
  ASSERT_EQ(cancels.size(), 2u);
  EXPECT_TRUE(bus_.answer_cancel(server, cancels[1], true));
  EXPECT_TRUE(bus_.finish(server, first, GoalStatus::kCanceled, blank(*fibonacci_->result)));
  bus_.cancel_all_goals(client, {&cause, 1});
  both();
  ASSERT_EQ(cancels.size(), 3u);
  EXPECT_TRUE(bus_.finish(server, second, GoalStatus::kAborted, blank(*fibonacci_->result)));
  EXPECT_TRUE(bus_.answer_cancel(server, cancels[2], true));
  tick();
  bus_.cancel_goal(client, second, {&cause, 1});
  both();
  EXPECT_EQ(taken(),
            (Lines{R"(robot 5 from 0 seq 5 request 2 goal G2 stamp never by env:6)",
                   R"(env 2 from 1 seq 5 goal G3 code 2 by robot:7)",
                   R"(robot 5 from 0 seq 6 request 3 goal G1 stamp 20000000 by env:7)",
                   R"(env 2 from 1 seq 6 goal G2 code 1 by robot:8)",
                   R"(robot 5 from 0 seq 7 request 4 goal G2 stamp never by env:8)",
                   R"(env 2 from 1 seq 7 cancels G1@20000000 by robot:9)",
                   R"(env 7 from 1 seq 8 goal G1 status 5 {sequence: []} by robot:10)",
                   R"(env 2 from 1 seq 10 code 1 by robot:12)", R"(env 2 from 1 seq 11 goal G2 code 3 by robot:13)",
                   R"(env 7 from 1 seq 9 goal G2 status 6 {sequence: []} by robot:11)"}));
  EXPECT_EQ(
      recorded(),
      (Lines{
          R"(env 40 {"op":"cancel","name":"/fib","seq":4,"goal_id":"G3"} env:1)",
          R"(env 40 {"op":"cancel","name":"/fib","seq":5,"goal_id":"G2"} env:1)",
          R"(robot 40 {"op":"cancel_response","name":"/fib","seq":5,"code":2,"canceling":[]} env:5)",
          R"(robot 40 {"op":"cancel_response","name":"/fib","seq":6,"code":1,"canceling":[]} env:6)",
          R"(env 40 {"op":"cancel","name":"/fib","seq":6,"not_after":20000000} env:1)",
          R"(robot 60 {"op":"cancel_response","name":"/fib","seq":7,"code":0,"canceling":["G1"]} env:7)",
          R"(robot 60 {"op":"result","name":"/fib","seq":8,"goal_id":"G1","status":5,"result":{"sequence":[]}} env:2)",
          R"(env 60 {"op":"cancel","name":"/fib","seq":7} env:1)",
          R"(robot 60 {"op":"result","name":"/fib","seq":9,"goal_id":"G2","status":6,"result":{"sequence":[]}} env:3)",
          R"(robot 60 {"op":"cancel_response","name":"/fib","seq":10,"code":1,"canceling":[]} env:8)",
          R"(env 80 {"op":"cancel","name":"/fib","seq":8,"goal_id":"G2"} env:1)",
          R"(robot 80 {"op":"cancel_response","name":"/fib","seq":11,"code":3,"canceling":[]} env:9)"}));
}

}  // namespace
}  // namespace cxlab::bus
