#include "cx/yaml/yaml.h"

#include <gtest/gtest.h>

namespace cxlab::yaml {
namespace {

struct Settings {
  std::string name = "none";
  double speed = 1;
  int count = 0;
  SimTime wait{};
};

Status read(const Document& document, Settings& settings) {
  Map map = document.root().as_map();
  map.read("name", settings.name)
      .read("speed", settings.speed)
      .read("count", settings.count)
      .read_seconds("wait_s", settings.wait);
  map.finish();
  return document.status();
}

std::string error_of(const std::string& text) {
  auto document = Document::parse(text, "s.yaml");
  if (!document) return document.error().text();
  Settings settings;
  const Status status = read(*document, settings);
  return status ? "" : status.error().text();
}

TEST(Yaml, ReadsWhatIsThereAndKeepsDefaults) {
  auto document = Document::parse("speed: 2.5\nwait_s: 0.02\n", "s.yaml");
  ASSERT_TRUE(document.ok());
  Settings settings;
  ASSERT_TRUE(read(*document, settings).ok());
  EXPECT_EQ(settings.name, "none");
  EXPECT_EQ(settings.speed, 2.5);
  EXPECT_EQ(settings.wait.count(), 20'000'000);
}

TEST(Yaml, ErrorsNameFileLineAndRemedy) {
  EXPECT_EQ(error_of("speed: 1\nspead: 2\n"), "s.yaml:2: unknown key 'spead', did you mean 'speed'?");
  EXPECT_EQ(error_of("qqqqqqqqqqqq: 2\n"),
            "s.yaml:1: unknown key 'qqqqqqqqqqqq'; known are: name, speed, count, wait_s");
  EXPECT_EQ(error_of("count: 1\ncount: 2\n"), "s.yaml:2: key 'count' stands here a second time");
  EXPECT_EQ(error_of("\ncount: many\n"), "s.yaml:2: count: found 'many', expected an integer");
  EXPECT_EQ(error_of("count: 99999999999\n"), "s.yaml:1: count: found 99999999999, which is out of range");
  EXPECT_EQ(error_of("wait_s: -1\n"), "s.yaml:1: wait_s: found -1, expected seconds from 0 to 1e9");
  EXPECT_EQ(error_of("name: [a, b]\n"), "s.yaml:1: name: found a list, expected a text");
  EXPECT_EQ(error_of("- 1\n"), "s.yaml:1: found a list, expected a map");
  EXPECT_NE(error_of("a: [1\n").find("s.yaml:2: not YAML"), std::string::npos);
}

TEST(Yaml, AMisspeltRequiredKeyIsToldByItsName) {
  const auto agent = [](const std::string& text) {
    auto document = Document::parse(text, "s.yaml");
    Map map = document->root().as_map();
    map.require("config");
    map.get("namespace");
    map.finish();
    return document->status().error().text();
  };
  EXPECT_EQ(agent("confg: a.yaml\n"), "s.yaml:1: key 'config' is missing, did you mean it by 'confg'?");
  EXPECT_EQ(agent("namespace: /a\nconfg: a.yaml\n"), "s.yaml:2: key 'config' is missing, did you mean it by 'confg'?");
  EXPECT_EQ(agent("namespace: /a\n"), "s.yaml:1: key 'config' is missing");
  EXPECT_EQ(agent("config: a.yaml\nqqqqqqqqqq: 1\nnamspace: /a\n"),
            "s.yaml:3: unknown key 'namspace', did you mean 'namespace'?")
      << "the one with a remedy comes first";
}

TEST(Yaml, SetWritesAtAPath) {
  auto document = Document::parse("world: {kind: rcll}\nagents: [{config: a}, {config: b}]\n", "s.yaml");
  ASSERT_TRUE(document.ok());
  EXPECT_TRUE(document->set("world.kind=none").ok());
  EXPECT_TRUE(document->set("agents[1].config=c").ok());
  EXPECT_TRUE(document->set("new.deep.key=[1, 2]").ok());
  EXPECT_EQ(document->root().dump(),
            "world: {kind: none}\nagents: [{config: a}, {config: c}]\nnew:\n  deep:\n    key: [1, 2]");
  EXPECT_EQ(document->set("agents[2].config=c").error().text(),
            "--set agents[2].config=c: index 2 is beyond the list's 2 items");
  EXPECT_EQ(document->set("world").error().text(), "--set world: expected PATH=VALUE");
  EXPECT_FALSE(document->set("world.kind.x=1").ok());
  EXPECT_EQ(document->set("world.kind=[").error().text().find("--set world.kind=[: the value is not YAML"), 0u);
  EXPECT_FALSE(document->set("a..b=1").ok());
}

TEST(Yaml, EachValueKnowsWhereItComesFrom) {
  auto document = Document::parse("world:\n  kind: rcll\n  robots: 3\nagents:\n  - {config: a}\n", "s.yaml");
  ASSERT_TRUE(document->set("world.robots=7").ok());
  ASSERT_TRUE(document->set("world.robots=8").ok());
  ASSERT_TRUE(document->set("agents[0]config", "b", "--config b").ok());
  Map root = document->root().as_map(), world = root.get("world").as_map();
  EXPECT_EQ(world.get("kind").origin(), (Origin{"s.yaml", 2}));
  EXPECT_EQ(world.get("robots").origin(), (Origin{"--set world.robots=8", 0})) << "the last one counts";
  Map agent = root.get("agents").as_list().front().as_map();
  EXPECT_EQ(agent.get("config").origin(), (Origin{"--config b", 0}));
  world.get("robots").fail("too many");
  EXPECT_EQ(document->status().error().text(), "--set world.robots=8: world.robots: too many");
}

struct Item {
  std::string name;
  Origin origin;
};

TEST(Yaml, AListOfMapsReplacesTheItems) {
  auto document = Document::parse("items:\n  - {name: a}\n  - {nam: b}\n", "s.yaml");
  std::vector<Item> items{{"before", {}}};
  Map root = document->root().as_map();
  const auto fields = [](Map& map, Item& item) { map.read("name", item.name); };
  root.read_list("others", items, fields);
  EXPECT_EQ(items.size(), 1u) << "a missing key leaves the items alone";
  root.read_list("items", items, fields);
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[0].name, "a");
  EXPECT_EQ(items[1].origin, (Origin{"s.yaml", 3}));
  EXPECT_EQ(document->status().error().text(), "s.yaml:3: unknown key 'nam' in 'items[1]', did you mean 'name'?");
}

}  // namespace
}  // namespace cxlab::yaml
