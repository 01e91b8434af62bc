#include "cx/network/network.h"
#include "cx/protobuf/wire.h"
#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr const char* kProto = R"(syntax = "proto2";
package t;
enum Color { RED = 0; BLUE = 5; }
message Part { optional int32 size = 1; optional Part inner = 2; }
message All {
  enum CompType { COMP_ID = 7; MSG_TYPE = 9; }
  optional double d = 1; optional float f = 2;
  optional int64 i64 = 3; optional uint64 u64 = 4; optional int32 i32 = 5; optional uint32 u32 = 6;
  optional fixed64 x64 = 7; optional fixed32 x32 = 8; optional sfixed32 sx32 = 9; optional sfixed64 sx64 = 10;
  optional sint32 s32 = 11; optional sint64 s64 = 12;
  optional bool b = 13; optional string s = 14; optional bytes raw = 15; optional Color color = 16;
  optional Part part = 17;
  repeated int32 numbers = 18; repeated Part parts = 19; repeated Color colors = 20; repeated string words = 21;
}
message Strict { enum CompType { COMP_ID = 7; MSG_TYPE = 10; } required int32 needed = 1; }
)";

/// Environments "main" and "other", each with the plugin; the other sends what the test says.
class Protobuf : public ::testing::Test {
 protected:
  void SetUp() override {
    lab_.options.stop_on_rule_error = false;
    lab_.write("agent/proto/all.proto", kProto);
    config("cx::ProtobufPlugin, proto_paths: [\"proto\"], pkg_share_dirs: [\"agent\"]");
    lab_.write("agent/rules.clp", "(deffacts start (here))");
  }
  void config(const std::string& plugin) {
    lab_.config(
        "environments: [\"main\", \"other\"]\n"
        "main: {plugins: [\"protobuf\", \"files\"]}\nother: {plugins: [\"protobuf\"]}\nprotobuf: {plugin: " +
        plugin + "}\nfiles: {plugin: \"cx::FileLoadPlugin\", pkg_share_dirs: [\"agent\"], load: [\"rules.clp\"]}");
  }
  /// Without an executive: facts stay until the test runs the rules.
  void run_up() { lab_.run_up(); }

  std::string eval(const std::string& expression, const std::string& environment = "main") {
    const auto value = lab_.engine(environment).eval(expression);
    return value ? value->print() : "error";
  }
  std::string failing(const std::string& expression) {
    EXPECT_EQ(eval(expression), "error") << expression;
    const auto errors = lab_.engine().take_errors();
    return errors.empty() ? "none" : errors.front().message;
  }
  std::vector<std::string> logged() {
    auto lines = std::exchange(lab_.log.lines, {});
    std::erase_if(lines, [](const std::string& l) { return !l.starts_with("warn ") && !l.starts_with("error "); });
    return lines;
  }
  /// A message in ?*m*.
  void message(const std::string& type) {
    if (!lab_.engine().has("defglobal", "m")) {
      ASSERT_TRUE(lab_.engine().build("(defglobal ?*m* = nil)").ok());
    }
    ASSERT_NE(eval("(bind ?*m* (pb-create \"" + type + "\"))"), "error");
  }
  std::string set(const std::string& field, const std::string& value) {
    if (eval("(pb-set-field ?*m* " + field + ' ' + value + ')') == "error") {
      lab_.engine().take_errors();
      return "error";
    }
    return eval("(pb-field-value ?*m* " + field + ')');
  }
  std::vector<std::string> take(const std::string& fact) {
    lab_.ticks(1);
    return lab_.facts(fact);
  }

  Lab lab_;
};

// --- Messages

TEST_F(Protobuf, FieldsOfAllTypesComeBack) {
  run_up();
  message("t.All");
  EXPECT_EQ(set("d", "0.5"), "0.5");
  EXPECT_EQ(set("f", "0.25"), "0.25");
  EXPECT_EQ(set("i64", "-9223372036854775807"), "-9223372036854775807");
  EXPECT_EQ(set("u64", "-1"), "-1");  // wraps, as INTEGERs do
  EXPECT_EQ(set("i32", "-2147483648"), "-2147483648");
  EXPECT_EQ(set("u32", "4294967295"), "4294967295");
  EXPECT_EQ(set("x64", "3"), "3");
  EXPECT_EQ(set("x32", "4"), "4");
  EXPECT_EQ(set("sx32", "-5"), "-5");
  EXPECT_EQ(set("sx64", "-6"), "-6");
  EXPECT_EQ(set("s32", "-7"), "-7");
  EXPECT_EQ(set("s64", "-8"), "-8");
  EXPECT_EQ(set("b", "TRUE"), "TRUE");
  EXPECT_EQ(set("b", "no"), "FALSE");
  EXPECT_EQ(set("s", "\"a word\""), "\"a word\"");
  EXPECT_EQ(set("s", "symbol"), "\"symbol\"");
  EXPECT_EQ(set("color", "BLUE"), "BLUE");
  EXPECT_EQ(set("color", "\"RED\""), "RED");
  EXPECT_THAT(logged(), IsEmpty());
}

