#include "lab/page.h"

#include "cx/template/template.h"
#include "scenarios/share.h"

namespace cxlab::lab {

Expected<std::string> render_page(const std::string& name, const std::string& json) {
  templates::Options options;
  options.variables = json;
  options.html = name.ends_with(".html") || name.ends_with(".svg") || name.ends_with(".xml");
  // The templates are ours and end; the data may be large.
  options.limits = {.steps = 1ull << 60, .output = 1ull << 40, .memory = 1ull << 40};
  return templates::render_file(find_share().pages.string(), name, options);
}

}  // namespace cxlab::lab
