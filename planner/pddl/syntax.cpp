#include "planner/pddl/syntax.h"

#include <charconv>
#include <cmath>

#include "planner/pddl/failure.h"

namespace cxlab::planner {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v'; }
bool ends_word(char c) { return is_space(c) || c == '(' || c == ')' || c == ';'; }
bool is_control(char c) { return (c >= 0 && c < 0x20) || c == 0x7f; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

class FormReader {
 public:
  FormReader(std::string_view text, const std::string& file, const Deadline& deadline)
      : text_(text), file_(file), deadline_(deadline) {}

  Expected<Node> read_file() {
    skip_space();
    if (at_end()) return error("the file is empty; expected (define ...)", line_);
    if (text_[position_] != '(')
      return error("found '" + std::string(take_word_for_message()) + "', expected (define ...)", line_);
    auto node = read_list(0);
    if (!node) return node;
    skip_space();
    if (!at_end())
      return error((text_[position_] == ')'
                        ? "found a ')' that closes nothing; expected the end of the file"
                        : "found more text behind the closing ')' of (define ...); expected the end of the file") +
                       last_section(),
                   line_);
    return node;
  }

 private:
  bool at_end() const { return position_ >= text_.size(); }

  void skip_space() {
    for (; !at_end(); ++position_) {
      const char c = text_[position_];
      if (c == '\n') ++line_;
      if (is_space(c)) continue;
      if (c != ';') return;
      while (!at_end() && text_[position_] != '\n') ++position_;
      --position_;  // the loop steps to the line's end, and counts it
    }
  }

  std::string_view take_word() {
    const std::size_t begin = position_;
    while (!at_end() && !ends_word(text_[position_])) ++position_;
    return text_.substr(begin, position_ - begin);
  }
  /// Where to look for the parenthesis: sections before the last were closed in order.
  std::string last_section() const {
    return section_line_ == 0 ? ""
                              : "; the last section before it, " + std::string(section_) + ", begins in line " +
                                    std::to_string(section_line_);
  }

  std::string_view take_word_for_message() { return take_word().substr(0, 60); }

  /// `(:action` and its like stand directly in (define ...): inside another section, that one was not closed.
  Status begin_section(const Node& outer, int depth) {
    const std::size_t begin = position_;
    ++position_;
    const std::string_view name = take_word_for_message();
    position_ = begin;
    if (depth > 0)
      return error("found (" + std::string(name) + " in line " + std::to_string(line_) +
                       ", expected a ')' before it for " +
                       (section_line_ > 0 ? "the section " + std::string(section_) : "the list") + " that begins here",
                   section_line_ > 0 ? section_line_ : outer.line);
    section_ = name;
    section_line_ = line_;
    return {};
  }

  Expected<Node> read_list(int depth) {
    Node list;
    list.is_list = true;
    list.line = line_;
    if (depth >= kDeepestNesting)
      return error("lists are nested more than " + std::to_string(kDeepestNesting) + " deep", line_);
    ++position_;
    while (true) {
      if (nodes_++ % kReadBetweenLooks == 0 && is_over(deadline_)) return too_late(file_);
      skip_space();
      if (at_end())
        return error("found the end of the file, expected a ')' for the list that begins here" + last_section(),
                     list.line);
      if (text_[position_] == ')') {
        ++position_;
        return list;
      }
      if (text_[position_] == '(') {
        if (text_.substr(position_ + 1).starts_with(':')) {
          if (Status s = begin_section(list, depth); !s) return s.error();
        }
        auto item = read_list(depth + 1);
        if (!item) return item;
        list.items.push_back(std::move(*item));
      } else {
        Node word;
        word.line = line_;
        word.word = take_word();
        for (const char c : word.word)
          if (is_control(c))
            return error(
                "found a control character (code " + std::to_string(static_cast<int>(c)) + ") in a name, expected text",
                line_);
        list.items.push_back(std::move(word));
      }
    }
  }

  Error error(std::string message, int line) const { return input_error(std::move(message), file_, line); }

  std::string_view text_;
  const std::string& file_;
  const Deadline& deadline_;
  std::size_t position_ = 0, nodes_ = 0;
  int line_ = 1;
  std::string_view section_;  // the last that began
  int section_line_ = 0;
};

void append_excerpt(const Node& node, std::string& out) {
  constexpr std::size_t kLongest = 60;
  if (out.size() > kLongest) return;
  if (!node.is_list) {
    out += node.word.substr(0, kLongest);
    return;
  }
  out += '(';
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (i > 0) out += ' ';
    if (out.size() > kLongest) {
      out += "...";
      break;
    }
    append_excerpt(node.items[i], out);
  }
  out += ')';
}

}  // namespace

bool is_over(const Deadline& deadline) { return deadline && std::chrono::steady_clock::now() >= *deadline; }

Error too_late(const std::string& file) {
  return resource_error("the time ended while the file was read", file).with_code(word_of(Failure::kLate));
}

Expected<Syntax> read_syntax(std::string_view text, const std::string& file, const Deadline& deadline) {
  Syntax syntax;
  syntax.text = std::make_unique<std::string>(text);
  for (char& c : *syntax.text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  std::string_view body = *syntax.text;
  if (body.starts_with("\xef\xbb\xbf")) body.remove_prefix(3);  // the mark of UTF-8 files
  auto root = FormReader(body, file, deadline).read_file();
  if (!root) return root.error();
  syntax.root = std::move(*root);
  return syntax;
}

std::string excerpt(const Node& node) {
  std::string out;
  append_excerpt(node, out);
  return out;
}

bool to_number(std::string_view word, double& number) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const std::string_view digits = word.starts_with('-') ? word.substr(1) : word;
  if (digits.empty() || !(is_digit(digits[0]) || (digits[0] == '.' && digits.size() > 1 && is_digit(digits[1]))))
    return false;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), number);
  return code == std::errc{} && end == word.data() + word.size() && std::isfinite(number);
}

}  // namespace cxlab::planner