TEST_F(Protobuf, NumbersAreConvertedWhereNothingIsLost) {
  run_up();
  message("t.All");
  EXPECT_EQ(set("d", "3"), "3.0");
  EXPECT_EQ(set("f", "3"), "3.0");
  EXPECT_EQ(set("i32", "4.0"), "4");
  EXPECT_THAT(failing("(pb-set-field ?*m* i32 4.5)"),
              HasSubstr("Function 'pb-set-field': t.All.i32: found 4.5, expected a whole number that int32 can hold"));
  EXPECT_THAT(failing("(pb-set-field ?*m* u32 -1)"), HasSubstr("found -1, expected a whole number that uint32"));
  EXPECT_THAT(failing("(pb-set-field ?*m* i32 2147483648)"), HasSubstr("found 2147483648"));
  EXPECT_THAT(failing("(pb-set-field ?*m* i64 1e19)"), HasSubstr("found 1e+19"));
  EXPECT_THAT(failing("(pb-set-field ?*m* d word)"), HasSubstr("found word, expected a number"));
  EXPECT_THAT(failing("(pb-set-field ?*m* b 1)"), HasSubstr("found 1, expected TRUE or FALSE"));
  EXPECT_THAT(failing("(pb-set-field ?*m* s 1)"), HasSubstr("found 1, expected a STRING or SYMBOL"));
  EXPECT_EQ(eval("(pb-field-value ?*m* i32)"), "4");
}

TEST_F(Protobuf, StrictCxConvertsNoNumber) {
  lab_.options.strict = true;
  run_up();
  message("t.All");
  for (const char* field : {"d", "f"}) {
    EXPECT_EQ(set(field, "3.0"), "3.0");
    EXPECT_THAT(
        failing("(pb-set-field ?*m* " + std::string(field) + " 4)"),
        HasSubstr("t.All." + std::string(field) + ": found 4, expected a FLOAT: CX converts no INTEGER (--strict-cx)"));
    EXPECT_EQ(eval("(pb-field-value ?*m* " + std::string(field) + ')'), "3.0");
  }
  for (const char* field : {"i32", "i64", "u32", "u64", "x64", "x32", "sx32", "sx64", "s32", "s64"}) {
    EXPECT_EQ(set(field, "3"), "3");
    EXPECT_THAT(failing("(pb-set-field ?*m* " + std::string(field) + " 4.0)"),
                HasSubstr("found 4.0, expected an INTEGER: CX converts no FLOAT (--strict-cx)"));
  }
  EXPECT_THAT(failing("(pb-add-list ?*m* numbers 4.0)"), HasSubstr("expected an INTEGER"));
  EXPECT_EQ(eval("(pb-field-list ?*m* numbers)"), "()");
}

TEST_F(Protobuf, StrictCxReportsMessagesThatRulesLeave) {
  lab_.options.strict = true;
  run_up();
  eval("(pb-peer-create-local \"127.0.0.1\" 1 4444)");
  eval("(pb-peer-create-local \"127.0.0.1\" 4444 1)", "other");
  message("t.All");
  eval("(pb-broadcast 1 ?*m*)");
  eval("(pb-field-value ?*m* part)");
  eval("(pb-create \"t.Part\")");
  eval("(pb-destroy (pb-create \"t.Strict\"))");
  lab_.ticks(1);
  ASSERT_THAT(lab_.facts("protobuf-msg", "other"), SizeIs(1)) << "no run has seen it: CX would destroy it";
  ASSERT_TRUE(lab_.manager->unload_plugin("other", "protobuf").ok());
  ASSERT_TRUE(lab_.manager->unload_plugin("main", "protobuf").ok());
  std::vector<std::string> found;
  for (const Error& error : lab_.manager->load_errors()) found.push_back(error.text());
  EXPECT_THAT(found,
              ElementsAre("strict-cx: leak: protobuf: environment main has not destroyed 1 message(s) of type t.All",
                          "strict-cx: leak: protobuf: environment main has not destroyed 2 message(s) of type t.Part"));
}

