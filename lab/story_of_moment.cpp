#include "lab/story_of_moment.h"

#include <algorithm>
#include <cstring>
#include <list>
#include <map>
#include <set>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "cx/engine/form_reader.h"
#include "cx/journal/input_log.h"
#include "cx/journal/journal_reader.h"
#include "cx/journal/run_folder.h"
#include "cx/testing/story_parts.h"
#include "lab/child.h"
#include "lab/moment.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

namespace {

/// All records of environments, from the start.
class Records final : public JournalListener {
 public:
  bool wants(std::string_view stream, RecordKind) const override { return stream.starts_with("env/"); }
  void heard(const JournalRecord& record) override { all.push_back(record); }
  std::vector<JournalRecord> all;
};

/// In single quotes of YAML.
std::string yaml_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + '\'';
}

std::string seconds_of(SimTime t) { return general_text(to_seconds(t), 12); }

/// Names in the records of an environment are as its rules wrote them.
std::string whole_name(const std::string& name) { return name.starts_with('/') ? name : '/' + name; }

std::string name_in(const JournalRecord& record) { return whole_name(std::string(record.data.text("name"))); }

std::string type_of(const std::vector<bus::Bus::Info>& all, const std::string& name) {
  const auto found = std::ranges::find(all, whole_name(name), &bus::Bus::Info::name);
  return found == all.end() ? "" : found->type;
}

/// A goal or a call of the environment, and how it ended.
struct SkillAnswer {
  std::string id;  ///< of the goal, or the number of the call
  SimTime sent{};
  std::optional<SimTime> ended = {};
  std::string outcome = "never", result = {};                  // JSON
  std::vector<std::pair<SimTime, std::string>> feedback = {};  ///< after the moment, JSON
  std::string handle = {};  ///< of the client of a goal that was accepted before the moment
};
/// The goals or calls of one action or service, in order of sending. Those of before the moment have no answer by then.
using SkillAnswers = std::list<SkillAnswer>;

/// What the bus knows of an answer, and its record in the journal does not say.
struct LoggedAnswer {
  std::string id;  ///< as in `SkillAnswer`
  bool accepted = false;
  bus::GoalStatus status{};
};
constexpr std::size_t kIdSize = 32;  // of a goal, in hex digits
/// By the record of the post.
using LoggedAnswers = std::map<std::pair<std::string, std::uint64_t>, LoggedAnswer>;

/// The answers that an environment took.
Expected<LoggedAnswers> read_answers(const fs::path& inputs, std::string_view stream) {
  auto log = InputLogReader::open(inputs);
  if (!log) return log.error();
  LoggedAnswers out;
  while (const auto input = log->next()) {
    const auto* take = std::get_if<LoggedTake>(&*input);
    if (take == nullptr || take->to != stream) continue;
    for (const LoggedDelivery& logged : take->deliveries) {
      const bus::Delivery& delivery = logged.delivery;
      const bool is_response = delivery.kind == bus::DeliveryKind::kServiceResponse;
      if (is_response || delivery.kind == bus::DeliveryKind::kGoalResponse ||
          delivery.kind == bus::DeliveryKind::kFeedback || delivery.kind == bus::DeliveryKind::kResult)
        out[{std::string(logged.cause_stream), delivery.cause.n}] = {
            is_response ? std::to_string(delivery.request_id) : bus::to_string(delivery.goal), delivery.accepted,
            delivery.status};
    }
  }
  return out;
}

class Writer {
 public:
  Writer(const Run& run, const MomentStory& moment, const fs::path& file, const Host& host)
      : run_(run), given_(moment), file_(file), host_(host) {}

  Expected<WrittenStory> write() {
    if (Status s = find(); !s) return s.error();
    auto logged = read_answers(run_.folder / "inputs.bin", stream_);
    if (!logged) return logged.error();
    logged_ = *std::move(logged);
    if (Status s = agent(); !s) return s.error();
    for (const JournalRecord& record : records_.all)
      if (record.stream == stream_) before(record);
    const std::size_t so_far = records_.all.size();
    facts();
    if (Status s = play_on(); !s) return s.error();
    for (std::size_t i = so_far; i < records_.all.size(); ++i)
      if (const JournalRecord& record = records_.all[i]; record.stream == stream_)
        record.t <= at_ ? before(record) : after(record);
    what_is_left();
    WrittenStory out;
    out.text = text();
    out.notes = notes_;
    out.expectations = static_cast<int>(expect_.size());
    return expect_.empty() ? Expected<WrittenStory>(nothing_happened()) : out;
  }

