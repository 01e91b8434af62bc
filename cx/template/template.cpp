#include "cx/template/template.h"

#include <minijinja.h>

#include "cx/base/file.h"

namespace cxlab::templates {

namespace {

/// One call of `render`.
struct Rendering {
  const Loader& loader;
  std::string loaded = {};
  std::string made = {};
  std::optional<Error> error = {};

  static minijinja_text text(const std::string& text) { return {text.data(), text.size()}; }
  static std::string string(minijinja_text text) { return {text.data, text.size}; }

  static int load(void* context, minijinja_text name, minijinja_text* text) {
    auto& rendering = *static_cast<Rendering*>(context);
    auto found = rendering.loader(string(name));
    if (!found) return 0;
    rendering.loaded = *std::move(found);
    *text = Rendering::text(rendering.loaded);
    return 1;
  }
  static void write(void* context, minijinja_text text) {
    static_cast<Rendering*>(context)->made.append(text.data, text.size);
  }
  static void fail(void* context, minijinja_text file, size_t line, minijinja_text message) {
    constexpr const char* kNoThread = "no thread could be started";  // third_party/minijinja/src/bounds.rs
    Error error = input_error(string(message), string(file), static_cast<int>(line));
    if (error.message.find(kNoThread) != std::string::npos) error.kind = ErrorKind::kResource;
    static_cast<Rendering*>(context)->error = std::move(error);
  }
};

}  // namespace

Loader folder_loader(const std::string& folder) {
  return [folder](const std::string& name) -> std::optional<std::string> {
    for (std::size_t at = 0; at <= name.size();) {  // as Jinja: no part of a name leads upwards
      const std::size_t end = std::min(name.find('/', at), name.size());
      if (name.substr(at, end - at) == "..") return std::nullopt;
      at = end + 1;
    }
    auto text = read_file(folder + "/" + name);
    return text ? std::optional(*std::move(text)) : std::nullopt;
  };
}

Expected<std::string> render(const Loader& loader, const std::string& name, const Options& options) {
  Rendering rendering{loader};
  const minijinja_job job{Rendering::text(name),
                          Rendering::text(options.variables),
                          options.html,
                          options.limits.steps,
                          options.limits.output,
                          options.limits.memory,
                          &rendering,
                          Rendering::load,
                          Rendering::write,
                          Rendering::fail};
  minijinja_render(&job);
  if (rendering.error) return *std::move(rendering.error);
  return std::move(rendering.made);
}

Expected<std::string> render_file(const std::string& folder, const std::string& file, const Options& options) {
  auto text = render(folder_loader(folder), file, options);
  if (text) return text;
  Error error = text.error();
  error.file = folder + "/" + error.file;
  return error;
}

std::string minijinja_version() { return MINIJINJA_VERSION; }

}  // namespace cxlab::templates
