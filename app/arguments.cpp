#include "app/arguments.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "cx/base/parse_number.h"

namespace cxlab::app {

namespace {

std::string expected(const std::string& found, const char* what) { return "found '" + found + "', expected " + what; }

}  // namespace

CLI::Validator not_negative() {
  return {[](std::string& text) {
            return parse_number<double>(text).value_or(-1) >= 0 ? std::string() : expected(text, "a number, 0 or more");
          },
          ""};
}

CLI::Validator positive() {
  return {[](std::string& text) {
            return parse_number<double>(text).value_or(0) > 0 ? std::string() : expected(text, "a number above 0");
          },
          ""};
}

CLI::Validator seed_number() {
  return {[](std::string& text) {
            return parse_number<std::uint64_t>(text) ? std::string()
                                                     : expected(text, "a whole number from 0 to 18446744073709551615");
          },
          ""};
}

void add_package_options(CLI::App& command, lab::PackageOptions& options) {
  command.add_option("--package", options.named, "NAME=DIR: where a package lies")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command
      .add_option("--prefix,--plugin-path", options.prefixes,
                  "DIR: packages installed below it are found, with their plugins (also $CXLAB_PREFIX_PATH)")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
}

/// Of a number that CLI11 cannot read it says neither what it expected nor how to write it.
static std::string told(const CLI::App& command, const CLI::ParseError& error) {
  const std::string text = error.what(), begin = "Could not convert: ";
  const std::size_t equals = text.find(" = ");
  if (!text.starts_with(begin) || equals == std::string::npos) return text;
  const std::string name = text.substr(begin.size(), equals - begin.size()), found = text.substr(equals + 3);
  const CLI::Option* option = command.get_option_no_throw(name);
  const bool whole = option && option->get_type_name().find("INT") != std::string::npos;
  const auto value = parse_number<double>(found);
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
