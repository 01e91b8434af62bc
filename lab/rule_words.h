#pragma once
// Words of rules, as those who change rules tell them apart.

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <set>
#include <string>
#include <string_view>

#include "cx/base/number_text.h"
#include "cx/engine/form_reader.h"

namespace cxlab::lab {

using WordSet = std::set<std::string, std::less<>>;

inline bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}
inline bool is_variable_word(std::string_view word) { return word.starts_with('?') || word.starts_with("$?"); }

/// `1`, `-3`, `2.5`, `1e3`.
inline bool is_number_word(std::string_view word) {
  return word.find_first_of("0123456789") != word.npos && read_number<double>(std::string(word)).has_value();
}

/// A symbol, number or text that stands for itself.
inline bool is_constant(const Term& term) {
  return term.kind == Token::Kind::kString || (term.kind == Token::Kind::kWord && !is_variable_word(term.text));
}

}  // namespace cxlab::lab