TEST_F(Protobuf, MissingNamesAreReported) {
  run_up();
  message("t.All");
  EXPECT_EQ(eval("(pb-field-value ?*m* d)"), "NOT-SET");
  EXPECT_EQ(eval("(pb-field-value ?*m* nope)"), "DOES-NOT-EXIST");
  EXPECT_EQ(eval("(pb-field-list ?*m* nope)"), "DOES-NOT-EXIST");
  EXPECT_EQ(eval("(pb-field-type ?*m* nope)"), "DOES-NOT-EXIST");
  EXPECT_EQ(eval("(pb-field-label ?*m* nope)"), "DOES-NOT-EXIST");
  EXPECT_THAT(logged(), ElementsAre("warn protobuf: Field d of t.All is not set",
                                    "warn protobuf: Could not find field nope of t.All",
                                    "warn protobuf: Could not find field nope of t.All"));
  EXPECT_EQ(eval("(pb-has-field ?*m* nope)"), "FALSE");
  EXPECT_EQ(eval("(pb-field-is-list ?*m* nope)"), "FALSE");
  EXPECT_THAT(logged(), IsEmpty());
  eval("(pb-set-field ?*m* nope 1)");
  eval("(pb-add-list ?*m* nope 1)");
  EXPECT_THAT(logged(), SizeIs(2));
  eval("(pb-set-field ?*m* color GREEN)");
  EXPECT_THAT(logged(), ElementsAre("warn protobuf: cannot set invalid enum value GREEN of t.All.color"));
  EXPECT_EQ(eval("(pb-has-field ?*m* color)"), "FALSE");
  eval("(pb-set-field ?*m* raw abc)");  // ignored
  EXPECT_EQ(eval("(pb-has-field ?*m* raw)"), "FALSE");
  EXPECT_THAT(failing("(pb-set-field ?*m* numbers 1)"), HasSubstr("t.All.numbers is a list, use pb-add-list"));
  EXPECT_THAT(failing("(pb-add-list ?*m* d 1)"), HasSubstr("t.All.d is no list, use pb-set-field"));
  EXPECT_THAT(failing("(pb-field-value ?*m* numbers)"), HasSubstr("t.All.numbers is a list, use pb-field-list"));
}

TEST_F(Protobuf, MessagesAreDescribed) {
  run_up();
  message("t.Strict");
  EXPECT_EQ(eval("(pb-field-label ?*m* needed)"), "REQUIRED");
  message("t.All");
  EXPECT_EQ(eval("(subseq$ (pb-field-names ?*m*) 1 3)"), "(d f i64)");
  std::string types;
  for (const char* field : {"d", "f", "i64", "u64", "i32", "x64", "x32", "b", "s", "part", "raw", "u32", "color",
                            "sx32", "sx64", "s32", "s64", "numbers"})
    types += eval(std::string("(pb-field-type ?*m* ") + field + ')') + ' ';
  EXPECT_EQ(types,
            "DOUBLE FLOAT INT64 UINT64 INT32 FIXED64 FIXED32 BOOL STRING MESSAGE BYTES UINT32 ENUM SFIXED32 SFIXED64 "
            "SINT32 SINT64 INT32 ");
  EXPECT_EQ(eval("(pb-field-label ?*m* d)"), "OPTIONAL");
  EXPECT_EQ(eval("(pb-field-label ?*m* numbers)"), "REPEATED");
  EXPECT_EQ(eval("(pb-field-is-list ?*m* numbers)"), "TRUE");
  EXPECT_EQ(eval("(pb-field-is-list ?*m* d)"), "FALSE");
  set("d", "0.5");
  EXPECT_EQ(eval("(pb-has-field ?*m* d)"), "TRUE");
  EXPECT_EQ(eval("(pb-has-field ?*m* numbers)"), "FALSE");
  eval("(pb-add-list ?*m* numbers 3)");
  EXPECT_EQ(eval("(pb-has-field ?*m* numbers)"), "TRUE");
  EXPECT_EQ(eval("(pb-tostring ?*m*)"), "\"d: 0.5 numbers: 3 \"");
}

TEST_F(Protobuf, ListsAreReadAndFilled) {
  run_up();
  message("t.All");
  for (const char* item : {"numbers 3", "numbers -4", "colors BLUE", "words one", "words \"two words\""})
    EXPECT_NE(eval(std::string("(pb-add-list ?*m* ") + item + ')'), "error") << item;
  EXPECT_EQ(eval("(pb-field-list ?*m* numbers)"), "(3 -4)");
  EXPECT_EQ(eval("(pb-field-list ?*m* colors)"), "(BLUE)");
  EXPECT_EQ(eval("(pb-field-list ?*m* words)"), "(\"one\" \"two words\")");
  EXPECT_EQ(eval("(pb-field-list ?*m* parts)"), "()");
  set("d", "0.5");
  EXPECT_EQ(eval("(pb-field-list ?*m* d)"), "(0.5)");
}

TEST_F(Protobuf, MessagesAreCopiedInAndOut) {
  run_up();
  ASSERT_TRUE(lab_.engine().build("(defglobal ?*p* = nil ?*q* = nil)").ok());
  message("t.All");
  eval("(bind ?*p* (pb-create \"t.Part\"))");
  eval("(pb-set-field ?*p* size 3)");
  eval("(pb-set-field ?*m* part ?*p*)");
  eval("(pb-add-list ?*m* parts ?*p*)");
  eval("(pb-set-field ?*p* size 4)");
  eval("(bind ?*q* (pb-field-value ?*m* part))");
  EXPECT_EQ(eval("(pb-field-value ?*q* size)"), "3");
  eval("(pb-set-field ?*q* size 5)");
  eval("(pb-destroy ?*p*)");
  EXPECT_EQ(eval("(pb-tostring ?*m*)"), "\"part {   size: 3 } parts {   size: 3 } \"");
  EXPECT_EQ(eval("(pb-field-value (nth$ 1 (pb-field-list ?*m* parts)) size)"), "3");
  message("t.All");
  EXPECT_EQ(eval("(pb-tostring (pb-field-value ?*m* part))"), "\"\"") << "one that is not set is a new one";
  EXPECT_THAT(failing("(pb-set-field ?*m* part ?*m*)"), HasSubstr("found a message of type t.All, expected t.Part"));
  EXPECT_THAT(failing("(pb-set-field ?*m* part ?*p*)"), HasSubstr("expected a message of type t.Part"));
  EXPECT_THAT(failing("(pb-set-field ?*m* part 3)"), HasSubstr("found 3, expected a message of type t.Part"));
}

