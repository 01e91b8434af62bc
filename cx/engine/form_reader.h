#pragma once
// Splits a CLIPS file into its top-level forms with their lines, so that every error of a rule file has a place.

#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab {

/// One top-level form `( ... )`, or a bare word, string or number between forms.
struct Form {
  std::string text;    ///< as written, from its first to its last character
  int line = 0;        ///< where it begins, counted from 1
  bool list = false;   ///< begins with a parenthesis
  std::string head;    ///< first word of a list: "defrule", "assert", ...; of a bare form the whole of it
  std::string name;    ///< second word of a list: the name of a construct, without its module
  std::size_t at = 0;  ///< where it begins, in bytes of the file
};

struct FormReading {
  std::vector<Form> forms;
  std::vector<Error> errors;  ///< each with file and line
};

/// Reads forms as the scanner of CLIPS would: `;` comments, strings with `\` escapes, words that end at
/// `( ) " & | ~ ;` and blanks. A form that is never closed is an error at the line where it begins; reading goes on
/// at the next line that begins with `(def`. A stray `)`, a zero byte and a form beyond `kDeepestForm` or `kWidestForm`
/// are errors and skipped.
FormReading read_forms(std::string_view text, const std::string& file);

/// CLIPS and our own readers use the stack for each level of parentheses.
inline constexpr int kDeepestForm = 1000;
/// CLIPS counts the parts of a form in 16 bits, and looks for many of them in time with the square of their number.
inline constexpr int kWidestForm = 30'000;
/// Why a text that CLIPS is to read as one or more forms is too large for that; empty if it is not.
std::string excess_of(std::string_view text);

/// `go` of `MAIN::go`.
inline std::string_view without_module(std::string_view name) {
  const std::size_t colons = name.find("::");
  return colons == std::string_view::npos ? name : name.substr(colons + 2);
}

/// The parts of a form, without comments.
struct Token {
  enum class Kind { kOpen, kClose, kWord, kString, kConnective };  ///< connectives: & | ~
  Kind kind = Kind::kWord;
  std::string_view text;
  int line = 0;  ///< within the file
};
/// The tokens of a form; they borrow its text.
std::vector<Token> tokens_of(const Form& form);

/// A form as a tree: a list, or a word, string or connective.
struct Term {
  Token::Kind kind = Token::Kind::kWord;  ///< kOpen: a list
  std::string text;                       ///< empty for a list; strings keep their quotes
  std::vector<Term> items;                ///< of a list
  int line = 0;                           ///< within the file
  std::size_t begin = 0, end = 0;         ///< of its characters in the text of the form

  bool is_list() const { return kind == Token::Kind::kOpen; }
  bool is(std::string_view word) const { return kind != Token::Kind::kString && text == word; }
  /// The first word of a list, else empty.
  std::string_view head() const;
  /// In one line.
  std::string print() const;
};
Term tree_of(const Form& form);

}  // namespace cxlab
