#pragma once
// JSON: values, and as text. Parser and writer are compiled once, in json.cpp.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace cxlab {

/// Objects keep the order in which their keys came.
using Json = nlohmann::ordered_json;

/// The value of a text; `is_discarded()` if it is no JSON.
Json parse_json(std::string_view text);

/// On one line, or indented by so many blanks. Texts of files and rules may be no UTF-8: what is not becomes U+FFFD.
std::string json_text(const Json& json, int indent = -1);

}  // namespace cxlab
