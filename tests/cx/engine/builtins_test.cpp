// Built-in functions of CLIPS that would look outside.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "tests/support/engine_test.h"

namespace cxlab {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

namespace fs = std::filesystem;

/// Reading from one folder; writing below it, wherever the rules wanted to write. "/secret" is refused.
class OneFolder : public FileAccess {
 public:
  explicit OneFolder(fs::path folder) : folder_(std::move(folder)) {}
  Expected<std::string> for_reading(const std::string& path) override {
    if (path.starts_with("/secret")) return input_error("may not read " + path);
    read.insert(path);
    return (folder_ / fs::path(path).relative_path()).string();
  }
  Expected<std::string> for_writing(const std::string& path) override {
    if (path.starts_with("/secret")) return input_error("may not write " + path);
    return (folder_ / fs::path(path).relative_path()).string();
  }
  std::set<std::string> read;

 private:
  fs::path folder_;
};

/// Answers with what was recorded, or records.
class Tape : public LookOutside {
 public:
  Value look(std::string_view function, const std::function<Value()>& outside) override {
    looked.emplace_back(function);
    if (replay) return kept;
    return kept = outside();
  }
  bool replay = false;
  Value kept;
  std::vector<std::string> looked;
};

struct Builtins : EngineTest {
  void SetUp() override {
    folder = fs::path(testing::TempDir()) / ("cxlab_engine_" + std::to_string(::getpid()) + "_" +
                                             testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder);
    fs::create_directories(folder);
    files = std::make_unique<OneFolder>(folder);
  }
  void TearDown() override { fs::remove_all(folder); }
  void with_files() {
    EngineOptions o = options();
    o.files = files.get();
    o.outside = &tape;
    engine_ = make(std::move(o));
  }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder / name) << text; }

  fs::path folder;
  std::unique_ptr<OneFolder> files;
  Tape tape;
};

TEST_F(Builtins, TimeIsSimulated) {
  EngineOptions o = options();
  o.epoch = from_seconds(1577880000.0);  // 2020-01-01 12:00 UTC
  engine_ = make(std::move(o));
  now = from_seconds(90.5);
  EXPECT_DOUBLE_EQ(engine().eval("(time)")->as_number(), 1577880090.5);
  EXPECT_EQ(engine().eval("(gm-time)")->print(), "(2020 1 1 12 1 30 Wednesday 0 FALSE)");
  EXPECT_EQ(engine().eval("(local-time)")->print(), "(2020 1 1 12 1 30 Wednesday 0 FALSE)");
  EXPECT_EQ(*engine().eval("(timer (loop-for-count 1000 (+ 1 1)))"), Value::number(0.0));
  EXPECT_EQ(*engine().eval("(timer)"), Value::number(0.0));
  EXPECT_EQ(*engine().eval("(timer (assert (first)) (assert (second)))"), Value::number(0.0));
  EXPECT_FALSE(engine().eval("(timer (div 1 0) (assert (third)))").ok());
  EXPECT_THAT(fact_texts(), ElementsAre("(first)", "(second)")) << "its arguments, up to the first that fails";
}

TEST_F(Builtins, RandomComesFromTheStreamOfTheEnvironment) {
  const auto draws = [](RuleEngine& engine) {
    std::vector<std::int64_t> list;
    for (int i = 0; i < 20; ++i) list.push_back(engine.eval("(random)")->as_integer());
    return list;
  };
  const auto first = draws(*make(options()));
  EXPECT_EQ(draws(*make(options())), first);
  EngineOptions o = options();
  o.seed = 8;
  EXPECT_NE(draws(*make(std::move(o))), first);
  for (int i = 0; i < 100; ++i) {
    const std::int64_t value = engine().eval("(random 3 5)")->as_integer();
    EXPECT_TRUE(value >= 3 && value <= 5) << value;
  }
  ASSERT_TRUE(engine().eval("(seed 1)").ok());
  const auto seeded = draws(engine());
  ASSERT_TRUE(engine().eval("(seed 1)").ok());
  EXPECT_EQ(draws(engine()), seeded);
  EXPECT_THAT(engine().eval("(random 5 3)").error().message, HasSubstr("the first bound is above the second"));
  EXPECT_THAT(engine().eval("(random 5)").error().message, HasSubstr("expected no or two bounds, found one"));
}

