#include "cx/base/expected.h"

#include <algorithm>
#include <numeric>

namespace cxlab {

std::string Error::text() const {
  std::string where;
  if (!file.empty()) {
    where = file + ':';
    if (line > 0) where += std::to_string(line) + ':';
    where += ' ';
  }
  return where + message;
}

namespace {

/// The smallest number of letters to insert, delete, replace, or swap with their neighbour.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0u);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before, last);
    std::swap(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

/// "begin-order" of "order-begin" and "begin_order".
std::string with_sorted_words(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : name)
    if (c == '-' || c == '_' || c == ':' || c == ' ')
      words.emplace_back();
    else
      words.back() += c;
  std::ranges::sort(words);
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : "-") + word;
  return out;
}

}  // namespace

/// Whether `text` has all letters of `word` in their order: then letters were left out, the commonest slip.
static bool is_shortened(const std::string& word, const std::string& text) {
  std::size_t at = 0;
  for (const char c : text)
    if (at < word.size() && word[at] == c) ++at;
  return at == word.size();
}

constexpr std::size_t kLongestName = 200;  // longer names are nobody's slip, and take long to compare

std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates) {
  std::string best;
  const std::string sorted = with_sorted_words(word);
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const auto& candidate : candidates) {
    if (std::max(word.size(), candidate.size()) > kLongestName) continue;
    std::size_t distance = edit_distance(word, candidate);
    if (const std::string in_order = with_sorted_words(candidate); sorted != word || in_order != candidate)
      distance = std::min(distance, 1 + edit_distance(sorted, in_order));
    const std::size_t longer = std::max(word.size(), candidate.size());
    if (distance >= longer || (distance > 1 && 2 * distance >= longer)) continue;  // too little in common
    const bool as_near = distance == best_distance && !best.empty();
    if (distance < best_distance || (as_near && is_shortened(word, candidate) && !is_shortened(word, best))) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates,
                         std::string_view separator) {
  const std::string near = nearest_word(word, candidates);
  return near.empty() ? near : std::string(separator) + "did you mean '" + near + "'?";
}

std::string found_expected(std::string_view found, std::string_view expected) {
  return "found " + std::string(found) + ", expected " + std::string(expected);
}

std::string found_text(std::string_view text, std::string_view expected) {
  return found_expected('\'' + std::string(text) + '\'', expected);
}

std::string some_of(const std::vector<std::string>& names, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i ? ", " : "") + names[i];
  return names.size() > most ? text + " and " + std::to_string(names.size() - most) + " more" : text;
}

std::string some_of_and_nearest(const std::string& word, const std::vector<std::string>& names, std::size_t most) {
  return some_of(names, most) + did_you_mean(word, names, "; ");
}

}  // namespace cxlab