 private:
  /// Names what a story could expect before and after these seconds.
  Error nothing_happened() {
    std::optional<SimTime> earlier, later;
    if (Status s = moment_->seek(moment_->end()); !s) return s.error();
    for (const JournalRecord& record : records_.all) {
      if (record.stream != stream_ || !is_expected(record)) continue;
      if (record.t <= at_) earlier = record.t;
      if (record.t > end_ && !later) later = record.t;
    }
    std::string remedy;
    if (earlier)
      remedy = "; a story begins after the tick of its moment: the last thing before happened at " +
               seconds_of(*earlier) + " s, which a story with --at " +
               seconds_of(std::max(SimTime::zero(), *earlier - testing::kTick)) + " has";
    if (later)
      remedy += "; the next thing happens at " + seconds_of(*later) + " s, which a story with --for " +
                general_text(to_seconds(*later - at_) + 1, 6) + " has";
    return negative("nothing that a story could expect happened within " + general_text(given_.seconds, 6) +
                    " s after " + seconds_of(at_) + " s" +
                    (remedy.empty() ? ", or at another time of the run" : remedy));
  }

  /// Whether a story can expect this event.
  bool is_expected(const JournalRecord& record) const {
    if (record.kind == RecordKind::kFire) return rules_.contains(rule_in(record));
    const std::string_view op = record.data.text("op");
    return record.kind == RecordKind::kBus && (op == "goal" || (op == "publish" && is_topic_of_rules(name_in(record))));
  }

  /// Goes to the last time at which the executive ran the rules.
  Status find() {
    auto moment = Moment::open(run_, host_);
    if (!moment) return moment.error();
    moment_ = *std::move(moment);
    if (Status s = seek(given_.at); !s) return about_option(s.error(), "--at");
    at_ = moment_->t();
    SimTime beat = kNever;
    for (const JournalRecord& record : records_.all)
      if (record.stream == stream_ && record.kind == RecordKind::kAssert && record.data.text("template") == "time") {
        begins_ = beat == kNever ? record.t : beat;
        beat = record.t;
      }
    if (beat == kNever) begins_ = at_;
    if (beat == kNever || beat == at_) return {};
    at_ = beat;
    if (Status s = moment_->rewind(); !s) return s;
    return seek(beat);
  }

  Status seek(SimTime t) {
    records_.all.clear();
    moment_->episode().journal().observe(records_);
    if (Status s = moment_->seek(SimTime{-1}); !s) return s;  // to before the first tick
    auto found = moment_->environments(given_.environment);
    if (!found) return found.error();
    if (found->size() > 1) {
      std::vector<std::string> names;
      for (const cx::Environment* one : *found) names.push_back(one->unique_name());
      return usage_error("the run has several environments: choose one with --env: " + some_of(names));
    }
    environment_ = found->front();
    stream_ = moment_->episode().journal().stream_name(environment_->engine().stream());
    at_the_start_.clear();
    for (const auto& [global, value] : environment_->engine().globals()) at_the_start_[global] = value.print();
    for (const FactCopy& fact : environment_->engine().facts()) at_the_start_[fact.print()];
    return moment_->seek(t);
  }

  /// Which one it is, and the files that it is made of.
  Status agent() {
    auto scenario = run_.scenario();
    if (!scenario) return scenario.error();
    auto& managers = moment_->episode().agents();
    for (std::size_t i = 0; i < managers.size(); ++i)
      for (std::size_t k = 0; k < managers[i]->size(); ++k)
        if (&managers[i]->environment(k) == environment_) {
          if (k > 0) head_ += "  environment: " + yaml_quoted(environment_->name()) + '\n';
          return agent(*scenario, scenario->agents[i]);
        }
    return input_error("no agent of the run has the environment " + environment_->unique_name());
  }