TEST_F(Builtins, WithoutFileAccessRulesMayNotTouchFiles) {
  for (const char* call :
       {"(open \"f\" f)", "(load \"f\")", "(batch* \"f\")", "(save-facts \"f\")", "(remove \"f\")", "(bsave \"f\")"}) {
    EXPECT_THAT(engine().eval(call).error().message, HasSubstr("rules may not use files here")) << call;
  }
}

TEST_F(Builtins, ReadingAndWritingGoWhereTheAccessSays) {
  with_files();
  write("in.txt", "12 abc\nsecond line\n");
  EXPECT_EQ(engine().eval("(open \"in.txt\" in)")->text(), "TRUE");
  EXPECT_EQ(*engine().eval("(read in)"), Value::integer(12));
  EXPECT_EQ(engine().eval("(progn (readline in) (readline in))")->text(), "second line");
  EXPECT_TRUE(files->read.contains("in.txt"));
  write("in.bin", "7");
  EXPECT_EQ(engine().eval("(open \"in.bin\" bytes \"rb\")")->text(), "TRUE");
  EXPECT_TRUE(files->read.contains("in.bin"));

  ASSERT_TRUE(engine().eval("(progn (open \"/out.txt\" out \"w\") (printout out \"hello\" crlf) (close out))").ok());
  std::string line;
  std::getline(std::ifstream(folder / "out.txt") >> std::ws, line);
  EXPECT_EQ(line, "hello") << "an absolute path lands in the folder";

  EXPECT_EQ(engine().eval("(open \"missing.txt\" m)")->text(), "FALSE");
  EXPECT_THAT(engine().eval("(open \"/secret/key\" k)").error().message, HasSubstr("may not read /secret/key"));
  EXPECT_THAT(engine().eval("(open \"/secret/key\" k \"a\")").error().message, HasSubstr("may not write /secret/key"));
}

TEST_F(Builtins, FactsAreSavedAndLoaded) {
  with_files();
  ASSERT_TRUE(engine().assert_string("(a 1)").ok());
  ASSERT_TRUE(engine().assert_string("(b \"x\")").ok());
  ASSERT_TRUE(engine().eval("(save-facts \"facts.fct\" visible a)").ok());
  ASSERT_TRUE(engine().eval("(bsave-facts \"facts.bin\")").ok());
  engine().reset();
  ASSERT_TRUE(engine().eval("(load-facts \"facts.fct\")").ok());
  EXPECT_THAT(fact_texts(), ElementsAre("(a 1)"));
  engine().reset();
  ASSERT_TRUE(engine().eval("(bload-facts \"facts.bin\")").ok());
  EXPECT_THAT(fact_texts(), ElementsAre("(a 1)", "(b \"x\")"));
}

TEST_F(Builtins, RegionsAreThoseOfTheFileThatRulesFetchedByItsName) {
  with_files();
  write("help.txt", "0MBEGIN-ENTRY-ROOT\nroot\nEND-ENTRY\n1IBEGIN-ENTRY-ONE\none\nEND-ENTRY\n");
  EXPECT_EQ(engine().eval("(fetch \"help.txt\")")->as_integer(), 2);
  EXPECT_EQ(engine().eval("(get-region \"help.txt\" ROOT ONE)")->text(), "one\n");
  EXPECT_EQ(engine().eval("(print-region t \"help.txt\" ^)")->text(), "FALSE");
  EXPECT_EQ(engine().eval("(print-region t \"help.txt\" ROOT)")->text(), "TRUE");
  const auto list = engine().eval("(get-region \"help.txt\" ROOT (create$ ONE 2 three))");
  EXPECT_EQ(list->text(), "") << "a list names no topic";
  EXPECT_EQ(engine().eval("(toss \"help.txt\")")->text(), "TRUE");
  EXPECT_THAT(engine().eval("(get-region \"/secret/key\" ONE)").error().message, HasSubstr("may not read /secret/key"));
}

