// Broken definitions and broken bytes, drawn from a seed: an error or a message, never anything else.

#include <gtest/gtest.h>

#include "cx/base/random.h"
#include "tests/support/bus_test.h"

namespace cxlab::bus {
namespace {

constexpr std::string_view kPieces[] = {"int8",  "string<=", "[<=",   "[",      "]",
                                        "---\n", "=",        "#",     "\"",     "'",
                                        "\n",    " ",        "/",     "Header", "99999999999999999999",
                                        "-",     "\\",       "1e999", "\xff",   "[1, 2",
                                        "true",  "A/B/C/D",  "LIMIT"};

/// A few characters changed, cut, doubled or put in.
std::string mutate(std::string text, RandomStream& random) {
  for (std::uint64_t i = 0, n = 1 + random.below(3); i < n; ++i) {
    const std::size_t at = random.below(text.size() + 1);
    switch (random.below(4)) {
      case 0: text.insert(at, kPieces[random.below(std::size(kPieces))]); break;
      case 1: text.erase(at, random.below(8)); break;
      case 2:
        if (at < text.size()) text[at] = static_cast<char>(random.below(256));
        break;
      default: text.insert(at, text.substr(random.below(text.size() + 1), random.below(30))); break;
    }
  }
  return text;
}

TEST(Robustness, MutatedDefinitionsAreReadOrReportedWithTheirLine) {
  const std::string good =
      "# a comment\nint32 LIMIT=0x10\nstring GREETING = \"a # b\"\nbool flag true\nint8[3] fixed [1, -2, 3]\n"
      "uint16[<=4] bounded [7]\nfloat64[] open [1.5, 2]\nstring<=5 short 'a#b'\nstring[] names [\"x, y\", z]\nInner "
      "inner\npkg/msg/Inner[2] pair\n";
  RandomStream random(1, "definitions");
  int read = 0, refused = 0;
  TempPackages packages;
  packages.write("pkg/msg/Inner", "int8 a 5\nstring b\n");
  for (int i = 0; i < 1500; ++i) {
    const auto file = packages.write("pkg/msg/T", mutate(good, random));
    Registry registry;
    ASSERT_TRUE(registry.add_packages_in(packages.folder()).ok());
    const auto type = registry.message("pkg/msg/T");
    if (type) {
      ++read;
      Message message(**type);
      std::string bytes;
      message.serialize(bytes);
      std::size_t position = 0;
      const auto again = Message::deserialize(**type, std::as_bytes(std::span(bytes)), position);
      ASSERT_TRUE(again.ok()) << again.error().text();
    } else {
      ++refused;
      EXPECT_EQ(type.error().file, file.string());
      EXPECT_GT(type.error().line, 0) << type.error().text();
    }
  }
  EXPECT_GT(read, 50);
  EXPECT_GT(refused, 100);
}

TEST(Robustness, MutatedBytesAreAMessageOrAnError) {
  Registry registry;
  add_interfaces(registry);
  RandomStream random(2, "bytes");
  int read = 0, refused = 0;
  for (const char* name :
       {"rcl_interfaces/msg/ParameterEvent", "sensor_msgs/msg/JointState",
        "cx_pddl_interfaces/action/PlanTemporal_Result", "std_msgs/msg/Empty", "action_msgs/srv/CancelGoal_Response"}) {
    const MessageType& type = **registry.message(name);
    for (int i = 0; i < 400; ++i) {
      std::string bytes;
      Message message(type);
      for (const Field& field : type.fields()) {
        if (field.is_sequence()) {
          ASSERT_TRUE(message->resize(field, random.below(3)).ok());
        }
      }
      message.serialize(bytes);
      bytes = mutate(bytes, random);
      std::size_t position = 0;
      const auto result = Message::deserialize(type, std::as_bytes(std::span(bytes)), position);
      (result ? read : refused)++;
      EXPECT_LE(position, bytes.size());
      if (!result) continue;
      std::string again;
      result->serialize(again);
      EXPECT_EQ(again, bytes.substr(0, position)) << "bytes and message are one to one";
    }
  }
  EXPECT_GT(read, 50);
  EXPECT_GT(refused, 100);
}

TEST(Robustness, MutatedYamlIsAMessageOrAnError) {
  Registry registry;
  add_interfaces(registry);
  const MessageType& type = **registry.message("rcl_interfaces/msg/ParameterDescriptor");
  const std::string good =
      "name: a\ntype: 3\nread_only: true\nfloating_point_range: [{from_value: 1.5, to_value: .inf, step: 0}]\n"
      "integer_range:\n- from_value: -1\n  to_value: 5\n  step: 1\n";
  RandomStream random(3, "yaml");
  int read = 0;
  for (int i = 0; i < 2000; ++i) read += Message::from_yaml(type, mutate(good, random)).ok();
  EXPECT_GT(read, 20);
  EXPECT_LT(read, 1950);
}

}  // namespace
}  // namespace cxlab::bus
