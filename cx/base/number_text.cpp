#include "cx/base/number_text.h"

#include <locale.h>

#include <array>
#include <charconv>

namespace cxlab {

namespace {

/// The largest number has 309 digits before the point.
template <class... Format>
std::string text_of(double value, Format... format) {
  std::array<char, 400> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, format...).ptr};
}

}  // namespace

std::string general_text(double value, int digits) { return text_of(value, std::chars_format::general, digits); }
std::string fixed_text(double value, int decimals) { return text_of(value, std::chars_format::fixed, decimals); }
std::string shortest_text(double value) { return text_of(value); }

CLocale::CLocale() {
  static const locale_t c = newlocale(LC_ALL_MASK, "C", nullptr);
  before_ = uselocale(c);
}
CLocale::~CLocale() { uselocale(static_cast<locale_t>(before_)); }

}  // namespace cxlab