TEST_F(Builtins, ABinaryFileThatRulesWroteInAnotherWayIsRefused) {
  with_files();
  ASSERT_TRUE(engine().assert_string("(a 1)").ok());
  ASSERT_TRUE(engine().eval("(bsave-facts \"facts.bin\")").ok());
  fs::copy_file(folder / "facts.bin", folder / "copy.bin");
  EXPECT_TRUE(engine().eval("(bload-facts \"copy.bin\")").ok()) << "the same content";
  write("text.bin", "no binary file");
  fs::copy_file(folder / "facts.bin", folder / "longer.bin");
  std::ofstream(folder / "longer.bin", std::ios::app) << 'x';
  for (const char* function : {"bload-facts", "bload-instances", "bload"})
    for (const char* file : {"text.bin", "longer.bin"})
      EXPECT_THAT(engine().eval('(' + std::string(function) + " \"" + file + "\")").error().message,
                  HasSubstr('\'' + std::string(file) + "' is not as a bsave function of this run wrote it"))
          << function;
  ASSERT_TRUE(engine().eval("(bsave-instances \"facts.bin\")").ok()) << "another function, the same path";
  EXPECT_TRUE(engine().eval("(bload-instances \"facts.bin\")").ok());
}

TEST_F(Builtins, TrustedRulesReadABinaryFileOfAnotherRun) {
  with_files();
  ASSERT_TRUE(engine().assert_string("(a 1)").ok());
  ASSERT_TRUE(engine().eval("(bsave-facts \"facts.bin\")").ok());
  for (const bool trusted : {false, true}) {
    OneFolder same_folder(folder);
    EngineOptions o = options();
    o.files = &same_folder;
    o.trust_rules = trusted;
    const auto other = make(std::move(o));
    EXPECT_EQ(other->eval("(bload-facts \"facts.bin\")").ok(), trusted);
    EXPECT_EQ(other->fact_count(), trusted ? 1U : 0U);
  }
}

TEST_F(Builtins, TrustedRulesRemoveAndRenameOnTheTape) {
  for (const bool trusted : {false, true}) {
    tape.looked.clear();
    EngineOptions o = options();
    o.files = files.get();
    o.outside = &tape;
    o.trust_rules = trusted;
    engine_ = make(std::move(o));
    write("a.txt", "a");
    EXPECT_EQ(engine().eval("(rename \"a.txt\" \"b.txt\")")->text(), "TRUE");
    EXPECT_FALSE(fs::exists(folder / "a.txt"));
    EXPECT_TRUE(fs::exists(folder / "b.txt"));
    EXPECT_EQ(engine().eval("(remove \"b.txt\")")->text(), "TRUE");
    EXPECT_FALSE(fs::exists(folder / "b.txt"));
    EXPECT_EQ(engine().eval("(remove \"b.txt\")")->text(), "FALSE");
    EXPECT_THAT(engine().eval("(remove \"/secret/key\")").error().message, HasSubstr("may not write /secret/key"));
    EXPECT_THAT(engine().eval("(rename \"b.txt\" \"/secret/key\")").error().message, HasSubstr("may not write"));
    if (trusted)
      EXPECT_THAT(tape.looked, ElementsAre("rename", "remove", "remove"));
    else
      EXPECT_THAT(tape.looked, IsEmpty());
  }
}

