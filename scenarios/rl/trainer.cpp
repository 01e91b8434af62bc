#include "scenarios/rl/trainer.h"

#include <algorithm>
#include <array>

#include "cx/base/number_text.h"
#include "cx/bus/needed.h"

namespace cxlab::rl {

namespace {

constexpr const char* kPackage = "cx_rl_interfaces";
constexpr SimTime kPatience = std::chrono::seconds(5);  // with an agent that does not serve reset_env, or a space
/// The time after the spaces. CX's trainer first makes its net of them, so that agents of any rate have finished their
/// start.
constexpr SimTime kGetReady = std::chrono::seconds(1);
/// The trainer gives up after so long without an answer, and so long after the agent accepted an action.
constexpr SimTime kHangs = std::chrono::seconds(10), kHangsAtWork = std::chrono::seconds(300);
constexpr SimTime kPoll = std::chrono::milliseconds(100);
/// A robot that was left idle is asked about again.
constexpr SimTime kRest = std::chrono::seconds(1);
constexpr std::int64_t kGiveUp = -1;  // as an action of an RlDecisionMade

/// What CX's trainer asks for before it trains, in its order.
struct Space {
  const char *name, *type;
};
constexpr std::array<Space, 4> kSpaces{{{"get_predefined_observables", "GetPredefinedObservables"},
                                        {"get_observable_predicates", "GetObservablePredicates"},
                                        {"get_predefined_actions", "GetPredefinedActions"},
                                        {"get_observable_actions", "GetObservableActions"}}};

std::vector<std::string> texts_of(const bus::MessageView& message, const char* field) {
  const bus::Field* found = message.type().find(field);
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < message.size(*found); ++i) texts.push_back(message.text(*found, i));
  return texts;
}

/// The elements of an array of Observation or Action, as texts.
std::vector<std::string> grounded_of(const bus::MessageView& message, const char* field) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < message.size(field); ++i) {
    const bus::MessageView item = message.nested(field, i);
    texts.push_back(grounded(item.text("name"), texts_of(item, "params")));
  }
  return texts;
}

std::string joined(const std::vector<std::string>& texts) {
  std::string state;
  for (const std::string& one : texts) state += (state.empty() ? "" : " ") + one;
  return state;
}

std::string state_of(const bus::MessageView& message, const char* field) {
  std::vector<std::string> all = grounded_of(message, field);
  std::sort(all.begin(), all.end());
  return joined(all);
}

}  // namespace

std::string grounded(const std::string& name, const std::vector<std::string>& params) {
  std::string text = name + '(';
  for (std::size_t i = 0; i < params.size(); ++i) text += (i > 0 ? "#" : "") + params[i];
  return text + ')';
}

/// Endpoints, with the types of their requests.
struct Trainer::Clients {
  struct Service {
    bus::EndpointId endpoint{};
    const bus::ServiceType* type = nullptr;
  };
  struct Goal {
    bus::EndpointId endpoint{};
    const bus::ActionType* type = nullptr;
  };
  Service observations, actions, episode_end, end_training;  // of the agent
  Service status, selection;                                 // of this node
  std::array<Service, kSpaces.size()> spaces;                // of the agent
  Service objects;                                           // of the agent: of a type
  Goal reset, free_robot, select;
  bus::EndpointId decisions{}, spaces_topic{}, made{};  // with the policy `external`
  const bus::MessageType *decision = nullptr, *spaces_message = nullptr;
};

Trainer::Trainer(TrainerOptions options, bus::Bus& bus, RecordSink& sink)
    : options_(std::move(options)),
      bus_(bus),
      sink_(sink),
      stream_(sink.open_stream("node" + options_.node.full_name())),
      node_(bus.join(bus::ParticipantKind::kNode, options_.node, stream_)),
      clients_(std::make_unique<Clients>()),
      chance_(options_.seed, "node" + options_.node.full_name()),
      table_(options_.model.value_or(QTable(options_.rates))),
      table_text_("episode,steps,reward,end\n") {}

