#include "app/stack_guard.h"

#include <signal.h>
#include <ucontext.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace cxlab::app {

namespace {

constexpr char kMessage[] =
    "\nerror: the stack is full: a message-handler, or what it calls, calls itself without end (see the last lines of "
    "the log for where)\n";

void on_fault(int number, siginfo_t* info, void* context) {
  const auto fault = reinterpret_cast<std::uintptr_t>(info->si_addr);
  const auto stack = static_cast<std::uintptr_t>(static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RSP]);
  const std::uintptr_t distance = fault > stack ? fault - stack : stack - fault;
  if (distance < 65536) {
    const auto written = write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
    _exit(written < 0 ? 70 : 4);
  }
  signal(number, SIG_DFL);  // the fault comes again
}

}  // namespace

void install_stack_guard() {
  static std::uint8_t memory[64 * 1024];
  stack_t other{};
  other.ss_sp = memory;
  other.ss_size = sizeof memory;
  struct sigaction action{};
  action.sa_sigaction = on_fault;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  if (sigaltstack(&other, nullptr) == 0) sigaction(SIGSEGV, &action, nullptr);
}

}  // namespace cxlab::app
