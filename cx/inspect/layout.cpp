#include "cx/inspect/layout.h"

#include <algorithm>
#include <vector>

namespace cxlab::inspect {

namespace {

constexpr std::size_t kLeastRoom = 40;

/// How many columns a text takes, of characters that take one each.
std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string_view without_blanks_before(std::string_view text) {
  return text.substr(std::min(text.find_first_not_of(' '), text.size()));
}

/// The text, cut before blanks that are within at most `depth` parentheses. Each part but the first has its blanks.
std::vector<std::string_view> parts_of(std::string_view text, int depth) {
  const bool has_strings = std::ranges::count(text, '"') % 2 == 0;  // else the text was cut in the middle of one
  std::vector<std::string_view> parts;
  std::size_t begin = 0;
  int open = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (has_strings && c == '"' && (i == 0 || text[i - 1] != '\\')) quoted = !quoted;
    if (quoted) continue;
    open += c == '(' ? 1 : c == ')' ? -1 : 0;
    const bool first_blank = c == ' ' && i > begin && text[i - 1] != ' ';
    const std::string_view rest = text.substr(i);
    const bool of_a_value = rest.starts_with(" = ") || text.substr(0, i).ends_with(" =");
    const bool before_unit =
        rest.starts_with(" s") && (rest.size() == 2 || std::string_view(" ,;:)").find(rest[2]) != rest.npos);
    if (!first_blank || open > depth || of_a_value || before_unit) continue;
    parts.push_back(text.substr(begin, i - begin));
    begin = i;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

class Lines {
 public:
  Lines(const std::string& first, const std::string& rest) : line_(first), rest_(rest) {
    width_ = std::max(kLineWidth, columns_of(rest) + kLeastRoom);
  }
  void add(std::string_view text, int depth) {
    for (const std::string_view part : parts_of(text, depth)) {
      const std::string_view bare = without_blanks_before(part);
      if (columns_of(line_) + columns_of(empty_ ? bare : part) <= width_)
        put(empty_ ? bare : part);
      else if (columns_of(rest_) + columns_of(bare) <= width_)
        put_on_new_line(bare);
      else if (depth < kDeepest)
        add(part, depth + 1);
      else
        put_in_pieces(bare);
    }
  }
  std::string text() && { return std::move(out_) + line_ + '\n'; }

 private:
  static constexpr int kDeepest = 8;  // of parentheses in a condition

  void put(std::string_view text) {
    line_ += text;
    empty_ = false;
  }
  void put_on_new_line(std::string_view text) {
    if (!empty_) {
      out_ += line_ + '\n';
      line_ = rest_;
    }
    put(text);
  }

  /// A text without blanks, such as a message, on new lines that end with a comma.
  void put_in_pieces(std::string_view text) {
    const std::size_t room = width_ - columns_of(rest_);
    while (columns_of(text) > room) {
      const std::size_t comma = text.substr(0, room).rfind(',');
      if (comma == text.npos) break;
      put_on_new_line(text.substr(0, comma + 1));
      text.remove_prefix(comma + 1);
    }
    if (!text.empty()) put_on_new_line(text);
  }

  std::string out_, line_, rest_;
  std::size_t width_ = kLineWidth;
  bool empty_ = true;  // the line has nothing but its beginning
};

}  // namespace

bool fits(std::string_view text, std::string_view before) {
  return columns_of(before) + columns_of(text) <= kLineWidth;
}

std::string laid_out(std::string_view text, const std::string& first, const std::string& rest) {
  Lines lines(first, rest);
  lines.add(text, 1);
  return std::move(lines).text();
}

}  // namespace cxlab::inspect
