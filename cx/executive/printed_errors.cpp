#include "cx/executive/printed_errors.h"

#include <algorithm>

namespace cxlab::cx {

namespace {

/// The line up to `most` bytes; no character is cut in two.
std::string shortened(std::string_view line, std::size_t most) {
  if (line.size() <= most) return std::string(line);
  while (most > 0 && (static_cast<unsigned char>(line[most]) & 0xC0) == 0x80) --most;
  return std::string(line.substr(0, most)) + " ...";
}

}  // namespace

void PrintedErrors::add(SimTime at, std::string environment, std::string_view text) {
  Line line{std::move(environment), shortened(text, kLongest)};
  last_ = line;
  last_at_ = at;
  if (std::ranges::find(kept_, line) != kept_.end()) return;
  if (kept_.size() < kMost)
    kept_.push_back(std::move(line));
  else
    ++others_;
}

std::vector<Error> PrintedErrors::warnings() const {
  std::vector<Error> out;
  for (const auto& [environment, text] : kept_)
    out.push_back(run_error("environment '" + environment + "' printed as error: " + text));
  if (others_ > 0) out.push_back(run_error(std::to_string(others_) + " more lines were printed as error, in the log"));
  return out;
}

std::optional<Error> PrintedErrors::last(SimTime at) const {
  if (at != last_at_) return std::nullopt;
  return run_error("environment '" + last_.first + "' gives up: " + last_.second).with_code("gave_up");
}

}  // namespace cxlab::cx