  Status agent(const Scenario& scenario, const AgentSpec& agent) {
    if (agent.name_space != "/" || !agent.remaps.empty())
      return input_error("the agent has a namespace or remaps, which a story cannot have", run_.folder.string());
    const fs::path home = fs::absolute(file_).lexically_normal().parent_path();
    const auto from_here = [&](const std::string& path) {
      return fs::absolute(scenario.resolve(path)).lexically_normal().lexically_proximate(home).string();
    };
    head_ += "  config: " + yaml_quoted(from_here(agent.config)) + '\n';
    std::map<std::string, PackageSpec> packages = scenario.packages;
    for (const auto& [name, package] : agent.packages) packages[name] = package;
    std::string list;
    for (const auto& [name, package] : packages)
      if (const auto own = own_packages_.find(name);
          own == own_packages_.end() || from_here(package.folder) != from_here(own->second))
        list += (list.empty() ? "" : ", ") + name + ": " + yaml_quoted(from_here(package.folder));
    if (!list.empty()) head_ += "  packages: {" + list + "}\n";
    list.clear();
    for (const cx::GivenParameter& param : agent.params)
      list += (list.empty() ? "" : ", ") + yaml_quoted(param.name) + ": " + param.value;
    if (!list.empty()) head_ += "  params: {" + list + "}\n";
    head_ += "  seed: " + std::to_string(run_.manifest.seed) + '\n';
    return {};
  }

  void facts() {
    const RuleEngine& engine = environment_->engine();
    for (const FactCopy& fact : engine.facts()) {
      const std::string text = fact.print();
      if (points_elsewhere(text))
        notes_.push_back("left out, because what it points to is not in a story: " + text);
      else if (text != "(initial-fact)")
        given_facts_.push_back(text);
    }
    for (const auto& [global, value] : engine.globals())
      if (const auto then = at_the_start_.find(global); then == at_the_start_.end() || then->second != value.print())
        globals_.emplace_back(global,
                              value.is(ValueType::kMultifield) ? "(create$ " + value.print().substr(1) : value.print());
    next_symbol();
    if (const std::size_t waiting = engine.agenda().size(); waiting > 0)
      notes_.push_back(std::to_string(waiting) + " rules were on the agenda without their turn: a story forgets them");
  }

  /// `gensym` goes on where it was: `setgen` takes back that it was asked.
  void next_symbol() {
    RuleEngine& engine = environment_->engine();
    const auto next = engine.eval("(gensym)");
    if (!next || !next->print().starts_with("gen")) return;
    const std::string set = "(setgen " + next->print().substr(3) + ")";
    if (engine.eval(set) && set != "(setgen 1)") setgen_ = set;
  }

  /// Whether it points to something other than running goals.
  bool points_elsewhere(std::string text) const {
    for (const auto& [name, met] : actions_met_)
      for (const SkillAnswer& goal : met)
        for (std::size_t at; !goal.handle.empty() && (at = text.find(goal.handle)) != std::string::npos;)
          text.erase(at, goal.handle.size());
    return text.find("<Pointer-") != std::string::npos || text.find("<Fact-") != std::string::npos;
  }

  Status play_on() {
    end_ = std::min(at_ + from_seconds(given_.seconds), moment_->end());
    for (const ConstructInfo& c : environment_->engine().constructs())
      if (c.kind == "defrule" && c.line > 0 && fs::path(c.file).is_absolute())
        rules_.insert((c.module == "MAIN" ? "" : c.module + "::") + c.name);
    if (Status s = moment_->seek(end_); !s) return s;
    topics_ = moment_->episode().bus().topics();
    services_ = moment_->episode().bus().services();
    actions_ = moment_->episode().bus().actions();
    return {};
  }

  /// Finds goals and calls on their way at the moment, and what servers there are.
  void before(const JournalRecord& record) {
    if (record.kind == RecordKind::kBus) sent(record);
    if (record.kind == RecordKind::kAssert || record.kind == RecordKind::kDecision) accepted(record);
    if (record.kind == RecordKind::kInput) {
      answered(record);
      look(record);
    }
  }

  /// A goal or a call.
  void sent(const JournalRecord& record) {
    const std::string_view op = record.data.text("op");
    if (op == "goal")
      actions_met_[name_in(record)].push_back({std::string(record.data.text("goal_id")), record.t});
    else if (op == "call")
      services_met_[name_in(record)].push_back({std::to_string(record.data.integer("id")), record.t});
  }

