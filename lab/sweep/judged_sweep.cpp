#include "lab/sweep/judged_sweep.h"

#include <algorithm>

#include "lab/statistics/sequential.h"

namespace cxlab::lab {

namespace {

/// Games that are played at once: those by their files with all seeds, else each seed is a game.
std::size_t played_together(const Suite& suite) { return suite.games.empty() ? 1 : suite.seeds.size(); }

std::size_t planned_games(const Suite& suite) {
  return suite.seeds.size() * std::max<std::size_t>(1, suite.games.size());
}

}  // namespace

Expected<JudgedRows> judged_rows(const Suite& suite, const std::vector<Row>& rows) {
  const auto judge = Judge::make(suite);
  if (!judge) return judge.error();
  JudgedRows out{.rows = rows, .answers = {}, .games = planned_games(suite), .planned = planned_games(suite)};
  auto answers = judge->judge(rows, statistics::looks(out.planned, played_together(suite)));
  if (!answers) return answers.error();
  out.answers = *std::move(answers);
  return out;
}

Expected<JudgedRows> judged_sweep(const Suite& suite, const SweepOptions& options, bool all, const Host& host) {
  const auto judge = Judge::make(suite);
  if (!judge) return judge.error();
  const std::size_t together = played_together(suite);
  JudgedRows out;
  out.planned = planned_games(suite);
  const std::vector<std::size_t> looks = statistics::looks(out.planned, together);
  for (const std::size_t look : all ? std::vector{out.planned} : looks) {
    Suite first = suite;
    if (suite.games.empty())
      first.seeds.resize(look);
    else
      first.games.resize(look / together);
    auto rows = sweep(first, options, host);
    if (!rows) return rows.error();
    out.rows = *std::move(rows);
    out.games = look;
    if (host.stopped()) return out;
    auto answers = judge->judge(out.rows, looks);
    if (!answers) return answers.error();
    out.answers = *std::move(answers);
    if (std::ranges::find(out.answers, Judgement::kUndecided, &Answer::judgement) == out.answers.end()) break;
  }
  return out;
}

}  // namespace cxlab::lab
