#pragma once
// Where a value came from, so that an error that is found later can name the right place.

#include <string>
#include <utility>

#include "cx/base/expected.h"

namespace cxlab {

/// A line of a file, or an option of the command line. Without a source: a default, or a value set by code.
struct Origin {
  std::string source;  ///< the file, or the option as it was given: "--set tier=timed"
  int line = 0;        ///< from 1; 0 for an option

  explicit operator bool() const { return !source.empty(); }
  bool operator==(const Origin&) const = default;
};

inline Error input_error(std::string message, const Origin& origin) {
  return input_error(std::move(message), origin.source, origin.line);
}
/// The error, at this place if it has none of its own.
inline Error at(const Origin& origin, Error error) {
  if (!error.file.empty()) return error;
  error.file = origin.source;
  error.line = origin.line;
  return error;
}

}  // namespace cxlab
