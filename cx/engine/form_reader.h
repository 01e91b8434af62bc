#pragma once
// Splits a CLIPS file into its top-level forms with their lines, so that every error of a rule file has a place.

#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab {

/// One top-level form `( ... )`, or a bare word, string or number between forms.
struct Form {
  std::string text;   ///< as written, from its first to its last character
  int line = 0;       ///< where it begins, counted from 1
  bool list = false;  ///< begins with a parenthesis
  std::string head;   ///< first word of a list: "defrule", "assert", ...; of a bare form the whole of it
  std::string name;   ///< second word of a list: the name of a construct, without its module
};

struct FormReading {
  std::vector<Form> forms;
  std::vector<Error> errors;  ///< each with file and line
};

/// Reads forms as the scanner of CLIPS would: `;` comments, strings with `\` escapes, words that end at
/// `( ) " & | ~ ;` and blanks. A form that is never closed is an error at the line where it begins and ends the
/// reading there; text that begins in column 1 with `(def` inside it is named as the probable place. A stray `)` is an error and skipped.
FormReading read_forms(std::string_view text, const std::string& file);

/// Words of a form in order, without those in strings and comments, each with its line within the file.
struct Word {
  std::string_view text;
  int line = 0;
  bool opens = false;   ///< the word stands directly after `(`: it is called, or names a template
};
std::vector<Word> words_of(const Form& form);

}  // namespace cxlab
