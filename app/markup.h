#pragma once
// Text inside HTML, SVG and XML.

#include <string>
#include <string_view>

namespace cxlab::app {

/// With & < > " as entities: for content and for attributes in double quotes.
std::string escape(std::string_view text);

}  // namespace cxlab::app
