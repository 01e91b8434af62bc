// cxlab why-not: why a rule of a recorded run has not fired at a time, from the rules alone, played up to then.

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/arguments.h"
#include "app/command.h"
#include "app/conditions.h"
#include "app/console.h"
#include "lab/recorded_run.h"

namespace cxlab::app {

namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string run, rule;
  std::optional<double> at;
  bool json = false;
};

std::string seconds(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", value);
  return text;
}

/// A fact as the journal tells it: `(order (id 3) (state OPEN))`.
std::string printed(const Json& data) {
  std::string out = '(' + data.value("template", std::string());
  for (const auto& [name, value] : data["slots"].items()) {
    std::string text;
    const auto put = [&](const Json& field) {
      text += ' ' + (field.is_string() ? field.get<std::string>() : field.dump());
    };
    if (value.is_array())
      for (const Json& field : value) put(field);
    else
      put(value);
    out += name == "implied" ? text : " (" + name + text + ')';
  }
  return out + ')';
}

/// When a rule fired, and how often; `facts` are those of the last time.
struct Firings {
  std::int64_t count = 0;
  double last = 0;  ///< s
  std::vector<std::string> facts;
};

Firings firings_of(const std::string& stream, const std::string& rule, const std::filesystem::path& journal) {
  Firings out;
  std::map<std::int64_t, Json> facts;  // by number, as they are at that place of the journal
  std::ifstream in(journal);
  for (std::string line; std::getline(in, line);) {
    const Json record = Json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (!record.is_object() || record.value("stream", "") != stream) continue;
    const std::string kind = record.value("kind", "");
    const Json& data = record["data"];
    if (kind == "assert") facts[data.value("fact", std::int64_t{0})] = data;
    if (kind == "modify")
      for (const auto& [slot, value] : data["slots"].items())
        facts[data.value("fact", std::int64_t{0})]["slots"][slot] = value;
    if (kind != "fire" || data.value("rule", "") != rule) continue;
    ++out.count;
    out.last = record.value("t", std::int64_t{0}) / 1e9;
    out.facts.clear();
    for (const Json& number : data["facts"])
      if (number.is_number_integer() && facts.contains(number.get<std::int64_t>()))
        out.facts.push_back(printed(facts[number.get<std::int64_t>()]));
  }
  return out;
}

/// The fact that fails in the fewest slots; the youngest of several.
struct Nearest {
  FactCopy fact;
  std::vector<Mismatch> differs;
};
std::optional<Nearest> nearest(const Condition& condition, const RuleEngine& engine) {
  std::optional<Nearest> best;
  for (FactCopy& fact : engine.facts(condition.template_name())) {
    std::vector<Mismatch> differs = mismatches(condition, fact);
    if (!best || differs.size() <= best->differs.size()) best = Nearest{std::move(fact), std::move(differs)};
  }
  return best;
}

/// Variables of a condition that earlier ones bind, too.
std::vector<std::string> shared_variables(const std::vector<Condition>& conditions, std::size_t index) {
  std::vector<std::string> out;
  for (const std::string& name : conditions[index].variables())
    for (std::size_t i = 0; i < index; ++i) {
      const auto earlier = conditions[i].variables();
      if (std::find(earlier.begin(), earlier.end(), name) == earlier.end()) continue;
      out.push_back(name);
      break;
    }
  return out;
}