  /// What a goal or a call met: answers may come in another order than what they answer. Whether it is one of these.
  bool answered(const JournalRecord& record) {
    const std::string_view what = record.data.text("what");
    const bool is_response = what == "response", is_result = what == "result", is_feedback = what == "feedback";
    if (!is_response && !is_result && !is_feedback && what != "goal-response") return false;
    accepted_ = nullptr;
    if (record.causes.empty()) return true;
    const auto logged = logged_.find({record.causes.front().stream, record.causes.front().n});
    if (logged == logged_.end()) return true;
    SkillAnswers& met = (is_response ? services_met_ : actions_met_)[name_in(record)];
    const auto is_open = [&](const SkillAnswer& one) { return one.id == logged->second.id && !one.ended; };
    const auto found = std::ranges::find_if(met, is_open);
    if (found == met.end()) return true;
    if (is_feedback) {
      if (record.t > at_) found->feedback.emplace_back(record.t, message(record, "message"));
      return true;
    }
    const bool ends = is_response || is_result || !logged->second.accepted;
    if (!ends) {
      accepted_ = &*found;
    } else if (record.t <= at_) {
      met.erase(found);
    } else if (!is_response && !is_result) {
      found->outcome = "reject";
    } else if (logged->second.status != bus::GoalStatus::kCanceled) {  // a stand-in cancels by itself
      found->ended = record.t;
      found->outcome = logged->second.status == bus::GoalStatus::kAborted ? "fail" : "succeed";
      found->result = message(record, "message");
    }
    return true;
  }

  /// A plugin says in a fact of its own, with the handle of the client, that a goal was accepted.
  void accepted(const JournalRecord& record) {
    const RecordValue* slots = record.data.find("slots");
    if (accepted_ == nullptr || slots == nullptr || !record.data.text("template").ends_with("goal-response")) return;
    const RecordValue* handle = slots->find("client-goal-handle-ptr");
    accepted_->handle = Value::handle(static_cast<Handle>(handle ? handle->integer("handle") : 0)).print();
    accepted_ = nullptr;
  }

  /// "action-ready /robot1/pick": rules asked whether it is served.
  void look(const JournalRecord& record) {
    if (record.data.text("what") != "look" || record.data.text("value") != "TRUE") return;
    const std::string text(record.data.text("name"));
    const std::size_t blank = text.find(' ');
    if (text.starts_with("action-ready ")) actions_met_[whole_name(text.substr(blank + 1))];
    if (text.starts_with("service-ready ")) services_met_[whole_name(text.substr(blank + 1))];
  }

  void after(const JournalRecord& record) {
    switch (record.kind) {
      case RecordKind::kBus: return did(record);
      case RecordKind::kInput: return came(record);
      case RecordKind::kFire: return fired(record);
      case RecordKind::kControl: return was_done(record);
      default: return;
    }
  }

  std::string message(const JournalRecord& record, const char* key) const {
    const RecordValue* value = record.data.find(key);
    return value == nullptr ? "" : to_json(*value);
  }

  void did(const JournalRecord& record) {
    sent(record);
    const std::string op(record.data.text("op")), name = name_in(record);
    const std::string fields = message(record, op == "goal" ? "goal" : "msg");
    if (op == "goal")
      expect("goal: " + yaml_quoted(name) + ", fields: " + fields, record.t);
    else if (op == "publish" && is_topic_of_rules(name))
      expect("published: " + yaml_quoted(name) + ", type: " + type_of(topics_, name) + ", fields: " + fields, record.t);
  }

  /// Not those of the node itself, such as `~/transition_event`.
  bool is_topic_of_rules(const std::string& name) const {
    return !type_of(topics_, name).empty() && name.find("clips_executive/") == std::string::npos;
  }

  void came(const JournalRecord& record) {
    const std::string what(record.data.text("what")), name = name_in(record);
    look(record);
    if (what == "topic") {
      const std::string type = type_of(topics_, name);
      if (!type.empty())
        steps_.push_back("{at: " + seconds_of(record.t) + ", publish: " + yaml_quoted(name) + ", type: " + type +
                         ", data: " + message(record, "message") + "}");
    } else if (answered(record)) {
      return;
    } else if (what != "look") {
      others_.insert(what + ' ' + name);
    }
  }

  static std::string rule_in(const JournalRecord& record) {
    const std::string rule(record.data.text("rule"));
    return rule.starts_with("MAIN::") ? rule.substr(6) : rule;
  }

  void fired(const JournalRecord& record) {
    const std::string rule = rule_in(record);
    if (!rules_.contains(rule)) return;
    auto& [count, last] = fired_[rule];
    ++count;
    last = record.t;
  }

