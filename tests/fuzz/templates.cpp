// Templates: parts of the text behind lines `--- NAME` are templates that others may name; the first is `main`.

#include <map>

#include "cx/template/template.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_templates {

FUZZ_TARGET(templates) {
  using namespace cxlab::templates;
  using cxlab::fuzz::promise;
  std::map<std::string, std::string> templates;
  std::string rest = "--- main\n" + cxlab::fuzz::text_of(data, size);
  while (!rest.empty()) {
    const std::size_t name_end = std::min(rest.find('\n'), rest.size());
    const std::size_t next = rest.find("\n--- ", name_end);
    const std::string name = rest.substr(4, name_end - 4);
    templates[name] =
        name_end < rest.size() ? rest.substr(name_end + 1, next == std::string::npos ? next : next - name_end) : "";
    rest = next == std::string::npos ? "" : rest.substr(next + 1);
  }
  const Loader loader = [&](const std::string& name) -> std::optional<std::string> {
    const auto found = templates.find(name);
    return found == templates.end() ? std::nullopt : std::optional(found->second);
  };
  const Options options{.limits = {100000, 1 << 20, 16 << 20}};
  const auto text = render(loader, "main", options);
  promise(text || !text.error().message.empty(), "an error says what was found");
  promise(text || !text.error().file.empty(), "an error has its template");
  promise(!text || text->size() <= options.limits.output, "the limit of output holds");
  const auto again = render(loader, "main", options);
  promise(text.ok() == again.ok() && (!text || *text == *again), "a template gives the same text each time");
  return 0;
}

}  // namespace fuzz_templates
