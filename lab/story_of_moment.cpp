#include "lab/story_of_moment.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "cx/journal/journal_reader.h"
#include "cx/testing/story_parts.h"
#include "lab/child.h"
#include "lab/moment.h"
#include "lab/moment_exchanges.h"
#include "lab/moment_facts.h"
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

std::string seconds_of(SimTime t) { return general_text(to_seconds(t), 12); }

/// Types of what was on the bus at some time of the story, by name.
using Types = std::map<std::string, std::string>;

void note(const std::vector<bus::Bus::Info>& all, Types& types) {
  for (const bus::Bus::Info& one : all)
    if (!one.type.empty()) types.try_emplace(one.name, one.type);
}

std::string rule_in(const JournalRecord& record) {
  const std::string rule(record.data.text("rule"));
  return rule.starts_with("MAIN::") ? rule.substr(6) : rule;
}

std::string section(const std::string& key, const std::string& items) {
  return items.empty() ? items : "  " + key + ":\n" + items;
}

std::string list_section(const std::string& key, const std::vector<std::string>& items) {
  std::string out;
  for (const std::string& item : items) out += "    - " + item + '\n';
  return section(key, out);
}

class Writer {
 public:
  Writer(const Run& run, const MomentStory& moment, const fs::path& file, const Host& host)
      : run_(run), given_(moment), file_(file), host_(host) {}

  /// Reads the moment and what comes after it, then writes: facts, stand-ins, steps, expectations.
  Expected<WrittenStory> write() {
    auto scenario = run_.scenario();
    if (!scenario) return scenario.error();
    scenario_ = *std::move(scenario);
    if (Status s = find(); !s) return s.error();
    auto exchanges = MomentExchanges::read(run_.folder / "inputs.bin", stream_, node_, at_);
    if (!exchanges) return exchanges.error();
    exchanges_ = *std::move(exchanges);
    if (Status s = agent(); !s) return s.error();
    const std::size_t so_far = records_.all.size();
    for (const JournalRecord& record : records_.all)
      if (record.stream == stream_) {
        exchanges_.hear(record);
        facts_.hear(record);
      }
    facts_.read(*environment_, exchanges_);
    if (has_goal_under_way() && begins_before_ >= begins_)
      return input_error("--at: at " + seconds_of(at_) +
                         " s a goal is in progress, and the rules have not run before; expected a later moment");
    if (Status s = play_on(); !s) return s.error();
    for (std::size_t i = so_far; i < records_.all.size(); ++i)
      if (records_.all[i].stream == stream_) happened(records_.all[i]);
    compare_facts();
    if (expect_.empty()) return nothing_happened();
    std::vector<std::string> notes = facts_.lost();
    notes.insert(notes.end(), notes_.begin(), notes_.end());
    for (const std::string& other : others_) notes.push_back("not in the story: " + other);
    for (const auto& [name, t] : exchanges_.without_server())
      if (has_stand_in(name))
        notes.push_back(name + " is served from the start of the story, and nobody served it in the run at " +
                        seconds_of(t) + " s");
    return WrittenStory{text(), std::move(notes), static_cast<int>(expect_.size())};
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
               seconds_of(std::max(SimTime::zero(), *earlier - scenario_.tick)) + " has";
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
    return record.kind == RecordKind::kBus &&
           (op == "goal" || (op == "publish" && is_topic_of_rules(name_in_rules(record, node_))));
  }

  /// Goes to the last time at which the executive ran the rules.
  Status find() {
    auto moment = Moment::open(run_, host_);
    if (!moment) return moment.error();
    moment_ = *std::move(moment);
    if (Status s = seek(given_.at); !s) return about_option(s.error(), "--at");
    if (moment_->cut_off()) return about_option(run_.ends_at(moment_->end()), "--at");
    at_ = moment_->t();
    SimTime beat = kNever, before = kNever;
    for (const JournalRecord& record : records_.all)
      if (record.stream == stream_ && record.kind == RecordKind::kAssert && record.data.text("template") == "time")
        before = std::exchange(beat, record.t);
    if (beat != kNever && beat != at_) {
      at_ = beat;
      if (Status s = moment_->rewind(); !s) return s;
      if (Status s = seek(beat); !s) return s;
    }
    begins_ = due_of(at_);
    begins_before_ = before == kNever ? at_ : due_of(before);
    return {};
  }

  /// When the rules had to run that ran in this tick: the executive counts from the time at which it begins.
  SimTime due_of(SimTime tick) const {
    const auto due = dues_.find(tick);
    return due == dues_.end() || due->second > tick || due->second + scenario_.tick <= tick ? tick : due->second;
  }