  /// What a story, a person or `cxlab rerun` did.
  void was_done(const JournalRecord& record) {
    const std::string what(record.data.text("what")), text(record.data.text("text"));
    if (what == "assert" && !points_elsewhere(text))
      steps_.push_back("{at: " + seconds_of(record.t) + ", assert: " + yaml_quoted(text) + "}");
    else
      others_.insert("what was done from outside, " + what);
  }

  void expect(const std::string& what, SimTime t) {
    // A refresh later, because what comes between two of them may come in another order.
    expect_.push_back("{" + what + ", after: " + seconds_of(at_) +
                      ", within_s: " + seconds_of(t + std::chrono::milliseconds(100)) + "}");
  }

  /// Firings, and facts that are there at the end and were not, or the other way round.
  void what_is_left() {
    for (const auto& [rule, use] : fired_)
      expect("fires: " + yaml_quoted(rule) + (use.first > 1 ? ", count: " + std::to_string(use.first) : ""),
             use.second);
    std::set<std::string> before(given_facts_.begin(), given_facts_.end());
    constexpr std::size_t kMost = 20;
    std::size_t fresh = 0, gone = 0;
    for (const FactCopy& fact : environment_->engine().facts()) {
      const std::string text = fact.print();
      if (before.erase(text) > 0 || text.find('<') != std::string::npos || is_of_plugin(text)) continue;
      const std::string pattern = without_ids(text);
      if (++fresh <= kMost) expect_.push_back("{fact: " + yaml_quoted(pattern) + ", at: " + seconds_of(end_) + "}");
    }
    for (const std::string& text : before)
      if (!is_of_plugin(text) && text.find("<Pointer-") == std::string::npos && without_ids(text) == text &&
          ++gone <= kMost)
        expect_.push_back("{no_fact: " + yaml_quoted(text) + ", at: " + seconds_of(end_) + "}");
    for (const auto& [count, what] : {std::pair(fresh, "new facts"), {gone, "facts that went"}})
      if (count > kMost)
        notes_.push_back("of " + std::to_string(count) + ' ' + what + " the story expects the first " +
                         std::to_string(kMost));
    for (const auto& [name, calls] : services_met_)
      if (std::ranges::any_of(calls, [&](const SkillAnswer& call) { return call.sent <= at_ && call.ended; }))
        notes_.push_back(name + " was called before: what it answered is not in the story");
    for (const std::string& other : others_) notes_.push_back("not in the story: " + other);
  }

  /// Goals have other ids in a story.
  std::string without_ids(std::string fact) const {
    for (const auto& [post, logged] : logged_) {
      if (logged.id.size() != kIdSize) continue;
      for (const std::string& word : {'"' + logged.id + '"', logged.id})
        for (std::size_t at; (at = fact.find(word)) != std::string::npos;) fact.replace(at, word.size(), "?");
    }
    return fact;
  }

  static bool is_of_plugin(const std::string& fact) {
    return fact.starts_with("(ros-msgs-") || fact.starts_with("(time ");
  }

  static std::string outcome_of(const SkillAnswer& answer, SimTime from) {
    std::string out = "outcome: " + answer.outcome;
    if (answer.ended) out += ", takes_s: " + seconds_of(*answer.ended - from);
    if (!answer.result.empty()) out += ", result: " + answer.result;
    std::string feedback;
    for (const auto& [t, data] : answer.feedback)
      feedback += (feedback.empty() ? "" : ", ") + ("{after_s: " + seconds_of(t - from)) + ", data: " + data + '}';
    if (!feedback.empty()) out += ", feedback: [" + feedback + ']';
    return out;
  }

  bool is_under_way(const SkillAnswer& goal) const { return goal.sent <= at_; }
  bool is_goal_under_way() const {
    return std::ranges::any_of(actions_met_, [&](const auto& met) {
      return std::ranges::any_of(met.second, [&](const SkillAnswer& goal) { return is_under_way(goal); });
    });
  }
  std::string times() const {
    const bool later = is_goal_under_way() && begins_ < at_;
    return "  begins_s: " + seconds_of(later ? begins_ : at_) + "\n  moment: true\n" +
           (later ? "  given_at_s: " + seconds_of(at_) + '\n' : "");
  }

  /// The name of an action or service as the facts of the plugin have it, by which rules find their client.
  std::string as_written(const std::string& name) const {
    const std::string relative = '"' + name.substr(1) + '"';
    const auto has = [&](const std::string& fact) {
      return fact.starts_with("(ros-msgs-") && fact.find(relative) != std::string::npos;
    };
    return std::ranges::any_of(given_facts_, has) ? name.substr(1) : name;
  }

