#include "app/arguments.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <sstream>

#include "app/command.h"
#include "cx/base/number_text.h"
#include "cx/inspect/text.h"
#include "lab/run.h"

namespace cxlab::app {

namespace {

std::optional<double> finite_number(const std::string& text) {
  const auto value = read_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::string expected(const std::string& found, const char* what) { return found_text(found, what); }

}  // namespace

CLI::Validator not_negative() {
  return {[](std::string& text) {
            return finite_number(text).value_or(-1) >= 0 ? std::string() : expected(text, "a number, 0 or more");
          },
          ""};
}

CLI::Validator positive() {
  return {[](std::string& text) {
            return finite_number(text).value_or(0) > 0 ? std::string() : expected(text, "a number above 0");
          },
          ""};
}

CLI::Validator between(double low, double high) {
  return {[low, high](std::string& text) {
            const auto value = finite_number(text);
            if (value && *value >= low && *value <= high) return std::string();
            return expected(text, "a number from ") + general_text(low, 6) + " to " + general_text(high, 6);
          },
          ""};
}

CLI::Validator picture_size() {
  return {[](std::string& text) {
            constexpr int kLeast = 16, kMost = 4096;
            const auto fits = [](int pixels) { return pixels >= kLeast && pixels <= kMost; };
            int width = 0, height = 0;
            char rest = 0;
            if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) == 2 && fits(width) && fits(height))
              return std::string();
            return expected(text, "WIDTHxHEIGHT, each from 16 to 4096");
          },
          ""};
}

std::size_t read_bytes(const std::string& text) {
  const std::size_t unit = std::min(text.find_first_not_of("0123456789."), text.size());
  const std::string_view word = std::string_view(text).substr(unit);
  const double factor = word == "MB" ? 1e6 : word == "kB" || word == "KB" ? 1e3 : word.empty() ? 1 : 0;
  const double bytes = read_number<double>(text.substr(0, unit)).value_or(0) * factor;
  return bytes < 1e15 ? static_cast<std::size_t>(bytes) : 0;
}

CLI::Validator byte_count() {
  return {[](std::string& text) {
            constexpr std::size_t kLeast = 10'000;
            return read_bytes(text) >= kLeast ? std::string()
                                              : expected(text, "a size of at least 10kB, as 2MB, 800kB or 2000000");
          },
          ""};
}

void read_size(const std::string& text, int& width, int& height) {
  std::sscanf(text.c_str(), "%dx%d", &width, &height);
}

namespace {

/// CLI11 gets the number in plain digits: it would read 010 as octal, and what is too large as the largest.
template <class Number>
std::string check_whole(std::string& text, Number low, Number high) {
  const auto value = read_number<Number>(text);
  if (value && *value >= low && *value <= high) {
    text = std::to_string(*value);
    return {};
  }
  const double written = finite_number(text).value_or(0.5), least = static_cast<double>(low);
  if (!value && written == std::floor(written) && written >= least && written <= static_cast<double>(high) &&
      written < 1e15)
    return expected(text, "a whole number: ") + std::to_string(static_cast<std::int64_t>(written));
  return expected(text, "a whole number from ") + std::to_string(low) + " to " + std::to_string(high);
}

}  // namespace

std::vector<std::string> given_options(const CLI::App& command, std::initializer_list<const char*> names) {
  std::vector<std::string> out;
  for (const char* name : names)
    if (const CLI::Option* option = command.get_option(name); option->count() > 0)
      out.insert(out.end(), {name, option->results().front()});
  return out;
}

CLI::Option* seed_number(CLI::Option* option) {
  return option->transform({[](std::string& text) { return check_whole<std::uint64_t>(text, 0, UINT64_MAX); }, ""});
}

CLI::Option* whole_number(CLI::Option* option, std::int64_t low, std::int64_t high) {
  const std::string from = "from " + std::to_string(low);
  return option->transform({[low, high](std::string& text) { return check_whole(text, low, high); },
                            high == INT64_MAX ? from : from + " to " + std::to_string(high)});
}

CLI::Option* time_option(CLI::Option* option) {
  return option->transform({[](std::string& text) {
                              const auto seconds = inspect::seconds_in(text);
                              if (!seconds || finite_number(*seconds).value_or(-1) > to_seconds(kLongestRun))
                                return expected(text, "a time: s from 0 to 1e9, as 312.4, or minutes and s, as 5:12.4");
                              text = *seconds;
                              return std::string();
                            },
                            ""});
}

CLI::Validator one_of(std::vector<std::string> words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : ",") + word;
  return {[words = std::move(words)](std::string& text) {
            if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
            return found_text(text, "one of: " + some_of_and_nearest(text, words));
          },
          '{' + list + '}'};
}

std::vector<std::string> words_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{'), end = type.find('}');
  std::vector<std::string> out;
  if (begin == std::string::npos || end == std::string::npos) return out;
  std::stringstream words(type.substr(begin + 1, end - begin - 1));
  for (std::string word; std::getline(words, word, ',');) out.push_back(word);
  return out;
}

std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> out;
  for (const std::string& name : option.get_snames()) out.push_back('-' + name);
  for (const std::string& name : option.get_lnames()) out.push_back("--" + name);
  return out;
}

std::string all_names(const CLI::Option& option) {
  std::string text;
  for (const std::string& name : names_of(option)) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? option.get_name(true) : text;
}