TEST_F(Builtins, AFileWithAnErrorInItsFirstLineIsReadAllTheSame) {
  with_files();
  write("wrong.clp", "(defrule go (a) => (no-such-function))\n(deffacts f (a))\n");
  EXPECT_EQ(engine().eval("(batch* \"wrong.clp\")")->text(), "TRUE");
  ASSERT_THAT(engine().take_errors(), SizeIs(1));
  EXPECT_EQ(engine().eval("(load* \"wrong.clp\")")->text(), "FALSE");
  const std::vector<RuleError> errors = engine().take_errors();
  ASSERT_THAT(errors, SizeIs(1));
  EXPECT_EQ(errors[0].line, 1);
  EXPECT_EQ(errors[0].file, "wrong.clp");
}

TEST_F(Builtins, TheTerminalIsReadByTrustedRulesAlone) {
  EXPECT_EQ(engine().eval("(read)")->text(), "EOF");
  EXPECT_EQ(engine().eval("(readline)")->text(), "EOF");
  EXPECT_EQ(engine().eval("(get-char)")->as_integer(), -1);
  EngineOptions o = options();
  o.trust_rules = true;
  tape.replay = true;
  tape.kept = Value::integer('7');
  o.outside = &tape;
  EXPECT_EQ(make(std::move(o))->eval("(get-char)")->as_integer(), '7');
  EXPECT_THAT(tape.looked, ElementsAre("terminal"));
}

TEST_F(Builtins, TheClockOfTheMachineIsNotSeen) {
  EXPECT_THAT(engine().eval("(profile constructs)").error().message, HasSubstr("a profile has the machine's time"));
  EXPECT_TRUE(engine().eval("(profile off)").ok());
  given("(defrule go (a) =>)");
  EXPECT_TRUE(engine().eval("(watch statistics)").ok());
  EXPECT_THAT(output["stderr"], HasSubstr("statistics are not watched"));
  EXPECT_TRUE(engine().eval("(watch all)").ok());
  EXPECT_TRUE(engine().watch("statistics"));
  ASSERT_TRUE(engine().assert_string("(a)").ok());
  EXPECT_EQ(engine().run().fired, 1);
  EXPECT_THAT(output["stdout"], AllOf(HasSubstr("FIRE"), Not(HasSubstr("Run time"))));
}

TEST_F(Builtins, TheStrategyRandomIsRefused) {
  EXPECT_THAT(engine().eval("(set-strategy random)").error().message, HasSubstr("the strategy 'random' draws from"));
  EXPECT_EQ(engine().eval("(set-strategy breadth)")->text(), "depth") << "the former one";
  EXPECT_EQ(engine().eval("(get-strategy)")->text(), "breadth");
}

TEST_F(Builtins, TextThatIsNestedTooDeepIsNotRead) {
  const auto nested = [](int depth) {
    std::string text;
    for (int i = 1; i < depth; ++i) text += "(+ 1 ";
    return text + "(+ 0 1)" + std::string(static_cast<std::size_t>(depth) - 1, ')');
  };
  given("(deffunction text (?t) ?t) (deftemplate a (slot x))");
  EXPECT_EQ(engine().eval("(eval \"" + nested(kDeepestForm) + "\")")->as_integer(), kDeepestForm);
  for (const std::string& call :
       {"(eval \"" + nested(kDeepestForm + 1) + "\")", "(build \"(deffunction deep () " + nested(kDeepestForm) + ")\")",
        "(assert-string \"(a (x =" + nested(kDeepestForm) + "))\")"})
    EXPECT_THAT(engine().eval(call).error().message, HasSubstr("nested more than 1000 deep")) << call.substr(0, 20);
}

