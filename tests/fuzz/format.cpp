// (format nil ...): the first byte chooses how many values come after the text, the next ones which they are, the rest
// is the text.

#include "cx/engine/engine.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_format {

FUZZ_TARGET(format) {
  using namespace cxlab;
  static const std::unique_ptr<RuleEngine> engine = *RuleEngine::create({});
  static const std::vector<Value> values{Value::integer(0),
                                         Value::integer(std::numeric_limits<std::int64_t>::min()),
                                         Value::number(1e308),
                                         Value::number(-0.0),
                                         Value::number(std::numeric_limits<double>::quiet_NaN()),
                                         Value::symbol("a%s"),
                                         Value::string(std::string(600, 'x')),
                                         Value::string("\xc3\xa4")};
  if (size == 0) return 0;
  const std::size_t count = data[0] % 6;
  if (size < 1 + count) return 0;
  std::vector<Value> arguments{Value::symbol("nil"), Value::string(fuzz::text_of(data + 1 + count, size - 1 - count))};
  for (std::size_t i = 0; i < count; ++i) arguments.push_back(values[data[1 + i] % values.size()]);
  const auto text = engine->call("format", arguments);
  for (const RuleError& error : engine->take_errors())
    fuzz::promise(!error.message.empty(), "an error says what it is");
  fuzz::promise(!text || text->is_text(), "format returns a text");
  return 0;
}

}  // namespace fuzz_format
