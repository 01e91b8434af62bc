#include "planner/pddl/syntax.h"

#include <algorithm>
#include <cmath>

#include "cx/base/number_text.h"
#include "planner/pddl/failure.h"

namespace cxlab::planner {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v'; }
bool ends_word(char c) { return is_space(c) || c == '(' || c == ')' || c == ';'; }
bool is_letter(char c) { return c >= 'a' && c <= 'z'; }
bool is_control(char c) { return (c >= 0 && c < 0x20) || c == 0x7f; }

class FormReader {
 public:
  FormReader(std::string_view text, const std::string& file, const Deadline& deadline)
      : text_(text), file_(file), deadline_(deadline) {}

  Node read_file() {
    skip_space();
    if (at_end()) fail(line_, "the file is empty; expected (define ...)");
    if (text_[position_] != '(') fail(line_, found_text(word_at(position_).substr(0, 60), "(define ...)"));
    Node node = read_list(0);
    skip_space();
    if (!at_end())
      fail(line_,
           found_expected(text_[position_] == ')' ? "a ')' that closes nothing"
                                                  : "more text behind the closing ')' of (define ...)",
                          "the end of the file"),
           last_section());
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

  /// No name begins with `-` or has a `?` inside: `?b -farm` is `?b - farm`, and `?v?a` are two variables.
  std::string_view word_at(std::size_t begin) const {
    if (text_[begin] == '-' && begin + 1 < text_.size() && is_letter(text_[begin + 1])) return text_.substr(begin, 1);
    std::size_t end = begin;
    while (end < text_.size() && !ends_word(text_[end]) && (text_[end] != '?' || end == begin)) ++end;
    return text_.substr(begin, end - begin);
  }
  /// Where to look for the parenthesis: sections before the last were closed in order.
  std::string last_section() const {
    if (section_line_ == 0) return {};
    return message("; the last section before it, ", section_, ", begins in line ", section_line_);
  }

  /// `(:action` and its like stand directly in (define ...): inside another section, that one was not closed.
  void begin_section(const Node& outer, int depth) {
    const std::string_view name = word_at(position_ + 1).substr(0, 60);
    if (depth > 0 && !stands_inside(outer.head(), name))
      fail(section_line_ > 0 ? section_line_ : outer.line,
           found_expected(message("(", name, " in line ", line_), "a ')' before it for "),
           section_line_ > 0 ? message("the section ", section_) : "the list", " that begins here");
    if (depth > 0) return;
    section_ = name;
    section_line_ = line_;
  }

  static bool stands_inside(std::string_view section, std::string_view name) {
    if (section == ":length") return name == ":serial" || name == ":parallel";
    return name == ":private" && (section == ":predicates" || section == ":objects" || section == ":constants");
  }

  Node read_list(int depth) {
    Node list;
    list.is_list = true;
    list.line = line_;
    if (depth >= kDeepestNesting) fail(line_, "lists are nested more than ", kDeepestNesting, " deep");
    ++position_;
    while (true) {
      if (nodes_++ % kReadBetweenLooks == 0 && is_over(deadline_)) throw Rejected{too_late(file_)};
      skip_space();
      if (at_end())
        fail(list.line, found_expected("the end of the file", "a ')' for the list that begins here"), last_section());
      if (text_[position_] == ')') {
        ++position_;
        return list;
      }
      if (text_[position_] == '(') {
        if (text_.substr(position_ + 1).starts_with(':')) begin_section(list, depth);
        list.items.push_back(read_list(depth + 1));
      } else {
        Node& word = list.items.emplace_back();
        word.line = line_;
        word.word = word_at(position_);
        position_ += word.word.size();
        if (const auto control = std::ranges::find_if(word.word, is_control); control != word.word.end())
          fail(line_, found_expected(message("a control character (code ", static_cast<int>(*control), ") in a name"),
                                     "text"));
      }
    }
  }

  template <class... Parts>
  [[noreturn]] void fail(int line, const Parts&... parts) const {
    throw Rejected{input_error(message(parts...), file_, line)};
  }

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
  syntax.text = std::make_unique<std::string>(lower_case(text));
  std::string_view body = *syntax.text;
  if (body.starts_with("\xef\xbb\xbf")) body.remove_prefix(3);  // the mark of UTF-8 files
  return accepted([&] {
    syntax.root = FormReader(body, file, deadline).read_file();
    return std::move(syntax);
  });
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return lower;
}

std::string excerpt(const Node& node) {
  std::string out;
  append_excerpt(node, out);
  return out;
}

bool to_number(std::string_view word, double& number) {
  const auto read = read_number<double>(word);
  if (!read || !std::isfinite(*read)) return false;
  number = *read;
  return true;
}

}  // namespace cxlab::planner
