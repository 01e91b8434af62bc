#pragma once
// JSON as text.

#include <string>

namespace cxlab {

/// A value of nlohmann::json as text, on one line or indented by so many blanks. Texts of files and rules may be no
/// UTF-8: what is not becomes U+FFFD.
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace cxlab
