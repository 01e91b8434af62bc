#include "planner/templates/lexer.h"

#include <array>
#include <cctype>
#include <charconv>

namespace cxlab::planner::templates {
namespace {

bool is_space(char c) { return kWhitespace.find(c) != std::string_view::npos; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}

void append_utf8(unsigned point, std::string& out) {
  if (point < 0x80) {
    out += static_cast<char>(point);
  } else if (point < 0x800) {
    out += static_cast<char>(0xc0 | (point >> 6));
    out += static_cast<char>(0x80 | (point & 0x3f));
  } else if (point < 0x10000) {
    out += static_cast<char>(0xe0 | (point >> 12));
    out += static_cast<char>(0x80 | ((point >> 6) & 0x3f));
    out += static_cast<char>(0x80 | (point & 0x3f));
  } else {
    out += static_cast<char>(0xf0 | (point >> 18));
    out += static_cast<char>(0x80 | ((point >> 12) & 0x3f));
    out += static_cast<char>(0x80 | ((point >> 6) & 0x3f));
    out += static_cast<char>(0x80 | (point & 0x3f));
  }
}

class Lexer {
 public:
  Lexer(std::string_view source, const std::string& file) : file_(file) {
    for (std::size_t i = 0; i < source.size(); ++i) {  // \r\n and \r become \n
      if (source[i] == '\r') {
        source_ += '\n';
        if (i + 1 < source.size() && source[i + 1] == '\n') ++i;
      } else {
        source_ += source[i];
      }
    }
    if (source_.ends_with('\n')) source_.pop_back();  // as Jinja does: keep_trailing_newline is off
  }

  Expected<std::vector<Token>> run() {
    while (position_ < source_.size()) {
      if (Status status = text(); !status) return status.error();
    }
    add(Token::Kind::kEnd, "");
    return std::move(tokens_);
  }

 private:
  Error error(std::string message, int line) const { return input_error(std::move(message), file_, line); }
  Error error(std::string message) const { return error(std::move(message), line_); }

  bool starts(std::string_view word) const { return std::string_view(source_).substr(position_).starts_with(word); }
  void skip(std::size_t count) {
    for (; count > 0 && position_ < source_.size(); --count) line_ += source_[position_++] == '\n';
  }
  void add(Token::Kind kind, std::string text, Value number = {}) {
    tokens_.push_back({kind, line_, std::move(text), std::move(number)});
  }

  /// Text up to the next tag, and the tag.
  Status text() {
    std::size_t tag = position_;
    for (; tag < source_.size(); ++tag)
      if (source_[tag] == '{' && tag + 1 < source_.size() &&
          (source_[tag + 1] == '{' || source_[tag + 1] == '%' || source_[tag + 1] == '#'))
        break;
    std::string_view plain = std::string_view(source_).substr(position_, tag - position_);
    const bool strip = tag + 2 < source_.size() && source_[tag + 2] == '-';
    std::string kept = trim(plain, kWhitespace, strip_next_, strip);
    strip_next_ = false;
    if (!kept.empty()) add(Token::Kind::kText, std::move(kept));
    skip(plain.size());
    if (position_ >= source_.size()) return {};
    const char type = source_[position_ + 1];
    if (type == '#') return comment();
    const int line = line_;
    skip(2);
    if (starts("-") || starts("+")) skip(1);
    if (type == '%' && at_raw("raw", false)) return raw(line);
    add(type == '{' ? Token::Kind::kOutputBegin : Token::Kind::kStatementBegin, "");
    return tag_body(type == '{' ? "}}" : "%}", type == '{' ? Token::Kind::kOutputEnd : Token::Kind::kStatementEnd,
                    line);
  }

  Status comment() {
    const int line = line_;
    const std::size_t end = source_.find("#}", position_ + 2);
    if (end == std::string::npos) return error("found a comment {# without end, expected #}", line);
    strip_next_ = source_[end - 1] == '-' && end - 1 > position_ + 1;
    skip(end + 2 - position_);
    return {};
  }

