#include <locale.h>

#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// Lines that a router makes of these writes.
std::vector<std::string> lines_of(std::vector<std::pair<std::string, std::string>> writes, bool redirect = false) {
  std::vector<std::string> lines;
  LogRouter router(redirect, [&](LogLevel level, std::string_view colour, std::string_view, std::string_view text) {
    lines.push_back(std::string(to_string(level)) + '|' + std::string(colour.empty() ? colour : colour.substr(1)) +
                    '|' + std::string(text));
  });
  for (const auto& [name, text] : writes) router.write(name, text);
  return lines;
}

TEST(LogRouter, GivesEachLogicalNameItsLevelAndColour) {
  EXPECT_THAT(lines_of({{"l", "a\n"}, {"t", "a\n"}, {"info", "a\n"}, {"loginfo", "a\n"}, {"stdout", "a\n"}}),
              ElementsAre("info||a", "info||a", "info||a", "info||a", "info||a"));
  EXPECT_THAT(lines_of({{"debug", "a\n"},
                        {"logdebug", "a\n"},
                        {"warn", "a\n"},
                        {"logwarn", "a\n"},
                        {"stdwrn", "a\n"},
                        {"error", "a\n"},
                        {"logerror", "a\n"},
                        {"stderr", "a\n"}}),
              ElementsAre("debug||a", "debug||a", "warn||a", "warn||a", "warn||a", "error||a", "error||a", "error||a"));
  EXPECT_THAT(lines_of({{"red", "a\n"},
                        {"green", "a\n"},
                        {"yellow", "a\n"},
                        {"blue", "a\n"},
                        {"magenta", "a\n"},
                        {"cyan", "a\n"},
                        {"white", "a\n"},
                        {"bold", "a\n"}}),
              ElementsAre("info|[31m|a", "info|[32m|a", "info|[33m|a", "info|[34m|a", "info|[35m|a", "info|[36m|a",
                          "info|[37m|a", "info|[1m|a"));
}

TEST(LogRouter, SharesOneLineBetweenAllNames) {
  EXPECT_THAT(lines_of({{"blue", "one "}, {"warn", "two "}, {"red", "three\nfour\nfive"}, {"info", "!\n"}}),
              ElementsAre("info|[31m|one two three", "info|[31m|four", "info||five!"));
}

TEST(LogRouter, KeepsTextWithoutAnEndOfLine) { EXPECT_THAT(lines_of({{"info", "waits"}}), ElementsAre()); }

TEST(LogRouter, RedirectsStdoutOnly) {
  EXPECT_THAT(lines_of({{"stdout", "a\n"}, {"info", "b\n"}}, true), ElementsAre("debug||a", "info||b"));
}

TEST(Log, AnUnknownLogicalNameIsAnErrorOfClips) {
  Lab lab;
  lab.options.stop_on_rule_error = false;
  lab.agent("(defrule say (time ?) => (printout purple \"hello\" crlf))");
  lab.run_up();
  lab.ticks(1);
  EXPECT_EQ(lab.log.with("main: [ROUTER1] Logical name 'purple' was not recognized by any routers.").size(), 1u);
  EXPECT_EQ(lab.log.with("rules.clp:1: rule say, RHS: [ROUTER1]").size(), 1u) << "a run that goes on tells the place";
}

TEST(Log, RulesAndWatchesPrintToTheEnvironmentsFile) {
  Lab lab;
  lab.agent("(defrule say (time ?t) => (printout debug \"quiet\" crlf) (printout warn \"loud\" crlf))");
  lab.options.params = {{"clips_manager.main.watch", "[Rules]"}};
  lab.options.run_folder = lab.folder / "run";
  lab.run_up();
  lab.ticks(6);
  ASSERT_TRUE(lab.manager->deactivate().ok());
  const std::string file = Lab::read(lab.folder / "run/logs/main.log");
  EXPECT_THAT(file, HasSubstr("[0.000] [main] [debug] quiet\n[0.000] [main] [warn] loud\n"));
  EXPECT_THAT(file, HasSubstr("[0.100] [main] [info] FIRE    1 say: f-"));
  EXPECT_THAT(file, Not(HasSubstr("time-retract")));
}

