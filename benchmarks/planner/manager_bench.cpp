// How long the PDDL manager takes to check a step's condition, list its effects and apply them: CPU time. Prints JSON.
//
//   bench_pddl_manager DOMAIN PROBLEM STEPS ROUNDS     STEPS: one "action arg arg" a line, each applicable in its turn

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <sstream>

#include "planner/manager/instance.h"
#include "planner/pddl/parser.h"

using namespace cxlab::planner;

namespace {

struct Named {
  std::string action;
  std::vector<std::string> arguments;
};

std::vector<Named> read_steps(const char* file) {
  std::vector<Named> steps;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    Named step;
    words >> step.action;
    for (std::string word; words >> word;) step.arguments.push_back(word);
    if (!step.action.empty()) steps.push_back(std::move(step));
  }
  return steps;
}

/// Checks, lists and applies one step, by names as in a request. False if it may not begin.
bool carry_out(Instance& instance, const Named& named) {
  const auto call = instance.step(named.action, named.arguments);
  if (!call || !instance.unsatisfied(*call, Instance::When::kStart).empty()) return false;
  const auto effects = instance.effects(*call);
  if (!effects) return false;
  for (const bool at_end : {false, true})
    for (const bool value : {false, true})
      for (const ReportedEffect& effect : *effects) {
        if (effect.at_end != at_end || effect.numeric || effect.value != value) continue;
        const auto fact = instance.fact(effect.name, effect.arguments);
        if (!fact || !instance.set(*fact, effect.value)) return false;
      }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: bench_pddl_manager DOMAIN PROBLEM STEPS ROUNDS\n");
    return 2;
  }
  const auto task = load_task(argv[1], argv[2]);
  if (!task) {
    std::fprintf(stderr, "%s\n", task.error().text().c_str());
    return 3;
  }
  const std::vector<Named> steps = read_steps(argv[3]);
  const int rounds = std::atoi(argv[4]);
  Instance instance(*task);
  const std::clock_t begin = std::clock();
  for (int round = 0; round < rounds; ++round)
    for (const Named& step : steps)
      if (!carry_out(instance, step)) {
        std::fprintf(stderr, "%s cannot begin\n", step.action.c_str());
        return 1;
      }
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::printf(
      "{\"steps\": %zu, \"us_per_step\": %.3f, \"facts\": %zu}\n", steps.size() * static_cast<std::size_t>(rounds),
      1e6 * seconds / static_cast<double>(steps.size() * static_cast<std::size_t>(rounds)), instance.facts().size());
}