TEST_F(Builtins, FilesLoadedByRulesAreReadFormByForm) {
  with_files();
  write("more.clp",
        "(defrule more\n  (a)\n  =>\n  (undefined))\n\n(defrule fine (a) => (assert (fine)))\n(defrule open\n (a)\n");
  write("calls.bat", "(assert (called))\n(assert (b)\n");
  given(
      "(deffacts f (a))\n(defrule loads (declare (salience 1)) (a) => (assert (loaded (load* \"more.clp\") (batch* "
      "\"calls.bat\"))))");
  engine().reset();
  const RunReport report = engine().run();
  std::vector<std::string> texts;
  for (const RuleError& error : report.errors) texts.push_back(error.text());
  EXPECT_THAT(texts, ElementsAre(HasSubstr("more.clp:4: [EXPRNPSR3]"), HasSubstr("more.clp:7: found no closing"),
                                 HasSubstr("calls.bat:2: found no closing")));
  EXPECT_THAT(fact_texts(), ElementsAre("(a)", "(called)", "(loaded FALSE TRUE)", "(fine)"));
  EXPECT_EQ(engine().find_construct("defrule", "fine")->file, "more.clp");
}

TEST_F(Builtins, AFileOfTheHostGoesThroughTheAccessToo) {
  with_files();
  write("rules.clp", "(defrule one (a) =>)");
  write("empty.clp", "");
  EXPECT_TRUE(engine().load_file("rules.clp", LoadMode::kConstructs).ok());
  EXPECT_TRUE(files->read.contains("rules.clp"));
  EXPECT_TRUE(engine().load_file("empty.clp", LoadMode::kConstructs).ok());
  EXPECT_THAT(engine().load_file("missing.clp", LoadMode::kConstructs).status().error().text(),
              "missing.clp: there is no such file");
}

TEST_F(Builtins, StrangersMayNotRunPrograms) {
  with_files();
  given("(deffacts f (a))\n(defrule evil (a) => (system \"touch \" \"/tmp/owned\"))");
  engine().reset();
  const RunReport report = engine().run();
  ASSERT_THAT(report.errors, SizeIs(1));
  EXPECT_THAT(report.errors[0].text(),
              AllOf(HasSubstr("rules.clp:2: rule evil, RHS"), HasSubstr("refused to rules that are not trusted")));
  EXPECT_FALSE(engine().eval("(chdir \"/\")").ok());
}

TEST_F(Builtins, TrustedRulesMayAndTheAnswerIsOnTheTape) {
  EngineOptions o = options();
  o.outside = &tape;
  o.trust_rules = true;
  engine_ = make(std::move(o));
  EXPECT_EQ(engine().eval("(system \"exit 0\")")->as_integer(), 0);
  EXPECT_THAT(tape.looked, ElementsAre("system"));
}

TEST_F(Builtins, WithoutATapeTheMachineAnswers) { EXPECT_GT(engine().eval("(mem-used)")->as_integer(), 0); }

TEST_F(Builtins, WhatDiffersBetweenMachinesIsAnsweredFromTheTape) {
  with_files();
  KeptRecords sink;
  EngineOptions o = options();
  o.outside = &tape;
  o.journal = &sink;
  engine_ = make(std::move(o));
  EXPECT_GT(engine().eval("(mem-used)")->as_integer(), 0);
  tape.replay = true;
  tape.kept = Value::integer(1234);
  EXPECT_EQ(*engine().eval("(mem-used)"), Value::integer(1234));
  ASSERT_THAT(sink.of(RecordKind::kInput), SizeIs(2));
  EXPECT_THAT(sink.of(RecordKind::kInput)[0].data, HasSubstr("mem-used"));
  EXPECT_THAT(sink.of(RecordKind::kInput)[0].data, HasSubstr("deterministic\xc2")) << "false in MessagePack";
}

TEST_F(Builtins, ExitEndsTheRunAndNotTheProcess) {
  given("(deffacts f (a))\n(defrule leave (a) => (exit) (assert (after)))");
  engine().reset();
  EXPECT_THAT(engine().run().errors, IsEmpty());
  EXPECT_TRUE(engine().exit_requested());
  EXPECT_THAT(fact_texts("after"), IsEmpty());
}

}  // namespace
}  // namespace cxlab