Trainer::~Trainer() { bus_.leave(node_); }

Expected<std::unique_ptr<Trainer>> Trainer::create(TrainerOptions options, bus::Bus& bus, RecordSink& sink) {
  auto made = std::unique_ptr<Trainer>(new Trainer(std::move(options), bus, sink));
  Trainer& self = *made;
  Clients& c = *self.clients_;
  Status failed;
  const auto type = [&](const char* name) -> const bus::ServiceType* {
    auto found = bus::needed_service(bus.registry(), std::string(kPackage) + "/srv/" + name);
    if (!found && failed) failed = found.error();
    return found ? *found : nullptr;
  };
  const auto client = [&](Clients::Service& to, const char* name, const char* of, auto answered) {
    to.type = type(of);
    if (!to.type) return;
    auto opened = bus.create_client(self.node_, std::string("~/") + name, *to.type, std::move(answered));
    if (opened)
      to.endpoint = *opened;
    else if (failed)
      failed = opened.error();
  };
  const auto server = [&](Clients::Service& to, const char* name, const char* of, auto asked) {
    to.type = type(of);
    if (!to.type) return;
    auto opened = bus.serve(self.node_, std::string("~/") + name, *to.type, std::move(asked));
    if (opened)
      to.endpoint = *opened;
    else if (failed)
      failed = opened.error();
  };
  const auto action = [&](Clients::Goal& to, const char* name, const char* of, bus::Handler result,
                          bus::Handler rejected) {
    auto found = bus::needed_action(bus.registry(), std::string(kPackage) + "/action/" + of);
    if (!found) {
      if (failed) failed = found.error();
      return;
    }
    to.type = *found;
    bus::Bus::ActionClientHandlers handlers;
    handlers.goal_response = [&self, rejected = std::move(rejected)](const bus::Delivery& d) {
      if (!d.accepted) return rejected(d);
      self.wait_.at_work = true;
      self.wait_.since = self.bus_.now();
      self.accepted(d.goal);
    };
    handlers.feedback = [&self](const bus::Delivery&) { self.wait_.since = self.bus_.now(); };
    handlers.result = std::move(result);
    handlers.cancel_response = [](const bus::Delivery&) {};
    auto opened = bus.create_action_client(self.node_, std::string("~/") + name, **found, std::move(handlers));
    if (opened)
      to.endpoint = *opened;
    else if (failed)
      failed = opened.error();
  };
  using D = bus::Delivery;
  server(c.status, "get_status", "GetStatus", [&self](const D& d) { self.answer_status(d); });
  server(c.selection, "exec_action_selection", "ExecActionSelection",
         [&self](const D& d) { self.answer_selection(d); });
  client(c.observations, "get_current_observations", "GetObservations", [&self](const D& d) {
    const std::uint64_t search = self.observations_.front();
    self.observations_.pop_front();
    if (search == self.search_) self.observed(*d.message);
  });
  client(c.actions, "get_action_list_executable_for_robot", "GetActionListRobot", [&self](const D& d) {
    const std::uint64_t search = self.lists_.front();
    self.lists_.pop_front();
    if (search == self.search_) self.choose(*d.message);
  });
  client(c.episode_end, "get_episode_end", "GetEpisodeEnd", [&self](const D& d) {
    const std::uint64_t phase = self.ends_.front();
    self.ends_.pop_front();
    const bus::MessageView answer = *d.message;
    if (phase == self.phase_) self.ended(answer.integer("episode_end") != 0, answer.integer("reward"));
  });
  for (std::size_t i = 0; i < kSpaces.size(); ++i)
    client(c.spaces[i], kSpaces[i].name, kSpaces[i].type, [&self](const D& d) { self.take_space(*d.message); });
  client(c.objects, "get_observable_objects", "GetObservableObjects",
         [&self](const D& d) { self.take_space(*d.message); });
  client(c.end_training, "end_training", "EndTraining", [](const D&) {});
  action(
      c.reset, "reset_env", "ResetEnv",
      [&self](const D& d) {
        if (d.status == bus::GoalStatus::kSucceeded) return self.observe();
        self.failure_ = run_error("reset_env of episode " + std::to_string(self.episode_ + 1) + " was not carried out");
      },
      [&self](const D&) {
        self.failure_ = run_error("reset_env of episode " + std::to_string(self.episode_ + 1) + " was rejected");
      });
  action(
      c.free_robot, "get_free_robot", "GetFreeRobot", [&self](const D& d) { self.robot_found(d); },
      [&self](const D& d) {
        if (d.goal != self.robot_goal_) return;
        self.robot_goal_.reset();
        self.searching_ = false;
        self.ask_for_end();
      });
  action(
      c.select, "action_selection", "ActionSelection",
      [&self](const D& d) {
        const bus::MessageView result = *d.message;
        self.selected(d.goal, d.status == bus::GoalStatus::kSucceeded, result.integer("reward"), result.text("info"));
      },
      [&self](const D& d) { self.selected(d.goal, false, 0, "rejected"); });
  if (self.options_.external) {
    const auto message = [&](const char* name) -> const bus::MessageType* {
      auto found = bus::needed_message(bus.registry(), std::string("cxlab_msgs/msg/") + name);
      if (!found && failed) failed = found.error();
      return found ? *found : nullptr;
    };
    c.decision = message("RlDecision");
    c.spaces_message = message("RlSpaces");
    const bus::MessageType* made_type = message("RlDecisionMade");
    const auto opened = [&](bus::EndpointId& to, Expected<bus::EndpointId> endpoint) {
      if (endpoint)
        to = *endpoint;
      else if (failed)
        failed = endpoint.error();
    };
    if (c.decision && c.spaces_message && made_type) {
      opened(c.decisions, bus.advertise(self.node_, "~/decisions", *c.decision));
      opened(c.spaces_topic, bus.advertise(self.node_, "~/spaces", *c.spaces_message));
      opened(c.made, bus.subscribe(self.node_, "~/decisions/made", *made_type,
                                   [&self](const D& d) { self.decided(*d.message); }));
    }
  }
  if (!failed) return failed.error();
  return made;
}

