#include "app/arguments.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <sstream>

namespace cxlab::app {

namespace {

std::optional<double> number_in(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value) ? std::optional(value)
                                                                                          : std::nullopt;
}

std::string expected(const std::string& found, const char* what) { return "found '" + found + "', expected " + what; }

std::string seconds(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", value);
  return text;
}

}  // namespace

CLI::Validator not_negative() {
  return {[](std::string& text) {
            return number_in(text).value_or(-1) >= 0 ? std::string() : expected(text, "a number, 0 or more");
          },
          ""};
}

CLI::Validator positive() {
  return {[](std::string& text) {
            return number_in(text).value_or(0) > 0 ? std::string() : expected(text, "a number above 0");
          },
          ""};
}

CLI::Validator seed_number() {
  return {[](std::string& text) {
            std::uint64_t value = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            return error == std::errc() && end == text.data() + text.size()
                       ? std::string()
                       : expected(text, "a whole number from 0 to 18446744073709551615");
          },
          ""};
}

Expected<std::vector<double>> snapshot_times(const std::string& text, double end) {
  const auto wrong = [](const std::string& message) { return usage_error("--snapshot: " + message); };
  const auto bad = [&] { return wrong(expected(text, "every:SECONDS or SECONDS,SECONDS,...")); };
  std::vector<double> times;
  if (text.empty()) return times;
  if (text.starts_with("every:")) {
    const auto step = number_in(text.substr(6));
    constexpr double kFewest = 1e-3;  // s; there is no shorter tick in use, and every time is kept
    if (!step || *step <= 0) return bad();
    if (*step < kFewest) return wrong("found '" + text + "', expected at least " + seconds(kFewest));
    for (int k = 0; k * *step <= end; ++k) times.push_back(k * *step);
    return times;
  }
  std::stringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto time = number_in(word);
    if (!time || *time < 0) return bad();
    if (*time > end) return wrong("there is no picture at " + seconds(*time) + ": the run ends at " + seconds(end));
    times.push_back(*time);
  }
  if (times.empty()) return bad();
  std::sort(times.begin(), times.end());
  return times;
}

/// Of a number that CLI11 cannot read it says neither what it expected nor how to write it.
static std::string told(const CLI::App& command, const CLI::ParseError& error) {
  const std::string text = error.what(), begin = "Could not convert: ";
  const std::size_t equals = text.find(" = ");
  if (!text.starts_with(begin) || equals == std::string::npos) return text;
  const std::string name = text.substr(begin.size(), equals - begin.size()), found = text.substr(equals + 3);
  const CLI::Option* option = command.get_option_no_throw(name);
  const bool whole = option && option->get_type_name().find("INT") != std::string::npos;
  const auto value = number_in(found);
  const bool is_whole = whole && value && *value == std::floor(*value) && std::abs(*value) < 1e15;
  return name + ": " + expected(found, whole ? "a whole number" : "a number") +
         (is_whole ? ": " + std::to_string(static_cast<std::int64_t>(*value)) : "");
}

int usage_exit(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);
  std::string command = "cxlab";
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) command += ' ' + (at = at->get_subcommands().front())->get_name();
  std::fprintf(stderr, "error: %s\n%s --help tells more\n", told(*at, error).c_str(), command.c_str());
  return static_cast<int>(ErrorKind::kUsage);
}

Status check_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return {};
  const std::string word = argv[1];
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), word) != names.end()) return {};
  return usage_error("there is no command '" + word + "'" + did_you_mean(word, names) + "; cxlab --help lists them");
}

}  // namespace cxlab::app
