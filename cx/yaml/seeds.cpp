#include "cx/yaml/seeds.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "cx/base/number_text.h"

namespace cxlab::yaml {

namespace {

/// Seeds in the order in which they are named.
class SeedList {
 public:
  Status add(std::uint64_t seed) {
    if (seeds_.size() >= kMostSeeds)
      return input_error(found_expected("more seeds", "at most " + std::to_string(kMostSeeds)));
    if (!known_.insert(seed).second)
      return input_error(
          found_expected("seed " + std::to_string(seed) + " twice", "each once: the same game is no second sample"));
    seeds_.push_back(seed);
    return {};
  }
  std::vector<std::uint64_t> take() { return std::move(seeds_); }

 private:
  std::vector<std::uint64_t> seeds_;
  std::unordered_set<std::uint64_t> known_;
};

}  // namespace

Expected<std::vector<std::uint64_t>> seeds_of(const std::string& text) {
  SeedList out;
  for (std::size_t begin = 0, end = 0; end < text.size() || begin == 0; begin = end + 1) {
    end = std::min(text.find(',', begin), text.size());
    std::string part = text.substr(begin, end - begin);
    part.erase(0, part.find_first_not_of(' '));
    part.erase(part.find_last_not_of(' ') + 1);
    const std::size_t dots = part.find("..");
    const auto first = read_number<std::uint64_t>(part.substr(0, dots));
    const auto last = dots == part.npos ? first : read_number<std::uint64_t>(part.substr(dots + 2));
    if (!first || !last || *last < *first)
      return input_error(found_text(text, "a seed, a range \"0..29\", or several with commas between them"));
    if (*last - *first >= kMostSeeds)
      return input_error(found_text(text, "a range of at most " + std::to_string(kMostSeeds) + " seeds"));
    for (std::uint64_t n = 0; n <= *last - *first; ++n)
      if (Status s = out.add(*first + n); !s) return s.error();
  }
  return out.take();
}

std::vector<std::uint64_t> read_seeds(const Value& value) {
  if (!value.is_list()) {
    auto seeds = seeds_of(value.text());
    if (seeds) return *std::move(seeds);
    value.fail(seeds.error().message);
    return {};
  }
  SeedList out;
  for (const Value& item : value.as_list())
    if (const auto seed = read_number<std::uint64_t>(item.text())) {
      if (Status s = out.add(*seed); !s) item.fail(s.error().message);
    } else {
      item.fail(found_expected(item.found(), "a seed, which is an integer from 0 to " + std::to_string(UINT64_MAX)));
    }
  return out.take();
}

}  // namespace cxlab::yaml
