// cxlab attach: a terminal on a run that is played with --control or --break.

#include <editline/readline.h>
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <optional>
#include <thread>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/journal/run_folder.h"
#include "lab/control/client.h"
#include "lab/state_folder.h"
#include "lab/time_travel.h"

namespace cxlab::app {

namespace {

using lab::ControlClient;
using Event = ControlClient::Event;

struct AttachOptions {
  std::string where, token;
  std::vector<std::string> commands;
  bool quiet = false, trust_programs = false;
};

std::string shown(const Event& event) {
  if (event.kind != Event::Kind::kLog) return printable(event.text);
  char begin[40];
  std::snprintf(begin, sizeof begin, "[%9.3f] ", event.t);
  return begin + printable("[" + event.level + "] [" + event.logger + "] " + event.text);
}

/// Carries out commands one after the other; after those that let the run go on it waits for the next stop.
class Script {
 public:
  Script(ControlClient& client, bool quiet) : client_(client) {
    client.on_event([quiet](const Event& event) {
      if (event.kind == Event::Kind::kLog && !quiet) std::fprintf(stderr, "%s\n", shown(event).c_str());
    });
  }
  /// The exit code where the script ends, else none.
  std::optional<int> carry_out(const std::string& line) {
    if (ended_) return fail(resource_error("the run has ended; '" + line + "' was not carried out"));
    const auto answer = client_.carry_out(line);
    if (!answer) return fail(answer.error());
    if (!answer->ok) return fail(negative(line + ": " + answer->text));
    if (!answer->text.empty()) std::printf("%s\n", answer->text.c_str());
    if (!answer->goes_on) return {};
    const auto stop = client_.wait_for_stop();
    if (!stop) return fail(stop.error());
    ended_ = stop->kind == Event::Kind::kEnd;
    std::printf("%s%s\n", ended_ ? "the run has ended: " : "", stop->text.c_str());
    return {};
  }

 private:
  ControlClient& client_;
  bool ended_ = false;
};

int play_script(ControlClient& client, const AttachOptions& options) {
  Script script(client, options.quiet);
  for (const std::string& line : options.commands)
    if (const auto code = script.carry_out(line)) return *code;
  if (!options.commands.empty()) return 0;
  for (std::string line; std::getline(std::cin, line) && line != "quit";)
    if (line.find_first_not_of(" \t") != std::string::npos)
      if (const auto code = script.carry_out(line)) return *code;
  return 0;
}

/// A person at a terminal: history, completion with Tab, and events above the line that is being written.
class Terminal {
 public:
  explicit Terminal(ControlClient& client) : client_(client) { at_work_ = this; }
  ~Terminal() { at_work_ = nullptr; }

  int talk() {
    std::FILE* const out = fdopen(dup(STDOUT_FILENO), "w");  // stdout escapes what moves the cursor
    if (out == nullptr) return fail(resource_error("the terminal cannot be opened"));
    rl_outstream = out;
    rl_initialize();
    rl_attempted_completion_function = complete;
    rl_completer_word_break_characters = const_cast<char*>(" \t(");
    const std::filesystem::path history = history_file();
    if (!history.empty()) read_history(history.c_str());
    client_.on_event([this](const Event& event) { above(shown(event), event.kind == Event::Kind::kEnd); });
    const auto where = client_.carry_out("where");
    std::printf("%s\nTab completes, help lists the commands, quit leaves.\n",
                where ? printable(where->text).c_str() : "");
    std::fflush(stdout);
    prompt();
    while (!left_ && !ended_) wait();
    rl_callback_handler_remove();
    if (!history.empty()) {
      stifle_history(1000);
      write_history(history.c_str());
    }
    std::fclose(out);
    return 0;
  }

 private:
  static std::filesystem::path history_file() {
    const std::filesystem::path folder = lab::state_folder();
    return folder.empty() || !make_folder(folder) ? std::filesystem::path() : folder / "attach_history";
  }

  void wait() {
    if (!client_.take_events() && !ended_) return above("the run ended or closed the connection", true);
    pollfd both[2] = {{STDIN_FILENO, POLLIN, 0}, {client_.descriptor(), POLLIN, 0}};
    if (poll(both, 2, -1) < 0) return;
    if (both[0].revents == 0) return;
    rl_callback_read_char();
    if (!line_) return;
    carry_out(*std::exchange(line_, std::nullopt));
    rl_callback_handler_remove();  // a new line begins; without it the library repeats the old one
    if (!left_ && !ended_) prompt();
  }

  static void prompt() {
    rl_callback_handler_install("cxlab> ", [](char* typed) {
      at_work_->left_ = typed == nullptr;
      if (typed != nullptr) at_work_->line_ = typed;
      std::free(typed);
    });
  }