SimTime Trainer::patience() const { return wait_.at_work ? kHangsAtWork : kHangs; }

std::string Trainer::unfinished() const {
  if (decision_.id != 0 && bus_.now() - decision_.asked >= kHangs)
    return options_.node.full_name() + ": nobody answered decision " + std::to_string(decision_.id) +
           "; with the policy external a program at a seat chooses";
  if (!options_.training || wait_.name.empty()) return {};
  return options_.node.full_name() + ": the training has not ended: in episode " + std::to_string(episode_ + 1) +
         " of " + std::to_string(options_.max_episodes) + " it waits since " + shortest_text(to_seconds(wait_.since)) +
         " s for " + wait_.name + (wait_.at_work ? ", which the agent has accepted" : "");
}

Status Trainer::hanging() const {
  if (wait_.name.empty()) return {};
  if (const std::string text = unfinished(); !text.empty() && bus_.now() - wait_.since >= patience())
    return run_error(text + "; the agent does not answer").with_code("trainer_hangs");
  return {};
}

bool Trainer::lacks_agent() const { return !over_ && !warned_ && !bus_.action_ready(clients_->reset.endpoint); }

SimTime Trainer::next_due() const {
  if (!options_.training) return kNever;
  SimTime due = begun_ ? kNever : std::min(begins_, bus_.now() + kPoll);
  if (lacks_agent()) due = std::min(due, kPatience);
  if (!wait_.name.empty() && !wait_.warned) due = std::min(due, wait_.since + patience());
  return std::min(due, rests_until_);
}

