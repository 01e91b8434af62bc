#include "cx/engine/form_reader.h"

#include <algorithm>
#include <span>

namespace cxlab {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v' || c == '\0'; }
bool ends_word(char c) {
  return is_blank(c) || c == '(' || c == ')' || c == '"' || c == '&' || c == '|' || c == '~' || c == ';';
}

/// Walks over text and counts lines.
class Scanner {
 public:
  Scanner(std::string_view text, std::size_t at, int line) : text_(text), at_(at), line_(line) {}

  bool done() const { return at_ >= text_.size(); }
  std::size_t at() const { return at_; }
  int line() const { return line_; }

  void skip_blanks_and_comments() {
    while (!done()) {
      if (text_[at_] == ';') {
        while (!done() && text_[at_] != '\n' && text_[at_] != '\r') ++at_;
      } else if (is_blank(text_[at_])) {
        step();
      } else {
        return;
      }
    }
  }

  /// The next token; false at the end. A string that is never closed runs to the end of the text.
  bool next(Token& token) {
    skip_blanks_and_comments();
    if (done()) return false;
    const std::size_t begin = at_;
    token.line = line_;
    const char c = text_[at_];
    if (c == '"') {
      token.kind = Token::Kind::kString;
      string_closed_ = false;
      step();
      while (!done() && !string_closed_) {
        if (text_[at_] == '\\') {
          step();
          if (!done()) step();
        } else {
          string_closed_ = text_[at_] == '"';
          step();
        }
      }
    } else if (c == '(' || c == ')' || c == '&' || c == '|' || c == '~') {
      token.kind = c == '(' ? Token::Kind::kOpen : c == ')' ? Token::Kind::kClose : Token::Kind::kConnective;
      ++at_;
    } else {
      token.kind = Token::Kind::kWord;
      ++at_;
      while (!done() && !ends_word(text_[at_]) && text_[at_] != '<') ++at_;  // ?f<-(a)
    }
    token.text = text_.substr(begin, at_ - begin);
    return true;
  }

  bool last_string_closed() const { return string_closed_; }

 private:
  void step() {
    if (text_[at_] == '\n') ++line_;
    ++at_;
  }

  std::string_view text_;
  std::size_t at_;
  int line_;
  bool string_closed_ = true;
};

/// The next line after `from` that begins with "(def", or npos.
std::size_t next_definition(std::string_view text, std::size_t from) {
  const std::size_t found = text.find("\n(def", from);
  return found == std::string_view::npos ? found : found + 1;
}

int count_lines(std::string_view text) {
  int lines = 0;
  for (const char c : text) lines += c == '\n';
  return lines;
}

/// How large a form gets while its tokens are added, and where it first gets too large.
class Extent {
 public:
  void add(const Token& token) {
    if (token.kind == Token::Kind::kConnective) return;
    if (token.kind == Token::Kind::kClose) {
      if (!parts_.empty()) parts_.pop_back();
      return;
    }
    if (!parts_.empty() && ++parts_.back() == kWidestForm + 1)
      exceed("found a form with more than " + std::to_string(kWidestForm) + " parts on one level", token.line);
    if (token.kind != Token::Kind::kOpen) return;
    parts_.push_back(0);
    if (parts_.size() == kDeepestForm + 1)
      exceed("found parentheses nested more than " + std::to_string(kDeepestForm) + " deep", token.line);
  }

  /// Lists that are open.
  std::size_t depth() const { return parts_.size(); }

  struct Excess {
    std::string what;  ///< empty: none
    int line = 0;
  };
  const Excess& excess() const { return excess_; }

 private:
  void exceed(std::string what, int line) {
    if (excess_.what.empty()) excess_ = {std::move(what), line};
  }

  std::vector<int> parts_;  ///< of each list that is open
  Excess excess_;
};

}  // namespace

std::string excess_of(std::string_view text) {
  Scanner scanner(text, 0, 1);
  Extent extent;
  for (Token token; scanner.next(token);) extent.add(token);
  return extent.excess().what;
}