  /// Whether the tag is `word %}`, or with `plus` also `word +%}`; position is behind {%. Moves behind it if so.
  bool at_raw(std::string_view word, bool plus) {
    std::size_t at = position_;
    while (at < source_.size() && is_space(source_[at])) ++at;
    if (!std::string_view(source_).substr(at).starts_with(word)) return false;
    at += word.size();
    while (at < source_.size() && is_space(source_[at])) ++at;
    const bool strip = at < source_.size() && source_[at] == '-';
    if (strip || (plus && at < source_.size() && source_[at] == '+')) ++at;
    if (!std::string_view(source_).substr(at).starts_with("%}")) return false;
    skip(at + 2 - position_);
    strip_next_ = strip;
    return true;
  }

  Status raw(int line) {
    const bool strip_first = strip_next_;
    const std::size_t begin = position_;
    const int text_line = line_;
    while (true) {
      const std::size_t tag = source_.find("{%", position_);
      if (tag == std::string::npos) return error("found {% raw %} without end, expected {% endraw %}", line);
      skip(tag - position_);
      skip(2);
      const bool strip = starts("-");
      if (strip || starts("+")) skip(1);
      if (!at_raw("endraw", true)) continue;
      std::string kept = trim(std::string_view(source_).substr(begin, tag - begin), kWhitespace, strip_first, strip);
      tokens_.push_back({Token::Kind::kText, text_line, std::move(kept), {}});
      return {};
    }
  }

  Status tag_body(std::string_view end, Token::Kind end_kind, int begin_line) {
    std::string open;  // brackets
    while (true) {
      while (position_ < source_.size() && is_space(source_[position_])) skip(1);
      if (position_ >= source_.size())
        return error("found a tag without end, expected " + std::string(end), begin_line);
      const bool minus = starts("-");
      if (open.empty() && (starts(end) || ((minus || starts("+")) &&
                                           std::string_view(source_).substr(position_ + 1).starts_with(end)))) {
        add(end_kind, "");
        if (!starts(end)) {
          strip_next_ = minus;
          skip(1);
        }
        skip(2);
        return {};
      }
      const char c = source_[position_];
      if (is_digit(c)) {
        if (Status status = number(); !status) return status;
      } else if (is_name_character(c)) {
        std::size_t last = position_;
        while (last < source_.size() && is_name_character(source_[last])) ++last;
        add(Token::Kind::kName, source_.substr(position_, last - position_));
        skip(last - position_);
      } else if (c == '"' || c == '\'') {
        if (Status status = string(c); !status) return status;
      } else if (Status status = operation(open); !status) {
        return status;
      }
    }
  }

  Status operation(std::string& open) {
    static constexpr std::array kOperators = {"==", "!=", ">=", "<=", "**", "//", "+", "-", "*", "/", "%", "~", "<",
                                              ">",  "=",  "(",  ")",  "[",  "]",  "{", "}", ".", ",", ":", "|", ";"};
    for (const std::string_view word : kOperators) {
      if (!starts(word)) continue;
      const char c = word[0];
      if (c == '(' || c == '[' || c == '{') open += c == '(' ? ')' : c == '[' ? ']' : '}';
      if (c == ')' || c == ']' || c == '}') {
        if (open.empty()) return error(std::string("found '") + c + "', which closes nothing");
        if (open.back() != c) return error(std::string("found '") + c + "', expected '" + open.back() + "'");
        open.pop_back();
      }
      add(Token::Kind::kOperator, std::string(word));
      skip(word.size());
      return {};
    }
    return error("found the character '" + source_.substr(position_, 1) + "' in a tag, expected an expression");
  }

  Status string(char quote) {
    const int line = line_;
    std::string out;
    std::size_t at = position_ + 1;
    while (true) {
      if (at >= source_.size()) return error("found a string without end", line);
      const char c = source_[at];
      if (c == quote) break;
      if (c != '\\' || at + 1 >= source_.size()) {
        out += c;
        ++at;
        continue;
      }
      if (Status status = escape(at, out); !status) return status;
    }
    add(Token::Kind::kString, std::move(out));
    skip(at + 1 - position_);
    return {};
  }

