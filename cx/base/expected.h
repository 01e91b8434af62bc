#pragma once
// Errors as values: what was found, what was expected, where. Bad input never throws and is never only logged.

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace cxlab {

/// What kind of failure it is; each has one exit code (docs/reference/contracts.md).
enum class ErrorKind {
  kNo = 1,        ///< the answer is no: a test failed, a difference was found
  kUsage = 2,     ///< wrong command line
  kInput = 3,     ///< bad input file or value
  kRun = 4,       ///< the run failed: rule error, rule loop, world diverged, plugin failed
  kResource = 5,  ///< disk full, memory, library missing
  kBug = 70,      ///< a mistake of cxlab
};

/// One error. `file` and `line` are empty and 0 where there is none.
struct Error {
  ErrorKind kind = ErrorKind::kInput;
  std::string message;
  std::string file;
  int line = 0;
  std::string code;  ///< short machine word for result.json, for example "rule_loop"; empty = derived from kind

  /// `file:line: message`, without the parts that are missing.
  std::string text() const;
  /// The same error with a machine word.
  Error with_code(std::string word) && {
    code = std::move(word);
    return std::move(*this);
  }
};

// One function for each kind: `return usage_error("expected FROM:=TO");`

/// The answer is no: a test failed, a difference was found.
inline Error negative(std::string message, std::string file = {}, int line = 0) {
  return {ErrorKind::kNo, std::move(message), std::move(file), line, {}};
}
inline Error usage_error(std::string message, std::string file = {}, int line = 0) {
  return {ErrorKind::kUsage, std::move(message), std::move(file), line, {}};
}
inline Error input_error(std::string message, std::string file = {}, int line = 0) {
  return {ErrorKind::kInput, std::move(message), std::move(file), line, {}};
}
inline Error run_error(std::string message, std::string file = {}, int line = 0) {
  return {ErrorKind::kRun, std::move(message), std::move(file), line, {}};
}
inline Error resource_error(std::string message, std::string file = {}, int line = 0) {
  return {ErrorKind::kResource, std::move(message), std::move(file), line, {}};
}
/// A mistake of cxlab.
inline Error bug_error(std::string message, std::string file = {}, int line = 0) {
  return {ErrorKind::kBug, std::move(message), std::move(file), line, {}};
}

/// A value or an error. `if (!x) return x.error();`
template <class T>
class [[nodiscard]] Expected {
 public:
  Expected(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Expected(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  explicit operator bool() const { return state_.index() == 0; }
  bool ok() const { return state_.index() == 0; }

  T& operator*() & { return std::get<0>(state_); }
  const T& operator*() const& { return std::get<0>(state_); }
  T&& operator*() && { return std::get<0>(std::move(state_)); }
  T* operator->() { return &std::get<0>(state_); }
  const T* operator->() const { return &std::get<0>(state_); }

  const Error& error() const& { return std::get<1>(state_); }
  Error&& error() && { return std::get<1>(std::move(state_)); }

 private:
  std::variant<T, Error> state_;
};

/// Success or an error.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}

  explicit operator bool() const { return !error_; }
  bool ok() const { return !error_; }
  const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

/// "found X, expected Y": how a message names what stands where something else should; more may follow behind Y.
std::string found_expected(std::string_view found, std::string_view expected);
/// The same with what was found in quotes: "found 'X', expected Y".
std::string found_text(std::string_view text, std::string_view expected);
/// The candidate nearest to `word` by edit distance, also with its words in another order, or empty if none is near;
/// for "did you mean". Names of more than 200 letters are not compared.
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates);
/// ", did you mean 'X'?" with the nearest candidate, or nothing; for the end of a message.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates,
                         std::string_view separator = ", ");
/// "a, b and 3 more": the first `most` of the names.
std::string some_of(const std::vector<std::string>& names, std::size_t most = std::string::npos);
/// "a, b; did you mean 'a'?": the names that `word` could have been, and the nearest; for the end of a message.
std::string some_of_and_nearest(const std::string& word, const std::vector<std::string>& names,
                                std::size_t most = std::string::npos);

}  // namespace cxlab