/// About the first pattern that nothing gets past.
Json explain_condition(const RuleMatches& matches, const std::vector<Condition>& conditions, const RuleEngine& engine) {
  Json out;
  for (std::size_t i = 0; i < matches.patterns.size(); ++i) {
    const RuleMatches::Pattern& pattern = matches.patterns[i];
    if (pattern.partial > 0) continue;
    out["condition"] = pattern.condition;
    out["matches_alone"] = pattern.matches;
    if (conditions.size() != matches.patterns.size()) return out;  // nested conditions: CLIPS counts them otherwise
    const Condition& condition = conditions[i];
    out["pattern"] = (condition.negated ? "(not " : "") + condition.pattern.text() + (condition.negated ? ")" : "");
    if (condition.negated) {
      out["because"] = "a fact forbids it";
      if (auto found = nearest(condition, engine)) out["fact"] = found->fact.print();
      return out;
    }
    auto found = nearest(condition, engine);
    if (!found) {
      out["because"] = "there is no fact of " + condition.template_name();
      return out;
    }
    out["fact"] = found->fact.print();
    if (!found->differs.empty()) {
      const Mismatch& first = found->differs.front();
      out["because"] = "the nearest fact differs in " +
                       std::string(first.slot == "implied" ? "its values" : "slot " + first.slot) + ": found " +
                       first.found + ", expected " + first.expected;
      out["slot"] = first.slot;
    } else if (pattern.matches > 0) {
      std::string names;
      for (const std::string& name : shared_variables(conditions, i)) names += (names.empty() ? "" : ", ") + name;
      out["because"] = std::to_string(pattern.matches) +
                       " facts match it alone, none of them together with the conditions before" +
                       (names.empty() ? "" : "; these must agree: " + names);
    } else {
      out["because"] = "a test of the pattern fails for every fact";
    }
    return out;
  }
  return out;
}

Json explain_agenda(const std::vector<ActivationInfo>& agenda, const std::string& rule) {
  Json out;
  const auto own = std::find_if(agenda.begin(), agenda.end(), [&](const ActivationInfo& a) { return a.rule == rule; });
  const auto above = own - agenda.begin();
  out["above"] = above;
  out["first_above"] = Json::array();
  constexpr std::ptrdiff_t kShown = 5;
  for (auto it = agenda.begin(); it != agenda.begin() + std::min(above, kShown); ++it)
    out["first_above"].push_back({{"rule", it->rule}, {"salience", it->salience}});
  out["salience"] = own->salience;
  return out;
}

/// `stream` is the environment's in the journal.
Json explain(cx::Environment& environment, const std::string& stream, const std::string& rule,
             const std::filesystem::path& journal) {
  RuleEngine& engine = environment.engine();
  const ConstructInfo& info = *engine.find_construct("defrule", rule);
  const std::string name = info.name;
  // The executive takes its time fact back after each run: here is what the next run would find.
  if (engine.find_construct("defrule", "time-retract") && engine.facts("time").empty())
    if (auto fact = engine.assert_string("(time " + std::to_string(to_seconds(environment.now())) + ")"); fact)
      engine.refresh_all_agendas();
  const Firings fired = firings_of(stream, name, journal);
  Json out{{"environment", environment.name()},
           {"rule", name},
           {"file", environment.files().journal_name(info.file)},
           {"line", info.line}};
  out["fired"] = fired.count;
  if (fired.count > 0) {
    out["last_fired_s"] = fired.last;
    out["last_facts"] = fired.facts;
  }
  auto matches = engine.matches(rule);
  if (!matches) {
    out["verdict"] = matches.error().message;
    return out;
  }
  const auto complete = [](const RuleMatches& m) {
    return std::all_of(m.patterns.begin(), m.patterns.end(), [](const auto& p) { return p.partial > 0; });
  };
  const auto best = std::find_if(matches->begin(), matches->end(), complete);
  if (std::any_of(matches->begin(), matches->end(), [](const RuleMatches& m) { return m.activations > 0; })) {
    out["verdict"] = "waiting";
    out["agenda"] = explain_agenda(engine.agenda(), name);
  } else if (best != matches->end()) {
    out["verdict"] = "fired";
  } else {
    out["verdict"] = "condition";
    out["first_unmet"] = explain_condition(matches->front(), conditions_of(info.text), engine);
  }
  return out;
}

