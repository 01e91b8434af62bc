// The reader of CLIPS files: a form is what stands in the file, and reads as itself alone.

#include <algorithm>

#include "cx/engine/form_reader.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_rules {

FUZZ_TARGET(rules) {
  using namespace cxlab;
  const std::string text = fuzz::text_of(data, size);
  const FormReading reading = read_forms(text, "fuzz.clp");
  const auto lines = 1 + std::count(text.begin(), text.end(), '\n');
  for (const Form& form : reading.forms) {
    fuzz::promise(text.find(form.text) != std::string::npos, "a form stands in the file");
    fuzz::promise(form.line >= 1 && form.line <= lines, "a form begins on a line of the file");
    for (const Token& token : tokens_of(form))
      fuzz::promise(token.line >= form.line && token.line <= lines, "a token lies within its form");
    if (form.text.starts_with("\xef\xbb\xbf")) continue;  // a word here, a byte order mark at the beginning of a file
    const FormReading alone = read_forms(form.text, "fuzz.clp");
    fuzz::promise(alone.errors.empty() && alone.forms.size() == 1 && alone.forms[0].text == form.text,
                  "a form reads as itself alone");
  }
  for (const Error& error : reading.errors)
    fuzz::promise(error.line >= 1 && error.line <= lines, "an error has a line of the file");
  return 0;
}

}  // namespace fuzz_rules