Status Trainer::act(SimTime now) {
  bus_.deliver(node_);
  if (!options_.training) return std::exchange(failure_, Status());
  if (!begun_) {
    ask_for_spaces(now);
    if (now >= begins_) {
      begun_ = true;
      make_spaces();
      if (failure_) begin_episode();
    }
  }
  if (now >= rests_until_) {
    rests_until_ = kNever;
    observe();
  }
  if (!wait_.warned && !hanging()) {
    wait_.warned = true;
    log(cx::LogLevel::kWarn, unfinished());
  }
  if (now >= kPatience && lacks_agent()) {
    warned_ = true;
    log(cx::LogLevel::kWarn,
        "nobody serves the action " + options_.node.full_name() + "/reset_env; the training begins when an agent does");
  }
  return std::exchange(failure_, Status());
}

// --- The spaces

void Trainer::ask_for_spaces(SimTime now) {
  if (begins_ != kNever || space_asked_) return;
  Clients& c = *clients_;
  const bool of_type = space_ == kSpaces.size() && type_ < types_.size();
  if (space_ == kSpaces.size() && !of_type) {
    begins_ = now + kGetReady;
    wait_ = {};
    if (!not_served_.empty()) {
      std::string names;
      for (const std::string& name : not_served_) names += (names.empty() ? "" : ", ") + name;
      log(cx::LogLevel::kInfo,
          "nobody serves " + names + ": the training begins without them, while CX's trainer would wait");
    }
    return;
  }
  const std::string name = of_type ? "get_observable_objects" : kSpaces[space_].name;
  const Clients::Service& service = of_type ? c.objects : c.spaces[space_];
  if (wait_.name.empty()) wait_for("the service " + name);
  if (!bus_.service_ready(service.endpoint)) {
    if (!bus_.action_ready(c.reset.endpoint)) return;  // no agent is there yet
    if (ready_since_ == kNever) ready_since_ = now;
    if (now - ready_since_ < kPatience) return;
    not_served_.push_back(name);
    if (of_type)
      type_ = types_.size();
    else
      ++space_;
    wait_ = {};
    return ask_for_spaces(now);
  }
  auto request = std::make_shared<bus::Message>(*service.type->request);
  if (of_type) request->view().set("type", types_[type_]);
  wait_for("the service " + name);
  space_asked_ = true;
  bus_.call(service.endpoint, std::move(request));
}

void Trainer::take_space(bus::MessageView response) {
  space_asked_ = false;
  wait_ = {};
  if (space_ == kSpaces.size()) {
    answers_.objects[types_[type_++]] = texts_of(response, "objects");
    return;
  }
  const bool of_actions = std::string_view(kSpaces[space_].name).ends_with("actions");
  ++space_;
  if (!response.type().find("param_types")) {
    (of_actions ? answers_.actions : answers_.observables) =
        grounded_of(response, of_actions ? "actions" : "observables");
    return;
  }
  std::vector<std::int64_t> counts;
  const bus::Field& field = *response.type().find("param_counts");
  for (std::size_t i = 0; i < response.size(field); ++i) counts.push_back(response.integer(field, i));
  const std::vector<std::string> types = texts_of(response, "param_types");
  std::vector<Schema> schemas =
      schemas_of(texts_of(response, of_actions ? "action_names" : "predicate_names"), counts, types);
  if (!of_actions) std::erase_if(schemas, [](const Schema& schema) { return schema.types.empty(); });  // as CX does
  (of_actions ? answers_.action_schemas : answers_.predicates) = std::move(schemas);
  for (const std::string& type : types)
    if (std::ranges::find(types_, type) == types_.end()) types_.push_back(type);
}

void Trainer::make_spaces() {
  auto spaces = Spaces::make(answers_);
  if (!spaces) {
    if (options_.external)
      failure_ = spaces.error();
    else
      log(cx::LogLevel::kWarn, spaces.error().message + "; spaces.json is not written");
    return;
  }
  spaces_ = *std::move(spaces);
  if (options_.write) failure_ = options_.write("spaces.json", spaces_.to_json());
  if (!options_.external) return;
  auto message = std::make_shared<bus::Message>(*clients_->spaces_message);
  for (const std::string& one : spaces_.observables()) message->view().append_text("observables", one);
  for (const std::string& one : spaces_.actions()) message->view().append_text("actions", one);
  bus_.publish(clients_->spaces_topic, std::move(message));
}

