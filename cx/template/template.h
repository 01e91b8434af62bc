#pragma once
// Templates in the language of Jinja, rendered by minijinja: PDDL files and the pages of reports.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "cx/base/expected.h"

namespace cxlab::templates {

/// Gives the text of the template that extends, include or import name; none if there is no such template. Must not
/// throw. Runs in a thread of the renderer while the caller waits for it.
using Loader = std::function<std::optional<std::string>(const std::string& name)>;

/// Templates below a folder. Names with a part `..` are not found.
Loader folder_loader(const std::string& folder);

/// What a template may use up before it is stopped with an error.
struct Limits {
  std::uint64_t steps = 20'000'000;    ///< instructions of minijinja
  std::uint64_t output = 64ull << 20;  ///< bytes of text
  std::uint64_t memory = 64ull << 20;  ///< bytes of memory besides the text
};

struct Options {
  std::string variables = "{}";  ///< a JSON object: what the template sees by name
  bool html = false;             ///< values are escaped for HTML, XML and SVG; printing an undefined one is an error
  Limits limits = {};
};

/// Renders the template of that name. Errors name the template in `file`, and the line.
Expected<std::string> render(const Loader& loader, const std::string& name, const Options& options = {});

/// Renders `file`, found below `folder`. Errors name the path of the template.
Expected<std::string> render_file(const std::string& folder, const std::string& file, const Options& options = {});

std::string minijinja_version();  ///< "3.0.5"

}  // namespace cxlab::templates
