#include "cx/yaml/seeds.h"

#include <algorithm>
#include <numeric>

#include "cx/base/number_text.h"

namespace cxlab::yaml {

namespace {

void add_seed(std::uint64_t seed, const Value& place, std::vector<std::uint64_t>& seeds) {
  if (std::find(seeds.begin(), seeds.end(), seed) != seeds.end())
    place.fail(
        found_expected("seed " + std::to_string(seed) + " twice", "each once: the same game is no second sample"));
  else
    seeds.push_back(seed);
}

}  // namespace

std::vector<std::uint64_t> read_seeds(const Value& value) {
  std::vector<std::uint64_t> out;
  if (value.is_list()) {
    for (const Value& item : value.as_list())
      if (const auto seed = read_number<std::uint64_t>(item.text()))
        add_seed(*seed, item, out);
      else
        item.fail(found_expected(item.found(), "a seed, which is an integer from 0 to " + std::to_string(UINT64_MAX)));
    return out;
  }
  auto range = seeds_of_range(value.text());
  if (range) return *std::move(range);
  value.fail(range.error().message);
  return out;
}

Expected<std::vector<std::uint64_t>> seeds_of_range(const std::string& text) {
  const std::size_t dots = text.find("..");
  const auto first = read_number<std::uint64_t>(text.substr(0, dots));
  const auto last = read_number<std::uint64_t>(dots == text.npos ? "" : text.substr(dots + 2));
  if (!first || !last || *last < *first) return input_error(found_text(text, "a list of seeds or a range \"0..29\""));
  if (*last - *first >= kMostSeeds)
    return input_error(found_text(text, "a range of at most " + std::to_string(kMostSeeds) + " seeds"));
  std::vector<std::uint64_t> out(*last - *first + 1);
  std::iota(out.begin(), out.end(), *first);
  return out;
}

}  // namespace cxlab::yaml
