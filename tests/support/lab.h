#pragma once
// A folder with configurations and rules, and managers on a bus with a clock that the test moves.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "cx/executive/environment_manager.h"
#include "cx/plugins/builtin.h"
#include "cx/run/loop.h"
#include "tests/support/test_bus.h"

namespace cxlab::cx {

inline constexpr SimTime kTick{20'000'000};

/// Keeps lines as "LEVEL logger: text", with the colour's sequence before the text.
class KeptLines final : public LogSink {
 public:
  void line(const LogLine& l) override {
    lines.push_back(std::string(to_string(l.level)) + ' ' + std::string(l.logger) + ": " + std::string(l.colour) +
                    std::string(l.text));
  }
  /// Those that contain the text.
  std::vector<std::string> with(const std::string& text) const {
    std::vector<std::string> out;
    for (const auto& l : lines)
      if (l.find(text) != std::string::npos) out.push_back(l);
    return out;
  }
  std::vector<std::string> lines;
};

class Lab : private bus::TestBus {
 public:
  Lab() {
    options.packages["agent"] = {folder / "agent", {}};
    options.plugin_types = builtin_plugins();
    options.log = &log;
  }

  /// Writes a file below the folder.
  std::filesystem::path write(const std::string& name, const std::string& text) {
    return put_file(folder / name, text);
  }
  static std::string read(const std::filesystem::path& path) { return content_of(path); }

  /// The first block of code of a page of docs that contains the word.
  static std::string page_code(const std::string& page, const std::string& word) {
    const std::string text = read(source_dir() / page), fence = "\n```\n";
    const std::size_t at = text.find(word, text.find(fence));
    const std::size_t begin = text.rfind(fence, at) + fence.size();
    return text.substr(begin, text.find(fence, begin) - begin);
  }

  /// The parameters below `ros__parameters`.
  void config(const std::string& parameters) {
    std::string text = "/**:\n  ros__parameters:\n";
    std::istringstream lines(parameters);
    for (std::string line; std::getline(lines, line);) text += "    " + line + '\n';
    options.config = write("config.yaml", text);
  }
  /// One environment "main" with all plugins and these rules, in agent/rules.clp; its executive runs at 10 Hz.
  /// `parameters` come first.
  void agent(const std::string& rules, const std::string& parameters = "") {
    config(parameters + R"(environments: ["main"]
main: {plugins: ["executive", "ament_index", "config", "ros_msgs", "files"]}
executive: {plugin: "cx::ExecutivePlugin"}
ament_index: {plugin: "cx::AmentIndexPlugin"}
config: {plugin: "cx::ConfigPlugin"}
ros_msgs: {plugin: "cx::RosMsgsPlugin"}
files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["agent"], load: ["rules.clp"]})");
    write("agent/rules.clp", rules);
  }

  Status create() {
    auto made = EnvironmentManager::create(options, bus, records);
    if (!made) return made.error();
    manager = std::move(*made);
    return {};
  }
  /// Creates, configures and activates.
  Status start() {
    if (Status s = create(); !s) return s;
    if (Status s = manager->configure(); !s) return s;
    return manager->activate();
  }
  /// Starts, which must go well.
  void run_up() {
    const Status s = start();
    ASSERT_TRUE(s.ok()) << s.error().text();
  }

  /// One tick of the manager; the clock moves after it.
  Status tick() {
    Loop loop(bus, kTick, {.agents = {manager.get()}});
    Status played = loop.tick_at(now);
    if (played) now += kTick;
    return played;
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i) {
      const Status s = tick();
      ASSERT_TRUE(s.ok()) << s.error().text();
    }
  }
  RuleEngine& engine(const std::string& name = "main") { return manager->find(name)->engine(); }
  /// Printed facts of a template.
  std::vector<std::string> facts(const std::string& name, const std::string& environment = "main") {
    std::vector<std::string> out;
    for (const FactCopy& f : engine(environment).facts(name)) out.push_back(f.print());
    return out;
  }

  TempFolder temp;
  const std::filesystem::path folder = temp.path();
  KeptLines log;
  KeptRecords& records = sink_;
  bus::Registry& registry = registry_;
  bus::Bus& bus = bus_;
  ManagerOptions options;
  std::unique_ptr<EnvironmentManager> manager;
  SimTime now{};
};

}  // namespace cxlab::cx
