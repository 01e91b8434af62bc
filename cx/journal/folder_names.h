#pragma once
// Folders that records call by what they are, so that a run has the same hash wherever its files lie.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cxlab {

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
