#include "lab/bag_options.h"

#include <filesystem>

#include "cx/base/number_text.h"

namespace cxlab::lab {

namespace {

/// In single quotes of YAML.
std::string quoted_value(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + '\'';
}

}  // namespace

Expected<std::vector<Override>> overrides_of(const BagOptions& options) {
  std::vector<Override> out;
  const auto set = [&](const char* key, const std::string& yaml, const std::string& option) {
    out.emplace_back(std::string("bag.") + key + '=' + yaml, option);
  };
  const auto set_number = [&](const char* key, const std::optional<double>& value) {
    const std::string text = value ? general_text(*value, 15) : "";
    if (value)
      set(key, text,
          "--bag-" + std::string(std::string_view(key).substr(0, std::string_view(key).find('_'))) + ' ' + text);
  };
  const auto set_text = [&](const char* key, const std::string& text) {
    if (!text.empty()) set(key, quoted_value(text), std::string("--bag-") + key + ' ' + text);
  };
  if (!options.file.empty())
    set("file", quoted_value(std::filesystem::absolute(options.file).lexically_normal().string()),
        "--bag " + options.file);
  set_number("start_s", options.start);
  set_number("offset_s", options.offset);
  set_number("rate", options.rate);
  set_text("topics", options.topics);
  set_text("exclude", options.exclude);
  std::string remaps, given;
  for (const std::string& remap : options.remaps) {
    const std::size_t sign = remap.find(":=");
    if (sign == std::string::npos || sign == 0) return usage_error("--bag-remap: " + found_text(remap, "FROM:=TO"));
    remaps += (remaps.empty() ? "" : ", ") + quoted_value(remap.substr(0, sign)) + ": " +
              quoted_value(remap.substr(sign + 2));
    given += " --bag-remap " + remap;
  }
  if (!remaps.empty()) set("remap", '{' + remaps + '}', given.substr(1));
  if (options.own) set("own", "true", "--bag-own");
  return out;
}

}  // namespace cxlab::lab
