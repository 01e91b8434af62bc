#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Calls functions of the plugin directly.
class Fields : public ::testing::Test {
 protected:
  void SetUp() override {
    lab_.options.strict = strict_;
    lab_.agent("");
    packages_ =
        lab_.write(
                "test_msgs/msg/All.msg",
                "bool b\nbyte y\nchar c\nint8 i8\nuint8 u8\nint64 i64\nuint64 u64\nfloat32 f32\nfloat64 f64\nstring s\n"
                "geometry_msgs/Point p\nbool[] bs\nint32[] is\nfloat64[3] fixed\nint8[<=2] few\nstring[] "
                "ss\ngeometry_msgs/Point[] ps\nchar[] cs\n")
            .parent_path()
            .parent_path();
    lab_.write("test_msgs/msg/Spot.msg", "float64 x\nfloat64 y\nfloat64 z\n");
    lab_.write("test_msgs/msg/Swapped.msg", "float64 y\nfloat64 x\nfloat64 z\n");
    lab_.write("test_msgs/msg/Short.msg", "float64 x\nfloat64 y\n");
    lab_.write("test_msgs/msg/Single.msg", "float32 x\nfloat64 y\nfloat64 z\n");
    lab_.write("test_msgs/msg/Path.msg", "string name\nSpot[] spots\n");
    lab_.write("test_msgs/msg/Track.msg", "string name\ngeometry_msgs/Point[] spots\n");
    lab_.write("test_msgs/msg/Bounded.msg", "string name\ngeometry_msgs/Point[<=3] spots\n");
    lab_.write("test_msgs/msg/Trip.msg", "Track track\n");
    ASSERT_TRUE(lab_.registry.add_package("test_msgs", packages_).ok());
    lab_.options.stop_on_rule_error = false;
    lab_.run_up();
    ASSERT_TRUE(lab_.engine().build("(defglobal ?*m* = (ros-msgs-create-message \"test_msgs/msg/All\"))").ok());
  }
  /// The field after setting it, printed; or the error.
  std::string set(const std::string& field, const std::string& value) {
    auto done = lab_.engine().eval("(ros-msgs-set-field ?*m* \"" + field + "\" " + value + ")");
    const auto errors = lab_.engine().take_errors();
    if (!errors.empty()) return errors[0].detail;
    if (!done) return done.error().message;
    return get("?*m*", field);
  }
  std::string get(const std::string& message, const std::string& field) {
    auto value = lab_.engine().eval("(ros-msgs-get-field " + message + " \"" + field + "\")");
    const auto errors = lab_.engine().take_errors();
    if (!errors.empty()) return errors[0].detail;
    return value ? value->print() : value.error().message;
  }

  /// A message whose x is 1.
  static std::string filled(const std::string& type) {
    return "(progn (bind ?*o* (ros-msgs-create-message \"" + type + "\")) (ros-msgs-set-field ?*o* x 1.0) ?*o*)";
  }

  Lab lab_;
  std::filesystem::path packages_;
  bool strict_ = false;
};

TEST_F(Fields, AMessageOfAnotherTypeWithTheSameFieldsIsTakenWithAWarning) {
  ASSERT_TRUE(lab_.engine().build("(defglobal ?*o* = 0)").ok());
  set("p", filled("test_msgs/msg/Spot"));
  EXPECT_EQ(get("(ros-msgs-get-field ?*m* p)", "x"), "1.0");
  set("ps", "(create$ " + filled("geometry_msgs/msg/Point") + ' ' + filled("geometry_msgs/msg/Vector3") + ')');
  EXPECT_EQ(get("(nth$ 2 (ros-msgs-get-field ?*m* ps))", "x"), "1.0");
  set("ps", "(create$ " + filled("geometry_msgs/msg/Vector3") + ')');
  const std::string end = ", expected geometry_msgs/msg/Point: it has the same fields, so it is accepted";
  EXPECT_THAT(lab_.log.with("warn "),
              ElementsAre("warn ros_msgs: found a message of type test_msgs/msg/Spot" + end,
                          "warn ros_msgs: found a message of type geometry_msgs/msg/Vector3" + end))
      << "once for each type";
  EXPECT_EQ(get("?*o*", "x"), "1.0") << "it is copied";
}

