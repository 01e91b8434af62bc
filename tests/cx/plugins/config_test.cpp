#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Config : public ::testing::Test {
 protected:
  /// The confval facts that this file gives, one a line as "path type value" or "path type (list)".
  std::vector<std::string> load(const std::string& yaml, const std::string& prefix = "/",
                                const std::string& parameters = "") {
    lab_.agent("", parameters);
    const auto file = lab_.write("agent/c.yaml", yaml);
    lab_.run_up();
    EXPECT_TRUE(lab_.engine().eval("(config-load \"" + file.string() + "\" \"" + prefix + "\")").ok());
    std::vector<std::string> out;
    for (const FactCopy& f : lab_.engine().facts("confval")) {
      const bool is_list = f.slot("is-list")->text() == "TRUE";
      out.push_back(f.slot("path")->text() + ' ' + f.slot("type")->text() + ' ' +
                    f.slot(is_list ? "list-value" : "value")->print());
    }
    return out;
  }
  Lab lab_;
};

TEST_F(Config, TypesScalarsAsCxDoes) {
  EXPECT_THAT(load("a: 1\nb: 2.5\nc: text\nd: true\ne: \"true\"\nf: yes\ng: \"7\"\nh: 99999999999\ni: a b\n"),
              ElementsAre("/a INT 1", "/b FLOAT 2.5", "/c STRING \"text\"", "/d BOOL TRUE", "/e BOOL TRUE",
                          "/f BOOL yes", "/g INT 7", "/h FLOAT 99999999999", "/i STRING \"a b\""));
}

TEST_F(Config, NumbersThatAreNoneForClipsKeepTheirWord) {
  EXPECT_THAT(load("a: .inf\nb: -.inf\nc: .nan\nd: 0x10\ne: inf\nf: nan\ng: 1e999\nh: 1e3\ni: +7\n"),
              ElementsAre("/a FLOAT .inf", "/b FLOAT -.inf", "/c FLOAT .nan", "/d INT 0x10", "/e STRING \"inf\"",
                          "/f STRING \"nan\"", "/g STRING \"1e999\"", "/h FLOAT 1000.0", "/i INT 7"));
}

TEST_F(Config, ListsAreStrings) {
  EXPECT_THAT(load("l: [1, two, 3.0]"), ElementsAre("/l STRING (\"1\" \"two\" \"3.0\")"));
}

TEST_F(Config, AnEmptyListIsNoFact) {
  EXPECT_THAT(load("a: []\nb: [{c: [], d: 1}]\ne: 2"), ElementsAre("/b/0/d INT \"1\"", "/e INT 2"));
  EXPECT_THAT(lab_.log.with("error "), IsEmpty());
}

TEST_F(Config, ScalarsAmongMapsAreOneListAfterThem) {
  EXPECT_THAT(load("k: [1, {a: 2}, x]"), ElementsAre("/k/1/a INT \"2\"", "/k STRING (\"1\" \"x\")"));
}

TEST_F(Config, TheReleasedCxHasNoQuotesInThePrefix) {
  EXPECT_THAT(load("/**: {a: 1}", "'/**'/a"), IsEmpty());
  EXPECT_THAT(load("b': {c: 1}", "b'"), ElementsAre("/b'/c INT 1"));
}

TEST_F(Config, TheNextCxHasQuotesInThePrefix) {
  const char* next = "compat: next\n";
  EXPECT_THAT(load("/**: {ros__parameters: {environments: [main], a/b: {c: 1}}}", "'/**'/ros__parameters", next),
              ElementsAre("//**/ros__parameters/environments STRING (\"main\")", "//**/ros__parameters/a/b/c INT 1"));
}

TEST_F(Config, APrefixMayEndAtAnything) {
  EXPECT_THAT(load("s: 7", "s", "compat: next\n"), ElementsAre("/s INT 7"));
  EXPECT_THAT(load("l: [a]", "/l/", "compat: next\n"), ElementsAre("/l STRING (\"a\")"));
  EXPECT_THAT(load("n: ~", "n", "compat: next\n"), IsEmpty());
  EXPECT_THAT(lab_.log.with("error "), ElementsAre("error config: Unsupported root node type after prefix traversal"));
}

TEST_F(Config, ListsOfMapsHaveTheirIndexAndQuotedValues) {
  EXPECT_THAT(load("robots: [{name: R1, id: 1}, {name: R2, skills: [a, b]}]"),
              ElementsAre("/robots/0/name STRING \"R1\"", "/robots/0/id INT \"1\"", "/robots/1/name STRING \"R2\"",
                          "/robots/1/skills STRING (\"a\" \"b\")"));
}

