#include <algorithm>
#include <cctype>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "lab/mutants.h"
#include "lab/rule_text.h"

namespace cxlab::lab {

namespace {

/// From the first byte of the line in which `at` lies.
std::size_t line_begin(const std::string& text, std::size_t at) {
  const std::size_t before = at == 0 ? text.npos : text.rfind('\n', at - 1);
  return before == text.npos ? 0 : before + 1;
}
std::size_t line_end(const std::string& text, std::size_t at) { return std::min(text.find('\n', at), text.size()); }

std::vector<std::string> lines_in(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find('\n', at);
    lines.push_back(text.substr(at, end == text.npos ? end : end - at));
    if (end == text.npos) return lines;
    at = end + 1;
  }
}

}  // namespace

std::set<int> skipped_lines(const std::string& text) {
  constexpr std::string_view kMark = "; mutate: skip";
  std::set<int> lines;
  bool pending = false;
  int number = 1;
  for (std::size_t at = 0; at < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line(text.data() + at, end - at);
    const std::size_t mark = line.find(kMark);
    const std::size_t first = line.find_first_not_of(" \t\r");
    const bool alone = first != line.npos && line[first] == ';';
    if (pending && first != line.npos && !alone) {
      lines.insert(number);
      pending = false;
    }
    if (mark != line.npos && std::ranges::count(line.substr(0, mark), '"') % 2 == 0) {
      lines.insert(number);
      pending |= alone;
    }
    at = end + 1;
  }
  return lines;
}

std::string squeezed(std::string_view text) {
  std::string out;
  bool quoted = false, blank = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!quoted && text[i] == ';') {
      i = std::min(text.find('\n', i), text.size());
      blank = true;
      continue;
    }
    if (!quoted && std::isspace(static_cast<unsigned char>(text[i])) != 0) {
      blank = true;
      continue;
    }
    if (blank && !out.empty() && out.back() != '(' && text[i] != ')') out += ' ';
    blank = false;
    out += text[i] == '\n' ? ' ' : text[i];
    if (quoted && text[i] == '\\' && i + 1 < text.size())
      out += text[++i];
    else if (text[i] == '"')
      quoted = !quoted;
  }
  return out;
}

std::string mutated(const std::string& text, const Mutant& mutant) {
  return text.substr(0, mutant.begin) + mutant.text + text.substr(mutant.end);
}

std::string diff_of(const RuleText& file, const Mutant& mutant) {
  constexpr std::size_t kContext = 2;  // lines
  const std::string& text = file.text;
  const std::size_t first = line_begin(text, mutant.begin), last = line_end(text, mutant.end);
  const std::vector<std::string> lines = lines_in(text), was = lines_in(text.substr(first, last - first));
  const std::vector<std::string> now =
      lines_in(text.substr(first, mutant.begin - first) + mutant.text + text.substr(mutant.end, last - mutant.end));
  const auto at =
      static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(first), '\n'));
  const std::size_t end = at + was.size(), begin = at - std::min(at, kContext);
  const std::size_t stop =
      std::min(end + kContext, lines.size() - (lines.back().empty() && lines.size() > end ? 1 : 0));
  std::string out = "--- " + file.name + "\n+++ " + file.name + "\n@@ -" + std::to_string(begin + 1) + ',' +
                    std::to_string(stop - begin) + " +" + std::to_string(begin + 1) + ',' +
                    std::to_string(stop - begin - was.size() + now.size()) + " @@ " + mutant.kind + ' ' +
                    mutant.construct + '\n';
  for (std::size_t i = begin; i < at; ++i) out += ' ' + lines[i] + '\n';
  for (const std::string& line : was) out += '-' + line + '\n';
  for (const std::string& line : now) out += '+' + line + '\n';
  for (std::size_t i = end; i < stop; ++i) out += ' ' + lines[i] + '\n';
  return out;
}

}  // namespace cxlab::lab
