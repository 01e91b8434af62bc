#pragma once
// New packages, made from the templates that come with cxlab.

#include <optional>
#include <string>

#include "cx/base/expected.h"

namespace cxlab::lab {

/// What a new package begins from.
struct NewPackage {
  /// Where pipelines of CI get cxlab. Empty: the user writes it into ci/cxlab.txt.
  struct Tarball {
    std::string address;  ///< https://..., or a file of the package
    std::string sha256;   ///< 64 hexadecimal digits
  };
  std::string kind, variant;          ///< docs/templates/KIND or KIND_VARIANT
  std::optional<Tarball> continuous;  ///< with docs/templates/ci and KIND_VARIANT_ci: pipelines and a suite
};

/// Copies the templates of `package` into `folder`, which must be new or empty. The last part of its path names the
/// package: in the files, `my_KIND` and `MyKind` become that name.
Status make_package(const NewPackage& package, const std::string& folder);

}  // namespace cxlab::lab
