#pragma once
// OpenGL without a display. The libraries are looked for at run time: a program that draws nothing needs none.

#include <memory>

#include "cx/base/expected.h"

namespace cxlab::sim {

class GlContext {
 public:
  virtual ~GlContext() = default;
  virtual bool make_current() = 0;

  /// OSMesa, or EGL without a surface where OSMesa is missing; kResource with the remedy where both are.
  /// CXLAB_GL=osmesa or egl asks for one of them.
  static Expected<std::unique_ptr<GlContext>> create(int width, int height);
};

}  // namespace cxlab::sim