  void above(const std::string& text, bool ends) {
    if (!ended_) {
      if (!busy_) std::fputs("\r\033[K", rl_outstream);
      std::fprintf(rl_outstream, "%s\n", text.c_str());
      std::fflush(rl_outstream);
      if (!ends && !busy_) rl_forced_update_display();
    }
    ended_ = ended_ || ends;
  }

  void carry_out(const std::string& line) {
    if (line == "quit" || line == "exit") left_ = true;
    if (left_ || line.find_first_not_of(" \t") == std::string::npos) return;
    add_history(line.c_str());
    busy_ = true;
    const auto answer = client_.carry_out(line);
    busy_ = false;
    if (!answer)
      above(printable(answer.error().text()), true);
    else if (!answer->text.empty())
      std::fprintf(rl_outstream, "%s%s\n", answer->ok ? "" : "error: ", shown_lines(answer->text).c_str());
    std::fflush(rl_outstream);
  }

  /// Printable, but for the ends of its lines.
  static std::string shown_lines(const std::string& text) {
    std::string out;
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      out += (at > 0 ? "\n" : "") + printable(std::string_view(text).substr(at, end - at));
      at = end + 1;
    }
    return out;
  }

  static char** complete(const char* begun, int, int) {
    rl_attempted_completion_over = 1;  // no names of files
    at_work_->busy_ = true;
    auto words = at_work_->client_.completions(begun);
    at_work_->busy_ = false;
    if (!words || words->empty()) return nullptr;
    at_work_->words_ = *std::move(words);
    return rl_completion_matches(begun, [](const char*, int k) -> char* {
      const auto& all = at_work_->words_;
      return static_cast<std::size_t>(k) < all.size() ? strdup(all[static_cast<std::size_t>(k)].c_str()) : nullptr;
    });
  }

  static Terminal* at_work_;  // the library calls functions without an argument for it
  ControlClient& client_;
  std::vector<std::string> words_;
  std::optional<std::string> line_;  // that was entered
  bool left_ = false, ended_ = false, busy_ = false;
};
Terminal* Terminal::at_work_ = nullptr;

int talk(ControlClient& client, const AttachOptions& options) {
  if (!options.commands.empty() || isatty(STDIN_FILENO) == 0) return play_script(client, options);
  return Terminal(client).talk();
}

/// A run that has ended is played again.
int travel(const AttachOptions& options) {
  auto run = open_run(options.where, options.trust_programs);
  if (!run) return fail(run.error());
  Console console(true);
  auto played = lab::TimeTravel::start(*run, console.host());
  if (!played) return fail(played.error());
  if (options.commands.empty() && isatty(STDIN_FILENO) != 0)
    std::fputs("playing the rules of the run again ...\n", stderr);
  while (true) {
    if (auto client = ControlClient::connect((*played)->address(), {})) return talk(**client, options);
    if (const auto code = (*played)->ended()) return *code == 0 ? static_cast<int>(ErrorKind::kRun) : *code;
    if (signal_that_came() != 0) return interrupted("the run was not played again");
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

int attach(const AttachOptions& options) {
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(options.where, ignored);
  const auto address = lab::ControlAddress::parse(
      folder ? (std::filesystem::path(options.where) / "control.sock").string() : options.where);
  if (!address) return fail(address.error());
  std::string token = options.token;
  if (const char* set = std::getenv("CXLAB_CONTROL_TOKEN"); token.empty() && set != nullptr) token = set;
  auto client = ControlClient::connect(*address, token);
  if (!client && std::filesystem::exists(std::filesystem::path(options.where) / "manifest.json", ignored))
    return travel(options);
  if (!client) return fail(client.error());
  return talk(**client, options);
}

}  // namespace

void add_attach(CLI::App& app, Action& action) {
  auto options = std::make_shared<AttachOptions>();
  CLI::App* command = app.add_subcommand(
      "attach",
      "Open a terminal on a run: on a run in progress (--control, --break), or back and forth through a finished one");
  command->add_option("run", options->where, "Folder of the run, its socket, or 127.0.0.1:PORT")->required();
  command->add_option("--token", options->token, "Token that the run printed (or $CXLAB_CONTROL_TOKEN)");
  once_each(command->add_option("-c,--command", options->commands,
                                "A command instead of the terminal (may be given often); 'help' lists the commands"));
  command->add_flag("--quiet", options->quiet, "With -c: no lines of the log");
  add_trust_programs(*command, options->trust_programs);
  command->footer(
      "Without a terminal, commands are read from standard input, a line each. After 'continue', 'step', 'tick' and\n"
      "'until' the next command waits until the run stops. The first command that fails ends cxlab with exit code 1.\n"
      "Examples:\n  cxlab run rcll/game --break --out /tmp/game   (and elsewhere:)\n"
      "  cxlab attach /tmp/game\n"
      "  cxlab attach /tmp/game -c 'until rule order-begin' -c 'facts order' -c agenda -c continue");
  command->callback([options, &action] { action = [options] { return attach(*options); }; });
}

}  // namespace cxlab::app
