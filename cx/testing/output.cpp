#include "cx/testing/output.h"

namespace cxlab::testing {

namespace {

/// The rule in a line of CLIPS: `==> Activation 0      open: f-1,f-2`. Empty if it is another line.
std::string activated_rule(std::string_view line) {
  constexpr std::string_view kActivation = "==> Activation ";
  if (!line.starts_with(kActivation)) return {};
  line.remove_prefix(kActivation.size());
  const auto name = line.find_first_not_of(' ', line.find(' '));
  return name == line.npos ? std::string() : std::string(line.substr(name, line.find(':', name) - name));
}

}  // namespace

void Output::line(const cx::LogLine& line) {
  if (const std::string rule = activated_rule(line.text); !rule.empty())
    ++activations_[rule];
  else if (line.level == cx::LogLevel::kWarn && line.text.find("cleaning up") != std::string_view::npos)
    left_open_.emplace_back(line.text);
}

long Output::activations(const std::string& rule) const {
  const auto known = activations_.find(rule);
  return known == activations_.end() ? 0 : known->second;
}

}  // namespace cxlab::testing
