#pragma once
// Numbers as text and back, whatever locale the host program has set.

#include <charconv>
#include <optional>
#include <string>
#include <string_view>

namespace cxlab {

/// The number that the whole text is, with or without a sign: `read_number<double>("1.5")`.
template <class Number>
std::optional<Number> read_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && at == end ? std::optional(number) : std::nullopt;
}

/// As printf writes a number with "%.<digits>g" in the C locale: `digits` significant digits, "1.5", "1e-07".
std::string general_text(double value, int digits);
/// "312.4 s": nine significant digits.
inline std::string seconds_text(double seconds) { return general_text(seconds, 9) + " s"; }
/// As printf writes a number with "%.<decimals>f" in the C locale.
std::string fixed_text(double value, int decimals);
/// The shortest text that reads back as the same number.
std::string shortest_text(double value);

/// While one lives, the C library reads and prints numbers on this thread as in the C locale: for code that uses it, as
/// CLIPS does.
class CLocale {
 public:
  CLocale();
  ~CLocale();
  CLocale(const CLocale&) = delete;
  CLocale& operator=(const CLocale&) = delete;

 private:
  void* before_;
};

}  // namespace cxlab
