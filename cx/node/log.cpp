#include "cx/node/log.h"

namespace cxlab::cx {

std::string_view to_string(LogLevel level) {
  static constexpr std::string_view kWords[] = {"debug", "info", "warn", "error"};
  return kWords[static_cast<std::size_t>(level)];
}

}  // namespace cxlab::cx
