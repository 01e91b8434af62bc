#pragma once
// Lines that rules print as an error, `(printout error ...)`. They become warnings of the run
// (docs/reference/contracts.md 4).

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"

namespace cxlab::cx {

/// Keeps the first different lines; of all others only how many there were.
class PrintedErrors {
 public:
  static constexpr std::size_t kMost = 10;      ///< lines that are kept
  static constexpr std::size_t kLongest = 500;  ///< bytes of a line that are kept

  void add(SimTime at, std::string environment, std::string_view line);
  /// One for each line that is kept, in order, and one that counts the others.
  std::vector<Error> warnings() const;
  /// The last line that was printed at that time, and by whom.
  std::optional<Error> last(SimTime at) const;

 private:
  using Line = std::pair<std::string, std::string>;  // environment, text

  std::vector<Line> kept_;
  std::size_t others_ = 0;
  Line last_;
  SimTime last_at_ = kNever;
};

}  // namespace cxlab::cx
