// cxlab ask: questions of a program about a run, a line of JSON each way.

#include <cstdio>
#include <iostream>
#include <memory>
#include <string>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/json.h"
#include "lab/run.h"
#include "lab/view/players.h"
#include "lab/view/visit.h"

namespace cxlab::app {

namespace {

struct LineQuestions {
  std::string run;
  bool trust_programs = false;
};

int answer_lines(const LineQuestions& options) {
  Console console(true);
  if (const auto run = lab::Run::open(options.run, catalogue(), options.trust_programs); !run) return fail(run.error());
  auto players = lab::Players::start(options.run, catalogue(), options.trust_programs, console.host());
  if (!players) return fail(players.error());
  lab::Visit visit(options.run, *players);
  for (std::string line; std::getline(std::cin, line);) {
    const Json request = parse_json(line);
    lab::ViewReply reply = visit.ask(request);
    if (reply.status != 200) {
      Json error = parse_json(reply.body);
      error["status"] = reply.status;
      reply.body = json_text(error);
    }
    std::printf("%s\n", reply.body.c_str());
    if (std::fflush(stdout) != 0) break;  // nobody reads the answers any more
  }
  return interrupted("nothing was written");
}

}  // namespace

void add_ask(CLI::App& app, Action& action) {
  auto options = std::make_shared<LineQuestions>();
  CLI::App* command =
      app.add_subcommand("ask", "Answer questions of a program about a run: a line of JSON in, a line of JSON out");
  add_limit_options(*command);
  command->add_option("run", options->run, "Folder of the run")->required();
  add_trust_programs(*command, options->trust_programs);
  command->footer(
      "It reads questions from standard input until that ends. It stays at the time of the last question, and goes on\n"
      "from there for the next one. docs/reference/questions.md lists the questions.\n"
      "Examples:\n  echo '{\"ask\": \"why_not\", \"what\": \"order-begin\", \"t\": 312}' | cxlab ask runs/game-1");
  command->callback([options, &action] { action = [options] { return answer_lines(*options); }; });
}

}  // namespace cxlab::app
