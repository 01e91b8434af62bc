#include <cx/executive/export_plugins.h>

int defined_nowhere();

namespace test {

class Incomplete final : public cxlab::cx::Plugin {
 public:
  using Plugin::Plugin;
  cxlab::Status clips_env_init(cxlab::cx::EnvironmentGuard) override {
    return defined_nowhere() ? cxlab::Status() : cxlab::input_error("none");
  }
};

}  // namespace test

CXLAB_PLUGINS(test::Incomplete);