FormReading read_forms(std::string_view text, const std::string& file) {
  FormReading reading;
  const std::size_t start = text.starts_with("\xef\xbb\xbf") ? 3 : 0;
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
    reading.errors.push_back(
        input_error(found_expected("a zero byte", "text"), file, 1 + count_lines(text.substr(0, zero))));
  }

  Scanner scanner(text, start, 1);
  while (true) {
    scanner.skip_blanks_and_comments();
    const std::size_t begin = scanner.at();
    Token token;
    if (!scanner.next(token)) break;
    if (token.kind == Token::Kind::kClose) {
      reading.errors.push_back(input_error("found ')' that closes nothing", file, token.line));
      continue;
    }

    Form form;
    form.line = token.line;
    form.at = begin;
    form.list = token.kind == Token::Kind::kOpen;
    Extent extent;
    extent.add(token);
    bool closed = token.kind != Token::Kind::kString || scanner.last_string_closed();
    int open_string = closed ? 0 : token.line;
    if (!form.list) {
      form.head = token.text;
    } else {
      std::size_t words = 0;
      while (extent.depth() > 0 && scanner.next(token)) {
        extent.add(token);
        if (token.kind == Token::Kind::kString && !scanner.last_string_closed()) open_string = token.line;
        if (token.kind == Token::Kind::kWord && extent.depth() == 1 && words < 2) {
          (words == 0 ? form.head : form.name) = words == 0 ? token.text : without_module(token.text);
          ++words;
        } else {
          words = 2;
        }
      }
      closed = extent.depth() == 0;
    }

    if (closed && !extent.excess().what.empty()) {
      reading.errors.push_back(input_error(extent.excess().what, file, extent.excess().line));
      continue;
    }
    if (closed) {
      form.text = text.substr(begin, scanner.at() - begin);
      // CLIPS would take a zero byte for the end of the form.
      if (form.text.find('\0') == std::string::npos) reading.forms.push_back(std::move(form));
      continue;
    }

    std::string what = form.list ? "found no closing parenthesis for this form" : "found a string that is never closed";
    if (form.list && !form.head.empty()) {
      what = "found no closing parenthesis for (" + form.head + (form.name.empty() ? "" : " " + form.name) + " ...)";
    }
    if (form.list && open_string != 0)
      what += "; a string that begins in line " + std::to_string(open_string) + " is never closed";
    const std::size_t next = next_definition(text, begin);
    int next_line = 0;
    if (next != std::string_view::npos) {
      next_line = form.line + count_lines(text.substr(begin, next - begin));
      what += "; the next construct begins in line " + std::to_string(next_line);
    }
    reading.errors.push_back(input_error(std::move(what), file, form.line));
    if (next == std::string_view::npos) break;
    scanner = Scanner(text, next, next_line);
  }
  return reading;
}

std::vector<Token> tokens_of(const Form& form) {
  std::vector<Token> tokens;
  Scanner scanner(form.text, 0, form.line);
  Token token;
  while (scanner.next(token)) tokens.push_back(token);
  return tokens;
}

namespace {

/// `text` is that of the form, which the tokens borrow.
Term take_term(std::span<const Token>& rest, const char* text) {
  const auto end_of = [text](const Token& token) {
    return static_cast<std::size_t>(token.text.data() - text) + token.text.size();
  };
  const Token first = rest.front();
  rest = rest.subspan(1);
  Term term{first.kind, {}, {}, first.line, static_cast<std::size_t>(first.text.data() - text), end_of(first)};
  if (!term.is_list()) {
    term.text = first.text;
    return term;
  }
  while (!rest.empty() && rest.front().kind != Token::Kind::kClose) {
    term.items.push_back(take_term(rest, text));
    term.end = term.items.back().end;
  }
  if (!rest.empty()) {
    term.end = end_of(rest.front());
    rest = rest.subspan(1);
  }
  return term;
}

}  // namespace

std::string_view Term::head() const {
  return items.empty() || items.front().kind != Token::Kind::kWord ? std::string_view() : items.front().text;
}

std::string Term::print() const {
  if (!is_list()) return text;
  std::string out = "(";
  for (std::size_t i = 0; i < items.size(); ++i) {
    const bool connected = i > 0 && ((items[i].kind == Token::Kind::kConnective && !items[i].is("~")) ||
                                     items[i - 1].kind == Token::Kind::kConnective);
    // The body of a test or call in a pattern: ?x&:(> ?x 3), =(+ 1 ?x).
    const bool body = i > 1 && items[i].is_list() && (items[i - 1].is(":") || items[i - 1].is("="));
    out += (i == 0 || connected || body ? "" : " ") + items[i].print();
  }
  return out + ')';
}

Term tree_of(const Form& form) {
  const std::vector<Token> tokens = tokens_of(form);
  std::span<const Token> rest(tokens);
  return rest.empty() ? Term() : take_term(rest, form.text.data());
}

}  // namespace cxlab
