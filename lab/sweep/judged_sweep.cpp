#include "lab/sweep/judged_sweep.h"

#include <algorithm>

#include "lab/statistics/sequential.h"

namespace cxlab::lab {

namespace {

/// Games that are played at once: those by their files with all seeds, else each seed is a game.
std::size_t played_together(const Suite& suite) { return suite.games.empty() ? 1 : suite.seeds.size(); }

}  // namespace

Expected<JudgedRows> judged_rows(const Suite& suite, const std::vector<Row>& rows) {
  const auto judge = Judge::make(suite);
  if (!judge) return judge.error();
  JudgedRows out{.rows = rows, .answers = {}, .games = suite.planned_games(), .planned = suite.planned_games()};
  auto answers = judge->judge(rows, statistics::looks(out.planned, played_together(suite)));
  if (!answers) return answers.error();
  out.answers = *std::move(answers);
  return out;
}

Expected<JudgedRows> judged_sweep(const Suite& suite, const SweepOptions& options, bool all, const Host& host) {
  const auto judge = Judge::make(suite);
  if (!judge) return judge.error();
  JudgedRows out;
  out.planned = suite.planned_games();
  const std::vector<std::size_t> looks = statistics::looks(out.planned, played_together(suite));
  const SweepStages stages{
      all ? std::vector{out.planned} : looks, [&](std::size_t games, const std::vector<Row>& rows) -> Expected<bool> {
        auto answers = judge->judge(rows, looks);
        if (!answers) return answers.error();
        out.games = games;
        out.answers = *std::move(answers);
        return std::ranges::find(out.answers, Judgement::kUndecided, &Answer::judgement) == out.answers.end();
      }};
  auto rows = sweep(suite, options, host, &stages);
  if (!rows) return rows.error();
  out.rows = *std::move(rows);
  if (host.stopped()) out.answers.clear();
  return out;
}

}  // namespace cxlab::lab
