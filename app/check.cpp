// cxlab check: finds faults in a rule base without running it.

#include <cstdio>
#include <filesystem>
#include <memory>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/suggestions.h"
#include "cx/base/file.h"
#include "cx/base/json.h"
#include "lab/check.h"

namespace cxlab::app {

namespace {

struct CheckCommand {
  lab::CheckOptions check;
  std::string graph;
  bool json = false;
};

std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + ' ' + what + (count == 1 ? "" : "s");
}

void print_json(const lab::Checked& checked) {
  Json findings = Json::array();
  for (const check::Finding& finding : checked.findings)
    findings.push_back(
        {{"file", finding.file}, {"line", finding.line}, {"code", finding.code}, {"message", finding.message}});
  std::printf("%s\n",
              json_text(Json{{"files", checked.files}, {"rules", checked.rules}, {"findings", findings}}, 2).c_str());
}

void print_text(const lab::Checked& checked) {
  for (const check::Finding& finding : checked.findings) std::printf("%s\n", printable(finding.text()).c_str());
  const std::size_t found = checked.findings.size();
  std::printf("%s in %s: %s\n", counted(checked.rules, "rule").c_str(), counted(checked.files, "file").c_str(),
              found == 0 ? "nothing found" : counted(found, "finding").c_str());
}

std::string codes_text() {
  std::string text = "The findings, by their codes:\n";
  for (const check::Code& code : check::codes()) {
    constexpr std::size_t kColumn = 18;
    text +=
        "  " + std::string(code.name) + std::string(kColumn - code.name.size(), ' ') + std::string(code.meaning) + '\n';
  }
  return text;
}

int examine(const CheckCommand& command) {
  lab::CheckOptions options = command.check;
  const std::filesystem::path graph(command.graph);
  if (!command.graph.empty()) {
    if (graph.extension() != ".svg" && graph.extension() != ".dot")
      return fail(usage_error("--graph: " + found_text(command.graph, "a file that ends in .svg or .dot")));
    options.graph = true;
    options.dot = graph.extension() == ".dot";
  }
  if (!command.graph.empty())
    if (Status s = make_folder_of(graph); !s) return fail(s.error());
  // Opened before this process gives up its rights to files of the user (cx/wall/wall.h).
  const auto close = [](std::FILE* file) { return std::fclose(file); };
  std::unique_ptr<std::FILE, decltype(close)> drawing(
      command.graph.empty() ? nullptr : std::fopen(command.graph.c_str(), "w"), close);
  if (!command.graph.empty() && !drawing) return fail(resource_error("cannot be written", command.graph));
  Console console(true);
  const auto checked = lab::check_rules(options, catalogue(), console.host());
  if (const int code = interrupted("the rules were not examined to the end")) return code;
  if (!checked) return fail(checked.error());
  if (drawing && (std::fputs(checked->graph.c_str(), drawing.get()) < 0 || std::fflush(drawing.get()) != 0))
    return fail(resource_error("cannot be written", command.graph));
  command.json ? print_json(*checked) : print_text(*checked);
  return checked->findings.empty() ? 0 : static_cast<int>(ErrorKind::kNo);
}

}  // namespace

void add_check(CLI::App& app, Action& action) {
  auto options = std::make_shared<CheckCommand>();
  CLI::App* command = app.add_subcommand("check", "Examine rules without running them (docs/reference/check.md)");
  command->footer(std::string("Examples:\n  cxlab check rcll/game\n  cxlab check my_agent/params/agent.yaml --graph "
                              "rules.svg\n  cxlab check "
                              "my_agent/clips/*.clp\n") +
                  codes_text() +
                  "A comment '; check: allow CODE' at the end of a line, or on the line above, silences a finding.\n"
                  "Exit codes: 0 nothing found; 1 findings; 3 an input cannot be read.");
  suggest(command
              ->add_option("inputs", options->check.inputs,
                           "Scenarios, configurations of the CLIPS-Executive (YAML), or rule files, which are one "
                           "rule base")
              ->required(),
          scenario_names, /*files=*/true);
  once_each(
      command->add_option("--param", options->check.params, "NODE.NAME=VALUE: changes a parameter of configurations"));
  add_package_options(*command, options->check.packages);
  command->add_option("--graph", options->graph,
                      "Draws which rules produce and consume which facts: FILE.svg, or FILE.dot for Graphviz");
  command->add_flag("--json", options->json, "Prints the findings as JSON");
  command->callback([options, &action] { action = [options] { return examine(*options); }; });
}

}  // namespace cxlab::app
