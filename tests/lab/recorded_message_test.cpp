// Messages of a journal, as bags get them: what was recorded comes back.

#include "lab/export/recorded_message.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <list>

#include "tests/support/bus_test.h"

namespace cxlab::lab {

namespace {

class RecordedMessage : public testing::Test {
 protected:
  const bus::MessageType& type_of(const std::string& definition) {
    auto& [folder, registry] = made_.emplace_back();
    folder.write("p/msg/Pair", "string name\nfloat64[] values\n");
    folder.write("p/msg/T", definition);
    EXPECT_TRUE(registry.add_package("p", folder.folder() / "p"));
    const auto type = registry.message("p/msg/T");
    EXPECT_TRUE(type) << (type ? "" : type.error().text());
    return **type;
  }
  /// What the journal has of a message.
  static RecordValue recorded(const bus::Message& message) {
    RecordData data;
    data.begin().name("message");
    message.view().record(data);
    return *decode_record_data(data.bytes())->find("message");
  }
  RecordValue recorded(const std::string& definition, const std::string& value) {
    const auto message = bus::Message::from_yaml(type_of(definition), value);
    EXPECT_TRUE(message) << (message ? "" : message.error().text());
    return recorded(*message);
  }

 private:
  struct Made {
    bus::TempPackages folder;
    bus::Registry registry;
  };
  std::list<Made> made_;
};

TEST_F(RecordedMessage, EachFieldAndEachElementOfAListComesBack) {
  for (const auto& [definition, value] : std::initializer_list<std::pair<const char*, const char*>>{
           {"string[] a\n", "{a: ['x', '', 'z']}"},
           {"string[2] a\nbool b\n", "{a: ['x', 'y'], b: true}"},
           {"float64[] a\n", "{a: [1.5, -2.0, 0.0]}"},
           {"float32[2] a\nfloat64 b\n", "{a: [0.5, .inf], b: -.inf}"},
           {"int16[] a\nuint8[3] b\n", "{a: [-1, 2, -3], b: [7, 0, 9]}"},
           {"uint64[] a\n", "{a: [1, 18446744073709551615]}"},
           {"bool[] a\n", "{a: [true, false, true]}"},
           {"Pair[] a\n", "{a: [{name: x, values: [1.0]}, {name: y, values: [2.0, 3.0]}, {name: z, values: []}]}"},
           {"Pair[2] a\nPair b\n", "{a: [{name: x}, {name: y, values: [4.0]}], b: {name: z}}"},
           {"float64[] a\nstring[] b\nPair[] c\n", "{a: [], b: [], c: []}"}}) {
    const bus::MessageType& type = type_of(definition);
    const auto message = bus::Message::from_yaml(type, value);
    ASSERT_TRUE(message) << definition << message.error().text();
    bus::Message again(type);
    const Status done = set_message(again.view(), recorded(*message));
    EXPECT_TRUE(done) << definition << done.error().text();
    EXPECT_EQ(again->to_string(), message->view().to_string()) << definition;
  }
}

/// A definition that has changed since the run.
TEST_F(RecordedMessage, WhatAnotherDefinitionRecordedIsAnError) {
  struct Row {
    const char *then, *value, *now, *said;
  };
  for (const Row& row : {
           Row{"float64 a\n", "{a: 1.0}", "float64 b\n",
               "a message p/msg/T of the journal has no field 'b' where its definition has it"},
           Row{"int32 a\nint32 b\n", "{}", "int32 a\n",
               "a message p/msg/T of the journal has 2 fields, its definition has 1"},
           Row{"int32[3] a\n", "{}", "int32[2] a\n", "field 'a': found 3 elements, expected 2"},
           Row{"int32[] a\n", "{a: [1]}", "string[] a\n", "field 'a': found 1, expected string[]"},
           Row{"int32 a\n", "{a: 1}", "int32[] a\n", "field 'a': found 1, expected a list"},
           Row{"string a\n", "{a: x}", "Pair a\n", "found \"x\", expected a message p/msg/Pair"},
       }) {
    bus::Message message(type_of(row.now));
    const Status done = set_message(message.view(), recorded(row.then, row.value));
    ASSERT_FALSE(done) << row.now;
    EXPECT_EQ(done.error().message, row.said);
  }
}

}  // namespace

}  // namespace cxlab::lab