  Status seek(SimTime t) {
    records_.all.clear();
    moment_->episode().journal().observe(records_);
    if (Status s = moment_->seek(SimTime{-1}); !s) return s;  // to before the first tick
    auto found = moment_->environments(given_.environment);
    if (!found) return found.error();
    std::vector<std::string> names;
    for (cx::Environment* one : *found) {
      names.push_back(one->unique_name());
      environment_ = one;
      if (names.back() != given_.environment) continue;
      names = {given_.environment};  // that of another agent may end in this name
      break;
    }
    if (names.size() > 1)
      return usage_error("the run has several environments: choose one with --env: " + some_of(names));
    std::tie(agent_, number_) = owner_of(*environment_);
    node_ = manager_node(scenario_.agents[agent_]);
    stream_ = moment_->episode().journal().stream_name(environment_->engine().stream());
    facts_.begin(environment_->engine());
    dues_.clear();
    moment_->after_tick = [this, due = kNever, &agent = *moment_->episode().agents()[agent_]]() mutable {
      dues_[moment_->t()] = std::exchange(due, agent.next_due());
      if (notes_types_) note_types();
    };
    return moment_->seek(t);
  }

  /// The agent that has the environment, and the environment's number there.
  std::pair<std::size_t, std::size_t> owner_of(const cx::Environment& environment) const {
    auto& managers = moment_->episode().agents();
    for (std::size_t i = 0; i < managers.size(); ++i)
      for (std::size_t k = 0; k < managers[i]->size(); ++k)
        if (&managers[i]->environment(k) == &environment) return {i, k};
    return {};
  }

  /// The files that the agent is made of, and its settings.
  Status agent() {
    const AgentSpec& agent = scenario_.agents[agent_];
    if (number_ > 0) head_ += "  environment: " + yaml_quoted(environment_->name()) + '\n';
    std::map<std::string, std::string> packages;
    for (const auto& [name, package] : scenario_.packages) packages[name] = normal(scenario_.resolve(package.folder));
    for (const auto& [name, package] : agent.packages) packages[name] = normal(scenario_.resolve(package.folder));
    fs::path config = normal(scenario_.resolve(agent.config));
    for (const auto& [name, now] : given_.packages) {
      const auto then = packages.find(name);
      if (then == packages.end()) {
        std::vector<std::string> names;
        for (const auto& [known, folder] : packages) names.push_back(known);
        return usage_error("--package: the run has no package '" + name + "'; it has " +
                           some_of_and_nearest(name, names));
      }
      const fs::path inside = config.lexically_relative(then->second);
      if (*inside.begin() != "..") config = normal(fs::path(now) / inside);
      packages[name] = normal(now);
    }
    if (!is_file(config))
      return input_error(
          "the configuration of the agent is not there: if its package was moved, name its folder with --package "
          "NAME=DIR",
          config.string());
    head_ += "  config: " + yaml_quoted(from_here(config)) + '\n';
    std::string list;
    for (const auto& [name, folder] : packages)
      if (const auto own = own_packages_.find(name); own == own_packages_.end() || folder != normal(own->second))
        list += (list.empty() ? "" : ", ") + name + ": " + yaml_quoted(from_here(folder));
    if (!list.empty()) head_ += "  packages: {" + list + "}\n";
    list.clear();
    for (const cx::GivenParameter& param : agent.params)
      list += (list.empty() ? "" : ", ") + yaml_quoted(param.name) + ": " + param.value;
    if (!list.empty()) head_ += "  params: {" + list + "}\n";
    head_ += "  seed: " + std::to_string(run_.manifest.seed) + '\n';
    if (scenario_.tick != testing::kTick) head_ += "  tick_s: " + seconds_of(scenario_.tick) + '\n';
    return {};
  }

  static std::string normal(const fs::path& path) { return fs::absolute(path).lexically_normal().string(); }
  std::string from_here(const fs::path& path) const {
    return path.lexically_proximate(fs::path(normal(file_)).parent_path()).string();
  }

  Status play_on() {
    end_ = std::min(at_ + from_seconds(given_.seconds), moment_->end());
    for (const ConstructInfo& c : environment_->engine().constructs())
      if (c.kind == "defrule" && c.line > 0 && fs::path(c.file).is_absolute())
        rules_.insert((c.module == "MAIN" ? "" : c.module + "::") + c.name);
    note_types();
    notes_types_ = true;
    return moment_->seek(end_);
  }

  /// Rules may close what they used before the end of the story.
  void note_types() {
    const bus::Bus& bus = moment_->episode().bus();
    note(bus.topics(), types_[bus::NameKind::kTopic]);
    note(bus.services(), types_[bus::NameKind::kService]);
    note(bus.actions(), types_[bus::NameKind::kAction]);
  }