TEST_F(Protobuf, MessagesInThemselvesHaveAnEnd) {
  run_up();
  message("t.Part");
  int deep = 0;
  while (deep < 1000 && eval("(pb-set-field ?*m* inner ?*m*)") != "error") ++deep;
  EXPECT_EQ(deep, 99);
  EXPECT_THAT(lab_.engine().take_errors().at(0).message, HasSubstr("more than 100 deep"));
}

TEST_F(Protobuf, AMessageThatIsNoneGivesFalseOrNothing) {
  run_up();
  message("t.Part");
  eval("(pb-destroy ?*m*)");
  eval("(pb-destroy ?*m*)");
  for (const char* call :
       {"(pb-field-names ?*m*)", "(pb-field-type ?*m* size)", "(pb-field-label ?*m* size)", "(pb-has-field ?*m* size)",
        "(pb-field-value ?*m* size)", "(pb-field-list ?*m* size)", "(pb-field-is-list ?*m* size)"})
    EXPECT_EQ(eval(call), "FALSE") << call;
  EXPECT_EQ(eval("(pb-tostring ?*m*)"), "\"\"");
  EXPECT_THAT(logged(), IsEmpty());
  eval("(pb-set-field ?*m* size 1)");
  EXPECT_THAT(logged(), ElementsAre("warn protobuf: pb-set-field: invalid message pointer"));
  EXPECT_EQ(eval("(pb-create \"t.Prt\")"), "<Pointer-C-0x0>");
  EXPECT_THAT(logged(), ElementsAre(HasSubstr("there is no such type, did you mean 't.Part'?")));
}

TEST_F(Protobuf, TypesAreRegistered) {
  run_up();
  EXPECT_EQ(eval("(pb-register-type \"t.All\")"), "TRUE");
  EXPECT_EQ(eval("(pb-register-type t.Strict)"), "TRUE");
  EXPECT_THAT(logged(), IsEmpty());
  EXPECT_EQ(eval("(pb-register-type \"t.Part\")"), "FALSE");
  EXPECT_EQ(eval("(pb-register-type \"t.Non\")"), "FALSE");
  EXPECT_THAT(logged(),
              ElementsAre("error protobuf: CLIPS-Protobuf: Registering type t.Part failed: it has no enum CompType "
                          "with COMP_ID and MSG_TYPE",
                          HasSubstr("CLIPS-Protobuf: Registering type t.Non failed: there is no message type")));
}

TEST_F(Protobuf, ArgumentsOfOtherTypesAreErrors) {
  run_up();
  EXPECT_THAT(failing("(pb-create 1)"), HasSubstr("expected argument #1 to be of type"));
  EXPECT_THAT(failing("(pb-peer-create sym 4444)"), HasSubstr("expected argument #1 to be of type string"));
  EXPECT_THAT(failing("(pb-broadcast \"1\" 2)"), HasSubstr("expected argument #1"));
  EXPECT_EQ(failing("(pb-connect \"host\")").substr(0, 11), "[ARGACCES1]");
}

// --- Peers

TEST_F(Protobuf, PeersTalk) {
  run_up();
  EXPECT_EQ(eval("(pb-peer-create-local \"127.0.0.1\" 4445 4444)"), "1");
  EXPECT_EQ(eval("(pb-peer-create-local \"127.0.0.1\" 4444 4445)", "other"), "1");
  message("t.All");
  set("d", "0.5");
  eval("(pb-broadcast 1 ?*m*)");
  EXPECT_THAT(lab_.facts("protobuf-msg", "other"), IsEmpty()) << "at the next tick";
  lab_.ticks(1);
  EXPECT_THAT(lab_.facts("protobuf-msg", "other"),
              ElementsAre("(protobuf-msg (type \"t.All\") (comp-id 7) (msg-type 9) (rcvd-via BROADCAST) "
                          "(rcvd-from 127.0.0.1 4444) (rcvd-at 0.0) (client-type PEER) (client-id 1) "
                          "(ptr <Pointer-C-0x1>))"));
  EXPECT_THAT(lab_.facts("protobuf-msg"), IsEmpty());
  lab_.engine("other").run();
  EXPECT_THAT(lab_.facts("protobuf-msg", "other"), IsEmpty()) << "it lives for one run";
  eval("(pb-send 1 ?*m*)");
  lab_.ticks(2);
  EXPECT_THAT(lab_.facts("protobuf-msg", "other"), SizeIs(1));
}