  Status escape(std::size_t& at, std::string& out) {
    const char c = source_[at + 1];
    static constexpr std::string_view kNames = "ntrfvab\\'\"";
    static constexpr std::string_view kCharacters = "\n\t\r\f\v\a\b\\'\"";
    const std::size_t digits = c == 'x' ? 2 : c == 'u' ? 4 : c == 'U' ? 8 : 0;
    if (digits > 0) {
      unsigned point = 0;
      const char* first = source_.data() + at + 2;
      const char* last = source_.data() + std::min(source_.size(), at + 2 + digits);
      const auto [end, code] = std::from_chars(first, last, point, 16);
      if (code != std::errc{} || end != first + digits || point > 0x10ffff)
        return error("found a broken escape in a string");
      append_utf8(point, out);
      at += 2 + digits;
      return {};
    }
    if (c >= '0' && c <= '7') {
      unsigned point = 0;
      std::size_t end = at + 1;
      for (; end < std::min(source_.size(), at + 4) && source_[end] >= '0' && source_[end] <= '7'; ++end)
        point = point * 8 + static_cast<unsigned>(source_[end] - '0');
      append_utf8(point, out);
      at = end;
      return {};
    }
    if (c == 'N') return error("found a character by its name (\\N) in a string: not supported, use \\u");
    const std::size_t known = kNames.find(c);
    if (c == '\n') {
    } else if (known != std::string_view::npos) {
      out += kCharacters[known];
    } else {
      out += '\\';
      out += c;
    }
    at += 2;
    return {};
  }

  Status number() {
    std::size_t at = position_;
    std::string digits;
    bool real = false;
    const auto take = [&] {
      while (at < source_.size() &&
             (is_digit(source_[at]) || (source_[at] == '_' && at + 1 < source_.size() && is_digit(source_[at + 1])))) {
        if (source_[at] != '_') digits += source_[at];
        ++at;
      }
    };
    const char base = source_[at] == '0' && at + 1 < source_.size() ? static_cast<char>(source_[at + 1] | 0x20) : ' ';
    if (base == 'x' || base == 'b' || base == 'o') {
      std::int64_t value = 0;
      for (at += 2;
           at < source_.size() && (std::isxdigit(static_cast<unsigned char>(source_[at])) != 0 || source_[at] == '_');
           ++at)
        if (source_[at] != '_') digits += source_[at];
      const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value,
                                               base == 'x'   ? 16
                                               : base == 'b' ? 2
                                                             : 8);
      if (code != std::errc{} || end != digits.data() + digits.size() || source_[at - 1] == '_')
        return error("found a broken number");
      add(Token::Kind::kInteger, "", Value(value));
      skip(at - position_);
      return {};
    }
    take();
    const bool after_dot =
        !tokens_.empty() && tokens_.back().kind == Token::Kind::kOperator && tokens_.back().text == ".";
    if (!after_dot && at + 1 < source_.size() && source_[at] == '.' && is_digit(source_[at + 1])) {
      real = true;
      digits += '.';
      ++at;
      take();
    }
    if (!after_dot && at + 1 < source_.size() && (source_[at] == 'e' || source_[at] == 'E')) {
      const bool signed_exponent = source_[at + 1] == '-' || source_[at + 1] == '+';
      if (is_digit(source_[at + 1]) || (signed_exponent && at + 2 < source_.size() && is_digit(source_[at + 2]))) {
        real = true;
        digits += 'e';
        ++at;
        if (signed_exponent) digits += source_[at++];
        take();
      }
    }
    Value value;
    if (real) {
      double parsed = 0;
      if (std::from_chars(digits.data(), digits.data() + digits.size(), parsed).ec != std::errc{})
        return error("found a number that is too large: " + digits);
      value = parsed;
    } else {
      if (digits[0] == '0' && digits.find_first_not_of('0') != std::string::npos && !after_dot)
        return error("found the number " + digits + ", expected no zero in front");
      std::int64_t parsed = 0;
      if (std::from_chars(digits.data(), digits.data() + digits.size(), parsed).ec != std::errc{})
        return error("found a number that is too large: " + digits.substr(0, 40));
      value = parsed;
    }
    add(real ? Token::Kind::kFloat : Token::Kind::kInteger, "", std::move(value));
    skip(at - position_);
    return {};
  }

  const std::string& file_;
  std::string source_;
  std::size_t position_ = 0;
  int line_ = 1;
  bool strip_next_ = false;
  std::vector<Token> tokens_;
};

}  // namespace

Expected<std::vector<Token>> tokenize(std::string_view source, const std::string& file) {
  return Lexer(source, file).run();
}

}  // namespace cxlab::planner::templates
