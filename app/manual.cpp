// cxlab help, man and completion.

#include <cstdio>

#include "app/arguments.h"
#include "app/command.h"
#include "app/exit_codes.h"
#include "app/suggestions.h"
#include "cx/base/json.h"
#include "lab/page.h"
#include "lab/versions.h"

namespace cxlab::app {

namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) { return app.get_subcommands(nullptr); }

/// A command with its options and subcommands: what lab/pages/cxlab.1, completion.bash and completion.zsh read;
/// `suggestions`: with names that completion offers.
Json describe(const CLI::App& command, bool suggestions) {
  Json options = Json::array(), nested = Json::array();
  for (const CLI::Option* option : command.get_options()) {
    const Suggested suggested = suggestions ? suggested_for(*option) : Suggested();
    options.push_back({{"names", names_of(*option)},
                       {"label", option->get_positional() ? option->get_name(true) : all_names(*option)},
                       {"description", option->get_description()},
                       {"positional", option->get_positional()},
                       {"required", option->get_required()},
                       {"many", option->get_items_expected_max() > 1},
                       {"takes_value", option->get_items_expected_max() > 0},
                       {"values", words_of(*option)},
                       {"type", option->get_type_name()},
                       {"default", option->get_default_str()},
                       {"suggested", suggested.names},
                       {"files", suggested.files}});
  }
  for (const CLI::App* sub : commands_of(command)) nested.push_back(describe(*sub, suggestions));
  const CLI::App* parent = command.get_parent();
  const std::string footer = command.get_footer();
  return {{"name", command.get_name()},
          {"description", command.get_description()},
          {"footer", parent && footer == parent->get_footer() ? "" : footer},
          {"options", options},
          {"commands", nested}};
}

Json describe_exit_codes() {
  Json rows = Json::array();
  for (const ExitCode& row : exit_codes())
    rows.push_back({{"code", row.code}, {"commands", row.commands}, {"meaning", row.meaning}});
  return rows;
}

/// Prints the template `page` of lab/pages, filled with what the commands declare.
int print_page(const CLI::App& app, const std::string& page, bool suggestions) {
  const auto text = lab::render_page(page, json_text(Json{{"cxlab", describe(app, suggestions)},
                                                          {"exit_codes", describe_exit_codes()},
                                                          {"version", lab::cxlab_version()}}));
  if (!text) return fail(text.error());
  std::fputs(text->c_str(), stdout);
  return 0;
}

}  // namespace

void add_help(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("help", "Show the help of cxlab or of a command");
  auto names = std::make_shared<std::vector<std::string>>();
  command->add_option("command", *names, "A command, and its subcommand");
  command->callback([&app, names, &action] {
    action = [&app, names] {
      const CLI::App* at = &app;
      std::string path;  // " new agent"
      for (const std::string& name : *names) {
        std::vector<std::string> known;
        const CLI::App* next = nullptr;
        for (const CLI::App* sub : commands_of(*at)) {
          known.push_back(sub->get_name());
          if (sub->get_name() == name) next = sub;
        }
        if (!next)
          return fail(
              usage_error("there is no command '" + (path + ' ' + name).substr(1) + "'" + did_you_mean(name, known)));
        at = next;
        path += ' ' + name;
      }
      std::fputs(app.get_formatter()->make_help(at, "cxlab" + path, CLI::AppFormatMode::Normal).c_str(), stdout);
      return 0;
    };
  });
}

void add_man(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("man", "Print the manual page (roff): cxlab man | man -l -");
  auto markdown = std::make_shared<bool>(false);
  command->add_flag("--markdown", *markdown, "As docs/reference/commands.md");
  command->callback([&app, markdown, &action] {
    action = [&app, markdown] { return print_page(app, *markdown ? "commands.md" : "cxlab.1", false); };
  });
}

void add_completion(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("completion", "Print a script that completes commands and options");
  command->footer("Examples:\n  source <(cxlab completion bash)\n  cxlab completion zsh > ~/.zfunc/_cxlab");
  auto shell = std::make_shared<std::string>();
  command->add_option("shell", *shell, "bash or zsh")->required()->check(one_of({"bash", "zsh"}));
  command->callback(
      [&app, shell, &action] { action = [&app, shell] { return print_page(app, "completion." + *shell, true); }; });
}

}  // namespace cxlab::app
