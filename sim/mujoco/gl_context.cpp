#include "sim/mujoco/gl_context.h"

#include <dlfcn.h>

#include <cstdlib>
#include <initializer_list>
#include <string_view>
#include <vector>

namespace cxlab::sim {
namespace {

/// A shared library, kept loaded: drivers do not survive being unloaded.
class Library {
 public:
  explicit Library(std::initializer_list<const char*> names) {
    for (const char* name : names)
      if ((handle_ = dlopen(name, RTLD_LAZY | RTLD_LOCAL))) return;
  }
  explicit operator bool() const { return handle_ != nullptr; }
  template <class Function>
  bool find(Function*& function, const char* name) const {
    function = reinterpret_cast<Function*>(dlsym(handle_, name));
    return function != nullptr;
  }

 private:
  void* handle_ = nullptr;
};

class OsMesaContext final : public GlContext {
 public:
  static std::unique_ptr<GlContext> create(int width, int height) {
    std::unique_ptr<OsMesaContext> made(new OsMesaContext(width, height));
    return made->open() ? std::move(made) : nullptr;
  }
  ~OsMesaContext() override {
    if (!context_) return;
    make_current_(nullptr, nullptr, 0, 0, 0);
    destroy_(context_);
  }
  bool make_current() override { return make_current_(context_, pixels_.data(), kUnsignedByte, width_, height_) != 0; }

 private:
  static constexpr unsigned kRgba = 0x1908, kUnsignedByte = 0x1401;  // GL/osmesa.h, GL/gl.h

  OsMesaContext(int width, int height)
      : width_(width),
        height_(height),
        pixels_(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}
  bool open() {
    const Library library{"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};
    void* (*create_context)(unsigned, int, int, int, void*) = nullptr;
    if (!library || !library.find(create_context, "OSMesaCreateContextExt") ||
        !library.find(make_current_, "OSMesaMakeCurrent") || !library.find(destroy_, "OSMesaDestroyContext"))
      return false;
    context_ = create_context(kRgba, 24, 8, 0, nullptr);
    return context_ && make_current();
  }

  int width_, height_;
  std::vector<unsigned char> pixels_;
  void* context_ = nullptr;
  unsigned char (*make_current_)(void*, void*, unsigned, int, int) = nullptr;
  void (*destroy_)(void*) = nullptr;
};

class EglContext final : public GlContext {
 public:
  static std::unique_ptr<GlContext> create() {
    std::unique_ptr<EglContext> made(new EglContext);
    return made->open() ? std::move(made) : nullptr;
  }
  ~EglContext() override {
    if (!context_) return;
    make_current_(display_, nullptr, nullptr, nullptr);
    destroy_(display_, context_);
  }
  bool make_current() override { return make_current_(display_, nullptr, nullptr, context_) != 0; }

 private:
  bool open() {
    // EGL/egl.h, EGL/eglext.h
    constexpr unsigned kSurfacelessMesa = 0x31DD, kOpenGlApi = 0x30A2;
    constexpr int kAttributes[] = {0x3033, 0x0001, 0x3040, 0x0008, 0x3038};  // surface: pbuffer; type: OpenGL; end
    const Library library{"libEGL.so.1", "libEGL.so"};
    void* (*get_display)(unsigned, void*, const void*) = nullptr;
    unsigned (*initialize)(void*, int*, int*) = nullptr;
    unsigned (*bind_api)(unsigned) = nullptr;
    unsigned (*choose_config)(void*, const int*, void**, int, int*) = nullptr;
    void* (*create_context)(void*, void*, void*, const int*) = nullptr;
    if (!library || !library.find(get_display, "eglGetPlatformDisplay") || !library.find(initialize, "eglInitialize") ||
        !library.find(bind_api, "eglBindAPI") || !library.find(choose_config, "eglChooseConfig") ||
        !library.find(create_context, "eglCreateContext") || !library.find(make_current_, "eglMakeCurrent") ||
        !library.find(destroy_, "eglDestroyContext"))
      return false;
    int major = 0, minor = 0, found = 0;
    void* config = nullptr;
    display_ = get_display(kSurfacelessMesa, nullptr, nullptr);
    if (!display_ || !initialize(display_, &major, &minor) || !bind_api(kOpenGlApi) ||
        !choose_config(display_, kAttributes, &config, 1, &found) || found < 1)
      return false;
    context_ = create_context(display_, config, nullptr, nullptr);
    return context_ && make_current();
  }

  void* display_ = nullptr;
  void* context_ = nullptr;
  unsigned (*make_current_)(void*, void*, void*, void*) = nullptr;
  unsigned (*destroy_)(void*, void*) = nullptr;
};

}  // namespace

Expected<std::unique_ptr<GlContext>> GlContext::create(int width, int height) {
  const char* asked = std::getenv("CXLAB_GL");
  const std::string_view only = asked ? asked : "";
  if (!only.empty() && only != "osmesa" && only != "egl")
    return usage_error("CXLAB_GL is '" + std::string(only) + "', expected osmesa or egl");
  if (only != "egl")
    if (auto context = OsMesaContext::create(width, height)) return context;
  if (only != "osmesa")
    if (auto context = EglContext::create()) return context;
  return resource_error("pictures need OSMesa or EGL, neither can be opened: apt install libosmesa6")
      .with_code("no_opengl");
}

}  // namespace cxlab::sim
