#include "cx/yaml/yaml.h"

#include <gtest/gtest.h>

#include "cx/yaml/writer.h"

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

TEST(Yaml, ASecondDocumentIsAnError) {
  EXPECT_EQ(error_of("---\na: 1\n---\nb: 2\n"), "s.yaml:3: found a second document, expected one");
  EXPECT_EQ(error_of("\n,a{]{{{ b:"), "s.yaml:2: found a second document, expected one");  // LoadAll never returns
  EXPECT_TRUE(Document::parse("---\na: 1\n", "s.yaml").ok());
  EXPECT_TRUE(Document::parse("", "s.yaml").ok());
}

TEST(Yaml, ATabInTheIndentationIsReportedWithItsLine) {
  EXPECT_EQ(error_of("schema: 1\nworld:\n\tkind: rcll\n"), "s.yaml:3: found a tab in the indentation, expected spaces");
  EXPECT_EQ(error_of("world:\n  \tkind: rcll\n  team: CYAN\n"),
            "s.yaml:2: found a tab in the indentation, expected spaces");
  EXPECT_NE(error_of("a: |\n  \tb\nc: d\ne: [1\n").find("not YAML"), std::string::npos);
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

TEST(Yaml, AnUnknownMapThatAnOptionMadeNamesTheOption) {
  auto document = Document::parse("world: {kind: rcll}\n", "s.yaml");
  ASSERT_TRUE(document->set("wrld.robots=2").ok());
  Map root = document->root().as_map();
  root.get("world");
  EXPECT_FALSE(root.finish());
  EXPECT_EQ(document->status().error().text(), "--set wrld.robots=2: unknown key 'wrld', did you mean 'world'?");
}

struct Wheel {
  std::string name;
  double radius = 0.1;
  Origin origin;
  template <class Keys>
  void fields(Keys& keys) {
    keys.required("name", name);
    keys("radius", radius);
  }
};

struct Car {
  std::string paint = "red";
  std::int64_t doors = 4;
  bool roof = true;
  SimTime start{};
  std::optional<double> limit;
  std::vector<std::string> tags;
  std::vector<std::pair<std::string, std::string>> names;
  std::vector<Wheel> wheels{{"spare", 0.1, {}}};
  double length = 4, width = 1.8;
  template <class Keys>
  void fields(Keys& keys) {
    keys.word("paint", paint, {"red", "blue"});
    keys("doors", doors);
    keys("roof", roof);
    keys("start_s", start);
    keys("limit", limit);
    keys("tags", tags);
    keys("names", names);
    keys("wheels", wheels);
    keys.below("size", [&](auto& size) {
      size("length", length);
      size("width", width);
    });
  }
};

Status validate(const Car& car) {
  for (std::size_t i = 0; i < car.wheels.size(); ++i)
    if (car.wheels[i].radius <= 0) return input_error("wheels[" + std::to_string(i) + "].radius: expected more than 0");
  return car.width < car.length ? Status() : Status(input_error("size.width: expected less than size.length"));
}

std::string read(const std::string& text, Car& car) {
  auto document = Document::parse(text, "s.yaml");
  Map map = document->root().as_map();
  map.read(car);
  map.finish();
  return document->status() ? "" : document->status().error().text();
}

const std::string kCar = R"(paint: blue
doors: 5
roof: false
start_s: 0.02
limit: 1e+30
tags: [a, "b: c", ""]
names: {z: "1", a: null-like}
wheels:
  - {name: "null", radius: 0.30000000000000004}
size: {width: 2}
)";

TEST(Yaml, AStructIsReadByTheKeysThatItLists) {
  Car car;
  EXPECT_EQ(read("{}\n", car), "");
  EXPECT_EQ(car.wheels.size(), 1u) << "a missing key leaves its field alone";
  EXPECT_EQ(car.limit, std::nullopt);
  EXPECT_EQ(read(kCar, car), "");
  EXPECT_EQ(car.paint, "blue");
  EXPECT_EQ(car.start, from_seconds(0.02));
  EXPECT_EQ(car.limit, 1e30);
  EXPECT_EQ(car.names[0], (std::pair<std::string, std::string>("z", "1")));
  ASSERT_EQ(car.wheels.size(), 1u);
  EXPECT_EQ(car.wheels[0].origin, (Origin{"s.yaml", 9}));
  EXPECT_EQ(car.length, 4);
  EXPECT_EQ(car.width, 2);
  EXPECT_EQ(read("paint: bleu\n", car),
            "s.yaml:1: paint: found 'bleu', expected one of: red, blue; did you mean 'blue'?");
  EXPECT_EQ(read("wheels:\n  - {nam: b}\n", car),
            "s.yaml:2: wheels[0]: key 'name' is missing, did you mean it by 'nam'?");
  EXPECT_EQ(read("size:\n  lenght: 1\n", car), "s.yaml:2: unknown key 'lenght' in 'size', did you mean 'length'?");
}

TEST(Yaml, WhatValidateFindsIsReportedAtItsKey) {
  Car car;
  EXPECT_EQ(read("doors: 2\nwheels:\n  - name: a\n  - name: b\n    radius: 0\n", car),
            "s.yaml:5: wheels[1].radius: expected more than 0");
  car = {};
  EXPECT_EQ(read("doors: 2\nsize:\n  length: 1\n", car), "s.yaml:3: size.width: expected less than size.length")
      << "a key that is not there: the line of what is around it";
}

TEST(Yaml, AStructIsWrittenAsItIsRead) {
  Car car;
  EXPECT_EQ(Writer::changed(car).text(), "{}\n");
  EXPECT_TRUE(Writer::changed(car).empty());
  ASSERT_EQ(read(kCar, car), "");
  Car again;
  ASSERT_EQ(read(Writer::of(car).text(), again), "") << Writer::of(car).text();
  EXPECT_EQ(Writer::of(again).text(), Writer::of(car).text());
  EXPECT_EQ(again.wheels[0].name, "null");
  EXPECT_EQ(again.wheels[0].radius, 0.30000000000000004);
  EXPECT_EQ(again.tags, car.tags);
  Car repainted;
  repainted.paint = "blue";
  EXPECT_EQ(Writer::changed(repainted).text(), "paint: blue\n");
}

TEST(Yaml, TextKeepsQuotesAndStyle) {
  const std::string text = "a: \"5\"\nb: [1, \"x: y\", {c: \"~\", d: ~}]\n\"7\": ''\nlong:\n  - {}\n  - []";
  EXPECT_EQ(Document::parse(text, "s.yaml")->root().dump(),
            "a: \"5\"\nb: [1, \"x: y\", {c: \"~\", d: ~}]\n\"7\": \"\"\nlong:\n  - {}\n  - []");
}

TEST(Yaml, TheWriterTakesTextThatIsYaml) {
  Writer out;
  out.put_yaml("data", "{x: 1}");
  out.put_yaml("broken", "{x: 1");
  Writer item;
  item("at", 0.5);
  out.append("list", item);
  EXPECT_EQ(out.text(), "data: {x: 1}\nbroken: \"{x: 1\"\nlist:\n  - at: 0.5\n");
}

}  // namespace
}  // namespace cxlab::yaml
