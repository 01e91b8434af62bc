#include "lab/json_fields.h"

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "scenarios/run_spec.h"

namespace cxlab::lab {

Expected<Json> parse_object(const std::string& text, const std::filesystem::path& file) {
  auto json = parse_json(text);
  if (!json.is_object()) return input_error("expected an object in JSON", file.string());
  return json;
}

Expected<Json> read_json(const std::filesystem::path& file) {
  auto text = read_file(file);
  if (!text) return text.error();
  return parse_object(*text, file);
}

std::string without_code(const Json::exception& e) {
  const std::string text = e.what();
  const std::size_t end = text.find("] ");
  return end == text.npos ? text : text.substr(end + 2);
}

void check_time(const char* name, double time, const Json& in) {
  if (!(time >= 0 && time <= to_seconds(kLongestRun)))
    throw Json::other_error::create(
        500, "'" + std::string(name) + "': " + found_expected(general_text(time, 9), "s from 0 to 1e9"), &in);
}

Json::other_error unknown_word(const char* name, const Json& found, const std::vector<std::string>& words) {
  return Json::other_error::create(
      500, "'" + std::string(name) + "': " + found_text(found.get<std::string>(), "one of: " + some_of(words)), &found);
}

}  // namespace cxlab::lab