TEST_F(Config, WhatListsHoldIsBelowThem) {
  EXPECT_THAT(load("l: [{a: {b: 1, c: [x]}}, [1, 2], 7, {d: [[3], 4]}]"),
              ElementsAre("/l/a/b INT 1", "/l/a/c STRING (\"x\")", "/l/1 STRING (\"1\" \"2\")", "/l/d/0 STRING (\"3\")",
                          "/l/d STRING (\"4\")", "/l STRING (\"7\")"));
}

TEST_F(Config, APrefixChoosesASubtree) {
  EXPECT_THAT(load("a: {b: {c: 1}, d: 2}\ne: 3", "a/b/"), ElementsAre("/a/b/c INT 1"));
}

TEST_F(Config, AWholeParameterFileHasItsDoubleSlash) {
  EXPECT_THAT(load("/**: {ros__parameters: {x: 1}}"), ElementsAre("//**/ros__parameters/x INT 1"));
}

TEST_F(Config, AMissingSegmentIsAnErrorLine) {
  EXPECT_THAT(load("a: 1", "/b"), IsEmpty());
  EXPECT_THAT(lab_.log.with("error "), ElementsAre("error config: Segment 'b' not found in YAML file."));
}

TEST_F(Config, NullIsSkippedWithAnErrorLine) {
  EXPECT_THAT(load("a:\nb: 1"), ElementsAre("/b INT 1"));
  EXPECT_THAT(lab_.log.with("NULL YAML KEY"), SizeIs(1));
}

TEST_F(Config, ABadFileAborts) {
  EXPECT_THAT(load("a: [1"), IsEmpty());
  EXPECT_THAT(lab_.log.with("warn config"), ElementsAre("warn config: Aborting config loading..."));
}

TEST_F(Config, AFileOutsideOfPackagesIsRefused) {
  load("a: 1");
  const auto secret = lab_.write("secret.yaml", "s: 1");
  ASSERT_TRUE(lab_.engine().eval("(config-load \"" + secret.string() + "\" \"/\")").ok());
  EXPECT_THAT(lab_.facts("confval"), SizeIs(1));
  EXPECT_THAT(lab_.log.with("refused"), SizeIs(1));
}

/// Answers from what another run found outside.
class Tape final : public LookOutside {
 public:
  Value look(std::string_view function, const std::function<Value()>& outside) override {
    if (replay) {
      const Value value = kept.at(next).second;
      EXPECT_EQ(kept.at(next++).first, function);
      return value;
    }
    kept.emplace_back(function, outside());
    return kept.back().second;
  }
  bool replay = false;
  std::size_t next = 0;
  std::vector<std::pair<std::string, Value>> kept;
};

TEST(InputLog, WhatRulesFindOutsideReplaysWithoutIt) {
  const std::string rules =
      R"((defrule go (time ?) => (config-load (str-cat (ament-index-get-package-share-directory "agent") "/c.yaml") "/")
    (ros-msgs-create-client "s" "std_srvs/srv/Empty")
    (println "ready " (neq FALSE (ros-msgs-async-send-request (ros-msgs-create-request "std_srvs/srv/Empty") "s")))))";
  Tape tape;
  std::vector<std::string> facts;
  std::string records;
  std::filesystem::path share;
  {
    Lab lab;
    lab.options.packages["agent"].share = "/share/agent";
    lab.options.outside = &tape;
    lab.agent(rules);
    lab.write("agent/c.yaml", "a: 1");
    const auto node =
        lab.bus.join(bus::ParticipantKind::kNode, {"peer", "/", {}}, lab.records.open_stream("node/peer"));
    ASSERT_TRUE(
        lab.bus.serve(node, "/s", **lab.registry.service("std_srvs/srv/Empty"), [](const bus::Delivery&) {}).ok());
    lab.run_up();
    lab.ticks(1);
    facts = lab.facts("confval");
    records = lab.records.text_by_stream().at("env/main");
    EXPECT_THAT(lab.log.with("ready TRUE"), SizeIs(1));
  }
  tape.replay = true;
  Lab again;
  again.options.packages["agent"].share = "/share/agent";
  again.options.outside = &tape;
  again.agent(rules);
  again.run_up();
  again.ticks(1);
  EXPECT_EQ(again.facts("confval"), facts);
  EXPECT_EQ(again.records.text_by_stream().at("env/main"), records);
  EXPECT_EQ(tape.next, tape.kept.size());
}

}  // namespace
}  // namespace cxlab::cx
