#pragma once
// Text to nested lists: the shape of a PDDL file before anything is known about names.

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"

namespace cxlab::planner {

/// A word, or a list of nodes. Words are lower case and point into the text of the Syntax.
struct Node {
  bool is_list = false;
  int line = 0;
  std::string_view word;
  std::vector<Node> items;

  /// The word that begins the list; empty if there is none.
  std::string_view head() const {
    return is_list && !items.empty() && !items[0].is_list ? items[0].word : std::string_view{};
  }
  /// What stands behind the head of a list.
  std::span<const Node> rest() const { return std::span(items).subspan(items.empty() ? 0 : 1); }
  bool is_word(std::string_view text) const { return !is_list && word == text; }
};

/// Ends the reading of a file; thrown and caught in this folder only.
struct Rejected {
  Error error;
};
/// What `read` returns, or the error with which it rejected the file.
template <class Read>
auto accepted(Read read) -> Expected<decltype(read())> {
  try {
    return read();
  } catch (Rejected& rejected) {
    return std::move(rejected.error);
  }
}

/// The single form of a file.
struct Syntax {
  std::unique_ptr<std::string> text;
  Node root;
};

/// Deepest nesting that is read; real files stay below 30.
inline constexpr int kDeepestNesting = 200;

/// When reading is to be given up; none: never.
using Deadline = std::optional<std::chrono::steady_clock::time_point>;

/// Nodes and facts that are read between two looks at the clock.
inline constexpr std::size_t kReadBetweenLooks = 1024;

bool is_over(const Deadline& deadline);
/// Failure::kLate.
Error too_late(const std::string& file);

/// Reads one form. Comments begin with `;`.
Expected<Syntax> read_syntax(std::string_view text, const std::string& file, const Deadline& deadline = {});

/// The node as text, shortened to about 60 characters, for messages.
std::string excerpt(const Node& node);

/// Joins texts, numbers and excerpts of nodes.
template <class... Parts>
std::string message(const Parts&... parts) {
  std::string text;
  const auto add = [&](const auto& part) {
    if constexpr (requires { excerpt(part); })
      text += excerpt(part);
    else if constexpr (requires { std::to_string(part); })
      text += std::to_string(part);
    else
      text += part;
  };
  (add(parts), ...);
  return text;
}

/// Names are read in any case.
std::string lower_case(std::string_view text);

/// The number that a word means, if it is one.
bool to_number(std::string_view word, double& number);

}  // namespace cxlab::planner
