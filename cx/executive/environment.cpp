#include "cx/executive/environment.h"

#include <algorithm>
#include <cctype>

#include "cx/base/number_text.h"
#include "cx/executive/thread_gate.h"

namespace cxlab::cx {

Environment::Environment(Options options, bus::Bus& bus, Files& files)
    : options_(std::move(options)),
      bus_(bus),
      files_(files),
      router_(options_.redirect_stdout_to_debug,
              [this](LogLevel level, std::string_view colour, std::string_view logical_name, std::string_view text) {
                const bool of_rules = logical_name != "stderr";
                write_line({now(), level, name_in_log(), text, colour, of_rules});
                if (level == LogLevel::kError && of_rules && options_.printed_errors)
                  options_.printed_errors->add(now(), name_in_log(), text);
                if (options_.topic_logging) options_.publish_line(name(), logical_name, text);
              }) {}

Expected<std::unique_ptr<Environment>> Environment::create(Options options, bus::Bus& bus, RecordSink& journal,
                                                           Files& files) {
  auto environment = std::unique_ptr<Environment>(new Environment(std::move(options), bus, files));
  Environment& self = *environment;
  const Options& given = self.options_;
  self.journal_ = &journal;
  EngineOptions engine;
  engine.name = given.unique_name;
  engine.now = [&bus] { return bus.now(); };
  engine.epoch = from_seconds(given.run->epoch);
  engine.seed = given.run->seed;
  engine.journal = &journal;
  engine.files = &files;
  engine.outside = given.run->outside;
  engine.max_load_firings = given.run->max_firings;
  engine.trust_rules = given.run->trust_rules;
  engine.limits = given.run->limits;
  engine.on_output = [&self](std::string_view name, std::string_view text) { self.router_.write(name, text); };
  engine.on_reading = [&self] { self.router_.end_line(); };
  auto made = RuleEngine::create(std::move(engine));
  if (!made) return made.error();
  self.engine_ = std::move(*made);
  self.engine_->count(given.run->counting);
  self.participant_ =
      bus.join(bus::ParticipantKind::kEnvironment, given.node, self.engine_->stream(), "environment " + given.name);
  return environment;
}

Environment::~Environment() {
  for (const auto& gate : gates_) gate->close();
  if (!engine_) return;
  if (settings().on_environment_end) settings().on_environment_end(*this);
  bus_.leave(participant_);
}

Expected<std::shared_ptr<ThreadGate>> Environment::open_gate(const std::string& plugin) {
  std::string word;  // letters and digits for the topic's name
  for (const char c : name()) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      word += c;
    else
      word += '_';
  }
  auto gate = std::make_shared<ThreadGate>(
      *this, plugin, options_.node.expand("~/threads/" + word + '_' + std::to_string(gates_opened_++)));
  if (Status s = gate->open(); !s) return s.error();
  gates_.push_back(gate);
  return gate;
}

void Environment::close_gates(std::string_view plugin) {
  for (const auto& gate : gates_)
    if (gate->owner() == plugin) gate->close();
  std::erase_if(gates_, [&](const auto& gate) { return gate->owner() == plugin; });
}

bus::ParticipantId Environment::join_threads(bus::NodeName name, const std::string& plugin) {
  name.name += "_threads";
  return bus_.join(bus::ParticipantKind::kNode, std::move(name),
                   journal_->open_stream("threads/" + options_.unique_name + '/' + plugin));
}

void Environment::begin_again() {
  ending_ = false;
  engine_->keep_same_constructs(KeepSame::kTypes);
}

Status Environment::take_inputs() {
  move_to_this_thread();
  engine_->begin_tick();
  for (const auto& gate : gates_) gate->hand_over();
  if (Status s = options_.run->feed->feed(participant_); !s) return s;
  engine_->clear_cause();
  if (Status s = check_errors(); !s) return s;
  const std::int64_t called = engine_->take_call_count(), most = options_.run->max_firings;
  if (most == 0 || called <= most) return {};
  return loop_error(std::to_string(called) + " callbacks were called in one tick");
}

Error Environment::loop_error(const std::string& what) const {
  return Error{ErrorKind::kRun,
               "environment '" + name_in_log() + "': " + what +
                   "; if they are right, allow more with max_firings_per_tick (now " +
                   std::to_string(options_.run->max_firings) +
                   ", 0 = no limit) of the scenario, or with --max-firings of cxlab env; a story allows no more",
               {},
               0,
               "rule_loop"};
}

