#include "lab/story_of_moment.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>
#include <set>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "cx/engine/form_reader.h"
#include "cx/journal/journal_reader.h"
#include "cx/journal/run_folder.h"
#include "cx/testing/story_parts.h"
#include "lab/child.h"
#include "lab/moment.h"

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

/// What a goal or a call met.
struct SkillAnswer {
  SimTime sent{};
  std::optional<SimTime> ended = {};
  std::string outcome = "never", result = {};  // JSON
};
/// A goal of before the moment that has no result yet.
struct GoalUnderWay {
  SkillAnswer answer;
  bool answered = false;  ///< whether it was taken
  std::string handle = {}, id = {};
};
/// By name, in order of sending. `earlier`: how many calls of before the moment have no answer yet.
struct SkillAnswers {
  std::vector<SkillAnswer> answers;
  std::deque<GoalUnderWay> under_way;
  std::size_t earlier = 0, replied = 0;

  /// The first that nothing is known of.
  SkillAnswer* open() {
    const auto found =
        std::ranges::find_if(answers, [](const SkillAnswer& a) { return !a.ended && a.outcome == "never"; });
    return found == answers.end() ? nullptr : &*found;
  }
};

class Writer {
 public:
  Writer(const Run& run, const MomentStory& moment, const fs::path& file, const Host& host)
      : run_(run), given_(moment), file_(file), host_(host) {}

  Expected<WrittenStory> write() {
    if (Status s = find(); !s) return s.error();
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
    if (expect_.empty())
      return negative("nothing that a story could expect happened within " + general_text(given_.seconds, 6) +
                      " s after " + seconds_of(at_) + " s: choose another time, or a longer stretch (--for)");
    return out;
  }