TEST(LogFile, HasSimulatedTimeLoggerAndLevelInEachLine) {
  Lab lab;
  auto file = LogFile::create(lab.folder / "a.log");
  ASSERT_TRUE(file.ok());
  (*file)->line({SimTime{12'340'000'000}, LogLevel::kWarn, "main", "one", "\033[31m"});
  (*file)->line({SimTime{999'999'999}, LogLevel::kDebug, "%v %n", "{} %t", {}});
  (*file)->line({SimTime{100'000'000'600'000}, LogLevel::kError, "", "", {}});
  (*file)->line({SimTime{1}, LogLevel::kInfo, "main", "last", {}});
  ASSERT_TRUE((*file)->flush().ok());
  EXPECT_EQ(Lab::read(lab.folder / "a.log"),
            "[12.340] [main] [warn] one\n"
            "[1.000] [%v %n] [debug] {} %t\n"
            "[100000.001] [] [error] \n"
            "[0.000] [main] [info] last\n");
}

TEST(LogFile, ThatCannotBeMadeIsAResourceError) {
  const auto file = LogFile::create("/nowhere/a.log");
  ASSERT_FALSE(file.ok());
  EXPECT_EQ(file.error().kind, ErrorKind::kResource);
}

TEST(ConsoleLog, HasAlignedTimesAndColoursIfWanted) {
  const LogLine line{SimTime{12'340'000'000}, LogLevel::kInfo, "main", "one", "\033[31m"};
  testing::internal::CaptureStderr();
  console_log(false)->line(line);
  console_log(true)->line(line);
  console_log(true)->line({SimTime{0}, LogLevel::kError, "nav", "two", {}});
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "[   12.340] [info] [main] one\n"
            "[   12.340] [info] [main] \033[31mone\033[0m\n"
            "[    0.000] [\033[1;31merror\033[0m] [nav] two\n");
}

TEST(Log, NamesTheManagerWhereARunHasSeveral) {
  Lab lab;
  lab.agent("(defrule say (time ?t) => (printout t \"hello\" crlf))");
  lab.options.one_of_several = true;
  lab.options.name_space = "/cyan";
  lab.options.run_folder = lab.folder / "run";
  lab.run_up();
  lab.ticks(1);
  EXPECT_THAT(lab.log.with("hello"), ElementsAre("info cyan/clips_manager/main: hello"));
  EXPECT_EQ(lab.log.with("debug cyan/clips_manager: Initialized new CLIPS environment: main").size(), 1u);
  ASSERT_TRUE(lab.manager->deactivate().ok());
  EXPECT_THAT(Lab::read(lab.folder / "run/logs/cyan_main.log"),
              HasSubstr("[0.000] [cyan/clips_manager/main] [info] hello\n"));
}

TEST(Numbers, AreThoseOfTheCLocaleWhileRulesRun) {
  Lab lab;
  lab.agent("(defrule ask (time ?t) => (look))");
  locale_t seen = LC_GLOBAL_LOCALE;
  ASSERT_TRUE(lab.create().ok());
  ASSERT_TRUE(lab.manager->configure().ok());
  ASSERT_TRUE(lab.engine().add_function({.name = "look"}, [&](Call&) { seen = uselocale(nullptr); }).ok());
  ASSERT_TRUE(lab.manager->activate().ok());
  lab.ticks(1);
  EXPECT_NE(seen, LC_GLOBAL_LOCALE);
  EXPECT_EQ(uselocale(nullptr), LC_GLOBAL_LOCALE);
}

TEST(Log, AnEnvironmentMayGoWithoutFile) {
  Lab lab;
  lab.agent("");
  lab.options.params = {{"clips_manager.main.log_clips_to_file", "false"}};
  lab.options.run_folder = lab.folder / "run";
  lab.run_up();
  EXPECT_FALSE(std::filesystem::exists(lab.folder / "run/logs/main.log"));
}

TEST(Log, WithRedirectionPrintoutIsDebug) {
  Lab lab;
  lab.agent("(defrule say (time ?t) => (printout t \"to t\" crlf) (printout info \"to info\" crlf))");
  lab.options.params = {{"clips_manager.main.redirect_stdout_to_debug", "true"}};
  lab.run_up();
  lab.ticks(1);
  EXPECT_THAT(lab.log.with("to "), ElementsAre("debug main: to t", "info main: to info"));
}

}  // namespace
}  // namespace cxlab::cx