// --- An episode

void Trainer::begin_episode() {
  wait_for("the action reset_env");
  steps_ = 0;
  reward_ = untold_ = 0;
  chosen_.clear();
  at_work_.clear();
  ++phase_;
  end_after_observation_ = false;
  bus_.send_goal(clients_->reset.endpoint, std::make_shared<bus::Message>(*clients_->reset.type->goal));
}

void Trainer::observe() {
  searching_ = true;
  ++search_;
  robot_.clear();
  ask_for_observations();
}

void Trainer::ask_for_observations() {
  observations_.push_back(search_);
  wait_for("the service get_current_observations");
  bus_.call(clients_->observations.endpoint, std::make_shared<bus::Message>(*clients_->observations.type->request));
}

void Trainer::observed(bus::MessageView response) {
  truths_ = grounded_of(response, "observations");
  std::sort(truths_.begin(), truths_.end());
  state_ = joined(truths_);
  if (end_after_observation_) return end_episode("end");
  if (robot_.empty()) return ask_for_robot();
  ask_for_actions();
}

void Trainer::ask_for_robot() {
  wait_for("the action get_free_robot");
  robot_goal_ =
      bus_.send_goal(clients_->free_robot.endpoint, std::make_shared<bus::Message>(*clients_->free_robot.type->goal));
}

void Trainer::robot_found(const bus::Delivery& result) {
  if (result.goal != robot_goal_) return;
  robot_goal_.reset();
  const bus::MessageView found = *result.message;
  if (found.integer("success") != 0) {
    robot_ = found.text("robot");
    return at_work_.empty() ? ask_for_actions() : ask_for_observations();
  }
  searching_ = false;
  ask_for_end();  // none is free any more: the game may be over
}

void Trainer::ask_for_actions() {
  auto request = std::make_shared<bus::Message>(*clients_->actions.type->request);
  request->view().set("robot", robot_);
  wait_for("the service get_action_list_executable_for_robot");
  lists_.push_back(search_);
  bus_.call(clients_->actions.endpoint, std::move(request));
}

void Trainer::choose(bus::MessageView response) {
  const std::vector<std::string> texts = grounded_of(response, "actions");
  const std::vector<std::string> ids = texts_of(response, "action_ids");
  std::vector<Action> actions;
  for (std::size_t i = 0; i < std::min(texts.size(), ids.size()); ++i) actions.push_back({ids[i], texts[i]});
  // What an agent lists first must not matter.
  std::sort(actions.begin(), actions.end(), [](const Action& a, const Action& b) { return a.text < b.text; });
  if (actions.empty()) return at_work_.empty() ? end_episode("no action") : rest();
  learn(robot_, actions);
  if (steps_ >= options_.max_steps) return end_episode("max_steps");
  if (options_.external) return decide(std::move(actions));
  select(actions[pick(state_, actions)]);
}

std::size_t Trainer::pick(const std::string& state, const std::vector<Action>& actions) {
  if (options_.chance_only || options_.external) return chance_.below(actions.size());
  std::vector<std::string> texts;
  for (const Action& action : actions) texts.push_back(action.text);
  return table_.choose(state, texts, options_.training ? table_.exploration(episode_) : 0, chance_);
}

void Trainer::decide(std::vector<Action> actions) {
  decision_.robot = robot_;
  decision_.actions = std::move(actions);
  publish_decision("");
}