TEST_F(Fields, NamesTypesAndOrderOfAllFieldsMustAgreeAtEachDepth) {
  ASSERT_TRUE(lab_.engine().build("(defglobal ?*o* = 0)").ok());
  for (const char* type : {"test_msgs/msg/Swapped", "test_msgs/msg/Short", "test_msgs/msg/Single"})
    EXPECT_THAT(set("p", filled(type)), HasSubstr("expected geometry_msgs/msg/Point")) << type;
  ASSERT_TRUE(lab_.engine().build("(defglobal ?*m* = (ros-msgs-create-message \"test_msgs/msg/Trip\"))").ok());
  const auto path = [](const std::string& type) {
    return "(progn (bind ?*o* (ros-msgs-create-message \"test_msgs/msg/" + type +
           "\")) (ros-msgs-set-field ?*o* name way) (ros-msgs-set-field ?*o* spots (create$ " +
           "(ros-msgs-create-message \"geometry_msgs/msg/Point\"))) ?*o*)";
  };
  set("track", path("Path"));
  EXPECT_EQ(get("(ros-msgs-get-field ?*m* track)", "name"), "\"way\"");
  EXPECT_EQ(lab_.engine().eval("(length$ (ros-msgs-get-field (ros-msgs-get-field ?*m* track) spots))")->print(), "1");
  EXPECT_THAT(set("track", path("Bounded")), HasSubstr("expected test_msgs/msg/Track"));
}

class StrictFields : public Fields {
 protected:
  StrictFields() { strict_ = true; }
};

TEST_F(StrictFields, AMessageOfAnotherTypeIsAnError) {
  ASSERT_TRUE(lab_.engine().build("(defglobal ?*o* = 0)").ok());
  EXPECT_THAT(set("p", filled("test_msgs/msg/Spot")),
              HasSubstr("found a message of type test_msgs/msg/Spot, expected geometry_msgs/msg/Point, and --strict-cx "
                        "takes no other type"));
  EXPECT_EQ(get("(ros-msgs-get-field ?*m* p)", "x"), "0.0");
}

TEST_F(Fields, DefaultsAreZero) {
  EXPECT_EQ(get("?*m*", "b"), "FALSE");
  EXPECT_EQ(get("?*m*", "i64"), "0");
  EXPECT_EQ(get("?*m*", "f32"), "0.0");
  EXPECT_EQ(get("?*m*", "s"), "\"\"");
  EXPECT_EQ(get("?*m*", "is"), "()");
  EXPECT_EQ(get("?*m*", "fixed"), "(0.0 0.0 0.0)");
}

TEST_F(Fields, EveryTypeComesBack) {
  EXPECT_EQ(set("b", "TRUE"), "TRUE");
  EXPECT_EQ(set("b", "\"TRUE\""), "TRUE");
  EXPECT_EQ(set("b", "no"), "FALSE");
  EXPECT_EQ(set("y", "255"), "255");
  EXPECT_EQ(set("c", "\"x\""), "\"x\"");
  EXPECT_EQ(set("i8", "-128"), "-128");
  EXPECT_EQ(set("u8", "255"), "255");
  EXPECT_EQ(set("i64", "-9223372036854775808"), "-9223372036854775808");
  EXPECT_EQ(set("f32", "0.5"), "0.5");
  EXPECT_EQ(set("f64", "0.1"), "0.1");
  EXPECT_EQ(set("s", "symbol"), "\"symbol\"");
  EXPECT_EQ(set("s", "\"a text\""), "\"a text\"");
}

TEST_F(Fields, ArraysComeBack) {
  EXPECT_EQ(set("bs", "(create$ TRUE FALSE)"), "(TRUE FALSE)");
  EXPECT_EQ(set("is", "(create$ 1 2 3)"), "(1 2 3)");
  EXPECT_EQ(set("is", "(create$)"), "()");
  EXPECT_EQ(set("fixed", "(create$ 1.5 2 3.0)"), "(1.5 2.0 3.0)");
  EXPECT_EQ(set("ss", "(create$ a \"b c\")"), "(\"a\" \"b c\")");
  EXPECT_EQ(set("cs", "(create$ \"a\" b)"), "(\"a\" \"b\")");
}

TEST_F(Fields, NumbersAreConvertedWhereExact) {
  EXPECT_EQ(set("f64", "3"), "3.0");
  EXPECT_EQ(set("f32", "16777216"), "16777216.0");
  EXPECT_EQ(set("i64", "3.0"), "3");
  EXPECT_EQ(set("is", "(create$ 1.0 2)"), "(1 2)");
  EXPECT_EQ(set("u64", "18446744073709549568.0"), "-2048") << "wraps as it is read";
  EXPECT_EQ(set("u64", "-1"), "-1") << "what was read can be set";
  EXPECT_THAT(set("u64", "18446744073709551616.0"), HasSubstr("expected a whole number"));
}

