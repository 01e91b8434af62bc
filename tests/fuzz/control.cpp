// What those who are attached to a run send: lines, which a run of three ticks answers until there are no more.

#include <filesystem>
#include <sstream>

#include "cx/base/file.h"
#include "cx/plugins/builtin.h"
#include "lab/control/debugger.h"
#include "tests/fuzz/surroundings.h"

namespace fuzz_control {
namespace {

namespace fs = std::filesystem;
using namespace cxlab;

constexpr const char* kConfiguration = R"(clips_manager:
  ros__parameters:
    environments: ["main", "second"]
    main: {plugins: [executive]}
    second: {plugins: [executive]}
    executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 50}
)";
constexpr const char* kRules = R"(
(deftemplate order (slot id (type INTEGER)) (slot state (default new)))
(defglobal ?*count* = 0)
(deffacts start (order (id 1)) (order (id 2)))
(defrule begin ?o <- (order (state new)) => (bind ?*count* (+ ?*count* 1)) (modify ?o (state begun)))
(defrule finish (declare (salience -5)) ?o <- (order (state begun)) => (modify ?o (state done)))
(reset)
)";

class Lines final : public lab::ControlLines {
 public:
  explicit Lines(const std::string& text) : text_(text) {}
  std::optional<Line> take(std::chrono::milliseconds) override {
    std::string line;
    if (!std::getline(text_, line)) return {};
    return Line{1, line};
  }
  void send(std::uint64_t, const std::string& line) override {
    fuzz::promise(line.find('\n') == std::string::npos, "an answer is one line");
  }
  void send_all(const std::string& line) override { send(0, line); }
  bool over() const { return text_.eof(); }

 private:
  std::istringstream text_;
};

}  // namespace

/// CLIPS forgets small blocks on errors of many functions.
FUZZ_TARGET(control, "detect_leaks=0") {
  Lines lines(fuzz::text_of(data, size));
  lab::Debugger::Options of_debugger;
  of_debugger.begin_stopped = true;
  of_debugger.over = [&lines] { return lines.over(); };
  lab::Debugger debugger(lines, of_debugger);
  const fs::path config = fuzz::folder() / "config.yaml";
  if (!fs::exists(config)) fuzz::promise(write_file(config, kConfiguration).ok(), "the configuration is written");
  Limits most;
  most.steps = 200'000;
  LimitsInUse limits(most);
  const inspect::Timeline nothing_recorded;
  cx::ManagerOptions options;
  options.config = config;
  options.plugin_types = cx::builtin_plugins();
  options.limits = &limits;
  options.control = &debugger;
  fuzz::live(std::move(options), 3, [&](cx::EnvironmentManager& manager) {
    const auto environments = [&] {
      std::vector<cx::Environment*> all;
      for (std::size_t i = 0; i < manager.size(); ++i) all.push_back(&manager.environment(i));
      return all;
    };
    const auto inspect = [&](cx::Environment& environment) {
      return inspect::Inspector(environment.name_in_log(), environment.engine(), nothing_recorded,
                                [](const std::string& file) { return file; });
    };
    const auto look = [](const std::string& what) -> Expected<std::string> { return "nothing called '" + what + "'"; };
    debugger.watch({.environments = environments, .inspect = inspect, .look = look});
    for (std::size_t i = 0; i < manager.size(); ++i)
      (void)manager.environment(i).engine().load_text(kRules, "rules.clp", LoadMode::kBatch);
  });
  return 0;
}

}  // namespace fuzz_control
