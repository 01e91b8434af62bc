#include "cx/engine/form_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "cx/base/random.h"

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> heads(const FormReading& reading) {
  std::vector<std::string> list;
  for (const Form& form : reading.forms) list.push_back(form.head + "/" + form.name + "@" + std::to_string(form.line));
  return list;
}

std::vector<std::string> errors(const FormReading& reading) {
  std::vector<std::string> list;
  for (const Error& error : reading.errors) list.push_back(error.text());
  return list;
}

TEST(FormReader, GivesEachFormItsHeadItsNameAndItsLine) {
  const FormReading reading =
      read_forms("; a comment (with parentheses\n\n(defrule MAIN::go (a) => (b))\n  (reset)\n", "f.clp");
  EXPECT_THAT(heads(reading), ElementsAre("defrule/go@3", "reset/@4"));
  EXPECT_EQ(reading.forms[0].text, "(defrule MAIN::go (a) => (b))");
  EXPECT_THAT(reading.errors, IsEmpty());
}

TEST(FormReader, ParenthesesInStringsAndCommentsDoNotCount) {
  const FormReading reading = read_forms("(a \")\\\" (\" ; )))\n b)\n(c)", "f.clp");
  EXPECT_THAT(heads(reading), ElementsAre("a/@1", "c/@3"));
  EXPECT_THAT(reading.errors, IsEmpty());
}

TEST(FormReader, AByteOrderMarkBeforeTheFirstFormIsNoWord) {
  const FormReading reading = read_forms("\xef\xbb\xbfgo (a)\n(b)", "f.clp");
  EXPECT_THAT(heads(reading), ElementsAre("go/@1", "a/@1", "b/@2"));
  EXPECT_THAT(reading.errors, IsEmpty());
}

TEST(FormReader, BareWordsAreFormsOfTheirOwn) {
  const FormReading reading = read_forms("TRUE 12\n\"text\" (a)", "f.clp");
  EXPECT_THAT(heads(reading), ElementsAre("TRUE/@1", "12/@1", "\"text\"/@2", "a/@2"));
  EXPECT_FALSE(reading.forms[0].list);
}

TEST(FormReader, AFormThatIsNeverClosedIsAnErrorWhereItBegins) {
  const FormReading reading = read_forms("(a)\n\n(defrule broken\n  (b)\n  =>\n  (c)\n", "f.clp");
  EXPECT_THAT(heads(reading), ElementsAre("a/@1"));
  EXPECT_THAT(errors(reading),
              ElementsAre(HasSubstr("f.clp:3: found no closing parenthesis for (defrule broken ...)")));
}

TEST(FormReader, ReadingGoesOnAtTheNextConstructInColumnOne) {
  const FormReading reading = read_forms("(defrule broken\n  (b)\n  =>\n\n(defrule fine (a) =>)\n", "f.clp");
  EXPECT_THAT(heads(reading), ElementsAre("defrule/fine@5"));
  EXPECT_THAT(errors(reading), ElementsAre(HasSubstr("the next construct begins in line 5")));
}

TEST(FormReader, AStrayClosingParenthesisIsAnErrorAndSkipped) {
  const FormReading reading = read_forms("(a))\n(b)", "f.clp");
  EXPECT_THAT(heads(reading), ElementsAre("a/@1", "b/@2"));
  EXPECT_THAT(errors(reading), ElementsAre("f.clp:1: found ')' that closes nothing"));
}

TEST(FormReader, AStringThatIsNeverClosedIsNamed) {
  const FormReading reading = read_forms("(a\n \"oh", "f.clp");
  EXPECT_THAT(errors(reading), ElementsAre(HasSubstr("a string that begins in line 2 is never closed")));
}

TEST(FormReader, AZeroByteIsAnError) {
  const FormReading reading = read_forms(std::string_view("(a)\n(b\0 c)", 10), "f.clp");
  EXPECT_THAT(heads(reading), ElementsAre("a/@1"));
  EXPECT_THAT(errors(reading), ElementsAre("f.clp:2: found a zero byte, expected text"));
}

TEST(FormReader, AFormThatIsNestedTooDeepIsAnErrorAndSkipped) {
  const auto nested = [](int depth) {
    return "(a\n" + std::string(static_cast<std::size_t>(depth) - 1, '(') + "x" +
           std::string(static_cast<std::size_t>(depth), ')') + "\n(b)";
  };
  EXPECT_EQ(read_forms(nested(kDeepestForm), "f.clp").forms.size(), 2U);
  const FormReading deep = read_forms(nested(kDeepestForm + 1), "f.clp");
  ASSERT_EQ(deep.forms.size(), 1U);
  EXPECT_EQ(deep.forms.front().head, "b");
  ASSERT_EQ(deep.errors.size(), 1U);
  EXPECT_EQ(deep.errors.front().text(), "f.clp:2: found parentheses nested more than 1000 deep");
}

TEST(FormReader, AFormThatIsTooWideIsAnErrorAndSkipped) {
  const auto wide = [](int parts) {
    std::string text = "(a\n(b";
    for (int i = 1; i < parts; ++i) text += " 1&~2|";
    return text + " (x)))\n(c)";
  };
  EXPECT_EQ(read_forms(wide(kWidestForm / 2), "f.clp").forms.size(), 2U);
  const FormReading reading = read_forms(wide(kWidestForm / 2 + 2), "f.clp");
  ASSERT_EQ(reading.forms.size(), 1U);
  EXPECT_EQ(reading.forms.front().head, "c");
  ASSERT_EQ(reading.errors.size(), 1U);
  EXPECT_EQ(reading.errors.front().text(), "f.clp:2: found a form with more than 30000 parts on one level");
}