CLI::Option* once_each(CLI::Option* option) { return option->take_all()->expected(1)->allow_extra_args(false); }

void add_prefix_option(CLI::App& command, std::vector<std::string>& prefixes) {
  once_each(command.add_option(
      "--prefix,--plugin-path", prefixes,
      "DIR: also finds the packages installed below it, with their plugins (also $CXLAB_PREFIX_PATH)"));
}

void add_package_options(CLI::App& command, lab::PackageOptions& options) {
  once_each(command.add_option("--package", options.named, "NAME=DIR: folder of a package"));
  add_prefix_option(command, options.prefixes);
}

void add_trust_programs(CLI::App& command, bool& trust) {
  command.add_flag("--trust-programs", trust,
                   "Lets the run's native plugins, and programs that its nodes name, read, write and run anything");
}

namespace {

/// The error for an unknown word of the command line, with the nearest option.
std::string unknown(const CLI::App& command) {
  const std::vector<std::string> rest = command.remaining();
  const auto option = std::find_if(rest.begin(), rest.end(), [](const std::string& word) { return word[0] == '-'; });
  if (option == rest.end())
    return rest.empty() ? "one argument too many" : "one argument too many: '" + rest.front() + "'";
  const std::string name = option->substr(0, option->find('='));
  std::vector<std::string> known;
  for (const CLI::Option* o : command.get_options())
    for (const std::string& long_name : o->get_lnames()) known.push_back("--" + long_name);
  return "there is no option '" + name + "'" + did_you_mean(name, known);
}

/// A subcommand that is missing, or the nearest to the word that stands in its place.
std::string missing_command(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* sub : command.get_subcommands(nullptr)) names.push_back(sub->get_name());
  const std::vector<std::string> rest = command.remaining();
  if (rest.empty()) return "a command is missing" + (command.get_parent() ? ": " + some_of(names) : "");
  return found_text(rest.front(), "one of: " + some_of_and_nearest(rest.front(), names));
}

/// One of its words if there are only some, else what its description says.
std::string what_it_takes(const CLI::Option& option) {
  const std::vector<std::string> words = words_of(option);
  return words.empty() ? option.get_description() : "one of " + some_of(words);
}

/// With all names of the option that a message begins with, where CLI11 says one.
std::string with_all_names(const CLI::App& command, const std::string& message) {
  const std::size_t end = std::min(message.find_first_of(": "), message.size());
  const CLI::Option* option = command.get_option_no_throw(message.substr(0, end));
  return option ? all_names(*option) + message.substr(end) : message;
}

/// The message of CLI11, or a better one: it names no near option.
std::string explained(const CLI::App& command, const CLI::ParseError& error) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError)) return unknown(command);
  const std::string text = error.what(), begin = "Could not convert: ";
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::RequiredError)) {
    if (command.get_require_subcommand_min() > 0) return missing_command(command);
    // The missing option may be a misspelt one.
    for (const std::string& word : command.remaining())
      if (word.starts_with('-')) return unknown(command);
    const CLI::Option* missing = command.get_option_no_throw(text.substr(0, text.find(" is required")));
    if (missing) return text + ": " + what_it_takes(*missing);
  }
  if (const std::size_t times = text.find(": At Most 1 required but received "); times != std::string::npos)
    return text.substr(0, times) + ": given " + text.substr(text.rfind(' ') + 1) + " times, expected once";
  if (text.find(": 1 required ") != std::string::npos && text.ends_with(" missing"))
    return text.substr(0, text.find(": ")) + ": its value is missing";
  if (const std::size_t given = text.find(" was given a disallowed flag override"); given != std::string::npos)
    return (given == 1 ? "-" : "--") + text.substr(0, given) + ": takes no value";
  const std::size_t equals = text.find(" = ");
  if (!text.starts_with(begin) || equals == std::string::npos) return text;
  const std::string name = text.substr(begin.size(), equals - begin.size()), found = text.substr(equals + 3);
  return name + ": " + expected(found, "a number");
}

}  // namespace

int usage_exit(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);
  std::string command = "cxlab";
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) command += ' ' + (at = at->get_subcommands().front())->get_name();
  const int code = fail(usage_error(with_all_names(*at, explained(*at, error))));
  std::fprintf(stderr, "%s --help says more\n", command.c_str());
  return code;
}

void refuse_values_of_flags(CLI::App& app) {
  for (CLI::Option* option : app.get_options())
    if (option->get_expected_max() == 0) option->disable_flag_override();
  for (CLI::App* command : app.get_subcommands(nullptr)) refuse_values_of_flags(*command);
}

Status check_values(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands()) {
    if (Status s = check_values(*command); !s) return s;
    for (const CLI::Option* option : command->get_options())
      if (option->get_expected_max() > 0)
        for (const std::string& value : option->results())
          if (value.empty()) return usage_error(all_names(*option) + ": " + found_text("", "a value"));
  }
  return {};
}

Status check_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return {};
  const std::string word = argv[1];
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  if (std::find(names.begin(), names.end(), word) != names.end()) return {};
  const std::string near = did_you_mean(word, names);
  return usage_error("there is no command '" + word + "'" + (near.empty() ? "; cxlab --help lists them" : near));
}

}  // namespace cxlab::app
