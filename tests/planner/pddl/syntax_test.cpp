#include "planner/pddl/syntax.h"

#include <gtest/gtest.h>

namespace cxlab::planner {
namespace {

TEST(Syntax, WordsAreLowerCaseAndLinesCounted) {
  const auto syntax = read_syntax("; first\n(Define\n  (DOMAIN Foo) ; more\n\n  x)", "a.pddl");
  ASSERT_TRUE(syntax) << syntax.error().text();
  EXPECT_EQ(syntax->root.head(), "define");
  EXPECT_EQ(syntax->root.line, 2);
  EXPECT_EQ(excerpt(syntax->root), "(define (domain foo) x)");
  EXPECT_EQ(syntax->root.items[2].line, 5);
}

std::string error_of(std::string_view text) {
  const auto syntax = read_syntax(text, "a.pddl");
  return syntax ? "no error" : syntax.error().text();
}

TEST(Syntax, AnExcerptIsCutAfterSixtyCharacters) {
  const auto cut = [](const std::string& text) { return excerpt(read_syntax(text, "a.pddl")->root); };
  const std::string sixty(60, 'x');
  EXPECT_EQ(cut("(a " + sixty + "y)"), "(a " + sixty + ")");
  EXPECT_EQ(cut("(a " + sixty + "y b)"), "(a " + sixty + " ...)");
  EXPECT_EQ(cut("(a (" + sixty + " b) c)"), "(a (" + sixty + " ...) ...)");
  EXPECT_EQ(cut("(a " + sixty.substr(4) + " b)"), "(a " + sixty.substr(4) + " b)");
}

TEST(Syntax, AListWithoutEndIsReportedWhereItBegins) {
  EXPECT_EQ(error_of("(define\n  (domain\n  foo)\n"),
            "a.pddl:1: found the end of the file, expected a ')' for the list that begins here");
  EXPECT_EQ(error_of("(define)\n)"), "a.pddl:2: found a ')' that closes nothing, expected the end of the file");
  EXPECT_EQ(error_of("(define)\n(define)"),
            "a.pddl:2: found more text behind the closing ')' of (define ...), expected the end of the file");
  EXPECT_EQ(error_of(" \n"), "a.pddl:2: the file is empty; expected (define ...)");
  EXPECT_EQ(error_of("domain"), "a.pddl:1: found 'domain', expected (define ...)");
}

TEST(Syntax, LongNamesOfSectionsAreCutAfter60Characters) {
  const std::string error = error_of("(define (domain d\n(:" + std::string(70, 'x') + " t)");
  EXPECT_EQ(error, "a.pddl:1: found (:" + std::string(59, 'x') +
                       " in line 2, expected a ')' before it for the list that begins here");
}

TEST(Syntax, SectionInsideAnotherNamesTheOneThatWasNotClosed) {
  EXPECT_EQ(error_of("(define (domain d)\n(:action a\n :effect (x)\n\n(:action b))"),
            "a.pddl:2: found (:action in line 5, expected a ')' before it for the section :action that begins here");
  EXPECT_EQ(error_of("(define (domain d\n(:types t)\n(:action b))"),
            "a.pddl:1: found (:types in line 2, expected a ')' before it for the list that begins here");
  EXPECT_EQ(error_of("(define (domain d)\n(:types t))\n(:action b))"),
            "a.pddl:3: found more text behind the closing ')' of (define ...), expected the end of the file; the last "
            "section before it, :types, begins in line 2");
  EXPECT_EQ(error_of("(define (domain d)\n(:types t)\n"),
            "a.pddl:1: found the end of the file, expected a ')' for the list that begins here; the last section "
            "before it, :types, begins in line 2");
}

TEST(Syntax, RejectsControlCharactersInNames) {
  EXPECT_EQ(error_of(std::string_view("(define\n a\0b)", 13)),
            "a.pddl:2: found a control character (code 0) in a name, expected text");
}

TEST(Syntax, DeepNestingIsAnErrorNotAnOverflow) {
  EXPECT_EQ(error_of(std::string(100000, '(')), "a.pddl:1: lists are nested more than 200 deep");
}

TEST(Syntax, NumbersAreFiniteAndWhole) {
  double number = 0;
  EXPECT_TRUE(to_number("-12.5", number));
  EXPECT_EQ(number, -12.5);
  EXPECT_TRUE(to_number("+.5", number));
  EXPECT_EQ(number, 0.5);
  EXPECT_TRUE(to_number("1e3", number));
  for (const char* word : {"", "-", "inf", "nan", "-inf", "1x", "0x10", ".", "1e999"})
    EXPECT_FALSE(to_number(word, number)) << word;
}

}  // namespace
}  // namespace cxlab::planner
