#include "tests/fuzz/copy.h"

#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <ucontext.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz.h"

namespace cxlab::fuzz {
namespace {

/// The counters of libFuzzer in one file of the process: the section that the compiler makes for them. There is none
/// in builds without it.
std::span<std::uint8_t> counters_of(const char* file, std::uintptr_t base) {
  std::span<std::uint8_t> found;
  const int fd = open(file, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return found;  // the kernel's own, which is no file
  const auto size = static_cast<std::size_t>(lseek(fd, 0, SEEK_END));
  // Not read, which would be megabytes to copy with each input.
  void* const mapped = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
  close(fd);
  promise(mapped != MAP_FAILED, std::string("can be read: ") + file);
  const char* const bytes = static_cast<const char*>(mapped);
  const auto* header = reinterpret_cast<const ElfW(Ehdr)*>(bytes);
  const auto* sections = reinterpret_cast<const ElfW(Shdr)*>(bytes + header->e_shoff);
  const char* const names = bytes + sections[header->e_shstrndx].sh_offset;
  for (const ElfW(Shdr) & section : std::span(sections, header->e_shnum))
    if (std::strcmp(names + section.sh_name, "__sancov_cntrs") == 0)
      found = {reinterpret_cast<std::uint8_t*>(base + section.sh_addr), section.sh_size};
  munmap(mapped, size);
  return found;
}

struct Counters {
  std::vector<std::span<std::uint8_t>> here;
  /// The counters of the copy, one after the other, in memory that both share.
  std::span<std::uint8_t> of_copy;

  Counters() {
    dl_iterate_phdr(
        [](dl_phdr_info* info, std::size_t, void* self) {
          const char* file = info->dlpi_name[0] == '\0' ? "/proc/self/exe" : info->dlpi_name;
          if (const auto found = counters_of(file, info->dlpi_addr); !found.empty())
            static_cast<Counters*>(self)->here.push_back(found);
          return 0;
        },
        this);
    std::size_t size = 0;
    for (const auto& part : here) size += part.size();
    if (size == 0) return;
    void* memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    promise(memory != MAP_FAILED, "there is memory for the counters");
    of_copy = {static_cast<std::uint8_t*>(memory), size};
  }

  void give() const {
    std::uint8_t* to = of_copy.data();
    for (const auto& part : here) to = std::copy(part.begin(), part.end(), to);
  }

  void take() const {
    const std::uint8_t* from = of_copy.data();
    for (const auto& part : here) {
      std::copy_n(from, part.size(), part.begin());
      from += part.size();
    }
  }
};

constexpr int kStackIsFull = 3;
struct sigaction sanitizers_own;

void on_fault(int number, siginfo_t* info, void* context) {
  const auto fault = reinterpret_cast<std::uintptr_t>(info->si_addr);
  const auto stack = static_cast<std::uintptr_t>(static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RSP]);
  if ((fault > stack ? fault - stack : stack - fault) < 65536) _exit(kStackIsFull);
  sigaction(number, &sanitizers_own, nullptr);  // the fault comes again
}

/// A full stack ends the program with a message of its own (app/faults.h), and is no fault of what is searched here.
void accept_full_stack() {
  static std::uint8_t memory[64 * 1024];
  stack_t other{};
  other.ss_sp = memory;
  other.ss_size = sizeof memory;
  promise(sigaltstack(&other, nullptr) == 0, "a second stack can be had");
  struct sigaction action{};
  action.sa_sigaction = on_fault;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigaction(SIGSEGV, &action, &sanitizers_own);
}

}  // namespace

void in_copy(const std::function<void()>& play) {
  static const Counters counters;
  const pid_t copy = fork();
  promise(copy >= 0, "the process can be copied");
  if (copy == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    accept_full_stack();
    play();
    counters.give();
    _exit(0);
  }
  int status = 0;
  while (waitpid(copy, &status, 0) < 0) promise(errno == EINTR, "the copy can be waited for");
  if (WIFEXITED(status) && WEXITSTATUS(status) == kStackIsFull) return;
  promise(WIFEXITED(status) && WEXITSTATUS(status) == 0, "a copy plays an input to its end");
  counters.take();
}

}  // namespace cxlab::fuzz