void Trainer::publish_decision(const std::string& outcome) {
  decision_.id = ++decisions_;
  decision_.asked = bus_.now();
  auto message = std::make_shared<bus::Message>(*clients_->decision);
  const bus::MessageView view = message->view();
  view.set("id", decision_.id).set("robot", decision_.robot).set("reward", untold_).set("outcome", outcome);
  untold_ = 0;
  const auto fill = [&](const char* name, const std::vector<std::uint8_t>& bits) {
    const bus::Field& field = *view.type().find(name);
    (void)view.resize(field, bits.size());
    for (std::size_t i = 0; i < bits.size(); ++i) (void)view.set_integer(field, bits[i], i);
  };
  std::vector<std::string> unknown;
  fill("observation", spaces_.observation(truths_, &unknown));
  if (!decision_.robot.empty()) {
    std::vector<std::uint8_t> mask(spaces_.actions().size());
    mask[0] = options_.no_op || !at_work_.empty();
    for (const Action& action : decision_.actions)
      if (const std::size_t place = spaces_.place_of(action.text))
        mask[place] = 1;
      else
        unknown.push_back(action.text);
    fill("mask", mask);
  }
  if (!unknown.empty() && !strange_) {
    strange_ = true;
    log(cx::LogLevel::kWarn, "the agent's spaces lack " + unknown.front() +
                                 "; it is left out, and so are others, without a further warning");
  }
  wait_ = {};  // not for the agent
  bus_.publish(clients_->decisions, std::move(message));
}

void Trainer::decided(bus::MessageView made) {
  if (decision_.id == 0 || made.integer("id") != decision_.id) return;  // of a decision that time has overtaken
  const Decision decision = std::exchange(decision_, {});
  const std::int64_t place = made.integer("action");
  if (decision.robot.empty()) return go_on();
  if (place == kGiveUp) return end_episode("given up");
  const auto& actions = spaces_.actions();
  if (place == 0) {  // also where its mask is 0: a choice that changes nothing
    ++steps_;
    ++total_steps_;
    return rest();
  }
  for (const Action& action : decision.actions)
    if (place > 0 && place < std::ssize(actions) && actions[static_cast<std::size_t>(place)] == action.text)
      return select(action);
  failure_ = run_error("action " + std::to_string(place) + " of decision " + std::to_string(decision.id) +
                       " cannot be chosen: its mask is 0, or it is not in the space of " +
                       std::to_string(actions.size()) + " actions");
}

void Trainer::select(const Action& action) {
  chosen_[robot_] = {state_, action.text};
  ++steps_;
  ++total_steps_;
  searching_ = false;
  auto goal = std::make_shared<bus::Message>(*clients_->select.type->goal);
  goal->view().set("action_id", action.id);
  wait_for("the action action_selection");
  at_work_[bus_.send_goal(clients_->select.endpoint, std::move(goal))] = robot_;
}

/// Another robot may be given something to do, once the agent knows what this one does.
void Trainer::accepted(const bus::GoalId& goal) {
  if (at_work_.contains(goal) && !searching_ && std::ssize(at_work_) < options_.robots) observe();
}

void Trainer::selected(const bus::GoalId& goal, bool done, std::int64_t reward, const std::string& info) {
  const auto found = at_work_.find(goal);
  if (found == at_work_.end()) return;  // of an episode that has ended
  Chosen& chosen = chosen_[found->second];
  at_work_.erase(found);
  chosen.reward += static_cast<double>(reward);
  reward_ += static_cast<double>(reward);
  untold_ += static_cast<double>(reward);
  if (!done) log(cx::LogLevel::kWarn, "action " + chosen.action + " was not carried out: " + info);
  ask_for_end();
}

void Trainer::ask_for_end() {
  if (!searching_) wait_for("the service get_episode_end");
  ends_.push_back(phase_);
  bus_.call(clients_->episode_end.endpoint, std::make_shared<bus::Message>(*clients_->episode_end.type->request));
}

void Trainer::ended(bool end, std::int64_t reward) {
  if (!end && searching_) return;
  if (end) {
    reward_ += static_cast<double>(reward);
    untold_ += static_cast<double>(reward);
    for (auto& [robot, chosen] : chosen_) chosen.reward += static_cast<double>(reward);
    ++phase_;  // one end is enough
    decision_ = {};
    give_up_search();
  }
  end_after_observation_ = end;
  rests_until_ = kNever;
  observe();
}

