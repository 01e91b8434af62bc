#pragma once
// Codes of AgentTask. Most are those of skills (sim::SkillCode) and of instructions (InstructError), which have the
// numbers of the league; the rest stands here.

#include <cstdint>

namespace cxlab::rcll {

enum class TaskCode : std::uint16_t {
  kNone = 0,
  kFailed = 1,  ///< for no reason that has a code
  kWrongRobot = 102,
  kNotSupported = 104,
};

/// Any of these as a number of the protocol.
template <class Code>
constexpr std::int64_t number_of(Code code) {
  return static_cast<std::int64_t>(code);
}

}  // namespace cxlab::rcll
