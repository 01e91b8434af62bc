// PDDL: the text up to a line `---` is the domain, the rest the problem. A problem that can be read is written, and
// reads back the same.

#include "planner/pddl/parser.h"
#include "planner/pddl/text.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_pddl_parser {

FUZZ_TARGET(pddl_parser) {
  using namespace cxlab::planner;
  using cxlab::fuzz::promise;
  const std::string text = cxlab::fuzz::text_of(data, size);
  const std::size_t split = text.find("\n---\n");
  const auto domain = parse_domain(text.substr(0, split), "d.pddl");
  if (!domain) {
    promise(domain.error().file == "d.pddl" && domain.error().line > 0, "an error of a domain has its file and line");
    return 0;
  }
  const std::string written = to_pddl(*domain);
  const auto again = parse_domain(written, "written.pddl");
  promise(again.ok(), "a domain that was written can be read: " + (again ? "" : again.error().text()) + "\n" + written);
  promise(to_pddl(*again) == written, "a domain that was written reads back the same:\n" + written);
  if (split == std::string::npos) return 0;
  const auto problem = parse_problem(text.substr(split + 5), "p.pddl", *domain);
  if (!problem) {
    promise(problem.error().file == "p.pddl" && problem.error().line > 0,
            "an error of a problem has its file and line");
    return 0;
  }
  const std::string written_problem = to_pddl(*domain, *problem);
  const auto problem_again = parse_problem(written_problem, "written.pddl", *domain);
  promise(problem_again.ok(), "a problem that was written can be read: " +
                                  (problem_again ? "" : problem_again.error().text()) + "\n" + written_problem);
  promise(to_pddl(*domain, *problem_again) == written_problem,
          "a problem that was written reads back the same:\n" + written_problem);
  return 0;
}

}  // namespace fuzz_pddl_parser
