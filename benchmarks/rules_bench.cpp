// Message -> fact -> rule -> command through the generic plugin, and the same rule in plain CLIPS with functions that
// return constants: in turns, CPU time, medians. Prints one line of JSON.
//
//   bench_rules [CYCLES] [ROUNDS]

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "benchmarks/rules_baseline.h"
#include "cx/bus/bus.h"
#include "cx/executive/environment_manager.h"
#include "cx/journal/journal.h"
#include "cx/plugins/builtin.h"

namespace cxlab {
namespace {

constexpr const char* kTemplate =
    "(deftemplate ros-msgs-message (slot topic (type STRING)) (slot msg-ptr (type EXTERNAL-ADDRESS)))";

/// A message of four fields: three are read, two of a new one are set; it is published, both are destroyed.
constexpr const char* kRule = R"((defrule command
  ?f <- (ros-msgs-message (topic "pose") (msg-ptr ?m))
  =>
  (retract ?f)
  (bind ?x (ros-msgs-get-field ?m "x"))
  (bind ?y (ros-msgs-get-field ?m "y"))
  (bind ?w (ros-msgs-get-field ?m "w"))
  (bind ?c (ros-msgs-create-message "geometry_msgs/msg/Vector3"))
  (ros-msgs-set-field ?c "x" (+ ?x ?w))
  (ros-msgs-set-field ?c "y" ?y)
  (ros-msgs-publish ?c "command")
  (ros-msgs-destroy-message ?c)
  (ros-msgs-destroy-message ?m)))";

[[noreturn]] void stop(const std::string& why) {
  std::fprintf(stderr, "bench_rules: %s\n", why.c_str());
  std::exit(1);
}

template <class T>
T need(Expected<T> value) {
  if (!value) stop(value.error().text());
  return std::move(*value);
}
void need(const Status& status) {
  if (!status) stop(status.error().text());
}

double cpu_now() {
  std::timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// One environment with the plugin on a bus with a journal, and a node that posts poses and takes commands.
class Lab {
 public:
  Lab() : folder_(std::filesystem::temp_directory_path() / "cxlab_bench_rules") {
    const char* source = std::getenv("CXLAB_SOURCE_DIR");
    need(registry_.add_packages_in(std::filesystem::path(source ? source : ".") / "cx" / "interfaces"));
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "config.yaml")
        << "/**: {ros__parameters: {environments: [main], main: {plugins: [ros_msgs]}, "
           "ros_msgs: {plugin: \"cx::RosMsgsPlugin\"}}}\n";
    cx::ManagerOptions options;
    options.config = folder_ / "config.yaml";
    options.plugin_types = cx::builtin_plugins();
    manager_ = need(cx::EnvironmentManager::create(std::move(options), bus_, journal_));
    need(manager_->configure());
    need(manager_->activate());
    RuleEngine& engine = manager_->environment(0).engine();
    need(engine.build(kRule));
    need(engine.eval("(ros-msgs-create-subscription \"pose\" \"geometry_msgs/msg/Quaternion\")"));
    need(engine.eval("(ros-msgs-create-publisher \"command\" \"geometry_msgs/msg/Vector3\")"));

    node_ = bus_.join(bus::ParticipantKind::kNode, {"world", "/", {}}, journal_.open_stream("node/world"));
    const bus::MessageType* pose = need(registry_.message("geometry_msgs/msg/Quaternion"));
    const bus::MessageType* command = need(registry_.message("geometry_msgs/msg/Vector3"));
    pose_ = need(bus_.advertise(node_, "pose", *pose));
    bus::Message message(*pose);
    message->set("x", 0.25).set("y", 0.5);
    message_ = std::make_shared<bus::Message>(std::move(message));
    const bus::Field* x = command->find("x");
    need(bus_.subscribe(node_, "command", *command,
                        [this, x](const bus::Delivery& d) { sum_ += d.message->view().real(*x); }));
  }
  ~Lab() {
    need(manager_->deactivate());
    std::filesystem::remove_all(folder_);
  }

  void cycle() {
    bus_.begin_tick(now_ += SimTime{20'000'000});
    bus_.publish(pose_, message_);
    need(manager_->perceive());
    need(manager_->environment(0).run());
    bus_.deliver(node_);
  }
  /// The sum of x over all commands that came back.
  double sum() const { return sum_; }
  std::string hash() const { return journal_.journal_hash(); }

 private:
  std::filesystem::path folder_;
  Journal journal_;
  bus::Registry registry_;
  bus::Bus bus_{registry_, journal_};
  std::unique_ptr<cx::EnvironmentManager> manager_;
  bus::ParticipantId node_{};
  bus::EndpointId pose_{};
  bus::SharedMessage message_;
  SimTime now_{};
  double sum_ = 0;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

int run(long cycles, long rounds) {
  Lab lab;
  Baseline* baseline = baseline_create(kTemplate, kRule);
  if (baseline == nullptr) stop("the rules do not load in plain CLIPS");
  std::vector<double> ours, plain, ratios;
  long long fired = 0;
  for (long round = 0; round < rounds; ++round) {
    double start = cpu_now();
    for (long i = 0; i < cycles; ++i) fired += baseline_cycle(baseline);
    plain.push_back((cpu_now() - start) / static_cast<double>(cycles) * 1e9);
    start = cpu_now();
    for (long i = 0; i < cycles; ++i) lab.cycle();
    ours.push_back((cpu_now() - start) / static_cast<double>(cycles) * 1e9);
    ratios.push_back(plain.back() / ours.back());
  }
  baseline_destroy(baseline);
  const double expected = 1.25 * static_cast<double>(cycles * rounds);
  if (lab.sum() != expected || fired != cycles * rounds) stop("a command is missing or wrong");
  std::printf("{\"cxlab_ns\": %.0f, \"plain_clips_ns\": %.0f, \"ratio\": %.3f, \"cycles\": %ld, \"hash\": \"%s\"}\n",
              median(ours), median(plain), median(ratios), cycles * rounds, lab.hash().c_str());
  return 0;
}

}  // namespace
}  // namespace cxlab

int main(int argc, char** argv) {
  return cxlab::run(argc > 1 ? std::atol(argv[1]) : 100000, argc > 2 ? std::atol(argv[2]) : 7);
}
