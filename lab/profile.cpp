#include "lab/profile.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <map>

#include "cx/explain/coverage.h"
#include "cx/explain/names.h"
#include "lab/child.h"
#include "lab/json_fields.h"
#include "lab/moment.h"
#include "lab/page.h"
#include "lab/trace_writer.h"

namespace cxlab::lab {

namespace {

double clock_seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Times as they were measured, with how often the clock was read for each.
struct Measured {
  Profile profile;
  std::vector<double> reads;  ///< of each number of seconds in `profile`, in the order of `for_each_time`
};

/// Calls `visit` for each time of a profile that reading the clock adds to.
template <class Visit>
void for_each_time(Profile& profile, Visit visit) {
  for (Profile::Rule& rule : profile.rules) {
    visit(rule.acting_s);
    visit(rule.agenda_s);
    for (Profile::Join& join : rule.joins) visit(join.s);
  }
  for (Profile::Function& function : profile.functions) visit(function.s);
}

void add_environment(const cx::Environment& environment, bool spans, Measured& out) {
  const EngineCounts counts = environment.engine().counts();
  const std::string& name = environment.unique_name();
  const auto file_of = [&](const ConstructInfo& info) {
    return info.file.empty() ? info.file : environment.files().journal_name(info.file);
  };
  for (const RuleCounts& one : counts.rules) {
    Profile::Rule rule{name,
                       explain::with_module(one.info.module, one.info.name),
                       file_of(one.info),
                       one.info.line,
                       one.fired,
                       one.activated,
                       0,
                       0,
                       one.acting.s,
                       one.activating.s,
                       {}};
    out.reads.push_back(one.acting.reads);
    out.reads.push_back(one.activating.reads);
    const auto labels = explain::join_labels(one);
    for (std::size_t i = 0; i < one.disjuncts.size(); ++i)
      for (std::size_t k = 0; k < one.disjuncts[i].size(); ++k) {
        const JoinCounts& join = one.disjuncts[i][k];
        const explain::JoinLabel& label = labels[i][k];
        rule.joins.push_back(
            {label.number, label.line, label.text, join.passed, join.compared, join.held, join.sharers, join.time.s});
        out.reads.push_back(join.time.reads);
      }
    out.profile.rules.push_back(std::move(rule));
  }
  out.profile.spans_left_out += counts.spans_left_out;
  if (!spans) return;
  static constexpr const char* kKinds[] = {"firing", "function", "matching"};
  std::map<std::size_t, std::vector<std::vector<explain::JoinLabel>>> labels_of_rules;
  for (const WorkSpan& span : counts.spans) {
    Profile::Span& one = out.profile.spans.emplace_back(Profile::Span{
        name, kKinds[static_cast<std::size_t>(span.kind)], span.name, span.begin_s, span.end_s, to_seconds(span.t)});
    if (!span.longest) continue;
    const RuleCounts& rule = counts.rules[span.longest->rule];
    one.name += " " + explain::with_module(rule.info.module, rule.info.name);
    const auto known = labels_of_rules.find(span.longest->rule);
    const auto& labels =
        (known != labels_of_rules.end() ? known->second
                                        : labels_of_rules[span.longest->rule] = explain::join_labels(rule))
            .at(span.longest->disjunct);
    if (span.longest->join >= labels.size()) {
      one.name += ", agenda";
      continue;
    }
    const explain::JoinLabel& label = labels[span.longest->join];
    one.name += ", condition " + std::to_string(label.number);
    one.condition = label.text;
  }
}

void add_functions(const cx::Environment& environment, Measured& out) {
  for (const FunctionCounts& one : environment.engine().counts().functions) {
    out.profile.functions.push_back(
        {environment.unique_name(), explain::with_module(one.info.module, one.info.name),
         one.info.file.empty() ? one.info.file : environment.files().journal_name(one.info.file), one.info.line,
         one.calls, one.time.s});
    out.reads.push_back(one.time.reads);
  }
}

struct Playing {
  std::optional<SimTime> at;
  std::string environment;
  bool spans = false;
};

/// What a process that plays the run says: its times, or how long it took alone.
Expected<Json> play_counting(const Run& run, const Playing& how, Counting counting, const Host& host) {
  auto moment = Moment::open(run, host, {.timelines = false, .counting = counting});
  if (!moment) return moment.error();
  const double begin = clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
  if (Status s = (*moment)->seek(how.at); !s && !(*moment)->stopped()) return s.error();
  const double took = clock_seconds(CLOCK_PROCESS_CPUTIME_ID) - begin;
  const auto environments = (*moment)->environments(how.environment);
  if (!environments) return environments.error();
  Measured out;
  out.profile.at_s = to_seconds((*moment)->t());
  out.profile.cut_off = (*moment)->cut_off();
  out.profile.profiled_s = took;
  if (counting == Counting::kTimes) {
    for (const cx::Environment* one : *environments) add_environment(*one, how.spans, out);
    for (const cx::Environment* one : *environments) add_functions(*one, out);
    // Clocks of environments that were not asked for were read, too.
    for (const cx::Environment* one : (*moment)->episode().environments())
      out.profile.reads += one->engine().counts().clock_reads;
  }
  return Json{{"profile", JsonWriter::json(out.profile)}, {"reads", out.reads}};
}

void sort_and_sum(Profile& profile) {
  double in_rules = 0;
  for (Profile::Rule& rule : profile.rules) {
    rule.matching_s = 0;
    for (const Profile::Join& join : rule.joins) rule.matching_s += join.s;
    rule.s = rule.matching_s + rule.acting_s + rule.agenda_s;
    in_rules += rule.s;
  }
  profile.elsewhere_s = std::max(0.0, profile.plain_s - in_rules);
  std::ranges::stable_sort(profile.rules, std::ranges::greater(), &Profile::Rule::s);
  std::ranges::stable_sort(profile.functions, std::ranges::greater(), &Profile::Function::s);
}

/// What shares are of. Rules may take longer in the play that is profiled than the whole play without it.
double whole(const Profile& profile) {
  double in_rules = 0, in_functions = 0;
  for (const Profile::Rule& rule : profile.rules) in_rules += rule.s;
  for (const Profile::Function& function : profile.functions) in_functions += function.s;
  return std::max({profile.plain_s, in_rules, in_functions, 1e-12});
}

struct JoinRow {
  const Profile::Rule* rule = nullptr;
  const Profile::Join* join = nullptr;
};

std::vector<JoinRow> slowest_joins(const Profile& profile) {
  std::vector<JoinRow> rows;
  for (const Profile::Rule& rule : profile.rules)
    for (const Profile::Join& join : rule.joins) rows.push_back({&rule, &join});
  std::ranges::stable_sort(rows, std::ranges::greater(), [](const JoinRow& row) { return row.join->s; });
  return rows;
}

std::string line_of(const char* format, auto... values) {
  char text[400];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string cost_text(const Profile& profile) {
  const double ns = 1e9 * profile.read_cost_s();
  return line_of("%.3f s of CPU without profiling, %.3f s with it: %.0f readings of the clock, ", profile.plain_s,
                 profile.profiled_s, profile.reads) +
         (ns >= 0.5 ? line_of("%.0f ns each, which are taken off below", ns)
                    : "which take too little time to be measured");
}

std::string in_one_line(std::string text, std::size_t most) {
  if (text.size() > most) text = text.substr(0, most - 3) + "...";
  return text;
}

std::string qualified(const std::string& environment, const std::string& name, bool several) {
  return several ? environment + ' ' + name : name;
}

}  // namespace

Expected<Profile> profile_of(const Run& run, std::optional<SimTime> at, const std::string& environment, bool spans,
                             const Host& host) {
  Host confined = host;
  confined.confine = true;
  confined.progress = nullptr;
  const Playing how{at, environment, spans};
  const auto play = [&](Counting counting) -> Expected<Json> {
    auto child = Child::start([&] { return play_counting(run, how, counting, confined); });
    return child ? child->finish(host) : child.error();
  };
  const auto plain = play(Counting::kNothing), timed = play(Counting::kTimes);
  if (!plain || !timed) return (plain ? timed : plain).error();
  Profile profile, alone;
  if (Status s = read_fields(timed->at("profile"), profile); !s) return s.error();
  if (Status s = read_fields(plain->at("profile"), alone); !s) return s.error();
  profile.plain_s = alone.profiled_s;
  const auto reads = timed->at("reads").get<std::vector<double>>();
  std::size_t i = 0;
  for_each_time(profile, [&](double& s) { s = std::max(0.0, s - reads[i++] * profile.read_cost_s()); });
  sort_and_sum(profile);
  return profile;
}

std::string text_of(const Profile& profile, std::size_t most) {
  const double all = whole(profile);
  const bool several = std::ranges::any_of(
      profile.rules, [&](const Profile::Rule& rule) { return rule.environment != profile.rules.front().environment; });
  std::string out = cost_text(profile) + "\n\n      time  share  matching    actions   fired  activated  rule\n";
  for (std::size_t i = 0; i < std::min(most, profile.rules.size()); ++i) {
    const Profile::Rule& rule = profile.rules[i];
    out += line_of("%7.2f ms %5.1f%% %6.2f ms %7.2f ms %7lld %10lld  ", 1e3 * rule.s, 100 * rule.s / all,
                   1e3 * rule.matching_s, 1e3 * rule.acting_s, static_cast<long long>(rule.fired),
                   static_cast<long long>(rule.activated)) +
           qualified(rule.environment, rule.name, several) + " (" + rule.file + ':' + std::to_string(rule.line) + ")\n";
  }
  out += "\n      time  share   compared     passed    held  condition\n";
  const std::vector<JoinRow> joins = slowest_joins(profile);
  for (std::size_t i = 0; i < std::min(most, joins.size()); ++i) {
    const auto& [rule, join] = joins[i];
    out += line_of("%7.2f ms %5.1f%% %10lld %10lld %7lld  ", 1e3 * join->s, 100 * join->s / all,
                   static_cast<long long>(join->compared), static_cast<long long>(join->passed),
                   static_cast<long long>(join->held)) +
           qualified(rule->environment, rule->name, several) + " " + std::to_string(join->number) + ": " +
           in_one_line(join->text, 100) +
           (join->sharers > 1 ? " (divided among " + std::to_string(join->sharers) + " rules)" : "") + '\n';
  }
  if (!profile.functions.empty()) out += "\n      time  share      calls  function\n";
  for (std::size_t i = 0; i < std::min(most, profile.functions.size()); ++i) {
    const Profile::Function& function = profile.functions[i];
    out += line_of("%7.2f ms %5.1f%% %10lld  ", 1e3 * function.s, 100 * function.s / all,
                   static_cast<long long>(function.calls)) +
           qualified(function.environment, function.name, several) + '\n';
  }
  out += line_of("\n%.2f ms (%.1f%%) outside of rules: inputs, the agenda, the executive\n", 1e3 * profile.elsewhere_s,
                 100 * profile.elsewhere_s / all);
  return out;
}

Json json_of(const Profile& profile) {
  Profile copy = profile;
  copy.spans.clear();
  return JsonWriter::json(copy);
}

Expected<std::string> to_page(const Profile& profile, const std::string& title) {
  Json data = json_of(profile);
  data["title"] = title;
  data["cost"] = cost_text(profile);
  data["whole_s"] = whole(profile);
  Json joins = Json::array();
  const std::vector<JoinRow> rows = slowest_joins(profile);
  constexpr std::size_t kMostJoins = 200;
  for (std::size_t i = 0; i < std::min(rows.size(), kMostJoins); ++i) {
    Profile::Join join = *rows[i].join;
    Json row = JsonWriter::json(join);
    row["rule"] = rows[i].rule->name;
    joins.push_back(std::move(row));
  }
  data["joins"] = std::move(joins);
  return render_page("profile.html", json_text(data));
}

namespace {

Json args_of(const Profile::Span& span) {
  Json args{{"t_s", span.t_s}};
  if (!span.condition.empty()) args["condition"] = span.condition;
  return args;
}

}  // namespace

std::string to_trace(const Profile& profile) {
  std::string out;
  TraceWriter trace(out);
  for (const Profile::Span& span : profile.spans)
    trace.span(trace.thread("rules", span.environment), span.name, span.kind, 1e6 * span.begin_s,
               1e6 * (span.end_s - span.begin_s), args_of(span));
  trace.end({{"displayTimeUnit", "ns"},
             {"otherData", {{"spans_left_out", profile.spans_left_out}, {"cost", cost_text(profile)}}}});
  return out;
}

}  // namespace cxlab::lab
