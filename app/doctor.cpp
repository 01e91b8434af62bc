// cxlab doctor: what this machine has, what is missing, and the remedy.

#include <cstdio>

#include "app/command.h"
#include "cx/base/json.h"
#include "lab/doctor.h"

namespace cxlab::app {

namespace {

using Verdict = lab::Finding::Verdict;

const char* word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood: return "ok";
    case Verdict::kOptional: return "note";
    case Verdict::kMissing: return "MISSING";
  }
  return "";
}

int doctor(bool json) {
  bool complete = true;
  Json list = Json::array();
  for (const lab::Finding& f : lab::examine_machine()) {
    complete = complete && f.verdict != Verdict::kMissing;
    if (json)
      list.push_back({{"what", f.what}, {"verdict", word(f.verdict)}, {"found", f.found}, {"remedy", f.remedy}});
    else
      std::printf("%-8s %-13s %s%s%s\n", word(f.verdict), f.what.c_str(), f.found.c_str(), f.remedy.empty() ? "" : "; ",
                  f.remedy.c_str());
  }
  if (json) std::printf("%s\n", json_text(list, 2).c_str());
  return complete ? 0 : static_cast<int>(ErrorKind::kResource);
}

}  // namespace

void add_doctor(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("doctor", "Report what this machine has, what is missing and the remedy; needs no network");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Prints the findings as JSON");
  command->callback([json, &action] { action = [json] { return doctor(*json); }; });
}

}  // namespace cxlab::app
