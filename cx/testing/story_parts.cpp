#include "cx/testing/story_parts.h"

#include <algorithm>
#include <map>
#include <utility>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/executive/environment.h"
#include "cx/explain/names.h"
#include "cx/explain/pattern.h"
#include "cx/journal/journal_reader.h"

namespace cxlab::testing {

namespace {

using Verb = Step::Verb;

/// Whether the fact was still there: one before it may have taken it with it. An act that fails would end a replay.
bool retract(cx::Environment& environment, const FactCopy& fact) {
  if (!environment.engine().fact(fact.index)) return false;
  return environment.act(cx::ControlAct::Verb::kRetract, std::to_string(fact.index), std::string(kActOfStory)).ok();
}

/// The prefix of the binding that has a client of that action; empty if the generic plugin has one, or none has.
std::string binding_of(const std::string& action, const RuleEngine& engine) {
  constexpr std::string_view kClient = "-client";
  std::string prefix;
  for (const FactCopy& fact : engine.facts()) {
    const Value* server = fact.slot("server");
    if (!server || server->text() != action || !fact.template_name.ends_with(kClient)) continue;
    if (fact.template_name == "ros-msgs-action-client") return {};
    prefix = fact.template_name.substr(0, fact.template_name.size() - kClient.size());
  }
  return prefix;
}

bool is_of_facts(const Step& step) { return step.verb == Verb::kAssert || step.verb == Verb::kRetract; }

}  // namespace

std::string global_of_story(const std::string& what, std::size_t number) {
  return "?*" + std::string(kGlobalOfStory) + what + '-' + std::to_string(number) + '*';
}

SimTime end_of(const StorySpec& spec) {
  SimTime end = std::max({spec.begins, spec.given_at, spec.end});
  for (const Step& step : spec.steps) end = std::max(end, step.at);
  for (const Expectation& e : spec.expect)
    end = std::max({end, e.after, e.until == kNever ? SimTime::zero() : e.until});
  return tick_not_before(end, spec.tick);
}

Expected<std::string> config_for_rules(const StorySpec& spec) {
  std::string files;
  for (const std::filesystem::path& file : spec.rules) {
    if (!is_file(file)) return input_error("there is no rule file " + file.string(), spec.file, spec.line);
    std::string name = std::filesystem::absolute(file).lexically_normal().string();
    for (std::size_t at = 0; (at = name.find('\'', at)) != std::string::npos; at += 2) name.insert(at, "'");
    files += (files.empty() ? "'" : ", '") + name + '\'';
  }
  return "/**:\n  ros__parameters:\n    environments: [main]\n    main: {plugins: [executive, ros_msgs, files]}\n"
         "    executive: {plugin: 'cx::ExecutivePlugin'}\n    ros_msgs: {plugin: 'cx::RosMsgsPlugin'}\n"
         "    files: {plugin: 'cx::FileLoadPlugin', load: [" +
         files + "]}\n";
}

std::string plain_objection(const explain::Pattern& pattern, const RuleEngine& engine, const std::string& of_clips) {
  Status plain = explain::check_names(pattern, engine);
  if (plain) plain = explain::check_values(pattern, engine, {});
  return plain ? of_clips : plain.error().message;
}

std::vector<Error> set_up(StandIns& stand_ins, const StorySpec& spec) {
  std::vector<Error> mistakes;
  const auto add = [&mistakes](const Status& fits) {
    if (!fits && std::ranges::count(mistakes, fits.error().text(), &Error::text) == 0) mistakes.push_back(fits.error());
  };
  std::map<std::string, Line> types;  // of topics, actions and services: what the story says first, and exists
  const auto add_type = [&](const std::string& name, const std::string& type, int line) {
    if (!stand_ins.has_type(type)) return;
    if (const Line& first = types.try_emplace(name, type, line).first->second; first.text != type)
      add(input_error(
          name + ": " + found_expected(type, first.text + ", its type on line " + std::to_string(first.line)),
          spec.file, line));
  };
  const auto add_all = [&add](const std::vector<Error>& found) { std::ranges::for_each(found, add); };
  std::vector<const StandIn*> served;
  for (const StandIn& stand_in : spec.stand_ins) {
    const std::vector<Error> found = stand_ins.check(stand_in);
    add_all(found);
    add_type(stand_in.name, stand_in.type, stand_in.line);
    if (found.empty()) add(stand_ins.add(stand_in));
    served.push_back(&stand_in);
  }
  for (const Fault& fault : spec.faults)
    if (!fault.name.empty() &&
        std::ranges::none_of(spec.stand_ins, [&](const StandIn& s) { return s.name == fault.name; }))
      add(input_error("nobody serves " + fault.name + ", so this fault can never strike", spec.file,
                      fault.outcome.line));
  for (const Step& step : spec.steps)
    if (step.verb == Verb::kStandIn) {
      add_all(stand_ins.check(*served.emplace_back(&step.stand_in)));
      add_type(step.stand_in.name, step.stand_in.type, step.line);
    } else if (step.verb == Verb::kPublish) {
      add(stand_ins.check_message(step.text, step.type, step.data, spec.file, step.line));
      add_type(step.text, step.type, step.line);
    }
  for (const Expectation& e : spec.expect)
    if (e.kind == Expectation::Kind::kPublished) {
      add(stand_ins.listen(e.text, e.type, spec.file, e.line));
      add(stand_ins.check_message(e.text, e.type, e.fields, spec.file, e.line));
      add_type(e.text, e.type, e.line);
    } else if (e.kind == Expectation::Kind::kGoal) {
      for (const StandIn* stand_in : served)
        if (stand_in->action && stand_in->name == e.text)
          add(stand_ins.check_goal(*stand_in, e.fields, spec.file, e.line));
    }
  return mistakes;
}

Status StorySteps::sense(SimTime now) {
  for (; next_ < spec_->steps.size() && spec_->steps[next_].at <= now; ++next_) {
    const Step& step = spec_->steps[next_];
    Status done;
    if (step.verb == Verb::kPublish)
      done = stand_ins_.publish(step.text, step.type, step.data, spec_->file, step.line);
    else if (step.verb == Verb::kStandIn)
      done = stand_ins_.add(step.stand_in);
    if (!done) return done;
  }
  return {};
}

SimTime StorySteps::next_due() const { return next_ < spec_->steps.size() ? spec_->steps[next_].at : kNever; }

Status StoryFacts::stop_at(cx::Environment& environment, const cx::ControlPlace& place) {
  const bool is_tick = place.fired < 0;
  if (!is_tick && (!begun_ || place.fired > 0)) return {};
  if (environment_.empty() && (spec_->environment.empty() || environment.name() == spec_->environment))
    environment_ = environment.unique_name();
  if (environment.unique_name() != environment_) return {};
  if (!std::exchange(begun_, true))
    if (Status s = begin(environment); !s) return s;
  if (place.t < spec_->given_at) return hold(environment);
  if (!is_tick) return {};
  if (!std::exchange(given_, true)) {
    if (Status s = give_all(environment); !s) return s;
  } else if (!std::exchange(answered_, true)) {
    if (Status s = answer(environment); !s) return s;
  }
  for (; next_ < spec_->steps.size() && spec_->steps[next_].at <= place.t; ++next_) {
    const Step& step = spec_->steps[next_];
    if (!is_of_facts(step)) continue;
    const Status done =
        step.verb == Verb::kAssert ? give(environment, {step.text, step.line}) : take(environment, step);
    if (!done) return done;
  }
  return {};
}

Status StoryFacts::evaluate(cx::Environment& environment, const Line& text) const {
  const auto done = environment.act(cx::ControlAct::Verb::kLoad, text.text, std::string(kActOfStory));
  return done ? Status() : input_error(text.text + ": " + done.error().message, spec_->file, text.line);
}

Status StoryFacts::begin(cx::Environment& environment) {
  for (const Line& call : spec_->calls)
    if (Status s = evaluate(environment, call); !s) return s;
  if (Status s = send_goals(environment); !s) return s;
  for (const StandIn& server : spec_->stand_ins)
    if (Status s = send_requests(environment, server); !s) return s;
  return {};
}

/// Sends a message without content. The global is nil then.
Status StoryFacts::send(cx::Environment& environment, const std::string& global, const std::string& created,
                        const std::string& sent, const std::string& destroy, int line) const {
  for (const std::string& text : {"(defglobal " + global + " = " + created + ')', sent,
                                  '(' + destroy + ' ' + global + ')', "(bind " + global + " nil)"})
    if (Status s = evaluate(environment, {text, line}); !s) return s;
  return {};
}

Status StoryFacts::send_goals(cx::Environment& environment) {
  for (const StandIn& server : spec_->stand_ins)
    if (server.action)
      for (const UnderWay& goal : server.under_way)
        sent_.push_back(
            {&server, &goal, global_of_story("goal", sent_.size() + 1), binding_of(server.name, environment.engine())});
  for (const Sent& sent : sent_) {
    const bool bound = !sent.binding.empty();
    const std::string created =
        bound ? sent.named("-goal-create") : "ros-msgs-create-goal-request \"" + sent.server->type + '"';
    const std::string sends = sent.named(bound ? "-send-goal " : "-async-send-goal ");
    if (Status s = send(environment, sent.handle, '(' + created + ')',
                        '(' + sends + sent.handle + " \"" + sent.server->name + "\")",
                        sent.named(bound ? "-goal-destroy" : "-destroy-message"), sent.goal->line);
        !s)
      return s;
  }
  return {};
}

/// Requests in progress have the numbers that they had, and so have those that follow.
Status StoryFacts::send_requests(cx::Environment& environment, const StandIn& server) {
  if (server.action) return {};
  for (const UnderWay& request : server.under_way) {
    if (Status s = number_requests(environment, server, request.id, request.line); !s) return s;
    const std::string global = global_of_story("request", ++requests_);
    if (Status s = send(environment, global, "(ros-msgs-create-request \"" + server.type + "\")",
                        "(ros-msgs-async-send-request " + global + " \"" + server.name + "\")",
                        "ros-msgs-destroy-message", request.line);
        !s)
      return s;
  }
  return server.next_id > 0 ? number_requests(environment, server, std::to_string(server.next_id), server.line)
                            : Status();
}

Status StoryFacts::number_requests(cx::Environment& environment, const StandIn& server, const std::string& number,
                                   int line) const {
  if (environment.act(cx::ControlAct::Verb::kCount, number, server.name)) return {};
  return input_error(server.name +
                         ": the agent has no client of this service when the story begins, so no request to it can "
                         "have been sent; open one in `calls`: (ros-msgs-create-client \"" +
                         server.name + "\" \"" + server.type + "\")",
                     spec_->file, line);
}

/// Keeps the handles of goals that were answered, and lets nothing fire.
Status StoryFacts::hold(cx::Environment& environment) const {
  for (const Sent& sent : sent_)
    if (Status s = evaluate(environment, {"(if (eq " + sent.handle + " nil) then (do-for-fact ((?f " +
                                              sent.named("-goal-response") + ")) (eq ?f:server \"" + sent.server->name +
                                              "\") (bind " + sent.handle + " ?f:client-goal-handle-ptr) (retract ?f)))",
                                          sent.goal->line});
        !s)
      return s;
  for (const FactCopy& fact : environment.engine().facts()) (void)retract(environment, fact);
  (void)environment.act(cx::ControlAct::Verb::kSettle, {});
  return {};
}

/// Answers to goals that were sent at the moment itself come after it.
Status StoryFacts::answer(cx::Environment& environment) const {
  for (const Sent& sent : sent_)
    if (sent.goal->handle.empty())
      if (Status s =
              evaluate(environment, {"(assert (" + sent.named("-goal-response") + " (server \"" + sent.server->name +
                                         "\") (client-goal-handle-ptr " + sent.handle + ")))",
                                     sent.goal->line});
          !s)
        return s;
  return {};
}

/// The fact with the goals of this story and the facts that it was given in the place of the words for them.
std::string StoryFacts::with_pointers(const std::string& fact) const {
  std::string out = fact;
  const auto replace = [&out](const std::string& word, const std::string& by) {
    for (std::size_t at = 0; !word.empty() && (at = out.find(word, at)) != std::string::npos; at += by.size())
      out.replace(at, word.size(), by);
  };
  for (const Sent& sent : sent_) {
    const std::string id = '(' + sent.named("-client-goal-handle-get-goal-id ") + sent.handle + ')';
    if (!sent.goal->id.empty()) replace('"' + sent.goal->id + '"', "(str-cat " + id + ')');
    replace(sent.goal->id, id);
    replace(sent.goal->handle, sent.handle);
  }
  for (const auto& [word, global] : named_) replace(word, global);
  return out;
}

Status StoryFacts::give_all(cx::Environment& environment) {
  using Act = cx::ControlAct::Verb;
  if (!sent_.empty())
    if (Status s = hold(environment); !s) return s;
  // Those that are given too: a fact that is asserted again would no longer follow from others.
  if (spec_->moment)
    for (const FactCopy& fact : environment.engine().facts()) (void)retract(environment, fact);
  for (const GivenFact& fact : spec_->given)
    if (Status s = give(environment, fact); !s) return s;
  if (spec_->moment) (void)environment.act(Act::kSettle, {});
  return {};
}

Status StoryFacts::give(cx::Environment& environment, const GivenFact& fact) {
  using Act = cx::ControlAct::Verb;
  const auto pattern = explain::Pattern::parse_plain(fact.text, spec_->file, fact.line);
  // Where CLIPS knows no template of that name, it takes the fact for an ordered one, and the slots for its mistake.
  if (pattern && pattern->module().empty() && !pattern->slot_names().empty())
    if (Status s = explain::check_names(*pattern, environment.engine()); !s)
      return input_error(fact.text + ": " + s.error().message, spec_->file, fact.line);
  const std::string text = with_pointers(fact.text);
  const bool is_plain = fact.as.empty() && text == fact.text;
  std::string asserts = is_plain ? text : "(assert " + text + ')';
  if (!fact.as.empty()) {
    const std::string global = global_of_story("fact", named_.size() + 1);
    named_.emplace_back(fact.as, global);
    asserts = "(defglobal " + global + " = " + asserts + ')';
  }
  const auto done = environment.act(is_plain ? Act::kAssert : Act::kLoad, asserts, std::string(kActOfStory));
  if (done) return {};
  const std::string& why = done.error().message;
  return input_error(fact.text + ": " + (pattern ? plain_objection(*pattern, environment.engine(), why) : why),
                     spec_->file, fact.line);
}

Status StoryFacts::take(cx::Environment& environment, const Step& step) const {
  const RuleEngine& engine = environment.engine();
  auto pattern = explain::Pattern::parse_plain(step.text, spec_->file, step.line);
  if (!pattern) return pattern.error();
  if (Status s = explain::check_names(*pattern, engine); !s)
    return input_error("retract " + step.text + ": " + s.error().message, spec_->file, step.line);
  bool any = false;
  for (const FactCopy& fact : engine.facts(pattern->template_name()))
    if (pattern->matches(fact)) any |= retract(environment, fact);
  if (any) return {};
  return negative(spec_->file + ':' + std::to_string(step.line) + ": retract " + step.text + " at " +
                  general_text(to_seconds(environment.now()), 6) + " s: there is no such fact");
}

}  // namespace cxlab::testing
