// cxlab view: pages about runs for a browser of this machine, which answer questions.

#include <cstdio>
#include <filesystem>
#include <memory>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/file.h"
#include "cx/base/process.h"
#include "cx/base/scratch_folder.h"
#include "cx/base/servant.h"
#include "lab/control/client.h"
#include "lab/view/http.h"

namespace cxlab::app {

namespace {

struct ViewOptions {
  std::string place;
  std::uint32_t port = 0;
  bool live = false, open = false, trust_programs = false;
};

/// Opens the address in the user's browser, by way of a file: arguments of programs are seen by all users.
class OpenedBrowser {
 public:
  Status open(const std::string& address) {
    auto folder = ScratchFolder::create();
    if (!folder) return folder.error();
    folder_ = *std::move(folder);
    const std::filesystem::path page = folder_->path() / "open.html";
    if (Status s = write_file(page, "<!doctype html><meta http-equiv=\"refresh\" content=\"0; url=" + address + "\">");
        !s)
      return s;
    auto browser = Process::start({.argv = {"xdg-open", page.string()}, .out = Stream::null(), .err = Stream::null()});
    if (!browser) return browser.error();
    browser_ = *std::move(browser);
    return {};
  }

 private:
  std::unique_ptr<ScratchFolder> folder_;
  std::optional<Process> browser_;
};

/// A process outside of the wall, which keeps the browser and its file as long as the server works.
Expected<Servant> open_browser(const std::string& address) {
  auto browser = std::make_shared<std::optional<OpenedBrowser>>(std::in_place);
  auto servant = Servant::start(
      [browser](const std::string& page, const auto&) {
        const Status opened = (*browser)->open(page);
        return Servant::Answer{opened ? "" : opened.error().text()};
      },
      [browser] { browser->reset(); });
  if (!servant) return servant.error();
  const auto answer = servant->ask(address);
  if (!answer) return answer.error();
  if (!answer->text.empty()) return resource_error(answer->text);
  return servant;
}

int view(const ViewOptions& options) {
  if (options.live) {
    const std::filesystem::path socket = std::filesystem::path(options.place) / "control.sock";
    if (auto client = lab::ControlClient::connect({.path = socket.string()}, {}); !client) return fail(client.error());
  }
  Console console(true);
  auto view = lab::Viewer::open(options.place, catalogue(), options.trust_programs, console.host());
  if (!view) return fail(view.error());
  auto server = lab::ViewServer::open(**view, static_cast<std::uint16_t>(options.port));
  if (!server) return fail(server.error());
  const std::string address = (*server)->address();
  std::optional<Servant> browser;
  if (options.open) {
    auto opened = open_browser(address);
    if (!opened) return fail(opened.error());
    browser = *std::move(opened);
  }
  (*view)->confine(console.host());
  std::printf("%s\n", address.c_str());
  std::fflush(stdout);
  std::fputs("open this address in a browser of this machine; Ctrl-C ends\n", stderr);
  (*server)->serve([] { return signal_that_came() != 0; });
  return interrupted("nothing was written");
}

}  // namespace

void add_view(CLI::App& app, Action& action) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = app.add_subcommand(
      "view", "Serve the page of a run, or of all runs of a folder, with answers to questions about its rules");
  add_limit_options(*command);
  command->add_option("place", options->place, "Folder of a run, or a folder with runs in it, such as that of a sweep")
      ->required();
  command->add_option("--port", options->port, "Port of 127.0.0.1, 0 to 65535; 0: any free port")
      ->check(CLI::Range(0, 65535));
  command->add_flag("--live", options->live,
                    "The run is in progress, with --control or --break (default: cxlab finds out)");
  command->add_flag("--open", options->open, "Opens the address in the browser (xdg-open)");
  add_trust_programs(*command, options->trust_programs);
  command->footer(
      "It prints the address, with a token that the page needs, and serves until Ctrl-C, for this machine only. The "
      "page\n"
      "of a run shows what index.html shows; facts, agenda, why and why-not come from the run's rules, which are "
      "played\n"
      "again up to the time that is shown. The folders are only read.\n"
      "Examples:\n  cxlab run rcll/game --tier timed --out /tmp/g\n  cxlab view /tmp/g\n"
      "  cxlab view runs            (all runs below, in a table)\n"
      "  cxlab run rcll/game --tier timed --break --out /tmp/live   (and elsewhere:)\n  cxlab view /tmp/live");
  command->callback([options, &action] { action = [options] { return view(*options); }; });
}

}  // namespace cxlab::app
