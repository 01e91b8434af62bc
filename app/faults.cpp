#include "app/faults.h"

#include <signal.h>
#include <sys/time.h>
#include <ucontext.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

#include "app/command.h"
#include "cx/base/sanitized.h"
#include "cx/engine/engine.h"
#include "lab/session.h"

namespace cxlab::app {

namespace {

constexpr char kStackIsFull[] =
    "\nerror: the stack is full: a message-handler, or what it calls, calls itself without end (see the last lines of "
    "the log for where)\n";
constexpr char kNothingMore[] = "\nerror: a bug of cxlab: the program crashed; what it was doing cannot be told\n";

template <std::size_t size>
[[noreturn]] void end_with(const char (&message)[size], int code) {
  const auto written = write(STDERR_FILENO, message, size - 1);
  _exit(written < 0 ? static_cast<int>(ErrorKind::kBug) : code);
}

[[noreturn]] void give_up(int) { end_with(kNothingMore, static_cast<int>(ErrorKind::kBug)); }

/// The program is in no good state: what follows may fault again, or wait for itself without end.
[[noreturn]] void end_after_crash(int number) {
  for (const int again : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGSYS, SIGALRM}) {
    struct sigaction action{};
    action.sa_handler = give_up;
    action.sa_flags = SA_ONSTACK | SA_NODEFER;
    sigaction(again, &action, nullptr);
  }
  sigset_t all;
  sigfillset(&all);
  sigprocmask(SIG_UNBLOCK, &all, nullptr);
  itimerval patience{};
  patience.it_value.tv_sec = 2;
  setitimer(ITIMER_REAL, &patience, nullptr);

  Error error = bug_error(std::string("a bug of cxlab: the program crashed (SIG") + sigabbrev_np(number) + ')')
                    .with_code("crashed");
  if (RuleEngine* engine = RuleEngine::at_work()) {
    engine->exceed_limits(error);
    if (const LimitsInUse* limits = engine->options().limits; limits && limits->exceeded) error = *limits->exceeded;
  }
  (void)fail(error);
  lab::note_crash(error);
  _exit(static_cast<int>(ErrorKind::kBug));
}

void on_fault(int number, siginfo_t* info, void* context) {
  const auto fault = reinterpret_cast<std::uintptr_t>(info->si_addr);
  const auto stack = static_cast<std::uintptr_t>(static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RSP]);
  const std::uintptr_t distance = fault > stack ? fault - stack : stack - fault;
  if (number == SIGSEGV && distance < 65536) end_with(kStackIsFull, static_cast<int>(ErrorKind::kRun));
  if (!kSanitized) end_after_crash(number);
  signal(number, SIG_DFL);  // the fault comes again
}

}  // namespace

void install_fault_handlers() {
  static std::uint8_t memory[512 * 1024];  // the message and the result are made there
  stack_t other{};
  other.ss_sp = memory;
  other.ss_size = sizeof memory;
  if (sigaltstack(&other, nullptr) != 0) return;
  struct sigaction action{};
  action.sa_sigaction = on_fault;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  sigaction(SIGSEGV, &action, nullptr);
  if (kSanitized) return;
  for (const int number : {SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGSYS}) sigaction(number, &action, nullptr);
}

}  // namespace cxlab::app