TEST_F(Fields, NumbersThatDoNotFitAreReported) {
  EXPECT_THAT(
      set("i64", "3.5"),
      HasSubstr("Failed to set field i64: found 3.5, expected a whole number (int64 i64 of test_msgs/msg/All)"));
  EXPECT_THAT(set("f32", "16777217"), HasSubstr("holds exactly"));
  EXPECT_THAT(set("f64", "9007199254740993"), HasSubstr("holds exactly"));
  EXPECT_THAT(set("f64", "9223372036854775807"), HasSubstr("holds exactly"));
  EXPECT_THAT(set("f32", "1e300"), HasSubstr("range of float32"));
  EXPECT_THAT(set("u8", "256"), HasSubstr("Failed to set field u8"));
  EXPECT_THAT(set("i8", "-129"), HasSubstr("Failed to set field i8"));
}

TEST_F(Fields, OtherMismatchesAreReported) {
  EXPECT_THAT(set("f64", "abc"), HasSubstr("expected a number"));
  EXPECT_THAT(set("s", "5"), HasSubstr("expected a STRING or SYMBOL"));
  EXPECT_THAT(set("b", "1"), HasSubstr("expected TRUE or FALSE"));
  EXPECT_THAT(set("c", "\"ab\""), HasSubstr("expected one character"));
  EXPECT_THAT(set("fixed", "(create$ 1.0 2.0)"), HasSubstr("found 2 values, expected exactly 3"));
  EXPECT_THAT(set("few", "(create$ 1 2 3)"), HasSubstr("Failed to set field few"));
  EXPECT_THAT(set("p", "(ros-msgs-create-message \"std_msgs/msg/Empty\")"),
              HasSubstr("expected geometry_msgs/msg/Point"));
  EXPECT_THAT(get("(ros-msgs-create-message \"std_msgs/msg/Int32\")", "data"), "0");
  EXPECT_THAT(get("(ros-msgs-create-message \"geometry_msgs/msg/Point\")", "position"),
              HasSubstr("geometry_msgs/msg/Point has no field 'position'; it has x, y, z"));
}

TEST_F(Fields, WhereCxLogsAndGoesOnTheRuleGoesOn) {
  const auto errors = [this](const std::string& actions) {
    lab_.log.lines.clear();
    EXPECT_TRUE(
        lab_.engine().build("(defrule goes-on (go) => " + actions + " (println \"went on\"))", "agent.clp", 7).ok());
    EXPECT_TRUE(lab_.engine().assert_string("(go)").ok());
    lab_.ticks(6);
    EXPECT_TRUE(lab_.engine().eval("(undefrule goes-on)").ok());
    EXPECT_TRUE(lab_.engine().eval("(do-for-all-facts ((?f go)) TRUE (retract ?f))").ok());
    EXPECT_EQ(lab_.log.with("went on").size(), 1U) << actions;
    return lab_.log.with("error ");
  };
  const auto told = [](const std::string& function, const std::string& text) {
    return "error main: agent.clp:7: rule goes-on, RHS: [CXLAB1] Function '" + function + "': " + text;
  };
  EXPECT_THAT(errors("(println \"got \" (ros-msgs-get-field ?*m* i65))"),
              ElementsAre("error ros_msgs: Failed to retrieve field i65",
                          told("ros-msgs-get-field", "test_msgs/msg/All has no field 'i65', did you mean 'i64'?")));
  EXPECT_EQ(lab_.log.with("got FALSE").size(), 1U) << "CX gives what is not defined";
  EXPECT_THAT(errors("(ros-msgs-set-field ?*m* i65 1)"),
              ElementsAre("error ros_msgs: Failed to set field i65",
                          told("ros-msgs-set-field", "test_msgs/msg/All has no field 'i65', did you mean 'i64'?")));
  EXPECT_THAT(
      errors("(ros-msgs-set-field ?*m* is 1)"),
      ElementsAre("error ros_msgs: expected multifield value!",
                  told("ros-msgs-set-field", "found 1, expected a multifield (int32[] is of test_msgs/msg/All)")));
  EXPECT_THAT(errors("(ros-msgs-set-field ?*m* p x)"),
              ElementsAre("error ros_msgs: Failed to set unknown message",
                          told("ros-msgs-set-field",
                               "found an unknown message pointer (geometry_msgs/msg/Point p of test_msgs/msg/All)")));
  EXPECT_EQ(errors("(ros-msgs-set-field ?*m* ps (create$ 1))").size(), 2U);
  EXPECT_EQ(get("?*m*", "ps"), "()") << "nothing is set by half";
}