void print(const Json& e) {
  const auto text = [](const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); };
  std::printf("%s (%s:%s) in %s\n", text(e["rule"]).c_str(), text(e["file"]).c_str(), text(e["line"]).c_str(),
              text(e["environment"]).c_str());
  if (e["verdict"] == "waiting") {
    const Json& agenda = e["agenda"];
    std::printf("  all its conditions hold: the next run fires it, with salience %s; %s activations stand above it\n",
                text(agenda["salience"]).c_str(), text(agenda["above"]).c_str());
    for (const Json& above : agenda["first_above"])
      std::printf("    %s, salience %s\n", text(above["rule"]).c_str(), text(above["salience"]).c_str());
  } else if (e["verdict"] == "fired") {
    std::printf("  all its conditions hold, and it has fired for what holds\n");
  } else if (e["verdict"] == "condition") {
    const Json& unmet = e["first_unmet"];
    std::printf("  condition %s does not hold%s%s\n", text(unmet["condition"]).c_str(),
                unmet.contains("pattern") ? ": " : "", unmet.contains("pattern") ? text(unmet["pattern"]).c_str() : "");
    if (unmet.contains("because")) std::printf("  %s\n", text(unmet["because"]).c_str());
    if (unmet.contains("fact")) std::printf("    %s\n", text(unmet["fact"]).c_str());
  }
  std::printf("  fired %s times so far", text(e["fired"]).c_str());
  if (e.contains("last_fired_s")) {
    std::printf(", the last time at %s with\n", seconds(e["last_fired_s"].get<double>()).c_str());
    for (const Json& fact : e["last_facts"]) std::printf("    %s\n", text(fact).c_str());
  } else {
    std::printf("\n");
  }
}

Error unknown_rule(Episode& episode, const std::string& rule) {
  std::vector<std::string> names;
  for (auto& agent : episode.agents())
    for (std::size_t i = 0; i < agent->size(); ++i)
      for (const ConstructInfo& info : agent->environment(i).engine().constructs())
        if (info.kind == "defrule") names.push_back(info.name);
  return input_error("no environment has a rule '" + rule + "'" + did_you_mean(rule, names));
}

int why_not(const Options& options) {
  auto run = lab::RecordedRun::open(options.run);
  if (!run) return fail(run.error());
  SimTime end = run->finished ? run->sim_time : lab::kLongestRun;
  if (options.at) end = std::min(end, from_seconds(*options.at));
  auto replay = lab::RulesReplay::load(*run, run->finished ? run->sim_time : lab::kLongestRun, JournalLevel::kFull);
  if (!replay) return fail(replay.error());
  Episode& episode = *replay->episode;
  if (!run->finished) end = std::min(end, episode.replay_end());
  Console console(true);
  const lab::Host host = console.host();
  Status played = episode.start();
  while (played && !episode.over() && !host.stopped() && episode.next_tick() <= end) played = episode.tick();
  if (signal_that_came()) return 128 + signal_that_came();
  if (!played && run->status != "failed") return fail(played.error());
  if (Status s = episode.journal().flush(); !s) return fail(s.error());
  Json explanations = Json::array();
  for (auto& agent : episode.agents())
    for (std::size_t i = 0; i < agent->size(); ++i)
      if (RuleEngine& engine = agent->environment(i).engine(); engine.find_construct("defrule", options.rule))
        explanations.push_back(explain(agent->environment(i), episode.journal().stream_name(engine.stream()),
                                       options.rule, replay->journal()));
  if (explanations.empty()) return fail(unknown_rule(episode, options.rule));
  const double t = std::max(0.0, to_seconds(episode.now()));
  if (options.json) {
    std::printf(
        "%s\n",
        Json{{"at_s", t}, {"explanations", explanations}}.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    return 0;
  }
  std::printf("after the tick at %s:\n", seconds(t).c_str());
  for (const Json& explanation : explanations) print(explanation);
  return 0;
}

}  // namespace

void add_why_not(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("why-not", "Says why a rule of a recorded run has not fired");
  command->add_option("run", options->run, "Folder of the run")->required();
  command->add_option("rule", options->rule, "Name of the rule")->required();
  command->add_option("--at", options->at, "When, s of simulated time (default: the end)")->check(not_negative());
  command->add_flag("--json", options->json, "The answer as JSON");
  command->callback([options, &action] { action = [options] { return why_not(*options); }; });
}

}  // namespace cxlab::app
