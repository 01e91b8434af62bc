#pragma once
// What this machine has for cxlab, what is missing, and the remedy.

#include <string>
#include <vector>

namespace cxlab::lab {

struct Finding {
  enum class Verdict { kGood, kOptional, kMissing };
  std::string what;
  Verdict verdict;
  std::string found;
  std::string remedy;
};

std::vector<Finding> examine_machine();

}  // namespace cxlab::lab