  std::string stand_ins(const std::map<std::string, SkillAnswers>& met, const char* word,
                        const std::vector<bus::Bus::Info>& known) const {
    std::string out;
    for (const auto& [name, answers] : met) {
      const std::string type = type_of(known, name);
      if (type.empty()) continue;
      std::string item = std::string("{") + word + ": " + yaml_quoted(as_written(name)) + ", type: " + type;
      std::string under_way, first, then;
      for (const SkillAnswer& answer : answers) {
        if (is_under_way(answer)) {
          if (&met != &actions_met_) continue;
          const std::string handle = answer.handle.empty() ? "" : "handle: " + yaml_quoted(answer.handle) + ", ";
          under_way += (under_way.empty() ? "{" : ",\n                   {") + handle +
                       "id: " + yaml_quoted(answer.id) + ", " + outcome_of(answer, at_) + '}';
        } else if (first.empty()) {
          first = outcome_of(answer, answer.sent);
        } else {
          then += (then.empty() ? "{" : ",\n           {") + outcome_of(answer, answer.sent) + '}';
        }
      }
      if (!under_way.empty()) item += ",\n       under_way: [" + under_way + "]";
      item += ", " + (first.empty() ? outcome_of({}, {}) : first);
      out += "    - " + item + (then.empty() ? "" : ",\n       then: [" + then + "]") + "}\n";
    }
    return out;
  }

  /// Globals that had changed by then; and topics, services and actions that rules had opened after the start, whose
  /// facts say which.
  std::string calls() const {
    std::string out;
    static const std::pair<const char*, const char*> kOpened[] = {
        {"(ros-msgs-subscription (topic ", "subscription"},
        {"(ros-msgs-publisher (topic ", "publisher"},
        {"(ros-msgs-client (service ", "client"},
        {"(ros-msgs-action-client (server ", "action-client"}};
    for (const std::string& fact : given_facts_)
      for (const auto& [begin, kind] : kOpened) {
        if (!fact.starts_with(begin) || at_the_start_.contains(fact)) continue;
        std::string arguments = fact.substr(std::strlen(begin));
        if (const std::size_t type = arguments.find(") (type "); type != std::string::npos)
          arguments.replace(type, std::strlen(") (type "), " ");
        if (arguments.ends_with("))")) arguments.pop_back();
        out += "    - " + yaml_quoted(std::string("(ros-msgs-create-") + kind + ' ' + arguments) + '\n';
      }
    if (!setgen_.empty()) out += "    - " + yaml_quoted(setgen_) + '\n';
    for (const auto& [global, value] : globals_)
      out += "    - " + yaml_quoted("(bind ?*" + global + "* " + value + ")") + '\n';
    return out;
  }

  static std::string list(const std::string& key, const std::vector<std::string>& items, bool quote) {
    std::string out;
    for (const std::string& item : items) out += "    - " + (quote ? yaml_quoted(item) : item) + '\n';
    return out.empty() ? out : "  " + key + ":\n" + out;
  }
  static std::string section(const std::string& key, const std::string& items) {
    return items.empty() ? items : "  " + key + ":\n" + items;
  }

  std::string text() const {
    const std::string run = fs::absolute(run_.folder).lexically_normal().filename().string();
    const std::string name = given_.name.empty() ? "at " + seconds_of(at_) + " s of " + run : given_.name;
    return "# Written by `cxlab new story`: what the agent knew at " + seconds_of(at_) + " s of the run " + run +
           ", what came to it then, and what it did.\n- story: " + yaml_quoted(name) + '\n' + head_ + times() +
           section("calls", calls()) + list("given", given_facts_, true) +
           section("skills", stand_ins(actions_met_, "action", actions_)) +
           section("serve", stand_ins(services_met_, "service", services_)) + list("steps", steps_, false) +
           list("expect", expect_, false);
  }

