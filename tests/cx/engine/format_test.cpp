// `format`: what CLIPS prints, and no buffer that a flag can overflow.

#include "tests/support/engine_test.h"

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Format : EngineTest {
  /// The result of `(format nil <arguments>)`.
  std::string format(const std::string& arguments) {
    (void)engine().take_errors();
    const Expected<Value> value = engine().eval("(format nil " + arguments + ")");
    return value ? value->text() : "error: " + value.error().message;
  }
};

TEST_F(Format, PrintsAsPrintfDoes) {
  const std::pair<const char*, const char*> rows[] = {
      {R"("%d" 42)", "42"},
      {R"("%5d|%-5d|%05d" 42 -42 42)", "   42|-42  |00042"},
      {R"("%d" 3.99)", "3"},
      {R"("%d" -9223372036854775808)", "-9223372036854775808"},
      {R"("%d" 1e300)", "-9223372036854775808"},
      {R"("%x %o %u" 255 8 7)", "ff 10 7"},
      {R"("%f" 1)", "1.000000"},
      {R"("%.2f|%8.3f" 3.14159 2)", "3.14|   2.000"},
      {R"("%e" 12345.678)", "1.234568e+04"},
      {R"("%g" 0.5)", "0.5"},
      {R"("%s and %s" abc "a string")", "abc and a string"},
      {R"("%10s|%-10s|%.2s" abc abc abc)", "       abc|abc       |ab"},
      {R"("%c%c%c" abc "xyz" 65)", "axA"},
      {R"("a%cb" "")", "ab"},
      {R"("a%nb%rc%td%ve%%")", "a\nb\rc\td\ve%"},
      {R"("")", ""},
      {R"("no flag")", "no flag"},
      {R"("%5")", "%5"},
      {R"("%5%d" 7)", "%57"},
  };
  for (const auto& [arguments, printed] : rows) EXPECT_EQ(format(arguments), printed) << arguments;
}

TEST_F(Format, LongTextsAreWhole) {
  EXPECT_EQ(format(R"("%f" 1e308)").size(), 309U + 7U);
  EXPECT_EQ(format(R"("%1000d" 1)"), std::string(999, ' ') + '1');
  EXPECT_EQ(format(R"("%.600f" 0.5)"), "0.5" + std::string(599, '0'));
  EXPECT_EQ(format("\"%700s|\" \"" + std::string(600, 'x') + '"'), std::string(100, ' ') + std::string(600, 'x') + '|');
  EXPECT_EQ(format("\"%s\" \"" + std::string(200'000, 'x') + '"').size(), 200'000U);
  EXPECT_EQ(format(R"("%999999d" 1)").size(), 999'999U);
}

TEST_F(Format, WhatIsTooLongIsAnError) {
  for (const char* flag : {"%1000001d", "%9999999s", "%-99999999999f", "%.99999999999e"})
    EXPECT_THAT(format('"' + std::string(flag) + "\" " + (flag[8] == 's' ? "a" : "1")),
                HasSubstr("gives more than a million characters"))
        << flag;
  EXPECT_THAT(format(R"("%.1000000s" a)"), HasSubstr("gives more than a million characters"));
  EXPECT_EQ(format(R"("%s" (str-cat (format nil "%999999s" "") x))").size(), 1'000'000U);
  EXPECT_THAT(format(R"("%s" (str-cat (format nil "%999999s" "") xx))"),
              HasSubstr("gives more than a million characters"));
}

TEST_F(Format, WrongArgumentsAreErrors) {
  const std::pair<const char*, const char*> rows[] = {
      {R"("%k" 1)", "[IOFUN3] Invalid format flag \"%k\" specified in format function."},
      {R"("%*d" 5 5)", "[IOFUN3] Invalid format flag \"%*\" specified in format function."},
      {R"("%d")", "[ARGACCES1] Function 'format' expected exactly 3 arguments."},
      {R"("a" 1)", "[ARGACCES1] Function 'format' expected exactly 2 arguments."},
      {R"("%d" abc)", "[ARGACCES2] Function 'format' expected argument #3 to be of type integer or float."},
      {R"("%f" abc)", "[ARGACCES2] Function 'format' expected argument #3 to be of type integer or float."},
      {R"("%s" 1)", "[ARGACCES2] Function 'format' expected argument #3 to be of type symbol or string."},
      {R"("%d%c" 1 1.5)",
       "[ARGACCES2] Function 'format' expected argument #4 to be of type symbol, string, or integer."},
      {R"("%s" (create$))", "[ARGACCES2] Function 'format' expected argument #3 to be of type symbol or string."},
  };
  for (const auto& [arguments, message] : rows) EXPECT_THAT(format(arguments), HasSubstr(message)) << arguments;
}

TEST_F(Format, WritesToALogicalName) {
  EXPECT_EQ(engine().eval(R"((format t "%d-%s" 1 a))")->text(), "1-a");
  EXPECT_EQ(engine().eval(R"((format warn "%d" 2))")->text(), "2");
  EXPECT_EQ(output["stdout"], "1-a");
  EXPECT_EQ(output["warn"], "2");
  EXPECT_FALSE(engine().eval(R"((format nowhere "%d" 2))")->text() == "2");
}

}  // namespace
}  // namespace cxlab
