// cxlab profile: where the rules of a recorded run spend their time.

#include "lab/profile.h"

#include <cstdio>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/base/file.h"

namespace cxlab::app {

namespace {

struct ProfileOptions {
  Question question;
  std::string page, trace;
  int most = 15;
};

int profile(const ProfileOptions& options) {
  const Question& question = options.question;
  auto run = open_run(question.run, question.trust_programs);
  if (!run) return fail(run.error());
  Console console(true);
  const auto found = lab::profile_of(*run, question.at ? std::optional(from_seconds(*question.at)) : std::nullopt,
                                     question.environment, !options.trace.empty(), console.host());
  if (const int code = interrupted("the run was not replayed up to that time")) return code;
  if (!found) return fail(lab::about_option(found.error(), "--at"));
  if (question.json) {
    std::printf("%s\n", json_text(lab::json_of(*found), 2).c_str());
  } else {
    if (found->cut_off)
      std::printf("up to the tick at %s%s:\n", seconds_text(from_seconds(found->at_s)).c_str(),
                  run->cut_off_text("log").c_str());
    std::printf("%s", lab::text_of(*found, static_cast<std::size_t>(options.most)).c_str());
  }
  if (!options.page.empty()) {
    const auto page = lab::to_page(*found, "Profile of " + question.run);
    if (!page) return fail(page.error());
    if (Status s = write_output(options.page, *page); !s) return fail(s.error());
  }
  if (options.trace.empty()) return 0;
  const Status written = write_output(options.trace, lab::to_trace(*found));
  return written ? 0 : fail(written.error());
}

}  // namespace

void add_profile(CLI::App& app, Action& action) {
  auto options = std::make_shared<ProfileOptions>();
  CLI::App* command = app.add_subcommand(
      "profile", "Report how much time and how many partial matches each rule, condition and function of a run takes");
  add_question(*command, options->question, Times::kAt);
  whole_number(command->add_option("--most", options->most, "Rows of each table of the text (default 15)"), 1, 100000);
  command->add_option("--html", options->page, "Writes a page with all rules, which needs no other file");
  command->add_option("--trace", options->trace,
                      "Writes firings, calls and matching along the time of the replay, for ui.perfetto.dev");
  command->footer(
      "cxlab plays the rules again twice, with and without profiling. The first line tells the cost of profiling.\n"
      "Times depend on this machine, and differ a little each time (docs/how-to/profile-rules.md).\n"
      "Examples:\n  cxlab profile runs/game-1\n  cxlab profile runs/game-1 --at 5:00 --html profile.html --trace "
      "trace.json");
  command->callback([options, &action] { action = [options] { return profile(*options); }; });
}

}  // namespace cxlab::app