  const Run& run_;
  const MomentStory& given_;
  const fs::path& file_;
  const Host& host_;
  const std::map<std::string, std::string> own_packages_ = own_packages();  // each story has them
  Records records_;                                                         // outlives the moment
  std::unique_ptr<Moment> moment_;
  cx::Environment* environment_ = nullptr;
  SimTime at_{}, begins_{}, end_{};  // begins_: the last time before at which the rules were run
  std::string stream_, head_, setgen_;
  std::map<std::string, std::string> at_the_start_;  // globals with values, and facts
  std::vector<std::string> given_facts_, steps_, expect_, notes_;
  std::vector<std::pair<std::string, std::string>> globals_;
  std::set<std::string> rules_, others_;
  LoggedAnswers logged_;
  std::vector<bus::Bus::Info> topics_, services_, actions_;
  std::map<std::string, SkillAnswers> actions_met_, services_met_;
  std::map<std::string, std::pair<int, SimTime>> fired_;
  SkillAnswer* accepted_ = nullptr;  // its handle is in the fact that comes next
};

/// The lines of this file that the texts name first: "FILE:12: ...".
std::set<int> lines_named(const std::vector<std::string>& texts, const std::string& file) {
  std::set<int> lines;
  for (const std::string& text : texts) {
    if (!text.starts_with(file + ':')) continue;
    const std::size_t begin = file.size() + 1, end = text.find(':', begin);
    if (const auto line = read_number<int>(text.substr(begin, end - begin))) lines.insert(*line);
  }
  return lines;
}

/// Whether this line expects a goal or a message of the agent.
bool is_message(const std::string& expectation) {
  return expectation.starts_with("{goal: ") || expectation.starts_with("{published: ");
}

}  // namespace

Expected<WrittenStory> story_of(const Run& run, const MomentStory& moment, const fs::path& file, const Host& host) {
  auto child = Child::start([&]() -> Expected<Json> {
    const auto story = Writer(run, moment, file, host).write();
    if (!story) return story.error();
    return Json{{"text", story->text}, {"notes", story->notes}, {"expectations", story->expectations}};
  });
  if (!child) return child.error();
  const auto story = child->finish(host);
  if (!story) return story.error();
  return WrittenStory{story->at("text"), story->at("notes").get<std::vector<std::string>>(), story->at("expectations")};
}

Status keep_what_holds(WrittenStory& story, const fs::path& file, const StoryPlan& plan, const Host& host) {
  const int all = story.expectations;
  std::vector<std::string> dropped_lines;
  while (true) {
    if (Status s = replace_file(file, story.text); !s) return s;
    auto stories = read_stories({file.string()});
    if (!stories) return stories.error();
    if (Status s = play_stories(*stories, plan, host); !s || host.stopped()) return s;
    const PlayedStory& played = stories->front();
    if (played.passed()) break;
    if (played.unreadable) return *played.result.bad;
    std::string kept;
    int number = 0, dropped = 0;
    bool in_expect = false;
    const std::set<int> wrong = lines_named(played.complaints(), file.string());
    for (std::size_t begin = 0, end; begin < story.text.size(); begin = end + 1) {
      end = story.text.find('\n', begin);
      const std::string line = story.text.substr(begin, end - begin);
      in_expect = in_expect || line == "  expect:";
      if (wrong.contains(++number) && in_expect) {
        ++dropped;
        dropped_lines.push_back(line.substr(line.find_first_not_of(" -")));
      } else {
        kept += line + '\n';
      }
    }
    if (dropped == 0) return negative("the story does not play like the run: " + played.complaints().front());
    story.text = kept;
    story.expectations -= dropped;
    if (story.expectations == 0)
      return negative(
          "nothing that happened in the run happens in the story: choose another time (--at), at which fewer "
          "actions run");
  }
  constexpr std::size_t kMostListed = 8;
  if (!dropped_lines.empty())
    story.notes.push_back(std::to_string(dropped_lines.size()) + " of " + std::to_string(all) +
                          " things that happened in the run do not happen in the story, and are not expected:");
  for (std::size_t i = 0; i < std::min(kMostListed, dropped_lines.size()); ++i)
    story.notes.push_back("  " + dropped_lines[i]);
  if (dropped_lines.size() > kMostListed)
    story.notes.push_back("  and " + std::to_string(dropped_lines.size() - kMostListed) + " more");
  if (story.text.find("\n    - {goal: ") == std::string::npos &&
      story.text.find("\n    - {published: ") == std::string::npos)
    story.notes.push_back(
        std::ranges::any_of(dropped_lines, is_message)
            ? "it expects rules and facts only: what the agent asked of skills and published in the run is among what "
              "does not happen in the story"
            : "it expects rules and facts only, for the agent asked for no skill and published nothing in these "
              "seconds; a longer --for or another --at shows more");
  return {};
}

}  // namespace cxlab::lab