Expected<std::int64_t> Environment::run(const Pass& pass) {
  engine_->refresh_all_agendas();
  std::int64_t fired = 0;
  if (pass.focus_stack.empty()) return run_rules(pass.rule_limit);
  for (const std::string& module : pass.focus_stack) {
    if (!engine_->focus_on(module)) continue;
    auto more = run_rules(pass.rule_limit < 0 ? -1 : pass.rule_limit - fired);
    if (!more) return more.error();
    fired += *more;
    if (fired == pass.rule_limit) break;
  }
  return fired;
}

Expected<std::int64_t> Environment::run_rules(std::int64_t rule_limit) {
  const std::int64_t most = options_.run->max_firings;
  const bool limited = rule_limit >= 0 && (most == 0 || rule_limit < most);
  if (limited && rule_limit == 0) return std::int64_t{0};
  if (stops()) return run_stopping(limited ? rule_limit : -1);
  RunReport report = engine_->run(limited ? rule_limit : most);
  if (Status s = check_errors(std::move(report.errors)); !s) return s.error();
  if (report.loop && !limited) return loop_error(report.loop_report);
  return report.fired;
}

Error Environment::loop_error(const LoopReport& report) const {
  Error error = loop_error(report.text());
  if (!report.rules.empty()) {
    error.file = report.rules.front().file;
    error.line = report.rules.front().line;
  }
  return error;
}

Status Environment::check_errors() {
  return check_errors(engine_->has_errors() ? engine_->take_errors() : std::vector<RuleError>());
}

Status Environment::check_errors(std::vector<RuleError> errors) {
  Status first;
  for (RuleError& e : errors) {
    if (options_.run->stop_on_rule_error && first) first = e.error();
    // A run that stops ends with the error; a run that continues logs its place here.
    if (!options_.run->stop_on_rule_error) log(LogLevel::kError, name(), e.error().text());
    if (options_.rule_errors) options_.rule_errors->push_back({name(), std::move(e)});
  }
  if (const LimitsInUse* limits = options_.run->limits; limits != nullptr && limits->exceeded) return *limits->exceeded;
  return first;
}

void Environment::note_input(std::string_view what, std::string_view name, const bus::Delivery& delivery) {
  data_.begin().field("what", what).field("name", name);
  if (delivery.message) {
    data_.name("message");
    delivery.message->view().record(data_);
  }
  engine_->set_cause(journal_->write(engine_->stream(), now(), RecordKind::kInput, data_, {&delivery.cause, 1}));
}

void Environment::note_input(std::string_view what, std::string_view name, std::string_view content, RecordRef cause) {
  data_.begin().field("what", what).field("name", name).field("message", content);
  engine_->set_cause(journal_->write(engine_->stream(), now(), RecordKind::kInput, data_, {&cause, 1}));
}

Value Environment::look(std::string_view function, const std::function<Value()>& outside) {
  Value value = options_.run->outside ? options_.run->outside->look(function, outside) : outside();
  data_.begin().field("what", "look").field("name", function).field("value", value.print());
  journal_->write(engine_->stream(), now(), RecordKind::kInput, data_, engine_->cause());
  return value;
}

void Environment::log(LogLevel level, std::string_view logger, std::string_view text) {
  const bool of_rules = RuleEngine::at_work() != nullptr;  // a function that they call has logged it
  write_line({now(), level, options_.logger_names.in_log(logger), text, {}, of_rules});
}

void Environment::write_line(const LogLine& line) {
  if (options_.run->log) options_.run->log->line(line);
  if (options_.log_file) options_.log_file->line(line);
}

// --- Control of the run

std::optional<ControlAct> Environment::next_act() const {
  ControlLog* log = options_.run->control_log;
  return log ? log->next(options_.unique_name) : std::nullopt;
}

Status Environment::stop_at_tick() {
  if (!stops()) return {};
  return stop_at({now(), place_.run, -1});
}

Status Environment::stop_at(ControlPlace place) {
  place_ = place;
  while (true) {
    const auto recorded = next_act();
    if (!recorded || recorded->place != place) break;
    options_.run->control_log->take(options_.unique_name);
    const auto done = act(recorded->verb, recorded->text, recorded->name);
    if (!done && is_planned(recorded->verb)) return done.error();
  }
  if (options_.run->control)
    if (Status s = options_.run->control->stop_at(*this, place); !s) return s;
  return check_errors();
}

Expected<std::string> Environment::act_after_tick(SimTime tick, ControlAct::Verb verb, const std::string& text) {
  move_to_this_thread();
  place_ = {tick, place_.run, ControlPlace::after_tick(tick).fired};
  return act(verb, text);
}

void Environment::repeat_acts_after_tick(SimTime tick) {
  while (true) {
    const auto recorded = next_act();
    if (!recorded || recorded->place != ControlPlace::after_tick(tick)) return;
    options_.run->control_log->take(options_.unique_name);
    (void)act_after_tick(tick, recorded->verb, recorded->text);
  }
}

