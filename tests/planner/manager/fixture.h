#pragma once
// A PDDL manager on a bus, and a client of its services.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "planner/manager/manager.h"
#include "tests/support/files.h"
#include "tests/support/test_bus.h"

namespace cxlab::planner {

/// The end of a planning goal, as the client sees it.
struct Answer {
  double time = -1;  ///< s
  bus::GoalStatus status{};
  bool success = false;
  std::vector<std::string> actions;  ///< "0 pick-up(c) @0+2 class 0"
};

class ManagerTest : public ::testing::Test, protected bus::TestBus {
 protected:
  ManagerTest() { client_ = join(bus::ParticipantKind::kEnvironment, "agent"); }

  static std::string blocks_folder() { return (source_dir() / "docs/examples/blocksworld/pddl").string(); }

  void start(PddlManagerOptions options = {}) {
    auto made = PddlManager::create(std::move(options), bus_, sink_);
    ASSERT_TRUE(made.ok()) << made.error().text();
    manager_ = *std::move(made);
  }

  void tick() {
    now_ += SimTime{20'000'000};
    bus_.begin_tick(now_);
    const Status sensed = manager_->sense(now_), done = [&] {
      bus_.deliver(client_);
      return manager_->act(now_);
    }();
    ASSERT_TRUE(sensed.ok() && done.ok());
  }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }

  /// Asks and waits; `type` is below `package`, the request YAML.
  bus::Message ask(const std::string& name, const std::string& type, const std::string& request,
                   const std::string& package = "cx_pddl_interfaces") {
    const bus::ServiceType& service = **registry_.service(package + "/srv/" + type);
    bus::Message answer(*service.response);
    auto made = bus_.create_client(client_, "/pddl_manager/" + name, service,
                                   [&](const bus::Delivery& d) { answer = *d.message; });
    EXPECT_TRUE(made.ok()) << made.error().text();
    auto message = bus::Message::from_yaml(*service.request, request);
    EXPECT_TRUE(message.ok()) << message.error().text();
    bus_.call(*made, std::make_shared<bus::Message>(*std::move(message)));
    ticks(2);
    bus_.remove(*made);
    return answer;
  }
  void request(const std::string& name, const std::string& type, const std::string& request) {
    const bus::Message answer = ask(name, type, request);
    EXPECT_EQ(answer->integer("success"), 1) << name << ": " << answer->text("error");
  }
  std::string error_of(const std::string& name, const std::string& type, const std::string& request) {
    const bus::Message answer = ask(name, type, request);
    EXPECT_EQ(answer->integer("success"), 0);
    return answer->text("error");
  }

  void load_blocks() {
    request("add_pddl_instance", "AddPddlInstance",
            "{name: bw, directory: \"" + blocks_folder() + "\", domain_file: domain.pddl, problem_file: problem.pddl}");
  }
  /// The same with a problem given as text.
  void load_blocks(const std::string& problem) {
    std::ofstream(folder_ / "blocks.pddl") << problem;
    std::filesystem::copy_file(blocks_folder() + "/domain.pddl", folder_ / "domain.pddl",
                               std::filesystem::copy_options::overwrite_existing);
    request("add_pddl_instance", "AddPddlInstance",
            "{name: bw, directory: \"" + folder_.string() + "\", domain_file: domain.pddl, problem_file: blocks.pddl}");
  }
  /// An instance `x` of a domain and a problem given as text.
  void load_text(const std::string& domain, const std::string& problem) {
    std::ofstream(folder_ / "d.pddl") << domain;
    std::ofstream(folder_ / "p.pddl") << problem;
    request("add_pddl_instance", "AddPddlInstance",
            "{name: x, directory: \"" + folder_.string() + "\", domain_file: d.pddl, problem_file: p.pddl}");
  }