TEST_F(Protobuf, SendersOfTheNextCxAreStrings) {
  config("cx::ProtobufPlugin, proto_paths: [\"proto\"], pkg_share_dirs: [\"agent\"]}\ncompat: next\nunused: {a: 1");
  run_up();
  eval("(pb-peer-create-local \"h\" 1 4444)");
  eval("(pb-peer-create-local \"h\" 4444 1)", "other");
  ASSERT_TRUE(lab_.engine("other").build("(defglobal ?*m* = nil)").ok());
  eval("(bind ?*m* (pb-create \"t.All\"))", "other");
  eval("(pb-broadcast 1 ?*m*)", "other");
  lab_.ticks(2);
  EXPECT_THAT(lab_.facts("protobuf-msg"), ElementsAre(HasSubstr("(rcvd-from \"127.0.0.1\" 1)")));
}

TEST_F(Protobuf, AMessageIsDestroyedWithItsFact) {
  lab_.write("agent/rules.clp",
             "(defglobal ?*seen* = nil)\n(defrule see (protobuf-msg (ptr ?p)) => (bind ?*seen* ?p)\n"
             " (printout t (pb-field-value ?p d) crlf))");
  run_up();
  eval("(pb-peer-create-local \"127.0.0.1\" 1 4444)");
  eval("(pb-peer-create-local \"127.0.0.1\" 4444 1)", "other");
  ASSERT_TRUE(lab_.engine("other").build("(defglobal ?*m* = nil)").ok());
  eval("(bind ?*m* (pb-create \"t.All\"))", "other");
  eval("(pb-set-field ?*m* d 0.5)", "other");
  eval("(pb-broadcast 1 ?*m*)", "other");
  lab_.ticks(2);
  lab_.engine().run();
  EXPECT_THAT(lab_.log.lines, Contains("info main: 0.5"));
  EXPECT_EQ(eval("(pb-tostring ?*seen*)"), "\"\"");
}

TEST_F(Protobuf, IdsAreCountedTogetherAndPortsAreChecked) {
  run_up();
  EXPECT_EQ(eval("(pb-peer-create \"192.168.1.255\" 4444)"), "1");
  EXPECT_EQ(eval("(pb-connect \"127.0.0.1\" 9)"), "2");
  EXPECT_EQ(eval("(pb-peer-create-local \"127.0.0.1\" 4444 0)"), "3");
  EXPECT_EQ(eval("(pb-peer-create-local \"127.0.0.1\" 0 4444)"), "0");
  EXPECT_EQ(eval("(pb-peer-create \"127.0.0.1\" -1)"), "0");
  EXPECT_EQ(eval("(pb-peer-create \"127.0.0.1\" 65536)"), "0");
  EXPECT_EQ(eval("(pb-connect \"127.0.0.1\" 70000)"), "0");
  EXPECT_EQ(eval("(pb-peer-create-crypto \"127.0.0.1\" 4444 key aes-128-cbc)"), "4");
  EXPECT_THAT(failing("(pb-peer-create-crypto \"127.0.0.1\" 4444 key rot13)"), HasSubstr("Unknown cipher 'rot13'"));
  EXPECT_THAT(failing("(pb-peer-setup-crypto 4 key rot13)"), HasSubstr("Unknown cipher 'rot13'"));
  message("t.All");
  logged();
  // Unknown ids and messages are silent.
  for (const char* call : {"(pb-broadcast 99 ?*m*)", "(pb-send 99 ?*m*)", "(pb-broadcast 1 (pb-create \"no\"))",
                           "(pb-peer-destroy 99)", "(pb-disconnect 99)", "(pb-peer-setup-crypto 99 a aes-128-cbc)"})
    EXPECT_NE(eval(call), "error") << call;
  EXPECT_THAT(logged(), SizeIs(1)) << "that there is no type";
}

TEST_F(Protobuf, PeersAndStreamsHaveAnEnd) {
  run_up();
  for (int i = 1; i <= 249; ++i) ASSERT_EQ(eval("(pb-peer-create \"h\" " + std::to_string(i) + ')'), std::to_string(i));
  eval("(pb-server-enable 4444)");
  eval("(pb-connect \"h\" 4444)", "other");
  eval("(pb-connect \"h\" 4444)", "other");
  lab_.ticks(2);
  EXPECT_THAT(lab_.facts("protobuf-server-client-connected"), SizeIs(1));
  lab_.ticks(1);
  EXPECT_THAT(lab_.facts("protobuf-client-disconnected", "other"), ElementsAre("(protobuf-client-disconnected 2)"));
  EXPECT_THAT(failing("(pb-peer-create \"h\" 1)"), HasSubstr("250 peers and streams are open"));
  EXPECT_THAT(failing("(pb-connect \"h\" 1)"), HasSubstr("250 peers and streams are open"));
  eval("(pb-peer-destroy 1)");
  EXPECT_EQ(eval("(pb-peer-create \"h\" 1)"), "251");
}

