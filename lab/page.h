#pragma once
// Pages, pictures and reports that are made of a template and data.

#include <string>

#include "cx/base/expected.h"

namespace cxlab::lab {

/// The template `name` of lab/pages, rendered with the fields of a JSON object. Values are escaped in pages whose name
/// ends in .html, .svg or .xml.
Expected<std::string> render_page(const std::string& name, const std::string& json);

}  // namespace cxlab::lab
