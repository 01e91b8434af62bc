#pragma once
// Patterns of facts, as stories write them: `(command (robot "R1") (skill pick) (target ?))`, `(door open)`.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::testing {

/// A fact as the journal has it; values as CLIPS prints them (strings in quotes, handles as `<handle 3>`). An ordered
/// fact has the one slot "implied".
struct FactText {
  std::string template_name;
  std::vector<std::pair<std::string, std::vector<std::string>>> slots;
  std::string print() const;
};

/// A template and some of its slots; slots left out may have any value. `?` (or `?name`) stands for one value, `$?` for
/// any number of them. Numbers are compared as numbers, everything else as text: `"A"` is a string, `A` a symbol.
class FactPattern {
 public:
  static Expected<FactPattern> parse(const std::string& text, const std::string& file, int line);

  bool matches(const FactText& fact) const;
  /// How many of the pattern's slots the fact fulfils.
  int closeness(const FactText& fact) const;
  /// The first slot that the fact lacks or has otherwise: `state is FAILED`; empty if it matches.
  std::string difference(const FactText& fact) const;

  const std::string& template_name() const { return template_name_; }
  /// Empty for an ordered fact.
  std::vector<std::string> slot_names() const;
  const std::string& text() const { return text_; }

 private:
  std::string text_, template_name_;
  std::vector<std::pair<std::string, std::vector<std::string>>> slots_;
};

}  // namespace cxlab::testing