TEST_F(Protobuf, EncryptedPeersTalk) {
  run_up();
  for (const std::string cipher : {"aes-128-ecb", "aes-128-cbc", "aes-256-ecb", "aes-256-cbc"}) {
    const std::string mine = eval("(pb-peer-create-local-crypto \"127.0.0.1\" 5 6 \"key\" \"" + cipher + "\")");
    const std::string theirs =
        eval("(pb-peer-create-local-crypto \"127.0.0.1\" 6 5 \"key\" \"" + cipher + "\")", "other");
    message("t.All");
    eval("(pb-broadcast " + mine + " ?*m*)");
    lab_.ticks(2);
    EXPECT_THAT(lab_.facts("protobuf-msg", "other"), SizeIs(1)) << cipher;
    EXPECT_THAT(lab_.facts("protobuf-receive-failed", "other"), IsEmpty()) << cipher;
    lab_.engine("other").run();
    eval("(pb-peer-destroy " + theirs + ")", "other");
  }
}

TEST_F(Protobuf, OtherKeysAndCiphersAreReported) {
  run_up();
  eval("(pb-peer-create-local \"127.0.0.1\" 5 6)");
  eval("(pb-peer-create-local \"127.0.0.1\" 6 5)", "other");
  message("t.All");
  const auto said = [&](const std::string& mine, const std::string& theirs) {
    eval("(pb-peer-setup-crypto 1 " + mine + ")");
    eval("(pb-peer-setup-crypto 1 " + theirs + ")", "other");
    eval("(pb-broadcast 1 ?*m*)");
    lab_.ticks(2);
    EXPECT_THAT(lab_.facts("protobuf-msg", "other"), IsEmpty());
    const auto facts = lab_.facts("protobuf-receive-failed", "other");
    lab_.engine("other").run();
    EXPECT_THAT(lab_.facts("protobuf-receive-failed", "other"), IsEmpty());
    return facts.size() == 1 ? facts[0] : std::to_string(facts.size()) + " facts";
  };
  EXPECT_THAT(said("\"\" \"\"", "k aes-128-cbc"),
              "(protobuf-receive-failed (comp-id 0) (msg-type 0) (rcvd-via BROADCAST) (rcvd-from 127.0.0.1 6) "
              "(client-id 1) (message \"Received plain text message, but encryption is enabled\"))");
  EXPECT_THAT(said("k aes-128-cbc", "\"\" \"\""), HasSubstr("encryption is disabled"));
  EXPECT_THAT(said("k aes-128-cbc", "k aes-256-ecb"), HasSubstr("cipher aes-128-cbc, expected aes-256-ecb"));
  EXPECT_THAT(said("k aes-128-cbc", "other aes-128-cbc"), HasSubstr("Decryption failed"));
  EXPECT_THAT(lab_.log.with("Receiving from 127.0.0.1:6 failed (id 1, BROADCAST, type 0:0): Decryption failed"),
              SizeIs(1));
}

TEST_F(Protobuf, MessagesThatCannotBeSentAreReported) {
  run_up();
  eval("(pb-peer-create-local \"127.0.0.1\" 5 6)");
  eval("(pb-connect \"127.0.0.1\" 9)");
  message("t.Strict");
  eval("(pb-broadcast 1 ?*m*)");
  eval("(pb-send 2 ?*m*)");
  message("t.Part");
  eval("(pb-broadcast 1 ?*m*)");
  message("t.All");
  eval("(pb-send 2 ?*m*)");
  EXPECT_THAT(logged(),
              ElementsAre("warn protobuf: CLIPS-Protobuf: Failed to broadcast message of type t.Strict: t.Strict lacks "
                          "required fields: needed",
                          "warn protobuf: CLIPS-Protobuf: Failed to send message of type t.Strict: t.Strict lacks "
                          "required fields: needed",
                          "warn protobuf: CLIPS-Protobuf: Failed to broadcast message of type t.Part: t.Part has no "
                          "enum CompType with COMP_ID and MSG_TYPE",
                          "warn protobuf: CLIPS-Protobuf: Failed to send message of type t.All: not connected"));
}

// --- Streams

TEST_F(Protobuf, AClientTalksToAServer) {
  run_up();
  eval("(pb-server-enable 4444)");
  eval("(pb-server-enable 5555)");  // there is one
  EXPECT_EQ(eval("(pb-connect \"localhost\" 4444)", "other"), "1");
  lab_.ticks(2);
  EXPECT_THAT(lab_.facts("protobuf-server-client-connected"),
              ElementsAre("(protobuf-server-client-connected 1 127.0.0.1 49152)"));
  lab_.ticks(1);
  EXPECT_THAT(lab_.facts("protobuf-client-connected", "other"), ElementsAre("(protobuf-client-connected 1)"));
  ASSERT_TRUE(lab_.engine("other").build("(defglobal ?*m* = nil)").ok());
  eval("(bind ?*m* (pb-create \"t.All\"))", "other");
  eval("(pb-send 1 ?*m*)", "other");
  message("t.All");
  eval("(pb-send 1 ?*m*)");
  lab_.ticks(2);
  EXPECT_THAT(lab_.facts("protobuf-msg"),
              ElementsAre(HasSubstr("(rcvd-via STREAM) (rcvd-from 127.0.0.1 49152) (rcvd-at 0.06) "
                                    "(client-type SERVER) (client-id 1)")));
  EXPECT_THAT(lab_.facts("protobuf-msg", "other"),
              ElementsAre(HasSubstr("(rcvd-from localhost 4444) (rcvd-at 0.06) (client-type CLIENT) (client-id 1)")));
  eval("(pb-disconnect 1)", "other");
  EXPECT_THAT(lab_.log.with("Disconnecting client 1"), SizeIs(1));
  lab_.ticks(2);
  EXPECT_THAT(lab_.facts("protobuf-server-client-disconnected"),
              ElementsAre("(protobuf-server-client-disconnected 1)"));
  EXPECT_THAT(lab_.facts("protobuf-client-disconnected", "other"), IsEmpty());
}

