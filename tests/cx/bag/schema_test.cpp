// Definitions of a bag against those of the workspace: what differs is named, and what recorders write in another way
// is the same.

#include "cx/bag/schema.h"

#include <gtest/gtest.h>

#include "cx/bus/cdr.h"
#include "tests/support/bus_test.h"

namespace cxlab::bag {

namespace {

class SchemaTest : public bus::BusTest {
 protected:
  const bus::MessageType& type(const std::string& name) { return **registry_.message(name); }
  static std::string block(const std::string& head, const std::string& text) {
    return std::string(80, '=') + '\n' + head + '\n' + text;
  }
};

TEST_F(SchemaTest, EachDefinitionIsLikeItself) {
  int types = 0;
  for (const std::string& package : registry_.packages())
    for (const std::string& name : registry_.interfaces(package)) {
      if (name.find("/msg/") == name.npos) continue;
      const std::string text = bus::ros2msg_schema(type(name));
      EXPECT_EQ(Schema(text).difference(type(name)), "") << name;
      ++types;
    }
  EXPECT_GT(types, 100);
}

TEST_F(SchemaTest, TheFirstDifferenceIsNamed) {
  struct Row {
    const char* type;
    std::string text, difference;
  };
  const Row rows[]{
      {"std_msgs/msg/String", "string data\n", ""},
      {"std_msgs/msg/String", "# a comment\nstring data  # more\nint8 A=3\n", ""},
      {"std_msgs/msg/String", "", ""},
      {"std_msgs/msg/String", "no definition at all", ""},
      {"std_msgs/msg/String", "wstring data\n",
       "field 1 of std_msgs/String is 'wstring data' in the bag and 'string data' in the workspace"},
      {"std_msgs/msg/String", "string text\n",
       "field 1 of std_msgs/String is 'string text' in the bag and 'string data' in the workspace"},
      {"std_msgs/msg/String", "string<=5 data\n",
       "field 1 of std_msgs/String is 'string<=5 data' in the bag and 'string data' in the workspace"},
      {"std_msgs/msg/String", "string data\nint8 more\n",
       "field 2 of std_msgs/String is 'int8 more' in the bag, and is not there in the workspace"},
      {"std_msgs/msg/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\n",
       "field 4 of std_msgs/ColorRGBA is 'float32 a' in the workspace, and is not there in the bag"},
      {"std_msgs/msg/Float64MultiArray", "MultiArrayLayout layout\nfloat64[3] data\n",
       "field 2 of std_msgs/Float64MultiArray is 'float64[3] data' in the bag and 'float64[] data' in the workspace"},
      {"std_msgs/msg/Byte", "uint8 data\n", ""},  // as rosbags writes it
      {"std_msgs/msg/Byte", "int8 data\n",
       "field 1 of std_msgs/Byte is 'int8 data' in the bag and 'byte data' in the workspace"},
      {"std_msgs/msg/Empty", "uint8 structure_needs_at_least_one_member\n", ""},
      // Nested: names as people write them, and a difference below.
      {"geometry_msgs/msg/PoseStamped", "Header header\nPose pose\n", ""},
      {"geometry_msgs/msg/PoseStamped", "std_msgs/msg/Header header\ngeometry_msgs/msg/Pose pose\n", ""},
      {"geometry_msgs/msg/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Point pose\n",
       "field 2 of geometry_msgs/PoseStamped is 'geometry_msgs/Point pose' in the bag and 'geometry_msgs/Pose pose' in "
       "the "
       "workspace"},
      {"geometry_msgs/msg/PoseStamped",
       "std_msgs/Header header\nPose pose\n" +
           block("MSG: geometry_msgs/Pose", "Point position\nQuaternion orientation\n") +
           block("MSG: geometry_msgs/msg/Point", "float64 x\nfloat64 y\nfloat32 z\n"),
       "field 3 of geometry_msgs/Point is 'float32 z' in the bag and 'float64 z' in the workspace"},
  };
  for (const Row& row : rows) EXPECT_EQ(Schema(row.text).difference(type(row.type)), row.difference) << row.text;
}

TEST_F(SchemaTest, PartsOfServicesAndActionsAreFoundByTheirNames) {
  struct Row {
    const char* part;
    std::string text, difference;
  };
  const std::string event = "service_msgs/ServiceEventInfo info\nstd_srvs/SetBool_Request[<=1] request\n";
  const Row rows[]{
      // As cxlab writes it, and as rosbag2 does: the file of the service.
      {"std_srvs/srv/SetBool_Request", event + block("MSG: std_srvs/SetBool_Request", "bool data\n"), ""},
      {"std_srvs/srv/SetBool_Request", event + block("MSG: std_srvs/SetBool_Request", "int8 data\n"),
       "field 1 of std_srvs/SetBool_Request is 'int8 data' in the bag and 'bool data' in the workspace"},
      {"std_srvs/srv/SetBool_Request",
       block("SRV: std_srvs/srv/SetBool", "bool data\n---\nbool success\nstring message\n"), ""},
      {"std_srvs/srv/SetBool_Response",
       block("SRV: std_srvs/srv/SetBool", "bool data\n---\nbool success\nstring message\n"), ""},
      {"std_srvs/srv/SetBool_Response",
       block("SRV: std_srvs/srv/SetBool", "bool data\n---\nbool success\nstring text\n"),
       "field 2 of std_srvs/SetBool_Response is 'string text' in the bag and 'string message' in the workspace"},
      {"std_srvs/srv/SetBool_Response", block("SRV: std_srvs/srv/Other", "bool data\n---\nint8 a\n"), ""},
      {"example_interfaces/action/Fibonacci_Goal",
       block("ACTION: example_interfaces/action/Fibonacci",
             "int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n"),
       ""},
      {"example_interfaces/action/Fibonacci_Feedback",
       block("ACTION: example_interfaces/action/Fibonacci",
             "int32 order\n---\nint32[] sequence\n---\nint32[] partial\n"),
       "field 1 of example_interfaces/Fibonacci_Feedback is 'int32[] partial' in the bag and 'int32[] sequence' in the "
       "workspace"},
      {"example_interfaces/action/Fibonacci_Result",
       block("ACTION: example_interfaces/action/Fibonacci",
             "int32 order\n---\nint64[] sequence\n---\nint32[] sequence\n"),
       "field 1 of example_interfaces/Fibonacci_Result is 'int64[] sequence' in the bag and 'int32[] sequence' in the "
       "workspace"},
  };
  for (const Row& row : rows)
    EXPECT_EQ(Schema(row.text).difference_of_part(type(row.part)), row.difference) << row.text;
}

}  // namespace

}  // namespace cxlab::bag
