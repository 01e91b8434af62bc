// Do intervals cover as often as they promise, and are decisions wrong as seldom? Counted in simulated sweeps, in a few
// hundred here, in $CXLAB_COMPARISONS of them in the long test.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "cx/base/random.h"
#include "lab/statistics/sequential.h"
#include "lab/statistics/statistics.h"

namespace cxlab::statistics {
namespace {

std::size_t comparisons() {
  const char* const set = std::getenv("CXLAB_COMPARISONS");
  return set ? std::strtoul(set, nullptr, 10) : 200;
}

/// The most or least of `n` that come with this probability but for once in thousands: 3.5 standard deviations.
double slack(double probability) {
  return 3.5 * std::sqrt(probability * (1 - probability) / static_cast<double>(comparisons()));
}

/// How the figure of an episode is distributed.
struct Population {
  const char* name;
  double mean;
  double (*draw)(RandomStream&);
};

double exponential(RandomStream& random) { return -std::log(1 - random.uniform()); }
double in_fives(double points) { return 5 * std::round(points / 5); }

const Population kPopulations[] = {
    {"points of a game, in fives, with a tail to the left", 600,
     [](RandomStream& random) { return in_fives(random.normal(660, 50) - 60 * exponential(random)); }},
    {"few deliveries: 0, 20 or 70", 24,
     [](RandomStream& random) {
       const double u = random.uniform();
       return u < 0.3 ? 0.0 : u < 0.8 ? 20.0 : 70.0;
     }},
    {"waits: exponential", 30, [](RandomStream& random) { return 30 * exponential(random); }},
    {"normal", 100, [](RandomStream& random) { return random.normal(100, 20); }},
};
/// Without a mean that an interval could cover.
const Population kCauchy{"Cauchy", 0,
                         [](RandomStream& random) { return std::tan(3.14159265358979 * (random.uniform() - 0.5)); }};

/// Prints the share in one line, so that the log of a test has the figures.
double reported(const std::string& what, std::size_t hits) {
  const double share = static_cast<double>(hits) / static_cast<double>(comparisons());
  std::printf("%-78s %5.1f %% of %zu\n", what.c_str(), 100 * share, comparisons());
  return share;
}

std::vector<double> draw(const Population& population, std::size_t n, RandomStream& random) {
  std::vector<double> out;
  for (std::size_t i = 0; i < n; ++i) out.push_back(population.draw(random));
  return out;
}

TEST(Intervals, CoverTheMeanDifferenceOfPairsAsTheyPromise) {
  for (const Population& population : kPopulations)
    for (const std::size_t n : {10u, 30u}) {
      RandomStream random(n, population.name);
      std::size_t covered = 0;
      for (std::size_t i = 0; i < comparisons(); ++i) {
        std::vector<double> differences = draw(population, n, random);
        for (double& one : differences) one = one + 7 - population.draw(random);
        const Interval interval = bootstrap_interval(differences, mean, widened_level(0.95, n), {1999, i});
        covered += interval.low <= 7 && 7 <= interval.high ? 1u : 0u;
      }
      EXPECT_NEAR(reported("difference of " + std::to_string(n) + " pairs, " + population.name, covered), 0.95,
                  0.015 + slack(0.95));
    }
}

// Not of ten: without a single one of the values that a fifth of all games have, as 0.8^10 = 11 % of such sweeps are,
// no interval can reach the mean.
TEST(Intervals, CoverTheMeanOfSkewedFigures) {
  for (const Population& population : kPopulations)
    for (const std::size_t n : {20u, 50u}) {
      RandomStream random(n, population.name);
      std::size_t covered = 0;
      for (std::size_t i = 0; i < comparisons(); ++i) {
        const std::vector<double> values = draw(population, n, random);
        const Interval interval = bootstrap_interval(values, mean, widened_level(0.95, n), {1999, i});
        covered += interval.low <= population.mean && population.mean <= interval.high ? 1u : 0u;
      }
      EXPECT_NEAR(reported("mean of " + std::to_string(n) + ", " + population.name, covered), 0.95,
                  0.025 + slack(0.95));
    }
}

Question question(const std::vector<double>& values, Question::About about = Question::About::kDifferences) {
  return {about, {values.begin(), values.end()}};
}

const Resampling kFlips{.resamples = 4999, .seed = 1};

/// How often there is a decision though there is no difference.
double wrong_decisions(const Population& population, std::size_t games, std::size_t strategies) {
  RandomStream random(games, population.name);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < comparisons(); ++i) {
    std::vector<Question> questions;
    const std::vector<double> first = draw(population, games, random);
    for (std::size_t k = 0; k < strategies; ++k) {
      std::vector<double> differences = draw(population, games, random);
      for (std::size_t j = 0; j < games; ++j) differences[j] -= first[j];
      questions.push_back(question(differences));
    }
    for (const Decision& decision : decide(questions, looks(games), kFlips))
      if (decision.side != Side::kUndecided) {
        ++wrong;
        break;
      }
  }
  return reported("wrong: " + std::to_string(games) + " games, " + std::to_string(strategies) + " against the first, " +
                      population.name,
                  wrong);
}

TEST(Decisions, AreWrongInFiveOfAHundredComparisonsWithoutADifferenceAtMost) {
  for (const std::size_t games : {12u, 40u}) {
    for (const Population& population : kPopulations)
      EXPECT_LE(wrong_decisions(population, games, 1), 0.05 + slack(0.05)) << population.name;
    EXPECT_LE(wrong_decisions(kCauchy, games, 1), 0.05 + slack(0.05));
  }
}

TEST(Decisions, OfManyStrategiesAreWrongInFiveOfAHundredSuitesAtMost) {
  EXPECT_LE(wrong_decisions(kPopulations[0], 30, 5), 0.05 + slack(0.05));
}

TEST(Decisions, OnAMeanAreWrongInFiveOfAHundredAtMost) {
  for (const Population& population : kPopulations)
    for (const std::size_t games : {20u, 50u}) {
      RandomStream random(games, population.name);
      std::size_t wrong = 0;
      for (std::size_t i = 0; i < comparisons(); ++i) {
        std::vector<double> values = draw(population, games, random);
        for (double& value : values) value -= population.mean;
        wrong +=
            decide({question(values, Question::About::kMean)}, looks(games)).front().side != Side::kUndecided ? 1u : 0u;
      }
      EXPECT_LE(reported("wrong: mean of " + std::to_string(games) + ", " + population.name, wrong),
                0.05 + slack(0.05));
    }
}

/// How often a strategy that loses `loss` in a share of the games, with noise, counts as not worse by `margin`.
double taken_for_as_good(double share, double loss, double noise, double margin, std::size_t games) {
  RandomStream random(games, "rare losses");
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < comparisons(); ++i) {
    std::vector<double> values;
    for (std::size_t k = 0; k < games; ++k)
      values.push_back(random.normal(0, noise) - (random.uniform() < share ? loss : 0) + margin);
    wrong += decide({question(values, Question::About::kMean)}, looks(games)).front().side == Side::kAbove ? 1u : 0u;
  }
  return reported("not worse: " + std::to_string(games) + " games, " + std::to_string(loss) + " less in a share of " +
                      std::to_string(share),
                  wrong);
}

TEST(Decisions, SeeALossThatComesInOneOfTenGames) {
  for (const std::size_t games : {30u, 60u})
    for (const double noise : {0.0, 3.0})
      EXPECT_LE(taken_for_as_good(0.1, 40, noise, 3, games), 0.05 + slack(0.05)) << games << ' ' << noise;
}

TEST(Decisions, FindADifferenceAndStopEarly) {
  // Differences of one standard deviation, and forty games: found nearly always, after a half of them on average.
  RandomStream random(1, "one standard deviation");
  std::size_t found = 0;
  double played = 0;
  for (std::size_t i = 0; i < comparisons(); ++i) {
    std::vector<double> differences;
    for (int k = 0; k < 40; ++k) differences.push_back(random.normal(-50, 50));
    const Decision decision = decide({question(differences)}, looks(40), kFlips).front();
    found += decision.side == Side::kBelow ? 1u : 0u;
    played += static_cast<double>(decision.after) / static_cast<double>(comparisons());
  }
  EXPECT_GT(reported("found: a difference of one standard deviation in 40 games", found), 0.98);
  std::printf("  after %.1f games on average\n", played);
  EXPECT_LT(played, 24);
}

}  // namespace
}  // namespace cxlab::statistics