TEST_F(Fields, AnInvalidPointerEndsTheRule) {
  EXPECT_THAT(set("s", "x"), "\"x\"");
  ASSERT_TRUE(lab_.engine().eval("(ros-msgs-destroy-message ?*m*)").ok());
  EXPECT_THAT(get("?*m*", "s"), HasSubstr("Failed to retrieve field s: invalid message pointer"));
  EXPECT_THAT(set("s", "x"), HasSubstr("Failed to set field s: invalid message pointer"));
}

TEST_F(Fields, ANameIsLookedUpForEachTypeThatACallSiteMeets) {
  ASSERT_TRUE(lab_.engine().build("(deffunction data (?m) (ros-msgs-get-field ?m data))").ok());
  EXPECT_EQ(lab_.engine().eval("(data (ros-msgs-create-message \"std_msgs/msg/Int32\"))")->print(), "0");
  EXPECT_EQ(lab_.engine().eval("(data (ros-msgs-create-message \"std_msgs/msg/String\"))")->print(), "\"\"");
  EXPECT_EQ(lab_.engine().eval("(data (ros-msgs-create-message \"std_msgs/msg/Int32\"))")->print(), "0");
}

TEST_F(Fields, ALongArrayOfMessagesGivesTheSameHandlesAgain) {
  ASSERT_TRUE(lab_.engine()
                  .build("(deffunction many (?n) (bind ?l (create$)) (bind ?p (ros-msgs-create-message "
                         "\"geometry_msgs/msg/Point\"))"
                         " (loop-for-count (?i ?n) (ros-msgs-set-field ?p x ?i) (bind ?l ?l ?p) ) (ros-msgs-set-field "
                         "?*m* ps ?l) (ros-msgs-destroy-message ?p))")
                  .ok());
  ASSERT_TRUE(lab_.engine().eval("(many 500)").ok());
  const std::string first = get("?*m*", "ps");
  EXPECT_EQ(get("?*m*", "ps"), first);
  EXPECT_NE(get("?*m*", "p"), get("(nth$ 1 (ros-msgs-get-field ?*m* ps))", "x"));
  ASSERT_TRUE(lab_.engine().eval("(ros-msgs-destroy-message (nth$ 3 (ros-msgs-get-field ?*m* ps)))").ok());
  EXPECT_NE(get("?*m*", "ps"), first) << "a handle that was destroyed is never used again";
  EXPECT_EQ(get("(nth$ 3 (ros-msgs-get-field ?*m* ps))", "x"), "500.0");
}

TEST_F(Fields, ANestedMessageIsAHandleIntoItsParent) {
  ASSERT_TRUE(lab_.engine().build("(defglobal ?*p* = (ros-msgs-get-field ?*m* p))").ok());
  ASSERT_TRUE(lab_.engine().eval("(ros-msgs-set-field ?*p* x 2.5)").ok());
  EXPECT_EQ(get("(ros-msgs-get-field ?*m* p)", "x"), "2.5");
  ASSERT_TRUE(lab_.engine().eval("(ros-msgs-destroy-message ?*m*)").ok());
  EXPECT_THAT(get("?*p*", "x"), HasSubstr("invalid message pointer"));
}

TEST_F(Fields, MessagesAreCopiedIn) {
  ASSERT_TRUE(lab_.engine().build("(defglobal ?*p* = (ros-msgs-create-message \"geometry_msgs/msg/Point\"))").ok());
  ASSERT_TRUE(lab_.engine().eval("(ros-msgs-set-field ?*p* x 1.0)").ok());
  set("p", "?*p*");
  set("ps", "(create$ ?*p* ?*p*)");
  ASSERT_TRUE(lab_.engine().eval("(ros-msgs-set-field ?*p* x 2.0)").ok());
  EXPECT_EQ(get("(ros-msgs-get-field ?*m* p)", "x"), "1.0");
  EXPECT_EQ(get("(nth$ 2 (ros-msgs-get-field ?*m* ps))", "x"), "1.0");
}

