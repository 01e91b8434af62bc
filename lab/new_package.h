#pragma once
// New packages, made from the templates that come with cxlab.

#include <string>

#include "cx/base/expected.h"

namespace cxlab::lab {

/// Copies docs/templates/KIND or KIND_VARIANT into `folder`, which must be new or empty. The last part of its path
/// names the package: in the files, `my_KIND` and `MyKind` become that name.
Status make_package(const std::string& kind, const std::string& variant, const std::string& folder);

}  // namespace cxlab::lab
