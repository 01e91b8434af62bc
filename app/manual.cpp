// cxlab help, man and completion.

#include "app/manual.h"

#include <cstdio>
#include <sstream>

#include "app/command.h"
#include "lab/versions.h"

namespace cxlab::app {

namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) { return app.get_subcommands(nullptr); }

/// "--seed", "-j": as it is written on the command line.
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> out;
  for (const std::string& name : option.get_snames()) out.push_back('-' + name);
  for (const std::string& name : option.get_lnames()) out.push_back("--" + name);
  return out;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

/// The values that an option takes if there are only some: those of "TEXT:{physics,timed}".
std::vector<std::string> values_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{'), end = type.find('}');
  std::vector<std::string> out;
  if (begin == std::string::npos || end == std::string::npos) return out;
  std::stringstream words(type.substr(begin + 1, end - begin - 1));
  for (std::string word; std::getline(words, word, ',');) out.push_back(word);
  return out;
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : between) + word;
  return out;
}

/// "run SCENARIO [OPTIONS]".
std::string usage_of(const CLI::App& command, std::string name) {
  for (const CLI::Option* option : command.get_options())
    if (option->get_positional()) {
      std::string word = option->get_name(true);
      for (char& c : word) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
      if (option->get_items_expected_max() > 1) word += "...";
      name += option->get_required() ? ' ' + word : " [" + word + ']';
    }
  return name + " [OPTIONS]";
}

// --- man

std::string roff(std::string text) {
  for (std::size_t at = 0; (at = text.find_first_of("\\-", at)) != std::string::npos; at += 2) text.insert(at, 1, '\\');
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
    if (text[at] == '.' || text[at] == '\'') text.insert(at, "\\&");
    if (text.find('\n', at) == std::string::npos) break;
  }
  return text;
}

void describe(const CLI::App& command, const std::string& name, std::string& out) {
  const auto nested = commands_of(command);
  for (const CLI::App* sub : nested) describe(*sub, name + ' ' + sub->get_name(), out);
  if (!nested.empty()) return;
  out += ".SS " + roff(usage_of(command, name)) + '\n' + roff(command.get_description()) + '\n';
  for (const CLI::Option* option : command.get_options()) {
    const std::string names = option->get_positional() ? option->get_name(true) : joined(names_of(*option), ", ");
    if (names == "-h, --help") continue;
    const std::vector<std::string> values = values_of(*option);
    const std::string value = !values.empty() ? joined(values, "|") : "VALUE";
    out += ".TP\n\\fB" + roff(names) + "\\fR" +
           (takes_value(*option) && !option->get_positional() ? " \\fI" + roff(value) + "\\fR" : "") + '\n' +
           roff(option->get_description()) + '\n';
  }
  if (const std::string footer = command.get_footer(); footer != command.get_parent()->get_footer())
    out += ".PP\n.nf\n" + roff(footer) + "\n.fi\n";
}

// --- completion

struct Words {
  std::vector<std::string> options, values;
  std::vector<std::pair<std::string, std::vector<std::string>>> values_of_options;
};

void add_words(const CLI::App& command, Words& words) {
  for (const CLI::App* sub : commands_of(command)) {
    words.values.push_back(sub->get_name());
    add_words(*sub, words);
  }
  for (const CLI::Option* option : command.get_options()) {
    const std::vector<std::string> values = values_of(*option), names = names_of(*option);
    words.options.insert(words.options.end(), names.begin(), names.end());
    if (option->get_positional()) words.values.insert(words.values.end(), values.begin(), values.end());
    if (!option->get_positional() && !values.empty()) words.values_of_options.emplace_back(joined(names, "|"), values);
  }
}

std::string in_single_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + '\'';
}

/// For a description inside of an argument of _arguments.
std::string zsh_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

}  // namespace

std::string manual_page(const CLI::App& app, const std::string& version) {
  const std::string about = app.get_description();
  const std::size_t colon = about.find(": ");
  std::string out = ".TH CXLAB 1 \"\" \"cxlab " + version + "\"\n.SH NAME\ncxlab \\- " + roff(about.substr(colon + 2)) +
                    "\n.SH SYNOPSIS\n\\fBcxlab\\fR \\fICOMMAND\\fR [\\fIARGUMENTS\\fR]\n.SH COMMANDS\n";
  for (const CLI::App* command : commands_of(app)) describe(*command, "cxlab " + command->get_name(), out);
  return out + ".SH EXIT STATUS\n" + roff(app.get_footer()) +
         "\n.SH ENVIRONMENT\n.TP\n\\fBCXLAB_PREFIX_PATH\\fR\nPrefixes below which packages are installed, separated by "
         "colons.\n.TP\n\\fBCXLAB_SHARE\\fR\nThe folder share/cxlab of the installation.\n.TP\n\\fBNO_COLOR\\fR\nNo "
         "colours on standard error.\n";
}