  /// A story has the names that the rules write, for its agent has no namespace and no remaps. None for names below
  /// that of the node: it may have another one in the story.
  std::string type_of(bus::NameKind kind, const std::string& name) const {
    const auto types = types_.find(kind);
    if (types == types_.end() || name.starts_with("/~")) return {};
    for (const std::string& written : {name, name.substr(1)})
      if (const auto found = types->second.find(node_.resolve(written, kind)); found != types->second.end())
        return found->second;
    return {};
  }

  void happened(const JournalRecord& record) {
    const bool is_answer = exchanges_.hear(record);
    if (record.t <= at_) return;
    switch (record.kind) {
      case RecordKind::kBus: return did(record);
      case RecordKind::kInput: return is_answer ? void() : came(record);
      case RecordKind::kFire: return fired(record);
      case RecordKind::kControl: return was_done(record);
      default: return;
    }
  }

  void did(const JournalRecord& record) {
    const std::string op(record.data.text("op")), name = name_in_rules(record, node_);
    const std::string fields = message_of(record, op == "goal" ? "goal" : "msg");
    if (op == "goal")
      expect("goal: " + yaml_quoted(facts_.as_written(name)) + ", fields: " + fields, record.t);
    else if (op == "publish" && is_topic_of_rules(name))
      expect(
          "published: " + yaml_quoted(name) + ", type: " + type_of(bus::NameKind::kTopic, name) + ", fields: " + fields,
          record.t);
  }

  /// Not those of the node itself, such as `~/transition_event`.
  bool is_topic_of_rules(const std::string& name) const {
    return !type_of(bus::NameKind::kTopic, name).empty() && name.find("clips_executive/") == std::string::npos;
  }

  void came(const JournalRecord& record) {
    const std::string what(record.data.text("what")), name = name_in_rules(record, node_);
    const std::string type = type_of(bus::NameKind::kTopic, name);
    if (what == "topic" && !type.empty())
      steps_.push_back("{at: " + seconds_of(record.t) + ", publish: " + yaml_quoted(name) + ", type: " + type +
                       ", data: " + message_of(record, "message") + "}");
    else if (what != "topic" && what != "look")
      others_.insert(what + ' ' + name);
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
    if (what == "assert" && !has_pointer(text))
      steps_.push_back("{at: " + seconds_of(record.t) + ", assert: " + yaml_quoted(text) + "}");
    else
      others_.insert("what was done from outside, " + what);
  }

  void expect(const std::string& what, SimTime t) {
    // A refresh later, because what comes between two of them may come in another order.
    expect_.push_back("{" + what + ", after: " + seconds_of(at_) +
                      ", within_s: " + seconds_of(t + std::chrono::milliseconds(100)) + "}");
  }

  /// Facts that are there at the end and were not, or the other way round; and the firings.
  void compare_facts() {
    for (const auto& [rule, use] : fired_)
      expect("fires: " + yaml_quoted(rule) + (use.first > 1 ? ", count: " + std::to_string(use.first) : ""),
             use.second);
    const std::vector<std::string> given = facts_.texts();
    std::set<std::string> before(given.begin(), given.end());
    constexpr std::size_t kMost = 20;
    std::size_t fresh = 0, gone = 0, unwritable = 0;
    const auto can_be_expected = [&](const std::string& fact) {
      if (fact.starts_with("(ros-msgs-") || fact.starts_with("(time ") || has_pointer(fact)) return false;
      const bool is_allowed = has_allowed_values(fact, environment_->engine());
      if (!is_allowed) ++unwritable;
      return is_allowed;
    };
    for (const FactCopy& fact : environment_->engine().facts()) {
      const std::string text = fact.print();
      if (before.erase(text) > 0 || !can_be_expected(text)) continue;
      const std::string pattern = exchanges_.without_ids(text);
      if (++fresh <= kMost) expect_.push_back("{fact: " + yaml_quoted(pattern) + ", at: " + seconds_of(end_) + "}");
    }
    for (const std::string& text : before)
      if (can_be_expected(text) && exchanges_.without_ids(text) == text && ++gone <= kMost)
        expect_.push_back("{no_fact: " + yaml_quoted(text) + ", at: " + seconds_of(end_) + "}");
    for (const auto& [count, what] : {std::pair(fresh, "new facts"), {gone, "facts that went"}})
      if (count > kMost)
        notes_.push_back("of " + std::to_string(count) + ' ' + what + " the story expects the first " +
                         std::to_string(kMost));
    if (unwritable > 0)
      notes_.push_back("not expected, because their templates do not allow their values: " +
                       std::to_string(unwritable) + " of the facts that are new or went");
  }

  static std::string outcome_of(const Exchange& answer, SimTime from) {
    std::string out = "outcome: " + answer.outcome;
    if (answer.ended) out += ", takes_s: " + seconds_of(*answer.ended - from);
    if (!answer.result.empty()) out += ", result: " + answer.result;
    std::string feedback;
    for (const auto& [t, data] : answer.feedback)
      feedback += (feedback.empty() ? "" : ", ") + ("{after_s: " + seconds_of(t - from)) + ", data: " + data + '}';
    if (!feedback.empty()) out += ", feedback: [" + feedback + ']';
    return out;
  }

