#include "lab/what_if.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "cx/engine/form_reader.h"
#include "cx/explain/names.h"
#include "cx/explain/pattern.h"
#include "lab/run.h"
#include "scenarios/catalogue.h"
#include "scenarios/episode.h"
#include "scenarios/metric.h"

namespace cxlab::lab {

namespace {

bool is_global(const std::string& name) { return name.starts_with("?*") && name.size() > 3 && name.ends_with('*'); }

/// `limit` of `?*limit*`.
std::string without_marks(const std::string& global) { return global.substr(2, global.size() - 3); }

/// "NAME=VALUE" as (NAME, VALUE).
std::pair<std::string, std::string> name_and_value(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  return {assignment.substr(0, equals), equals == assignment.npos ? std::string() : assignment.substr(equals + 1)};
}

/// `executive.assert_time` of "/ns/clips_manager.executive.assert_time" or "clips_manager.executive.assert_time", if
/// that is the node.
std::optional<std::string> parameter_of(const bus::NodeName& node, const std::string& name) {
  for (const std::string& prefix : {node.name + '.', node.full_name() + '.'})
    if (name.starts_with(prefix) && name.size() > prefix.size()) return name.substr(prefix.size());
  return std::nullopt;
}

std::string list(const std::vector<std::string>& names) { return names.empty() ? "none" : some_of(names); }

std::vector<std::string> nodes_of(const Scenario& scenario) {
  std::vector<std::string> nodes;
  for (const AgentSpec& agent : scenario.agents) nodes.push_back(manager_node(agent).full_name());
  return nodes;
}

/// What a name stands for that is no global and no parameter of an agent's node: always an error.
Error not_to_set(const std::string& name, const std::string& value, const Run& run, const Scenario& scenario) {
  const std::string option = "--set " + name + '=' + value;
  const std::string node = name.substr(0, name.find('.'));
  for (const ServerSpec& server : scenario.servers)
    if (node == server.kind->name)
      return usage_error(
          "the node " + node + " is no agent's; a stimulus set_param of the scenario sets its parameters", option);
  std::vector<std::string> overrides = run.manifest.overrides;
  overrides.push_back(name + '=' + value);
  const auto other =
      Scenario::parse(scenario.text, scenario.file, *run.catalogue, {overrides.begin(), overrides.end()});
  if (other && name.starts_with("agents[") && name.find(".params") != name.npos)
    return usage_error(
        "in the middle of a run a parameter is set by itself: --set NODE.NAME=VALUE, of " + list(nodes_of(scenario)),
        option);
  if (other)
    return usage_error(name + " is fixed when a run begins; cxlab run " + scenario.file.filename().string() +
                           " --set " + name + '=' + value + " plays another one",
                       option);
  std::vector<std::string> nodes;
  for (const AgentSpec& agent : scenario.agents) nodes.push_back(manager_node(agent).name);
  return usage_error(found_text(name, "a parameter of an agent's node (NODE.NAME, of " + list(nodes_of(scenario)) +
                                          ") or a global of rules (?*NAME*)" + did_you_mean(node, nodes)),
                     option);
}

Status check_set(const std::string& assignment, const Run& run, const Scenario& scenario) {
  const auto [name, value] = name_and_value(assignment);
  if (name.empty() || name.size() == assignment.size())
    return usage_error("--set: " + found_text(assignment, "NODE.NAME=VALUE or ?*GLOBAL*=VALUE"));
  const std::string option = "--set " + assignment;
  if (name.starts_with('?')) {
    if (!is_global(name)) return usage_error(found_text(name, "a global of rules: ?*NAME*"), option);
    const FormReading reading = read_forms(value, {});
    if (!reading.errors.empty()) return usage_error(reading.errors.front().message, option);
    if (reading.forms.empty()) return usage_error("the value is missing", option);
    return {};
  }
  std::vector<std::string> named;
  for (const AgentSpec& agent : scenario.agents) {
    const bus::NodeName node = manager_node(agent);
    if (parameter_of(node, name)) named.push_back(node.full_name());
  }
  std::ranges::sort(named);
  named.erase(std::ranges::unique(named).begin(), named.end());
  if (named.size() > 1)
    return usage_error("several nodes are called so: " + list(named) + "; expected the whole name of one, as in " +
                           named.front() + name.substr(name.find('.')),
                       option);
  return named.empty() ? Status(not_to_set(name, value, run, scenario)) : Status();
}

Status check_fact(const std::string& fact) {
  const FormReading reading = read_forms(fact, {});
  const std::string option = "--assert " + fact;
  if (!reading.errors.empty()) return usage_error(reading.errors.front().message, option);
  if (reading.forms.size() != 1 || !reading.forms.front().list || reading.forms.front().head.empty())
    return usage_error("expected one fact, as in '(order (id 3))'", option);
  return {};
}

/// The environments that the run had, as its streams name them.
std::vector<std::string> environments_of(const Run& run) {
  std::vector<std::string> names;
  for (const auto& [stream, hash] : run.stream_hashes)
    if (stream.starts_with("env/")) names.push_back(stream.substr(4));
  return names;
}

Error no_environment(const std::string& name, const std::vector<std::string>& known, const std::string& when) {
  return usage_error("--env: " + when + " has no environment '" + name + "'; its environments: " + list(known) +
                     did_you_mean(name, known));
}

Error several_environments(const std::vector<std::string>& known) {
  return usage_error("--assert: there are " + std::to_string(known.size()) + " environments: " + list(known) +
                     "; --env says which one gets the facts");
}

/// The error, which the log of the run has as well: a replay ends with it.
Error refuse(cx::Environment& environment, Error error) {
  (void)environment.act(cx::ControlAct::Verb::kFail, error.text());
  return error;
}

Error placed(Error error, const std::string& option, const cx::Environment& environment, bool several) {
  if (error.file.empty()) error.file = option;
  if (several) error.message += " (in the environment " + environment.unique_name() + "; --env chooses others)";
  error.kind = ErrorKind::kInput;
  return error;
}

}  // namespace

Status prepare(WhatIf& what_if, const Run& run, const Scenario& scenario) {
  if (run.finished && run.ticks == 0) return usage_error("--at: the run ended before its first tick");
  if (Status s = run.reaches(from_seconds(what_if.at)); !s) return about_option(s.error(), "--at");
  if (!what_if.file.empty()) {
    if (!is_file(what_if.file))
      return input_error(path_exists(what_if.file) ? "is no file; expected one with rules" : "there is no such file",
                         what_if.file);
    auto text = read_file(what_if.file);
    if (!text) return text.error();
    what_if.text = *std::move(text);
    const FormReading reading = read_forms(what_if.text, what_if.file);
    if (!reading.errors.empty()) return reading.errors.front();
    if (std::ranges::none_of(reading.forms, &Form::list))
      return input_error("found no rule and no call in it, which begin with a parenthesis", what_if.file);
  }
  for (const std::string& assignment : what_if.set)
    if (Status s = check_set(assignment, run, scenario); !s) return s;
  for (const std::string& fact : what_if.facts)
    if (Status s = check_fact(fact); !s) return s;
  if (!run.finished) return {};
  const std::vector<std::string> known = environments_of(run);
  for (const std::string& name : what_if.environments)
    if (std::ranges::count(known, name) == 0) return no_environment(name, known, "the run");
  if (!what_if.facts.empty() && what_if.environments.empty() && known.size() > 1) return several_environments(known);
  return {};
}

// --- Carrying it out

WhatIfControl::WhatIfControl(std::vector<WhatIf> changes) {
  for (WhatIf& change : changes) changes_.push_back({std::move(change)});
}

Status WhatIfControl::stop_at(cx::Environment& environment, const cx::ControlPlace& place) {
  if (place.fired >= 0) return {};
  const Status changed = change(environment, place);
  return changed ? changed : Status(Error(changed.error()).with_code(kWhatIfCode));
}

Status WhatIfControl::change(cx::Environment& environment, const cx::ControlPlace& place) {
  for (Change& change : changes_) {
    if (place.t < from_seconds(change.what_if.at)) continue;
    if (!change.begun)
      if (Status s = begin(change, place.t); !s) return refuse(environment, s.error());
    if (change.waiting.erase(environment.unique_name()) == 0) continue;
    if (Status s = carry_out(change, environment); !s) return s;
    if (change.waiting.empty())
      if (Status s = end(change); !s) return refuse(environment, s.error());
  }
  return {};
}

Status WhatIfControl::begin(Change& change, SimTime t) const {
  change.begun = true;
  std::vector<std::string> known;
  for (const cx::Environment* environment : environments_()) known.push_back(environment->unique_name());
  const std::string when = "the run at " + seconds_text(to_seconds(t));
  for (const std::string& name : change.what_if.environments)
    if (std::ranges::count(known, name) == 0) return no_environment(name, known, when);
  if (!change.what_if.facts.empty() && change.what_if.environments.empty() && known.size() > 1)
    return several_environments(known);
  change.waiting = {known.begin(), known.end()};
  return {};
}

Status WhatIfControl::carry_out(Change& change, cx::Environment& environment) {
  const WhatIf& what_if = change.what_if;
  if (Status s = set_parameters(change, environment); !s) return s;
  if (!what_if.environments.empty() && std::ranges::count(what_if.environments, environment.unique_name()) == 0)
    return {};
  if (!what_if.file.empty())
    if (Status s = load(what_if, environment); !s) return s;
  if (Status s = set_globals(change, environment); !s) return s;
  return assert_facts(what_if, environment);
}

Status WhatIfControl::set_parameters(Change& change, cx::Environment& environment) {
  for (const std::string& assignment : change.what_if.set) {
    const auto [name, value] = name_and_value(assignment);
    const auto parameter = is_global(name) ? std::nullopt : parameter_of(environment.node(), name);
    // Environments share the parameters of their node.
    if (!parameter || !change.set.insert(assignment).second) continue;
    const auto set = environment.act(cx::ControlAct::Verb::kSet, value, *parameter);
    if (!set) return placed(set.error(), "--set " + assignment, environment, false);
    note(environment, "sets " + name + " to " + value);
  }
  return {};
}

Status WhatIfControl::load(const WhatIf& what_if, cx::Environment& environment) {
  using Key = std::tuple<std::string, std::string, std::string>;
  const std::string file = what_if.file_name();
  std::map<Key, ConstructInfo> before;
  for (ConstructInfo& info : environment.engine().constructs())
    before.insert_or_assign(Key{info.kind, info.module, info.name}, std::move(info));
  const auto loaded = environment.act(cx::ControlAct::Verb::kLoad, what_if.text, file);
  if (!loaded) {
    Error error = loaded.error();
    if (error.file == file) error.file = what_if.file;
    return placed(std::move(error), what_if.file, environment, environments_().size() > 1);
  }
  bool any = false;
  for (const ConstructInfo& info : environment.engine().constructs()) {
    const auto old = before.find({info.kind, info.module, info.name});
    if (info.file != file || (old != before.end() && old->second.file == file && old->second.text == info.text))
      continue;
    any = true;
    const std::string name = info.kind + ' ' + (info.module == "MAIN" ? "" : info.module + "::") + info.name;
    if (old == before.end())
      note(environment, file + " adds " + name);
    else
      note(environment,
           file + " replaces " + name + " (" + old->second.file + ':' + std::to_string(old->second.line) + ')');
  }
  if (!any) note(environment, file + " is loaded; it defines nothing new");
  return {};
}

Status WhatIfControl::set_globals(Change& change, cx::Environment& environment) {
  for (const std::string& assignment : change.what_if.set) {
    const auto [name, value] = name_and_value(assignment);
    if (!is_global(name) || !environment.engine().has("defglobal", without_marks(name))) continue;
    change.set.insert(assignment);
    const auto globals = environment.engine().globals();
    const auto before = std::ranges::find(globals, without_marks(name), &std::pair<std::string, Value>::first);
    const auto set = environment.act(cx::ControlAct::Verb::kSet, value, name);
    if (!set) return placed(set.error(), "--set " + assignment, environment, environments_().size() > 1);
    note(environment,
         "sets " + name + " to " + *set + (before == globals.end() ? "" : " (it was " + before->second.print() + ')'));
  }
  return {};
}

Status WhatIfControl::assert_facts(const WhatIf& what_if, cx::Environment& environment) {
  for (const std::string& fact : what_if.facts) {
    const std::string option = "--assert " + fact;
    const bool several = environments_().size() > 1;
    // CLIPS understands or reports a text that is no pattern here, such as a call in a slot.
    const FormReading reading = read_forms(fact, {});
    if (const auto pattern = explain::Pattern::parse(tree_of(reading.forms.front())))
      if (Status s = explain::check_names(*pattern, environment.engine()); !s)
        return refuse(environment, placed(s.error(), option, environment, several));
    const std::size_t facts = environment.engine().fact_count();
    const auto asserted = environment.act(cx::ControlAct::Verb::kAssert, fact);
    if (!asserted) return placed(asserted.error(), option, environment, several);
    const bool fresh = environment.engine().fact_count() > facts;
    note(environment, (fresh ? "asserts " : "has already ") + *asserted + ' ' + fact);
  }
  return {};
}

Status WhatIfControl::end(const Change& change) const {
  for (const std::string& assignment : change.what_if.set) {
    if (change.set.contains(assignment)) continue;
    const std::string name = name_and_value(assignment).first;
    if (!is_global(name)) return input_error("the node has no environment that could be asked", "--set " + assignment);
    std::vector<std::string> known;
    for (const cx::Environment* environment : environments_())
      for (const auto& [global, value] : environment->engine().globals()) known.push_back("?*" + global + '*');
    return input_error("there is no global '" + name + "'" + did_you_mean(name, known), "--set " + assignment);
  }
  return {};
}

void WhatIfControl::note(const cx::Environment& environment, std::string what) {
  done_.push_back({environment.now(), environment.unique_name(), std::move(what)});
}

// --- Results

namespace {

/// The value at a path of keys, or null.
const Json& at(const Json& json, std::initializer_list<const char*> path) {
  static const Json kNone;
  const Json* value = &json;
  for (const char* key : path) {
    if (!value->is_object() || !value->contains(key)) return kNone;
    value = &(*value)[key];
  }
  return *value;
}

std::string text_of(const Json& value) {
  if (value.is_null()) return "-";
  return value.is_string() ? value.get<std::string>() : json_text(value);
}

std::string size_of(const Json& value) { return value.is_array() ? std::to_string(value.size()) : "-"; }

}  // namespace

std::vector<ResultChange> compare_results(const WorldKind& world, const std::string& then_json,
                                          const std::string& now_json) {
  const Json then = parse_json(then_json), now = parse_json(now_json);
  std::vector<ResultChange> out;
  const auto add = [&](const std::string& what, std::string before, std::string after, bool always) {
    if (always || before != after) out.push_back({what, std::move(before), std::move(after)});
  };
  add("status", text_of(at(then, {"status"})), text_of(at(now, {"status"})), true);
  add("reason", text_of(at(then, {"reason", "message"})), text_of(at(now, {"reason", "message"})), false);
  add("sim_time_s", text_of(at(then, {"sim_time_s"})), text_of(at(now, {"sim_time_s"})), true);
  for (const Metric& metric : world.metrics) {
    using Values = std::map<std::string, double>;
    const auto values = [&metric](const std::string& json) {
      const auto all = measure_apart(metric, json);
      return Values(all.begin(), all.end());
    };
    const Values before = values(then_json), after = values(now_json);
    std::set<std::string> names;
    for (const Values* one : {&before, &after})
      for (const auto& [name, value] : *one) names.insert(name);
    const auto text = [](const Values& of, const std::string& name) {
      const auto found = of.find(name);
      return found == of.end() ? "-" : general_text(found->second, 6);
    };
    for (const std::string& name : names)
      add(name, text(before, name), text(after, name), &metric == &world.metrics.front());
  }
  for (const char* list : {"rule_errors", "warnings"})
    add(list, size_of(at(then, {list})), size_of(at(now, {list})), false);
  return out;
}

}  // namespace cxlab::lab
