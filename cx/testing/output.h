#pragma once
// What the rules of a story print, as far as the story wants to know it.

#include <map>
#include <string>
#include <vector>

#include "cx/executive/log_router.h"

namespace cxlab::testing {

class Output final : public cx::LogSink {
 public:
  void line(const cx::LogLine& line) override;

  /// What plugins cleaned up at the end: it was left open.
  const std::vector<std::string>& left_open() const { return left_open_; }
  /// How often a rule was put on the agenda; needs `watch activations` in the environment.
  long activations(const std::string& rule) const;

 private:
  std::vector<std::string> left_open_;
  std::map<std::string, long> activations_;  // by rule
};

}  // namespace cxlab::testing