TEST_F(Protobuf, AServerThatGoesAndOneThatIsNotThereDisconnectClients) {
  run_up();
  eval("(pb-connect \"127.0.0.1\" 4444)", "other");
  lab_.ticks(2);
  EXPECT_THAT(lab_.facts("protobuf-client-disconnected", "other"), ElementsAre("(protobuf-client-disconnected 1)"));
  eval("(pb-server-enable 0)");
  eval("(pb-server-enable 4444)");
  eval("(pb-connect \"127.0.0.1\" 4444)", "other");
  lab_.ticks(3);
  EXPECT_THAT(lab_.facts("protobuf-client-connected", "other"), ElementsAre("(protobuf-client-connected 2)"));
  eval("(pb-server-disable)");
  eval("(pb-server-disable)");
  lab_.ticks(2);
  EXPECT_THAT(lab_.facts("protobuf-client-disconnected", "other"),
              ElementsAre("(protobuf-client-disconnected 1)", "(protobuf-client-disconnected 2)"));
  EXPECT_THAT(lab_.facts("protobuf-server-client-disconnected"), IsEmpty());
}

/// Sends bytes of its own.
class ProtobufStranger : public Protobuf {
 protected:
  void SetUp() override {
    Protobuf::SetUp();
    lab_.options.network = &network_;
    run_up();
    const auto node = lab_.bus.join(bus::ParticipantKind::kNode, {"stranger", "/", {}}, lab_.records.open_stream("s"));
    host_ = *net::Host::create(network_, node, [this](const net::Event& e) {
      if (e.kind == net::EventKind::kClosed) ++closed_;
    });
  }
  void TearDown() override {
    host_.reset();
    lab_.manager.reset();
  }
  net::Network network_{lab_.bus, lab_.records};
  std::unique_ptr<net::Host> host_;
  int closed_ = 0;
};

TEST_F(ProtobufStranger, BrokenDatagramsAreReportedOnceAndChangeNothing) {
  eval("(pb-peer-create-local \"127.0.0.1\" 5 6)");
  const net::LinkId link = host_->open_datagrams(6, 5);
  const std::string good = pb::write_frame({7, 9}, "");
  const auto said = [&](const std::string& bytes) {
    host_->send(link, bytes);
    lab_.ticks(1);
    EXPECT_THAT(lab_.facts("protobuf-msg"), IsEmpty());
    const auto facts = lab_.facts("protobuf-receive-failed");
    lab_.engine().run();
    return facts.size() == 1 ? facts[0] : std::to_string(facts.size()) + " facts";
  };
  EXPECT_THAT(said(""), HasSubstr("Invalid number of bytes: found 0, expected 8"));
  EXPECT_THAT(said(good.substr(0, 11)), HasSubstr("Invalid number of bytes: found 11, expected 12"));
  EXPECT_THAT(said(good + '\0'), HasSubstr("Invalid number of bytes: found 13, expected 12"));
  EXPECT_THAT(said(pb::write_frame({7, 99}, "")),
              HasSubstr("(comp-id 7) (msg-type 99) (rcvd-via BROADCAST) (rcvd-from 127.0.0.1 5) (client-id 1) "
                        "(message \"Message type 7:99 not registered\")"));
  EXPECT_THAT(said(pb::write_frame({7, 9}, "\xff")), HasSubstr("the bytes are no t.All"));
  EXPECT_THAT(said(pb::write_frame({7, 10}, "")), HasSubstr("t.Strict lacks required fields: needed"));
  host_->send(link, good);
  lab_.ticks(1);
  EXPECT_THAT(lab_.facts("protobuf-msg"), SizeIs(1));
}

TEST_F(ProtobufStranger, ABrokenStreamIsReportedAndClosed) {
  eval("(pb-server-enable 4444)");
  const net::LinkId link = host_->connect(4444);
  lab_.ticks(1);
  lab_.bus.deliver(host_->participant());
  host_->send(link, pb::write_frame({7, 99}, ""));
  host_->send(link, pb::write_frame({7, 9}, "") + "GET / HTTP/1.1");
  host_->send(link, pb::write_frame({7, 9}, ""));  // too late
  lab_.ticks(1);
  EXPECT_THAT(lab_.facts("protobuf-msg"), SizeIs(1));
  EXPECT_THAT(lab_.facts("protobuf-server-receive-failed"),
              ElementsAre(HasSubstr("(message \"Message type 7:99 not registered\")"),
                          HasSubstr("(comp-id 0) (msg-type 0) (rcvd-via STREAM) (rcvd-from 127.0.0.1 49152) "
                                    "(client-id 1) (message \"found frame header version 71, expected 2\")")));
  EXPECT_THAT(lab_.facts("protobuf-server-client-disconnected"), SizeIs(1));
  lab_.bus.deliver(host_->participant());
  EXPECT_EQ(closed_, 1);
  lab_.engine().run();
  EXPECT_THAT(lab_.log.with("Server: receiving from 127.0.0.1:49152 failed"), SizeIs(2));
}