TEST_F(Fields, ElementsMayMoveWithinTheirOwnArray) {
  ASSERT_TRUE(lab_.engine()
                  .build("(deffunction point (?x) (bind ?p (ros-msgs-create-message \"geometry_msgs/msg/Point\")) "
                         "(ros-msgs-set-field ?p x ?x) ?p)")
                  .ok());
  set("ps", "(create$ (point 1.0) (point 2.0) (point 3.0))");
  set("ps", "(rest$ (ros-msgs-get-field ?*m* ps))");
  EXPECT_EQ(get("(nth$ 1 (ros-msgs-get-field ?*m* ps))", "x"), "2.0");
  EXPECT_EQ(get("(nth$ 2 (ros-msgs-get-field ?*m* ps))", "x"), "3.0");
}

TEST_F(Fields, AHandleBeyondAShorterArrayIsInvalid) {
  set("ps", "(create$ (ros-msgs-create-message \"geometry_msgs/msg/Point\"))");
  ASSERT_TRUE(lab_.engine().build("(defglobal ?*e* = (nth$ 1 (ros-msgs-get-field ?*m* ps)))").ok());
  set("ps", "(create$)");
  EXPECT_THAT(get("?*e*", "x"), HasSubstr("invalid message pointer"));
}

/// An expression for a value of the field, and how it prints when it comes back; empty for messages, whose fields
/// follow.
std::pair<std::string, std::string> sample(const bus::Field& field) {
  using T = bus::FieldType;
  switch (field.type) {
    case T::kBool: return {"TRUE", "TRUE"};
    case T::kChar: return {"\"z\"", "\"z\""};
    case T::kFloat32:
    case T::kFloat64: return {"-0.5", "-0.5"};
    case T::kString:
    case T::kWstring: return {"two", "\"two\""};
    case T::kMessage: return {"(ros-msgs-create-message \"" + field.nested->name() + "\")", ""};
    default: return {"101", "101"};
  }
}

TEST_F(Fields, EachFieldOfEachInterfaceIsSetAndRead) {
  std::vector<std::string> types;
  for (const std::string& package : lab_.registry.packages())
    for (const std::string& interface : lab_.registry.interfaces(package)) {
      const bool service = interface.find("/srv/") != std::string::npos,
                 action = interface.find("/action/") != std::string::npos;
      if (!service && !action) types.push_back(interface);
      for (const char* part : {"_Request", "_Response"})
        if (service) types.push_back(interface + part);
      for (const char* part : {"_Goal", "_Result", "_Feedback"})
        if (action) types.push_back(interface + part);
    }
  ASSERT_TRUE(lab_.engine().build("(defglobal ?*x* = nil)").ok());
  std::size_t fields = 0;
  for (const std::string& name : types) {
    const auto type = lab_.registry.message(name);
    ASSERT_TRUE(type.ok()) << type.error().text();
    ASSERT_TRUE(lab_.engine().eval("(bind ?*x* (ros-msgs-create-message \"" + name + "\"))").ok());
    for (const bus::Field& field : (*type)->fields()) {
      const auto [value, printed] = sample(field);
      const std::size_t size = field.array == bus::ArrayKind::kFixed ? field.size_limit : 1;
      std::string set = value, expected = printed;
      if (field.array != bus::ArrayKind::kSingle) {
        set = "(create$", expected = "(";
        for (std::size_t i = 0; i < size; ++i) set += ' ' + value, expected += (i == 0 ? "" : " ") + printed;
        set += ')', expected += ')';
      }
      ASSERT_TRUE(lab_.engine().eval("(ros-msgs-set-field ?*x* " + field.name + ' ' + set + ")").ok())
          << name << ' ' << field.name;
      EXPECT_TRUE(lab_.engine().take_errors().empty()) << name << ' ' << field.name;
      const std::string found = get("?*x*", field.name);
      if (field.is_message())
        EXPECT_THAT(found, HasSubstr("<Pointer-C-")) << name << ' ' << field.name;
      else
        EXPECT_EQ(found, expected) << name << ' ' << field.name;
      ++fields;
    }
    ASSERT_TRUE(lab_.engine().eval("(ros-msgs-destroy-message ?*x*)").ok());
  }
  EXPECT_GT(fields, 700u);
}

}  // namespace
}  // namespace cxlab::cx
