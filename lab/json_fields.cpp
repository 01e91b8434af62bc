#include "lab/json_fields.h"

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "scenarios/run_spec.h"

namespace cxlab::lab {

Expected<nlohmann::json> parse_object(const std::string& text, const std::filesystem::path& file) {
  auto json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return input_error("expected an object in JSON", file.string());
  return json;
}

Expected<nlohmann::json> read_json(const std::filesystem::path& file) {
  auto text = read_file(file);
  if (!text) return text.error();
  return parse_object(*text, file);
}

std::string without_code(const nlohmann::json::exception& e) {
  const std::string text = e.what();
  const std::size_t end = text.find("] ");
  return end == text.npos ? text : text.substr(end + 2);
}

void check_time(const char* name, double time, const nlohmann::json& in) {
  if (!(time >= 0 && time <= to_seconds(kLongestRun)))
    throw nlohmann::json::other_error::create(
        500, "'" + std::string(name) + "': found " + general_text(time, 9) + ", expected s from 0 to 1e9", &in);
}

nlohmann::json::other_error unknown_word(const char* name, const nlohmann::json& found,
                                         const std::vector<std::string>& words) {
  return nlohmann::json::other_error::create(500,
                                             "'" + std::string(name) + "': found '" + found.get<std::string>() +
                                                 "', expected one of: " + some_of(words, words.size()),
                                             &found);
}

}  // namespace cxlab::lab
