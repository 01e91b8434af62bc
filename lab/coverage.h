#pragma once
// Coverage (cx/explain/coverage.h) as others read it: JSON, lcov, a page.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "cx/explain/coverage.h"

namespace cxlab::lab {

/// Texts of rule files, by the name that they have in a coverage.
using Sources = std::map<std::string, std::string>;
/// Reads those that are not there; a file that cannot be read has none.
void read_sources(const explain::Coverage& coverage, Sources& sources);
/// Where rule files lie, by the name that they have in a coverage. An absolute name needs none.
using Places = std::map<std::string, std::string>;
/// What readers of lcov do not find by these places: files that have none, and files whose text is another now.
std::vector<std::string> notes_on_places(const explain::Coverage& coverage, const Sources& sources,
                                         const Places& places);

struct CoverageOptions {
  std::string lcov, page;            ///< files to write; empty: none
  std::optional<double> fail_under;  ///< percent of the rules that must have fired
  bool asked() const { return !lcov.empty() || !page.empty() || fail_under; }
};

/// `rules`, `functions` and `totals` (docs/reference/coverage.md).
Json json_of(const explain::Coverage& coverage);
/// Rules and deffunctions as functions of lcov, conditions as lines, whether a rule was activated and fired as
/// branches.
std::string to_lcov(const explain::Coverage& coverage, const Places& places = {});
/// A page with the coloured source of each file; it asks for nothing else.
Expected<std::string> to_page(const explain::Coverage& coverage, const Sources& sources, const std::string& title);

/// Writes what the options name.
Status write_reports(const explain::Coverage& coverage, const CoverageOptions& options, Sources sources,
                     const Places& places, const std::string& title);
/// An error of kind kNo if fewer rules fired than must, or if there is no rule.
Status check_share(const explain::Coverage& coverage, const CoverageOptions& options);

}  // namespace cxlab::lab
