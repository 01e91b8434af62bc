// A plugin with a thread of its own: what the thread finds becomes a fact, through the environment's gate.

#include <cx/executive/export_plugins.h>
#include <cx/executive/thread_gate.h>

#include <atomic>
#include <string>
#include <thread>

namespace own {

namespace cx = cxlab::cx;

/// Asserts (reading N), N = 1, 2, ... up to the parameter `readings`, each as soon as the last one is in. A real one
/// would wait for a device here.
class SensorPlugin final : public cx::Plugin {
 public:
  using Plugin::Plugin;

  cxlab::Status initialize() override { return parameter("readings", readings_); }

  cxlab::Status clips_env_init(cx::EnvironmentGuard environment) override {
    auto gate = environment->open_gate(name());
    if (!gate) return gate.error();
    Sensor& sensor = sensors_.add(*environment);
    sensor.thread = std::thread([&sensor, gate = *gate, last = readings_] {
      for (std::int64_t n = 1; n <= last && !sensor.ended; ++n) {
        auto answer = gate->assert_fact("(reading " + std::to_string(n) + ")");
        if (!answer.get()) return;  // it waits for the next tick; an error says that the plugin is unloaded
      }
    });
    return {};
  }

  /// The gate is closed by now, so that the thread does not wait.
  void clips_env_destroyed(cx::EnvironmentGuard environment) override {
    Sensor* sensor = sensors_.find(*environment);
    sensor->ended = true;
    sensor->thread.join();
    sensors_.remove(*environment);
  }

 private:
  struct Sensor {
    std::thread thread;
    std::atomic<bool> ended = false;
  };

  std::int64_t readings_ = 3;
  cx::PerEnvironment<Sensor> sensors_;
};

}  // namespace own

CXLAB_PLUGINS(own::SensorPlugin);
