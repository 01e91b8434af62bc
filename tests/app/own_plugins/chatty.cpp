// Logs each call of a hook, and fails or throws where its parameters say so.

#include <clips_ns/clips.h>
#include <cx/executive/export_plugins.h>

#include <cstdio>
#include <stdexcept>

namespace clips {
extern "C" {
void SystemError(Environment*, const char*, int);
void ExitRouter(Environment*, int);
}
}  // namespace clips

namespace test {

namespace cx = cxlab::cx;

class Chatty final : public cx::Plugin {
 public:
  using Plugin::Plugin;
  ~Chatty() override { log(cx::LogLevel::kInfo, "gone"); }

  cxlab::Status initialize() override {
    if (cxlab::Status s = parameter("fail", fail_); !s) return s;
    if (cxlab::Status s = parameter("throw", throw_); !s) return s;
    return hook("initialize");
  }
  cxlab::Status clips_env_init(cx::EnvironmentGuard environment) override {
    if (cxlab::Status s = hook("clips_env_init", environment->name()); !s) return s;
    return environment.engine().add_function({.name = "chat",
                                              .returns = "l",
                                              .max_args = 0,
                                              .kind = cxlab::FunctionKind::kActing,
                                              .owner = name(),
                                              .doc = "Gives 7."},
                                             [this](cxlab::Call& call) {
                                               if (throw_ == "chat") throw std::runtime_error("no words");
                                               if (fail_ == "clips") {  // as CLIPS does where its data is in disorder
                                                 clips::SystemError(call.engine().raw(), "CHATTY", 1);
                                                 clips::ExitRouter(call.engine().raw(), 1);
                                               }
                                               call.give_integer(7);
                                             });
  }
  void clips_env_destroyed(cx::EnvironmentGuard environment) override {
    (void)hook("clips_env_destroyed", environment->name());
  }
  void finalize() override { (void)hook("finalize"); }

 private:
  cxlab::Status hook(const std::string& hook, const std::string& environment = {}) {
    log(cx::LogLevel::kInfo, hook + (environment.empty() ? "" : " " + environment));
    if (throw_ == hook) throw std::runtime_error("out of words");
    if (fail_ == hook) return cxlab::Error{cxlab::ErrorKind::kRun, "does not want to", {}, 0, {}};
    return {};
  }
  std::string fail_, throw_;
};

/// Logs when the library leaves the process.
struct Library {
  ~Library() { std::fputs("the library is closed\n", stderr); }
} library;

}  // namespace test

CXLAB_PLUGINS(test::Chatty);