  bool has_goal_under_way() const {
    return std::ranges::any_of(exchanges_.actions(), [&](const auto& of) {
      return facts_.has_action_client(of.first) && exchanges_.any_under_way(of.second);
    });
  }

  /// When the story begins: before the moment, if goals have to run by then.
  std::string times() const {
    const bool later = has_goal_under_way();
    return "  begins_s: " + seconds_of(later ? begins_before_ : begins_) + "\n  moment: true\n" +
           (later ? "  given_at_s: " + seconds_of(at_) + '\n' : "");
  }

  bool has_stand_in(const std::string& name) const {
    return (exchanges_.actions().contains(name) && !type_of(bus::NameKind::kAction, name).empty()) ||
           (exchanges_.services().contains(name) && !type_of(bus::NameKind::kService, name).empty());
  }

  std::string skills() const {
    std::string out;
    for (const auto& [name, goals] : exchanges_.actions())
      if (const std::string type = type_of(bus::NameKind::kAction, name); !type.empty())
        out += stand_in("action: " + yaml_quoted(facts_.as_written(name)) + ", type: " + type, goals,
                        facts_.has_action_client(name), "");
    return out;
  }

  std::string services() const {
    std::string out;
    for (const auto& [name, requests] : exchanges_.services()) {
      const std::string type = type_of(bus::NameKind::kService, name);
      if (type.empty()) continue;
      const bool has_client = facts_.has_client(name);
      const std::int64_t next = exchanges_.next_request(name);
      out += stand_in("service: " + yaml_quoted(facts_.as_written(name)) + ", type: " + type, requests, has_client,
                      has_client && next > 1 ? ", next_id: " + std::to_string(next) : "");
    }
    return out;
  }

  /// `more` are further keys.
  std::string stand_in(const std::string& of, const MomentExchanges::List& answers, bool is_sent_again,
                       const std::string& more) const {
    std::string under_way, first, then;
    for (const Exchange& answer : answers) {
      if (exchanges_.is_under_way(answer)) {
        if (!is_sent_again) continue;
        const std::string handle = answer.handle.empty() ? "" : "handle: " + yaml_quoted(answer.handle) + ", ";
        under_way += (under_way.empty() ? "{" : ",\n                   {") + handle + "id: " + yaml_quoted(answer.id) +
                     ", " + outcome_of(answer, at_) + '}';
      } else if (first.empty()) {
        first = outcome_of(answer, answer.sent);
      } else {
        then += (then.empty() ? "{" : ",\n           {") + outcome_of(answer, answer.sent) + '}';
      }
    }
    return "    - {" + of + more + (under_way.empty() ? "" : ",\n       under_way: [" + under_way + "]") + ", " +
           (first.empty() ? outcome_of({}, {}) : first) + (then.empty() ? "" : ",\n       then: [" + then + "]") +
           "}\n";
  }

  std::string text() const {
    const std::string run = fs::absolute(run_.folder).lexically_normal().filename().string();
    const std::string name = given_.name.empty() ? "at " + seconds_of(at_) + " s of " + run : given_.name;
    return "# Written by `cxlab new story`: what the agent knew at " + seconds_of(at_) + " s of the run " + run +
           ", what came to it then, and what it did.\n- story: " + yaml_quoted(name) + '\n' + head_ + times() +
           section("calls", facts_.calls()) + section("given", facts_.given()) + section("skills", skills()) +
           section("serve", services()) + list_section("steps", steps_) + list_section("expect", expect_);
  }

  const Run& run_;
  const MomentStory& given_;
  const fs::path& file_;
  const Host& host_;
  const std::map<std::string, std::string> own_packages_ = own_packages();  // each story has them
  Scenario scenario_;
  Records records_;  // outlives the moment
  std::unique_ptr<Moment> moment_;
  cx::Environment* environment_ = nullptr;
  std::size_t agent_ = 0, number_ = 0;  // of the scenario, and of the environment in it
  std::map<SimTime, SimTime> dues_;     // what was due next before each tick
  SimTime at_{}, end_{};
  SimTime begins_{}, begins_before_{};  // when the rules had to run that ran at the moment, and those before
  std::string stream_, head_;
  MomentExchanges exchanges_;
  MomentFacts facts_;
  std::vector<std::string> steps_, expect_, notes_;
  std::set<std::string> rules_, others_;  // others_: what came and is not in the story
  std::map<bus::NameKind, Types> types_;
  bus::NodeName node_;  // of the agent in the run
  bool notes_types_ = false;
  std::map<std::string, std::pair<int, SimTime>> fired_;
};

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

}  // namespace cxlab::lab