/// Leaves the robot idle until another one has done its work, or for a while.
void Trainer::rest() {
  searching_ = false;
  if (at_work_.empty())
    rests_until_ = bus_.now() + kRest;
  else
    wait_for("the action action_selection");
}

void Trainer::learn(const std::string& robot, const std::vector<Action>& next) {
  const auto chosen = chosen_.find(robot);
  if (chosen == chosen_.end()) return;
  if (!options_.chance_only && !options_.external) {
    Step step{chosen->second.state, chosen->second.action, chosen->second.reward, state_, {}};
    for (const Action& action : next) step.next_actions.push_back(action.text);
    table_.learn(step);
  }
  chosen_.erase(chosen);
}

void Trainer::give_up_search() {
  if (robot_goal_) bus_.cancel_goal(clients_->free_robot.endpoint, *robot_goal_);
  robot_goal_.reset();
  searching_ = false;
  ++search_;
}

void Trainer::end_episode(const std::string& how) {
  while (!chosen_.empty()) learn(std::string(chosen_.begin()->first), {});
  give_up_search();
  at_work_.clear();
  ++phase_;
  ++episode_;
  RecordData data;
  data.begin().field("episode", episode_).field("steps", steps_).field("reward", reward_).field("end", how);
  sink_.write(stream_, bus_.now(), RecordKind::kDecision, data);
  table_text_ +=
      std::to_string(episode_) + ',' + std::to_string(steps_) + ',' + shortest_text(reward_) + ',' + how + '\n';
  if (options_.write) failure_ = options_.write("training.csv", table_text_);
  if (!options_.external) return go_on();
  decision_ = {};
  publish_decision(how);
}

void Trainer::go_on() {
  if (episode_ < options_.max_episodes) return begin_episode();
  end_training();
}

void Trainer::end_training() {
  over_ = true;
  wait_ = {};
  const bool learns = !options_.chance_only && !options_.external;
  log(cx::LogLevel::kInfo, "trained " + std::to_string(episode_) + " episodes, " + std::to_string(total_steps_) +
                               " steps, " + std::to_string(table_.states()) + " states");
  if (options_.write && failure_ && learns) failure_ = options_.write("model.json", table_.to_text());
  bus_.call(clients_->end_training.endpoint, std::make_shared<bus::Message>(*clients_->end_training.type->request));
}

// --- What agents ask

void Trainer::answer_status(const bus::Delivery& request) {
  auto response = std::make_shared<bus::Message>(*clients_->status.type->response);
  response->view()
      .set("mode", options_.training ? "TRAINING" : "EXECUTION")
      .set("current_episode", episode_)
      .set("current_episode_step", steps_)
      .set("total_steps", total_steps_)
      .set("model_loaded", options_.model.has_value());
  bus_.respond(clients_->status.endpoint, request, std::move(response));
}

void Trainer::answer_selection(const bus::Delivery& request) {
  const bus::MessageView asked = *request.message;
  const std::vector<std::string> texts = grounded_of(asked, "actions");
  const std::vector<std::string> ids = texts_of(asked, "action_ids");
  std::vector<Action> actions;
  for (std::size_t i = 0; i < std::min(texts.size(), ids.size()); ++i) actions.push_back({ids[i], texts[i]});
  std::sort(actions.begin(), actions.end(), [](const Action& a, const Action& b) { return a.text < b.text; });
  auto response = std::make_shared<bus::Message>(*clients_->selection.type->response);
  if (!actions.empty()) {
    response->view().set("action_id", actions[pick(state_of(asked, "observations"), actions)].id);
    ++total_steps_;
  }
  bus_.respond(clients_->selection.endpoint, request, std::move(response));
}

void Trainer::log(cx::LogLevel level, const std::string& text) const {
  if (options_.log)
    options_.log->line({.t = bus_.now(), .level = level, .logger = options_.node.name, .text = text, .colour = {}});
}

}  // namespace cxlab::rl
