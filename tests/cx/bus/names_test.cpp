#include "cx/bus/names.h"

#include <gtest/gtest.h>

#include "cx/bus/bus.h"

namespace cxlab::bus {
namespace {

struct Case {
  const char* name_space;
  std::vector<std::pair<std::string, std::string>> remaps;
  const char* written;
  const char* expected;
};

TEST(Names, ResolveAsInRos) {
  const std::vector<Case> cases{
      {"/", {}, "chatter", "/chatter"},
      {"/", {}, "turtle1/pose", "/turtle1/pose"},
      {"/", {}, "/chatter", "/chatter"},
      {"/", {}, "~/list_envs", "/node/list_envs"},
      {"/", {}, "~", "/node"},
      {"/team/cyan", {}, "chatter", "/team/cyan/chatter"},
      {"/team/cyan", {}, "/chatter", "/chatter"},
      {"/team/cyan", {}, "~/x", "/team/cyan/node/x"},
      {"/ns", {{"chatter", "other"}}, "chatter", "/ns/other"},
      {"/ns", {{"chatter", "other"}}, "/ns/chatter", "/ns/other"},
      {"/ns", {{"chatter", "other"}}, "/chatter", "/chatter"},
      {"/ns", {{"/chatter", "/other"}}, "/chatter", "/other"},
      {"/ns", {{"/ns/chatter", "/other"}}, "chatter", "/other"},
      {"/ns", {{"~/x", "x"}}, "~/x", "/ns/x"},
      {"/ns", {{"a", "b"}, {"b", "c"}, {"a", "d"}}, "a", "/ns/b"},  // the first, once
      {"/ns", {{"chat", "other"}}, "chatter", "/ns/chatter"},       // whole names only
  };
  for (const Case& c : cases)
    EXPECT_EQ((NodeName{"node", c.name_space, c.remaps}.resolve(c.written)), c.expected) << c.written;
}

TEST(Names, RemapsMayHoldForOneNodeOrOneKind) {
  const NodeName node{"node",
                      "/ns",
                      {{"rosservice://a", "s"},
                       {"rostopic://a", "t"},
                       {"node:b", "mine"},
                       {"other:b", "theirs"},
                       {"rosservice:///c", "/d"},
                       {"{node}/e", "f/{ns}"}}};
  EXPECT_EQ(node.resolve("a", NameKind::kService), "/ns/s");
  EXPECT_EQ(node.resolve("a", NameKind::kTopic), "/ns/t");
  EXPECT_EQ(node.resolve("a", NameKind::kAction), "/ns/a");
  EXPECT_EQ(node.resolve("b"), "/ns/mine");
  EXPECT_EQ(node.resolve("/c", NameKind::kService), "/d");
  EXPECT_EQ(node.resolve("/c", NameKind::kTopic), "/c");
  EXPECT_EQ(node.resolve("node/e"), "/ns/f/ns");
  EXPECT_EQ(node.expand("{node}/x"), "/ns/node/x");
  EXPECT_EQ(node.expand("/{namespace}/x"), "/ns/x");
}

TEST(Names, ANodeMayBeRenamed) {
  NodeName node{"node", "/", {{"other:__ns", "/wrong"}, {"node:__ns", "/right"}, {"__node", "me"}, {"a", "b"}}};
  rename_node(node);
  EXPECT_EQ(node.full_name(), "/right/me");
  EXPECT_EQ(node.remaps.size(), 1u);
}

TEST(Names, WhatRosRefusesIsAFault) {
  for (const char* good :
       {"a", "/a", "~/a", "~", "a/b_2", "_hidden", "/a/_b", "{node}/a", "/{ns}/b", "azAZ09_", "Z9/A0"})
    EXPECT_EQ(name_fault(good), "") << good;
  for (const char* bad : {"",      "/",        "a//b", "//a", "a/", "2a", "a/2b", "a b", "a-b",  "~a",   "a~",
                          "{foo}", "\xc3\xa4", "a\n",  "a@",  "a[", "a`", "a{",   "a:",  "a/0b", "a/9b", "~~"})
    EXPECT_NE(name_fault(bad), "") << bad;
}

TEST(Names, ANamespaceIsAbsolute) {
  for (const char* good : {"/", "/cyan", "/cyan/one_2"}) EXPECT_EQ(namespace_fault(good), "") << good;
  for (const char* bad : {"", "cyan", "//", "/a//b", "/a/", "/a b", "/2a"}) EXPECT_NE(namespace_fault(bad), "") << bad;
}

TEST(Names, ARemapNeedsGoodNames) {
  for (const auto& [from, to] : {std::pair{"a", "b"},
                                 {"/a", "~/b"},
                                 {"n:a", "b"},
                                 {"rostopic://a", "b"},
                                 {"n:rosservice:///a", "rosservice://b"},
                                 {"__node", "other"},
                                 {"n:__name", "other"},
                                 {"__ns", "/cyan/one"},
                                 {"__ns", "/"},
                                 {"~/x", "{ns}/x"}})
    EXPECT_EQ(remap_fault({from, to}), "") << from << ' ' << to;
  for (const auto& [from, to] : {std::pair{"a b", "c"},
                                 {"a", "c d"},
                                 {"", "a"},
                                 {"a", ""},
                                 {"a", "b//c"},
                                 {"x y:a", "b"},
                                 {"x/y:a", "b"},
                                 {"/x:a", "b"},
                                 {"~/x:a", "b"},
                                 {"{node}:a", "b"},
                                 {":a", "b"},
                                 {"__node", "/a"},
                                 {"__node", "a/b"},
                                 {"__ns", "cyan"},
                                 {"__ns", "/a b"},
                                 {"rostopic://a b", "c"}})
    EXPECT_NE(remap_fault({from, to}), "") << from << ' ' << to;
  EXPECT_TRUE(check_node("/cyan", {{"a", "b"}, {"__node", "other"}}).ok());
  EXPECT_EQ(check_node("cyan", {}).error().message,
            "namespace: the name 'cyan' does not begin with '/'; expected an absolute name like /cyan");
  const Status wrong = check_node("/", {{"a", "b"}, {"a", "c d"}});
  ASSERT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.error().kind, ErrorKind::kInput);
  EXPECT_EQ(wrong.error().message, "remap.a: the name 'c d' has a ' '; expected letters, digits, '_' and '/'");
  EXPECT_EQ(remap_fault({"a b", "c"}), "the name 'a b' has a ' '; expected letters, digits, '_' and '/'");
}

TEST(Names, GoalIdsAreHexDigitsWithoutDashes) {
  GoalId id{};
  id[0] = 0x0f;
  id[15] = 0xa0;
  EXPECT_EQ(to_string(id), "0f0000000000000000000000000000a0");
}

}  // namespace
}  // namespace cxlab::bus