Expected<std::int64_t> Environment::run_stopping(std::int64_t rule_limit) {
  const std::int64_t most = options_.run->max_firings;
  ControlPlace place{now(), place_.run + 1, 0};
  while (true) {
    if (Status s = stop_at(place); !s) return s.error();
    std::int64_t stretch = rule_limit < 0 ? most : rule_limit - place.fired;
    if (options_.run->control && options_.run->control->before_each_firing()) stretch = 1;
    const auto recorded = next_act();
    if (recorded && recorded->place.t == place.t && recorded->place.run == place.run &&
        recorded->place.fired > place.fired)
      stretch = recorded->place.fired - place.fired;
    RunReport report = engine_->run(stretch);
    place.fired += report.fired;
    const bool ended = report.fired == 0 || report.halted || !report.errors.empty();
    if (Status s = check_errors(std::move(report.errors)); !s) return s.error();
    if (report.loop && most > 0 && place.fired >= most && rule_limit < 0) return loop_error(report.loop_report);
    if (ended || !report.loop || place.fired == rule_limit) break;
  }
  return place.fired;
}

Expected<std::string> Environment::act(ControlAct::Verb verb, const std::string& text, const std::string& name) {
  const bool between_ticks = place_.is_between_ticks();
  was_controlled_ = was_controlled_ || between_ticks || !is_planned(verb);
  if (options_.run->control_log) {
    const ControlPlace place = between_ticks ? ControlPlace::after_tick(place_.t) : place_;
    options_.run->control_log->add(options_.unique_name, {place, verb, text, name});
  }
  constexpr const char* kWords[] = {"eval", "build", "load", "assert", "set", "fail", "retract", "settle", "count"};
  data_.begin().field("what", kWords[static_cast<std::size_t>(verb)]);
  if (!name.empty()) data_.field("name", name);
  if (between_ticks) data_.field("by", "program");
  data_.field("text", text);
  engine_->set_cause(journal_->write(engine_->stream(), now(), RecordKind::kControl, data_));
  auto done = carry_out(verb, text, name);
  engine_->clear_cause();
  // The answer tells what went wrong; the run goes on unless the caller ends it.
  (void)engine_->take_errors();
  return done;
}

Expected<std::string> Environment::carry_out(ControlAct::Verb verb, const std::string& text, const std::string& name) {
  const auto evaluated = [this](const std::string& expression) -> Expected<std::string> {
    auto value = engine_->eval(expression);
    if (!value) return value.error();
    return value->print();
  };
  const auto silent = [](const Status& done) { return done ? Expected<std::string>("") : done.error(); };
  switch (verb) {
    case ControlAct::Verb::kEval: return evaluated(text);
    case ControlAct::Verb::kBuild: return silent(engine_->build(text));
    case ControlAct::Verb::kLoad: return silent(load_planned(text, name));
    case ControlAct::Verb::kAssert: {
      auto index = engine_->assert_string(text);
      if (index) return "f-" + std::to_string(*index);
      const std::vector<RuleError> said = engine_->take_errors();
      return said.empty() ? index.error() : input_error(said.front().message);
    }
    case ControlAct::Verb::kFail: return input_error(text);
    case ControlAct::Verb::kSettle: engine_->settle_agenda(); return std::string();
    case ControlAct::Verb::kRetract: {
      const auto index = read_number<std::int64_t>(text);
      if (!index || !engine_->retract(*index)) return input_error("there is no fact f-" + text);
      return std::string();
    }
    case ControlAct::Verb::kCount: {
      const auto number = read_number<std::uint64_t>(text);
      if (!number || !bus_.number_requests_from(participant_, name, *number))
        return input_error("there is no client of service " + name);
      return std::string();
    }
    case ControlAct::Verb::kSet: break;
  }
  if (name.starts_with("?*")) return evaluated("(bind " + name + ' ' + text + ')');
  if (!options_.set_parameter) return input_error("the environment has no parameters");
  return silent(options_.set_parameter(name, text));
}

Status Environment::load_planned(const std::string& text, const std::string& file) {
  const auto module = engine_->eval("(get-current-module)");
  engine_->keep_same_constructs(KeepSame::kAll);
  const LoadReport report = engine_->load_text(text, file, LoadMode::kBatch);
  engine_->keep_same_constructs(KeepSame::kNothing);
  (void)engine_->take_notes();  // that it replaces constructs is what it is for
  if (module) (void)engine_->use_module(module->text());
  return report.status();
}

}  // namespace cxlab::cx