// --- The plugin

TEST_F(Protobuf, ALinkedClassReadsTheFilesOfItsPackage) {
  config("cx::AgentProtobufPlugin");
  run_up();
  EXPECT_NE(eval("(pb-create \"t.All\")"), "<Pointer-C-0x0>");
  EXPECT_EQ(lab_.manager->plugin_names("main")->front(), "protobuf");
}

TEST_F(Protobuf, ALinkedClassReadsTheFilesOfAnyPackageWhereItsOwnHasNone) {
  config("cx::BringupProtobufPlugin");
  lab_.options.packages["cx_bringup"] = {lab_.folder / "bringup", {}};
  lab_.options.packages["messages"] = {lab_.folder / "messages", {}};
  lab_.write("bringup/package.xml", "<package/>");
  lab_.write("messages/deep/more/b.proto",
             "syntax = \"proto2\";\nimport \"sub/c.proto\";\nmessage B { optional C c = 1; }");
  lab_.write("messages/deep/more/sub/c.proto", "syntax = \"proto2\";\nmessage C { }");
  run_up();
  EXPECT_NE(eval("(pb-create \"t.All\")"), "<Pointer-C-0x0>");
  EXPECT_NE(eval("(pb-create B)"), "<Pointer-C-0x0>");
}

TEST_F(Protobuf, ALinkedClassWithoutFilesSaysWhatToDo) {
  config("cx::BringupProtobufPlugin");
  std::filesystem::remove_all(lab_.folder / "agent/proto");
  const Status s = lab_.start();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_THAT(s.error().text(), HasSubstr("config.yaml:6: plugin 'protobuf' (cx::BringupProtobufPlugin): no package of "
                                          "the run has .proto files"));
}

TEST_F(Protobuf, BrokenFilesAreErrorsWithTheirLine) {
  lab_.write("agent/proto/bad.proto", "syntax = \"proto2\";\nmessage M {\n  optional strin a = 1;\n}\n");
  const Status s = lab_.start();
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.error().kind, ErrorKind::kInput);
  EXPECT_EQ(s.error().text(), (lab_.folder / "agent/proto/bad.proto").string() + ":3: \"strin\" is not defined.");
}

TEST_F(Protobuf, FoldersThatAreNotThereAreErrors) {
  config("cx::ProtobufPlugin, proto_paths: [\"nowhere\"], pkg_share_dirs: [\"agent\"]");
  const Status s = lab_.start();
  ASSERT_FALSE(s.ok());
  EXPECT_THAT(s.error().text(), HasSubstr("config.yaml:6: Cannot resolve folder nowhere: not in "));
}

TEST_F(Protobuf, FoldersBelowAreThereToBeImported) {
  lab_.write("agent/proto/sub/broken.proto", "nonsense");
  lab_.write("agent/proto/sub/good.proto", "syntax = \"proto2\";\nmessage Good { }");
  lab_.write("agent/proto/more.proto", "syntax = \"proto2\";\nimport \"sub/good.proto\";\n");
  run_up();
  EXPECT_NE(eval("(pb-create Good)"), "<Pointer-C-0x0>");
}

TEST_F(Protobuf, TheWellKnownTypesAreThere) {
  lab_.write("agent/proto/stamped.proto",
             "syntax = \"proto2\";\nimport \"google/protobuf/timestamp.proto\";\nmessage S { optional "
             "google.protobuf.Timestamp t = 1; }");
  run_up();
  EXPECT_EQ(eval("(pb-field-names (pb-create \"google.protobuf.Timestamp\"))"), "(seconds nanos)");
}

TEST_F(Protobuf, ItGoesAndComesBack) {
  run_up();
  eval("(pb-peer-create-local \"127.0.0.1\" 5 6)");
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(lab_.manager->unload_plugin("main", "protobuf").ok());
    EXPECT_TRUE(lab_.engine().has("deftemplate", "protobuf-msg")) << "as in CX its constructs stay";
    const Status s = lab_.manager->load_plugin("main", "protobuf");
    ASSERT_TRUE(s.ok()) << s.error().text();
    EXPECT_EQ(eval("(pb-peer-create-local \"127.0.0.1\" 5 6)"), "1");
  }
  ASSERT_TRUE(lab_.manager->deactivate().ok());
  const Status s = lab_.manager->activate();
  ASSERT_TRUE(s.ok()) << s.error().text();
  EXPECT_EQ(eval("(pb-peer-create-local \"127.0.0.1\" 5 6)"), "1");
  EXPECT_THAT(logged(), IsEmpty());
}

}  // namespace
}  // namespace cxlab::cx
