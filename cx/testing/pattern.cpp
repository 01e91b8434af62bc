#include "cx/testing/pattern.h"

#include <algorithm>
#include <charconv>

#include "cx/engine/form_reader.h"

namespace cxlab::testing {

namespace {

using Values = std::vector<std::string>;

bool is_number(const std::string& text, double& out) {
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size();
}

bool value_matches(const std::string& pattern, const std::string& value) {
  if (pattern.starts_with('?')) return true;
  if (pattern == value) return true;
  double a = 0, b = 0;
  return is_number(pattern, a) && is_number(value, b) && a == b;
}

bool values_match(const Values& pattern, std::size_t p, const Values& values, std::size_t v) {
  if (p == pattern.size()) return v == values.size();
  if (pattern[p].starts_with("$?")) {
    for (std::size_t end = v; end <= values.size(); ++end)
      if (values_match(pattern, p + 1, values, end)) return true;
    return false;
  }
  return v < values.size() && value_matches(pattern[p], values[v]) && values_match(pattern, p + 1, values, v + 1);
}

const Values* slot_of(const FactText& fact, const std::string& name) {
  const auto found =
      std::find_if(fact.slots.begin(), fact.slots.end(), [&](const auto& slot) { return slot.first == name; });
  return found == fact.slots.end() ? nullptr : &found->second;
}

std::string join(const Values& values) {
  std::string out;
  for (const std::string& v : values) out += (out.empty() ? "" : " ") + v;
  return out;
}

}  // namespace

std::string FactText::print() const {
  std::string out = '(' + template_name;
  for (const auto& [name, values] : slots) {
    if (name == "implied")
      out += (values.empty() ? "" : " ") + join(values);
    else
      out += " (" + name + (values.empty() ? "" : " ") + join(values) + ')';
  }
  return out + ')';
}

Expected<FactPattern> FactPattern::parse(const std::string& text, const std::string& file, int line) {
  const auto bad = [&](const std::string& what) {
    return input_error("fact pattern " + text + ": " + what, file, line);
  };
  const FormReading reading = read_forms(text, file);
  if (!reading.errors.empty()) return bad(reading.errors.front().message);
  if (reading.forms.size() != 1 || !reading.forms[0].list) return bad("expected one pattern in parentheses");
  FactPattern pattern;
  pattern.text_ = text;
  const std::vector<Token> tokens = tokens_of(reading.forms[0]);
  if (tokens.size() < 3 || tokens[1].kind != Token::Kind::kWord) return bad("expected the name of a deftemplate first");
  pattern.template_name_ = tokens[1].text;
  std::size_t i = 2;
  while (i + 1 < tokens.size()) {
    if (tokens[i].kind == Token::Kind::kConnective)
      return bad("&, | and ~ are not understood here; use several expectations");
    if (tokens[i].kind == Token::Kind::kOpen) {
      if (tokens[i + 1].kind != Token::Kind::kWord) return bad("expected the name of a slot");
      pattern.slots_.emplace_back(std::string(tokens[i + 1].text), Values{});
      for (i += 2; i + 1 < tokens.size() && tokens[i].kind != Token::Kind::kClose; ++i) {
        if (tokens[i].kind != Token::Kind::kWord && tokens[i].kind != Token::Kind::kString)
          return bad("a slot holds words, numbers, strings and ? only");
        pattern.slots_.back().second.emplace_back(tokens[i].text);
      }
      ++i;
      continue;
    }
    if (pattern.slots_.empty()) pattern.slots_.emplace_back("implied", Values{});
    if (pattern.slots_.back().first != "implied") return bad("values between slots");
    pattern.slots_.back().second.emplace_back(tokens[i++].text);
  }
  return pattern;
}

bool FactPattern::matches(const FactText& fact) const {
  return fact.template_name == template_name_ && difference(fact).empty();
}

int FactPattern::closeness(const FactText& fact) const {
  return static_cast<int>(std::count_if(slots_.begin(), slots_.end(), [&](const auto& slot) {
    const Values* values = slot_of(fact, slot.first);
    return values && values_match(slot.second, 0, *values, 0);
  }));
}

std::string FactPattern::difference(const FactText& fact) const {
  for (const auto& [name, wanted] : slots_) {
    const Values* values = slot_of(fact, name);
    if (!values) return "there is no slot " + name;
    if (!values_match(wanted, 0, *values, 0))
      return (name == "implied" ? "it" : name) + " is " + join(*values) + ", not " + join(wanted);
  }
  return {};
}

std::vector<std::string> FactPattern::slot_names() const {
  std::vector<std::string> out;
  for (const auto& slot : slots_)
    if (slot.first != "implied") out.push_back(slot.first);
  return out;
}

}  // namespace cxlab::testing