  static std::vector<std::string> texts(const bus::MessageView& message, std::string_view field) {
    std::vector<std::string> out;
    const bus::Field& f = *message.type().find(field);
    for (std::size_t i = 0; i < message.size(f); ++i) out.push_back(message.text(f, i));
    return out;
  }
  static std::string called(const bus::MessageView& m) {
    std::string text = m.text("name") + "(";
    for (const std::string& arg : texts(m, "args")) text += (text.back() == '(' ? "" : " ") + arg;
    return text + ")";
  }
  std::vector<std::string> fluents(const std::string& instance) {
    const bus::Message answer = ask("get_fluents", "GetFluents", "{pddl_instance: " + instance + "}");
    std::vector<std::string> out;
    for (std::size_t i = 0; i < answer->size("fluents"); ++i) out.push_back(called(answer->nested("fluents", i)));
    return out;
  }
  /// `sat`, or the conditions that do not hold.
  std::vector<std::string> check(const std::string& action, const std::string& name = "check_action_condition",
                                 const std::string& type = "CheckActionCondition",
                                 const std::string& package = "cx_pddl_interfaces", const std::string& more = "") {
    const bus::Message answer = ask(name, type, "{action: " + action + more + "}", package);
    EXPECT_EQ(answer->integer("success"), 1) << answer->text("error");
    return answer->integer("sat") ? std::vector<std::string>{"sat"} : texts(answer.view(), "unsatisfied_conditions");
  }
  /// "START +on(a b)", "END (moves) + 1"
  std::vector<std::string> effects(const std::string& action) {
    const bus::Message answer = ask("get_action_effects", "GetActionEffects", "{action: " + action + "}");
    std::vector<std::string> out;
    if (!answer->integer("success")) return {answer->text("error")};
    for (std::size_t i = 0; i < answer->size("fluent_effects"); ++i) {
      const bus::MessageView e = answer->nested("fluent_effects", i);
      out.push_back(e.text("time_point") + (e.integer("value") ? " +" : " -") + called(e.nested("fluent")));
    }
    for (std::size_t i = 0; i < answer->size("function_effects"); ++i) {
      const bus::MessageView e = answer->nested("function_effects", i);
      char number[32];
      std::snprintf(number, sizeof number, "%g", e.real("value"));
      out.push_back(e.text("time_point") + ' ' + called(e.nested("function")) + ' ' + e.text("operator_type") + ' ' +
                    number);
      EXPECT_EQ(e.nested("function").real("value"), e.real("value"));
    }
    return out;
  }

  /// Sends a planning goal; its end is in the answer that is returned.
  std::shared_ptr<Answer> plan(const std::string& goal, const std::string& package = "cx_pddl_interfaces") {
    const bus::ActionType& type = **registry_.action(package + "/action/PlanTemporal");
    auto answer = std::make_shared<Answer>();
    bus::Bus::ActionClientHandlers handlers;
    handlers.result = [this, answer](const bus::Delivery& d) {
      answer->time = to_seconds(now_);
      answer->status = d.status;
      const bus::MessageView result = d.message->view();
      answer->success = result.integer("success") != 0;
      for (std::size_t i = 0; i < result.size("actions"); ++i) {
        const bus::MessageView a = result.nested("actions", i);
        char text[96];
        std::snprintf(text, sizeof text, " @%.2f+%g class %d", a.real("start_time"), a.real("duration"),
                      static_cast<int>(a.integer("equiv_class")));
        answer->actions.push_back(called(a) + text);
      }
    };
    auto made = bus_.create_action_client(client_, "/pddl_manager/temp_plan", type, std::move(handlers));
    EXPECT_TRUE(made.ok()) << made.error().text();
    auto message = bus::Message::from_yaml(*type.goal, goal);
    EXPECT_TRUE(message.ok()) << message.error().text();
    last_client_ = *made;
    last_goal_ = bus_.send_goal(*made, std::make_shared<bus::Message>(*std::move(message)));
    return answer;
  }

  /// The messages of a topic from now on, as text.
  std::shared_ptr<std::vector<std::string>> listen(const std::string& topic, const std::string& type) {
    auto received = std::make_shared<std::vector<std::string>>();
    auto made = bus_.subscribe(client_, topic, **registry_.message(type), [received](const bus::Delivery& d) {
      received->push_back(d.message->view().to_string());
    });
    EXPECT_TRUE(made.ok());
    return received;
  }

  bus::ParticipantId client_{};
  std::unique_ptr<PddlManager> manager_;
  TempFolder temp_;
  const std::filesystem::path folder_ = temp_.path();
  SimTime now_{};
  bus::EndpointId last_client_{};
  bus::GoalId last_goal_{};
};

}  // namespace cxlab::planner
