#pragma once
// Checks of option values; their messages say what was found and what was expected.

#include <CLI/CLI.hpp>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/named_value.h"
#include "lab/packages.h"

namespace cxlab::app {

/// A number, 0 or more.
CLI::Validator not_negative();
/// A number above 0.
CLI::Validator positive();
/// A number within these bounds.
CLI::Validator between(double low, double high);
/// Limits for the speed of a film.
inline constexpr double kSlowest = 0.01, kFastest = 10000;
/// How many frames a film may have in a second.
inline constexpr double kFewestFrames = 1, kMostFrames = 120;
inline constexpr const char *kVideoHelp = "A film, as film.gif (an animated image), or film.mp4 (needs ffmpeg)",
                            *kMaxSizeHelp =
                                "Largest size of an animated image, such as 2MB or 800kB (default 5MB); cxlab leaves "
                                "out frames, or makes them smaller";
/// Bytes, as 2MB, 800kB or a plain number; at least 10kB.
CLI::Validator byte_count();
/// What a text that `byte_count` has let through says; 0 for an empty one.
std::size_t read_bytes(const std::string& text);
/// WIDTHxHEIGHT, px.
CLI::Validator picture_size();
/// What a text that `picture_size` has let through says.
void read_size(const std::string& text, int& width, int& height);
/// One of these words.
CLI::Validator one_of(std::vector<std::string> words);
/// Declares an option that takes one of the words of an enumeration.
template <class Enum>
CLI::Option* add_choice(CLI::App& command, const std::string& name, NamedValue<Enum> value, const std::string& what) {
  return command
      .add_option_function<std::string>(
          name, [value](const std::string& word) mutable { value.set(word); }, what)
      ->check(one_of({value.begin, value.end}));
}
/// The words of `one_of`, if the option takes only these.
std::vector<std::string> words_of(const CLI::Option& option);

/// Those of these options that the command line gives, each followed by its value; sizes are in bytes.
std::vector<std::string> given_options(const CLI::App& command, std::initializer_list<const char*> names);

/// The names of an option with their dashes; none for an argument.
std::vector<std::string> names_of(const CLI::Option& option);
/// "-j, --jobs", or the name of an argument.
std::string all_names(const CLI::Option& option);

/// The option takes a whole number in decimal digits, within these bounds. Every option that holds an integer has this
/// check or the next one.
CLI::Option* whole_number(CLI::Option* option, std::int64_t low, std::int64_t high = INT64_MAX);
/// The option takes a whole number from 0 that 64 bits hold.
CLI::Option* seed_number(CLI::Option* option);
/// The option takes a time of a run, as s (312.4) or as minutes and s (5:12, 5:12.4), and holds it in s.
CLI::Option* time_option(CLI::Option* option);
/// The option may come often, with one value each time; it takes no argument that follows.
CLI::Option* once_each(CLI::Option* option);
/// Declares `--prefix`.
void add_prefix_option(CLI::App& command, std::vector<std::string>& prefixes);
/// Declares `--package` and `--prefix`.
void add_package_options(CLI::App& command, lab::PackageOptions& options);

/// Declares `--trust-programs` of commands that play a recorded run.
void add_trust_programs(CLI::App& command, bool& trust);

/// Exit code of a command line that cannot be used; 0 after `--help` and `--version`.
int usage_exit(const CLI::App& app, const CLI::ParseError& error);
/// `--quiet=3` and `--quiet=false` become errors; CLI11 would count them or turn the flag off.
void refuse_values_of_flags(CLI::App& app);
/// Fails where an argument is empty, which nothing takes.
Status check_values(const CLI::App& app);
/// Fails if the first argument is no command: CLI11 would only say that one is missing.
Status check_command(const CLI::App& app, int argc, char** argv);

}  // namespace cxlab::app
