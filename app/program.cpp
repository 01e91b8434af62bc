// The frame of a program: signals, faults, the command line, exit codes.

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <system_error>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/faults.h"
#include "cx/executive/plugin_library.h"
#include "lab/versions.h"
#include "sim/mujoco/library.h"

namespace cxlab::app {

int fail(const Error& error) {
  std::fprintf(stderr, "%s %s\n", coloured("error:", kRed).c_str(), printable(error.text()).c_str());
  return static_cast<int>(error.kind);
}

namespace {

std::vector<std::string> g_command_line;
const Catalogue* g_catalogue = nullptr;

/// `code`; or that standard output did not take the answer, as on a full disk. A pipe whose reader has seen enough is
/// no error.
int with_all_said(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  struct stat out{};
  if (fstat(STDOUT_FILENO, &out) == 0 && (S_ISFIFO(out.st_mode) || S_ISSOCK(out.st_mode))) return code;
  std::fputs("error: standard output cannot be written\n", stderr);
  return code == 0 ? static_cast<int>(ErrorKind::kResource) : code;
}

/// A file that is opened must not take the place of a stream that the caller has closed.
void open_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDWR) < 0) std::_Exit(static_cast<int>(ErrorKind::kResource));
}

/// The machine has no more of something: descriptors, threads, memory, room on the disk.
bool is_shortage(const std::error_code& code) {
  for (const std::errc scarce :
       {std::errc::too_many_files_open, std::errc::too_many_files_open_in_system, std::errc::not_enough_memory,
        std::errc::no_space_on_device, std::errc::resource_unavailable_try_again, std::errc::device_or_resource_busy})
    if (code == scarce) return true;
  return code.value() == EDQUOT;
}

/// The error that a person reads where nobody caught the exception.
Error error_of(const std::exception& e) {
  if (dynamic_cast<const std::bad_alloc*>(&e)) return resource_error("out of memory");
  if (const auto* system = dynamic_cast<const std::system_error*>(&e); system && is_shortage(system->code()))
    return resource_error(std::string("the machine, or a limit of this shell (ulimit -a), does not have enough: ") +
                          e.what());
  return bug_error(std::string("a bug of cxlab: ") + e.what());
}

/// What an exception that nobody catches has to say. The linker runs constructors of a plugin's library, and catches
/// nothing.
[[noreturn]] void on_terminate() {
  Error error = bug_error("a bug of cxlab: nobody caught an exception");
  std::string what = "something that is no std::exception";
  if (std::current_exception()) try {
      throw;
    } catch (const std::exception& e) {
      what = e.what();
      error = error_of(e);
      if (error.kind == ErrorKind::kBug) error.message = "a bug of cxlab: nobody caught " + what;
    } catch (...) {
      error.message = "a bug of cxlab: nobody caught " + what;
    }
  const std::string library = cx::library_being_opened();
  const int code =
      fail(library.empty() ? error : run_error(library + ": a constructor of its variables threw: " + what));
  std::fflush(nullptr);
  std::_Exit(code);
}

/// Says what is going on, for commands that may take a while without output.
void report_silence_of(const CLI::App& app) {
  static constexpr std::string_view kLong[] = {
      "run",    "env",     "test",    "bench", "plan",  "replay", "rerun", "render",   "why-not", "validate", "facts",
      "agenda", "globals", "firings", "why",   "rules", "diff",   "check", "coverage", "profile", "export",   "mutate"};
  for (const CLI::App* command : app.get_subcommands())
    if (std::ranges::find(kLong, command->get_name()) != std::end(kLong)) doing("cxlab " + command->get_name());
}

int run(int argc, char** argv, Commands declare) {
  end_at_signals();
  std::set_terminate(on_terminate);
  sim::on_mujoco_bug([](const char* message) {
    std::fprintf(stderr, "error: a bug of cxlab: MuJoCo: %s\n", message);
    std::_Exit(static_cast<int>(ErrorKind::kBug));
  });
#ifndef __SANITIZE_ADDRESS__  // which reports every fault itself
  install_fault_handlers();
  setenv("MESA_SHADER_CACHE_DISABLE", "true", /*overwrite=*/0);  // it lies in the user's home, behind the wall
#endif
  g_command_line.assign(argv, argv + argc);
  open_standard_streams();
  if (!make_answers_printable()) return fail(resource_error("no memory is left"));
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  CLI::App app{
      "cxlab: rule-based robot agents (the CLIPS-Executive) in simulated worlds, one process, one clock, one seed."};
  app.name("cxlab");
  app.require_subcommand(1);
  app.set_version_flag("--version", lab::cxlab_version());
  Action action;
  if (Status s = declare(app, action); !s) return fail(s.error());
  if (Status s = check_command(app, argc, argv); !s) return fail(s.error());
  refuse_values_of_flags(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return usage_exit(app, e);
  }
  if (Status s = check_values(app); !s) return fail(s.error());
  report_silence_of(app);
  return with_all_said(action());
}

}  // namespace

const std::vector<std::string>& command_line() { return g_command_line; }
const Catalogue& catalogue() { return *g_catalogue; }

int run_commands(int argc, char** argv, const Catalogue& catalogue, Commands declare) {
  g_catalogue = &catalogue;
  try {
    return run(argc, argv, declare);
  } catch (const std::exception& e) {
    return fail(error_of(e));
  }
}

}  // namespace cxlab::app