std::string bash_completion(const CLI::App& app) {
  std::vector<std::string> names;
  std::string cases;
  for (const CLI::App* command : commands_of(app)) {
    names.push_back(command->get_name());
    Words words;
    add_words(*command, words);
    cases += "    " + command->get_name() + ")\n      options='" + joined(words.options, " ") + "'\n      values='" +
             joined(words.values, " ") + "'\n";
    if (!words.values_of_options.empty()) {
      cases += "      case $previous in\n";
      for (const auto& [option, values] : words.values_of_options)
        cases += "        " + option + ") COMPREPLY=($(compgen -W '" + joined(values, " ") +
                 "' -- \"$current\")); return ;;\n";
      cases += "      esac\n";
    }
    cases += "      ;;\n";
  }
  return "# bash completion of cxlab; made by: cxlab completion bash\n_cxlab() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} options='--help --version' "
         "values\n"
         "  if [ \"$COMP_CWORD\" = 1 ]; then\n    values='" +
         joined(names, " ") + "'\n  else\n  case ${COMP_WORDS[1]} in\n" + cases +
         "  esac\n  fi\n  case $current in\n    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$current\")) ;;\n    *) "
         "COMPREPLY=($(compgen -W \"$values\" -- \"$current\"))\n"
         "       [ \"$COMP_CWORD\" = 1 ] || COMPREPLY+=($(compgen -f -- \"$current\")) ;;\n  esac\n}\n"
         "complete -o filenames -F _cxlab cxlab\n";
}

std::string zsh_completion(const CLI::App& app) {
  std::string names, cases;
  for (const CLI::App* command : commands_of(app)) {
    names += "    " + in_single_quotes(command->get_name() + ':' + zsh_text(command->get_description())) + '\n';
    cases += "    " + command->get_name() + ") _arguments";
    std::vector<const CLI::App*> parts = commands_of(*command);
    parts.insert(parts.begin(), command);
    std::string values;
    for (const CLI::App* part : parts) {
      if (part != command) values += ' ' + part->get_name();
      for (const CLI::Option* option : part->get_options()) {
        const std::string choice = joined(values_of(*option), " ");
        if (option->get_positional()) values += choice.empty() ? "" : ' ' + choice;
        for (const std::string& name : names_of(*option))
          cases += " \\\n      " + in_single_quotes((option->get_items_expected_max() > 1 ? "*" : "") + name + '[' +
                                                    zsh_text(option->get_description()) + ']' +
                                                    (!takes_value(*option) ? ""
                                                     : choice.empty()      ? ":value:_files"
                                                                           : ":value:(" + choice + ')'));
      }
    }
    cases += " \\\n      " +
             in_single_quotes("*:argument:" + (values.empty() ? "_files" : '(' + values.substr(1) + ')')) + " ;;\n";
  }
  return "#compdef cxlab\n# zsh completion of cxlab; made by: cxlab completion zsh\n_cxlab() {\n  local -a commands\n"
         "  commands=(\n" +
         names +
         "  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n"
         "  local command=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $command in\n" +
         cases + "  esac\n}\nif [ \"$funcstack[1]\" = _cxlab ]; then _cxlab \"$@\"; else compdef _cxlab cxlab; fi\n";
}

void add_help(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("help", "Shows the help of cxlab or of a command");
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
  CLI::App* command = app.add_subcommand("man", "Prints the manual page (roff): cxlab man | man -l -");
  command->callback([&app, &action] {
    action = [&app] {
      std::fputs(manual_page(app, lab::cxlab_version()).c_str(), stdout);
      return 0;
    };
  });
}

void add_completion(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("completion", "Prints a script that completes commands and options");
  command->footer("Examples:\n  source <(cxlab completion bash)\n  cxlab completion zsh > ~/.zfunc/_cxlab");
  auto shell = std::make_shared<std::string>();
  command->add_option("shell", *shell, "bash or zsh")->required()->check(CLI::IsMember({"bash", "zsh"}));
  command->callback([&app, shell, &action] {
    action = [&app, shell] {
      std::fputs((*shell == "bash" ? bash_completion(app) : zsh_completion(app)).c_str(), stdout);
      return 0;
    };
  });
}

}  // namespace cxlab::app