 private:
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
        globals_.emplace_back(global, value.print());
    if (const std::size_t waiting = engine.agenda().size(); waiting > 0)
      notes_.push_back(std::to_string(waiting) + " rules were on the agenda without their turn: a story forgets them");
  }

  /// Whether it points to something other than running goals.
  bool points_elsewhere(std::string text) const {
    for (const auto& [name, met] : actions_met_)
      for (const GoalUnderWay& goal : met.under_way)
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
    const std::string name = name_in(record);
    if (record.kind == RecordKind::kBus && record.data.text("op") == "goal")
      actions_met_[name].under_way.push_back({.answer = {record.t}, .id = std::string(record.data.text("goal_id"))});
    if (record.kind == RecordKind::kBus && record.data.text("op") == "call") ++services_met_[name].earlier;
    if (record.kind == RecordKind::kAssert || record.kind == RecordKind::kDecision) taken(record);
    if (record.kind != RecordKind::kInput) return;
    const std::string_view what = record.data.text("what");
    if (what == "goal-response") last_name_ = name;
    if (what == "result" && !actions_met_[name].under_way.empty()) actions_met_[name].under_way.pop_front();
    if (what == "response" && services_met_[name].earlier > 0) --services_met_[name].earlier;
    look(record);
  }

  /// The handle of the client, in the slots of `ros-msgs-goal-response`.
  static Value handle_in(const RecordValue& slots) {
    const RecordValue* slot = slots.find("client-goal-handle-ptr");
    return Value::handle(static_cast<Handle>(slot ? slot->integer("handle") : 0));
  }
  static bool is_rejected(const RecordValue& slots) { return handle_in(slots).as_handle() == Handle::kNone; }

  /// A goal was taken before the moment, or rejected.
  void taken(const JournalRecord& record) {
    const RecordValue* slots = record.data.find("slots");
    if (record.data.text("template") != "ros-msgs-goal-response" || slots == nullptr || last_name_.empty()) return;
    auto& goals = actions_met_[last_name_].under_way;
    const auto goal = std::ranges::find(goals, false, &GoalUnderWay::answered);
    last_name_.clear();
    if (goal == goals.end()) return;
    goal->answered = true;
    if (is_rejected(*slots))
      goals.erase(goal);
    else
      goal->handle = handle_in(*slots).print();
  }

  /// The first goal of before the moment of which it is not known how it ended.
  static SkillAnswer* earlier_of(SkillAnswers& met) {
    const auto goal = std::ranges::find_if(
        met.under_way, [](const GoalUnderWay& g) { return !g.answer.ended && g.answer.outcome == "never"; });
    return goal == met.under_way.end() ? nullptr : &goal->answer;
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
      case RecordKind::kBus: return sent(record);
      case RecordKind::kInput: return came(record);
      case RecordKind::kFire: return fired(record);
      case RecordKind::kAssert:
      case RecordKind::kDecision: return asserted(record);
      default: return;
    }
  }

  std::string message(const JournalRecord& record, const char* key) const {
    const RecordValue* value = record.data.find(key);
    return value == nullptr ? "" : to_json(*value);
  }

  void sent(const JournalRecord& record) {
    const std::string op(record.data.text("op")), name = name_in(record);
    if (op == "goal") actions_met_[name].answers.push_back({record.t});
    if (op == "call") services_met_[name].answers.push_back({record.t});
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
    const std::string content = message(record, "message");
    look(record);
    if (what == "topic") {
      const std::string type = type_of(topics_, name);
      if (!type.empty())
        steps_.push_back("{at: " + seconds_of(record.t) + ", publish: " + yaml_quoted(name) + ", type: " + type +
                         ", data: " + content + "}");
    } else if (what == "result" || what == "response") {
      SkillAnswers& met = (what == "result" ? actions_met_ : services_met_)[name];
      SkillAnswer* answer = earlier_of(met);
      if (answer == nullptr && met.earlier > 0) {
        --met.earlier;
        skipped_.insert(name);
      } else if (answer != nullptr || (answer = met.open()) != nullptr) {
        answer->ended = record.t;
        answer->outcome = "succeed";
        answer->result = content;
        last_ = answer;
      }
    } else if (what == "goal-response") {
      SkillAnswers& met = actions_met_[name];
      const auto waits = std::ranges::find(met.under_way, false, &GoalUnderWay::answered);
      if (waits != met.under_way.end()) {
        waits->answered = true;
        last_ = &waits->answer;
        return;
      }
      last_ = met.replied < met.answers.size() ? &met.answers[met.replied++] : nullptr;
    } else if (what != "look" && what != "feedback") {
      others_.insert(what + ' ' + name);
    }
  }

  void fired(const JournalRecord& record) {
    std::string rule(record.data.text("rule"));
    if (rule.starts_with("MAIN::")) rule = rule.substr(6);
    if (!rules_.contains(rule)) return;
    auto& [count, last] = fired_[rule];
    ++count;
    last = record.t;
  }

  /// A plugin tells in a fact of its own how a goal was taken, or ended.
  void asserted(const JournalRecord& record) {
    const std::string_view deftemplate = record.data.text("template");
    const RecordValue* slots = record.data.find("slots");
    if (last_ == nullptr || slots == nullptr) return;
    if (deftemplate.ends_with("goal-response")) {
      if (is_rejected(*slots)) last_->outcome = "reject";
    } else if (deftemplate.ends_with("wrapped-result")) {
      if (slots->text("code") == "ABORTED") last_->outcome = "fail";
      if (slots->text("code") == "CANCELED") *last_ = {last_->sent, {}, "never", {}};  // a stand-in cancels by itself
    } else {
      return;
    }
    last_ = nullptr;
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
      if (++fresh <= kMost) expect_.push_back("{fact: " + yaml_quoted(text) + ", at: " + seconds_of(end_) + "}");
    }
    for (const std::string& text : before)
      if (!is_of_plugin(text) && text.find("<Pointer-") == std::string::npos && ++gone <= kMost)
        expect_.push_back("{no_fact: " + yaml_quoted(text) + ", at: " + seconds_of(end_) + "}");
    for (const auto& [count, what] : {std::pair(fresh, "new facts"), {gone, "facts that went"}})
      if (count > kMost)
        notes_.push_back("of " + std::to_string(count) + ' ' + what + " the story expects the first " +
                         std::to_string(kMost));
    for (const std::string& name : skipped_)
      notes_.push_back(name + " was called before: what it answered is not in the story");
    for (const std::string& other : others_) notes_.push_back("not in the story: " + other);
  }

  static bool is_of_plugin(const std::string& fact) {
    return fact.starts_with("(ros-msgs-") || fact.starts_with("(time ");
  }

  static std::string outcome_of(const SkillAnswer& answer, SimTime from) {
    std::string out = "outcome: " + answer.outcome;
    if (answer.ended) out += ", takes_s: " + seconds_of(*answer.ended - from);
    if (!answer.result.empty()) out += ", result: " + answer.result;
    return out;
  }

  bool is_goal_under_way() const {
    return std::ranges::any_of(actions_met_, [](const auto& met) { return !met.second.under_way.empty(); });
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
      std::string under_way;
      for (const GoalUnderWay& goal : answers.under_way) {
        std::string one;
        if (!goal.handle.empty()) one += "handle: " + yaml_quoted(goal.handle) + ", ";
        if (!goal.id.empty()) one += "id: " + yaml_quoted(goal.id) + ", ";
        under_way += (under_way.empty() ? "{" : ",\n                   {") + one + outcome_of(goal.answer, at_) + '}';
      }
      if (!under_way.empty()) item += ",\n       under_way: [" + under_way + "]";
      std::string then;
      for (std::size_t i = 0; i < std::max<std::size_t>(answers.answers.size(), 1); ++i) {
        const SkillAnswer answer = i < answers.answers.size() ? answers.answers[i] : SkillAnswer();
        const std::string outcome = outcome_of(answer, answer.sent);
        if (i == 0)
          item += ", " + outcome;
        else
          then += (then.empty() ? "" : ",\n           ") + ("{" + outcome + "}");
      }
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
  Records records_;  // outlives the moment
  std::unique_ptr<Moment> moment_;
  cx::Environment* environment_ = nullptr;
  SimTime at_{}, begins_{}, end_{};  // begins_: the last time before at which the rules were run
  std::string stream_, head_, last_name_;
  std::map<std::string, std::string> at_the_start_;  // globals with values, and facts
  std::vector<std::string> given_facts_, steps_, expect_, notes_;
  std::vector<std::pair<std::string, std::string>> globals_;
  std::set<std::string> rules_, skipped_, others_;
  std::vector<bus::Bus::Info> topics_, services_, actions_;
  std::map<std::string, SkillAnswers> actions_met_, services_met_;
  std::map<std::string, std::pair<int, SimTime>> fired_;
  SkillAnswer* last_ = nullptr;
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
        "it expects rules and facts only, for the agent asked for no skill and published nothing in these seconds; "
        "a longer --for or another --at shows more");
  return {};
}

}  // namespace cxlab::lab
