#pragma once
// The bytes of a `RecordData`: as JSON, and with names instead of folders.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab {

/// Appends the bytes of a `RecordData` as JSON: shortest numbers that read back the same (a real keeps a point or an
/// exponent; what JSON has no number for becomes "nan", "inf" or "-inf"), always valid UTF-8 (U+FFFD for each invalid
/// byte). Fails on malformed bytes; `out` then ends with what was read before. Never reads beyond the bytes.
Status append_json(std::string_view bytes, std::string& out);
void append_json_string(std::string_view text, std::string& out);

/// The integer or text under `key` of the outermost map, found without decoding the rest; 0 or empty if there is none
/// of that type. The text points into `bytes`.
std::int64_t integer_in(std::string_view bytes, std::string_view key);
std::string_view text_in(std::string_view bytes, std::string_view key);

/// Folders that records call by what they are, so that a run has the same hash wherever its files lie.
class FolderNames {
 public:
  /// `folder` is absolute. A folder that is known keeps its first name.
  void add(const std::string& folder, const std::string& name);

  bool empty() const { return names_.empty(); }
  /// Whether texts in the bytes of a `RecordData` hold one of the folders (as a whole path or the beginning of one);
  /// `out` is then the same data with names instead.
  bool rewrite(std::string_view bytes, std::string& out) const;

 private:
  const std::pair<std::string, std::string>* find(std::string_view text, std::size_t slash) const;
  bool in_text(std::string_view text, std::string& out) const;

  std::vector<std::pair<std::string, std::string>> names_;  ///< longest folder first
};

}  // namespace cxlab