TEST(FormReader, ExcessIsThatOfListsOutsideOfStringsAndComments) {
  const std::string deep(kDeepestForm + 1, '('), wide(2 * kWidestForm + 2, ' ');
  EXPECT_EQ(excess_of("a b"), "");
  EXPECT_EQ(excess_of("(a \"" + deep + "\" ; " + deep + "\n (b))"), "");
  EXPECT_EQ(excess_of(deep.substr(1)), "");
  EXPECT_EQ(excess_of(deep), "found parentheses nested more than 1000 deep");
  EXPECT_EQ(excess_of("))) (a)" + wide), "");
  std::string parts = wide;
  for (std::size_t i = 0; i < parts.size(); i += 2) parts[i] = 'x';
  EXPECT_EQ(excess_of(parts), "") << "forms, not parts of one";
  EXPECT_EQ(excess_of("(a (" + parts + "))"), "found a form with more than 30000 parts on one level");
}

TEST(FormReader, TokensHaveTheirLineInTheFile) {
  const FormReading reading = read_forms("\n(a ; no\n  ?x&:(f \"s\"))", "f.clp");
  std::vector<std::string> list;
  for (const Token& token : tokens_of(reading.forms[0]))
    list.push_back(std::string(token.text) + "@" + std::to_string(token.line));
  EXPECT_THAT(list, ElementsAre("(@2", "a@2", "?x@3", "&@3", ":@3", "(@3", "f@3", "\"s\"@3", ")@3", ")@3"));
}

// Whatever bytes come: no crash, lines in order and within the file, every form balanced and found in the text.
TEST(FormReader, SurvivesTenThousandMutations) {
  const std::string original =
      "; rules\n(defrule go \"a (doc\" (a ?x&:(> ?x 1)) => (printout t \"x\\\"\" crlf))\n(deffacts f (a 1))\nTRUE\n";
  RandomStream random(3, "mutations");
  const std::string alphabet = "()\"\\;&|~ \nax\t\r";
  for (int round = 0; round < 10000; ++round) {
    std::string text = original;
    for (std::uint64_t i = random.below(8); i-- > 0;) {
      const std::size_t at = random.below(text.size());
      switch (random.below(3)) {
        case 0: text[at] = alphabet[random.below(alphabet.size())]; break;
        case 1: text.erase(at, random.below(5)); break;
        default: text.insert(at, 1, static_cast<char>(random.below(256)));
      }
    }
    const FormReading reading = read_forms(text, "f.clp");
    int line = 1;
    for (const Form& form : reading.forms) {
      ASSERT_GE(form.line, line) << text;
      line = form.line;
      ASSERT_NE(text.find(form.text), std::string::npos);
      int depth = 0;
      for (const Token& token : tokens_of(form)) {
        depth += token.kind == Token::Kind::kOpen;
        depth -= token.kind == Token::Kind::kClose;
        ASSERT_GE(depth, 0) << text;
      }
      ASSERT_EQ(depth, 0) << text;
    }
    const auto lines = 1 + std::count(text.begin(), text.end(), '\n');
    for (const Error& error : reading.errors) ASSERT_TRUE(error.line >= 1 && error.line <= lines) << text;
  }
}

TEST(FormReader, EachOfTheseEndsAWord) {
  for (const char* end : {" ", "\t", "\n", "\r", "\f", "\v", "(", ")", "\"", "&", "|", "~", ";", "<"}) {
    Form form;
    form.text = "(word" + std::string(end) + "x)";
    const std::vector<Token> tokens = tokens_of(form);
    ASSERT_GE(tokens.size(), 2u);
    EXPECT_EQ(tokens[1].text, "word") << end;
  }
}

TEST(FormReader, ATermIsPrintedAsClipsReadsIt) {
  const std::string rule = "(defrule r ?f<-(a (x ~1&?v | 2)   (y ?v&:(<= ?v 3)&=(+ ?v 1))) =>)";
  const Term term = tree_of(read_forms(rule, "f.clp").forms.front());
  EXPECT_EQ(term.print(), "(defrule r ?f <- (a (x ~1&?v|2) (y ?v&:(<= ?v 3)&=(+ ?v 1))) =>)");
  for (const char* same : {"(a =(+ 1 2))", "(a :(> 1 2) b)", "(a ~=(+ 1 2) (b))", "(a (b) ~c)", "((a))", "()"})
    EXPECT_EQ(tree_of(read_forms(same, "f.clp").forms.front()).print(), same);
}

void expect_places(const Term& term, const std::string& form) {
  const std::string text = form.substr(term.begin, term.end - term.begin);
  if (!term.is_list()) {
    EXPECT_EQ(text, term.text);
    return;
  }
  EXPECT_EQ(text.front(), '(') << text;
  EXPECT_EQ(text.back(), ')') << text;
  for (const Term& item : term.items) expect_places(item, form);
}

TEST(FormReader, TellsWhereFormsAndTheirPartsStand) {
  const std::string text =
      "\xef\xbb\xbf; first\n(defrule a ?f<-(b \"c ; (d)\" ~e|f) ; (not this)\n  () (test (> 1 2)) => (g))\nword\n(h)";
  const FormReading reading = read_forms(text, "f.clp");
  ASSERT_EQ(reading.forms.size(), 3u);
  for (const Form& form : reading.forms) {
    EXPECT_EQ(text.substr(form.at, form.text.size()), form.text);
    expect_places(tree_of(form), form.text);
  }
}

}  // namespace
}  // namespace cxlab
