#pragma once
// Access of rules to the world outside, and how its results get into the input log.

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "cx/base/expected.h"
#include "cx/engine/value.h"

namespace cxlab {

/// The hash of a file that rules wrote with a bsave function.
using BinaryHash = std::pair<std::uint64_t, std::uint64_t>;

/// Decides on every path that rules name (open, load, batch, load-facts, save-facts, bsave, dribble-on, remove, ...).
/// Answers with the path to open; an error is reported to the rule. A missing file is no error here.
class FileAccess {
 public:
  virtual ~FileAccess() = default;
  /// Called before each reading; the place to log the content.
  virtual Expected<std::string> for_reading(const std::string& path) = 0;
  virtual Expected<std::string> for_writing(const std::string& path) = 0;
  /// How the journal names a file: the same on every machine, for example relative to its package.
  virtual std::string journal_name(const std::string& path) const { return path; }

  std::set<BinaryHash> binaries;  ///< written by rules of this run; no others are read
};

/// Every result of a function that looks outside passes here: a recording one calls `outside` and keeps the value, a
/// replaying one answers with the value kept.
class LookOutside {
 public:
  virtual ~LookOutside() = default;
  virtual Value look(std::string_view function, const std::function<Value()>& outside) = 0;
};

}  // namespace cxlab
