// Stands for a fault of the program that lets rules run code of their own: a function that tries all ways out.

#include <cstdio>
#include <string>

#include "cx/executive/export_plugins.h"
#include "escapes.h"

namespace escape {

namespace cx = cxlab::cx;

class Plugin final : public cx::Plugin {
 public:
  using cx::Plugin::Plugin;

  cxlab::Status clips_env_init(cx::EnvironmentGuard environment) override {
    const cxlab::Status crash = environment.engine().add_function({.name = "crash",
                                                                   .returns = "v",
                                                                   .min_args = 0,
                                                                   .max_args = 0,
                                                                   .kind = cxlab::FunctionKind::kActing,
                                                                   .owner = name(),
                                                                   .doc = "Writes to memory that is not there."},
                                                                  [](cxlab::Call&) {
                                                                    volatile int* nowhere =
                                                                        reinterpret_cast<int*>(1 << 20);
                                                                    *nowhere = 1;
                                                                  });
    if (!crash) return crash;
    return environment.engine().add_function({.name = "escape",
                                              .returns = "v",
                                              .min_args = 5,
                                              .max_args = 5,
                                              .arg_types = "*",
                                              .kind = cxlab::FunctionKind::kActing,
                                              .owner = name(),
                                              .doc = "Tries to get out: OUTSIDE PACKAGE RUN PROCESS PORT."},
                                             [](cxlab::Call& call) {
                                               const cxlab::test::Targets targets{
                                                   std::string(call.text(0)), std::string(call.text(1)),
                                                   std::string(call.text(2)), static_cast<pid_t>(call.integer(3)),
                                                   static_cast<int>(call.integer(4))};
                                               int tried = 0;
                                               for (const auto& way : cxlab::test::escapes()) {
                                                 ++tried;
                                                 if (way.succeeds(targets))
                                                   std::fprintf(stderr, "escaped: %s\n", way.name);
                                               }
                                               std::fprintf(stderr, "tried %d ways\n", tried);
                                             });
  }
  void clips_env_destroyed(cx::EnvironmentGuard) override {}
};

}  // namespace escape

CXLAB_PLUGINS(escape::Plugin);
