#include "cx/wall/wall.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <linux/openat2.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <set>
#include <sstream>
#include <thread>
#include <utility>

namespace cxlab {

namespace {

namespace fs = std::filesystem;

// --- Landlock. The numbers are those of the kernel; headers of Debian 12 know those of version 2 only.

struct RulesetAttributes {
  std::uint64_t files = 0, network = 0, scopes = 0;
};

constexpr std::uint64_t kWriteFile = 1 << 1, kReadFile = 1 << 2, kReadFolder = 1 << 3, kRemoveFolder = 1 << 4,
                        kRemoveFile = 1 << 5, kMakeFolder = 1 << 7, kMakeFile = 1 << 8, kMakeLink = 1 << 12,
                        kRefer = 1 << 13, kTruncate = 1 << 14, kDeviceControl = 1 << 15;
constexpr std::uint64_t kReadBelow = kReadFile | kReadFolder;
constexpr std::uint64_t kWriteBelow = kReadBelow | kWriteFile | kRemoveFolder | kRemoveFile | kMakeFolder | kMakeFile;

/// All kinds of access to files that a version of Landlock can take away.
std::uint64_t files_of(int version) {
  if (version >= 5) return (1 << 16) - 1;  // ioctl of devices
  if (version >= 3) return (1 << 15) - 1;  // truncate
  if (version == 2) return (1 << 14) - 1;  // refer: to move and link from folder to folder
  return (1 << 13) - 1;
}

int landlock_version() {
  constexpr unsigned kVersion = 1;
  const long version = syscall(SYS_landlock_create_ruleset, nullptr, 0, kVersion);
  return version > 0 ? static_cast<int>(version) : 0;
}

class Ruleset {
 public:
  explicit Ruleset(int version) : version_(version) {
    const RulesetAttributes all{files_of(version), version >= 4 ? 3ULL : 0ULL, version >= 6 ? 3ULL : 0ULL};
    const std::size_t size = version >= 6   ? sizeof all
                             : version >= 4 ? offsetof(RulesetAttributes, scopes)
                                            : offsetof(RulesetAttributes, network);
    descriptor_ = static_cast<int>(syscall(SYS_landlock_create_ruleset, &all, size, 0));
  }
  ~Ruleset() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  Ruleset(const Ruleset&) = delete;
  Ruleset& operator=(const Ruleset&) = delete;

  int descriptor() const { return descriptor_; }
  bool is_open() const { return descriptor_ >= 0; }

  /// On the way to a file or folder.
  enum class Links { kFollowed, kRefused };

  /// False with errno set; what is not there is left out.
  bool allow(const fs::path& path, std::uint64_t access, Links links = Links::kFollowed) {
    open_how how{};
    how.flags = O_PATH | O_CLOEXEC;
    if (links == Links::kRefused) how.resolve = RESOLVE_NO_SYMLINKS;
    const int file = static_cast<int>(syscall(SYS_openat2, AT_FDCWD, path.c_str(), &how, sizeof how));
    if (file < 0) return errno != EMFILE && errno != ENFILE && errno != ENOMEM;
    struct stat found{};
    if (fstat(file, &found) == 0 && !S_ISDIR(found.st_mode))
      access &= kReadFile | kWriteFile | kTruncate | kDeviceControl;
    landlock_path_beneath_attr below{};
    below.allowed_access = access & files_of(version_);
    below.parent_fd = file;
    const bool added = syscall(SYS_landlock_add_rule, descriptor_, LANDLOCK_RULE_PATH_BENEATH, &below, 0) == 0;
    const int number = errno;
    close(file);
    errno = number;
    return added;
  }

 private:
  int version_, descriptor_ = -1;
};

/// What libraries look at: further libraries, locales, time zones, how many cores there are.
std::vector<fs::path> system_paths() {
  std::vector<fs::path> paths;
  for (const char* path : {"/lib",
                           "/lib64",
                           "/usr/lib",
                           "/usr/lib64",
                           "/usr/local/lib",
                           "/usr/share/zoneinfo",
                           "/usr/share/locale",
                           "/usr/share/drirc.d",
                           "/usr/share/glvnd",
                           "/etc/drirc",
                           "/etc/glvnd",
                           "/etc/ld.so.cache",
                           "/etc/localtime",
                           "/proc/self",
                           "/proc/cpuinfo",
                           "/proc/meminfo",
                           "/proc/stat",
                           "/proc/sys/vm/overcommit_memory",
                           "/sys/devices/system/cpu",
                           "/sys/kernel/mm/transparent_hugepage",
                           "/dev/zero",
                           "/dev/urandom",
                           "/dev/random"})
    paths.emplace_back(path);
  if (const char* named = std::getenv("LD_LIBRARY_PATH")) {
    std::stringstream list(named);
    for (std::string folder; std::getline(list, folder, ':');)
      if (folder.starts_with('/') && folder != "/") paths.emplace_back(folder);
  }
  return paths;
}

// --- Threads that run already. Landlock confines the thread that asks for it and those that it starts.

constexpr int kSignal = SIGSYS;  // Mesa's threads block all other signals
std::atomic<int> g_ruleset = -1, g_failed = 0;
std::atomic<pid_t> g_confined = 0;

bool restrict_self(int ruleset) {
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && syscall(SYS_landlock_restrict_self, ruleset, 0) == 0;
}

void confine_thread(int) {
  const int number = errno;
  if (!restrict_self(g_ruleset)) g_failed = errno;
  g_confined = static_cast<pid_t>(syscall(SYS_gettid));
  errno = number;
}

std::set<pid_t> threads() {
  std::set<pid_t> all;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/proc/self/task", ignored))
    all.insert(static_cast<pid_t>(std::strtol(entry.path().filename().c_str(), nullptr, 10)));
  all.erase(static_cast<pid_t>(syscall(SYS_gettid)));
  return all;
}

/// Whether the thread has confined itself, or has ended.
bool confine(pid_t thread) {
  using Clock = std::chrono::steady_clock;
  g_confined = 0;
  if (syscall(SYS_tgkill, getpid(), thread, kSignal) != 0) return errno == ESRCH;
  for (const auto end = Clock::now() + std::chrono::seconds(5); g_confined != thread;) {
    if (Clock::now() > end) {
      errno = ETIMEDOUT;
      return false;
    }
    if (!threads().contains(thread)) return true;
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  errno = g_failed;
  return g_failed == 0;
}

/// A thread that is confined starts only confined ones, so that this comes to an end.
bool confine_other_threads(int ruleset) {
  g_ruleset = ruleset;
  g_failed = 0;
  struct sigaction action{}, before{};
  action.sa_handler = confine_thread;
  action.sa_flags = SA_RESTART;
  sigfillset(&action.sa_mask);
  if (sigaction(kSignal, &action, &before) != 0) return false;
  std::set<pid_t> done;
  bool fine = true, any = true;
  while (fine && std::exchange(any, false))
    for (const pid_t thread : threads())
      if (fine && done.insert(thread).second) any = true, fine = confine(thread);
  const int number = errno;
  sigaction(kSignal, &before, nullptr);
  errno = number;
  return fine;
}

Status raise_landlock(const Wall& wall, int version) {
  Ruleset rules(version);
  bool fine = rules.is_open();
  for (const fs::path& path : system_paths()) fine = fine && rules.allow(path, kReadBelow);
  fine = fine && rules.allow("/dev/null", kReadFile | kWriteFile | kTruncate);
  if (wall.pictures) fine = fine && rules.allow("/dev/dri", kReadBelow | kWriteFile | kDeviceControl);
  for (const fs::path& path : wall.read) fine = fine && rules.allow(path, kReadBelow);
  for (const fs::path& path : wall.exact) fine = fine && rules.allow(path, kReadBelow, Ruleset::Links::kRefused);
  for (const fs::path& path : wall.list) fine = fine && rules.allow(path, kReadFolder);
  for (const fs::path& path : wall.write) fine = fine && rules.allow(path, kWriteBelow | kRefer | kTruncate);
  for (const fs::path& path : wall.links) fine = fine && rules.allow(path, kMakeLink);
  if (fine && confine_other_threads(rules.descriptor()) && restrict_self(rules.descriptor())) return {};
  return resource_error(std::string("Landlock refused: ") + std::strerror(errno));
}

// --- seccomp

/// Calls that reach only what the process has, or what Landlock leaves it.
constexpr const char* kCalls[] = {
    // files that are open
    "read", "write", "readv", "writev", "pread64", "pwrite64", "preadv", "pwritev", "preadv2", "pwritev2", "lseek",
    "close", "close_range", "fstat", "ftruncate", "fallocate", "fsync", "fdatasync", "flock", "dup", "dup2", "dup3",
    "getdents", "getdents64", "fadvise64", "readahead", "copy_file_range", "sendfile", "splice", "tee", "fstatfs",
    "sync_file_range", "msync", "memfd_create",
    // paths: Landlock looks at them; who a file belongs to and its times say nothing of its content
    "stat", "lstat", "newfstatat", "statx", "access", "faccessat", "faccessat2", "readlink", "readlinkat", "statfs",
    "getcwd", "umask", "rename", "renameat", "renameat2", "mkdir", "mkdirat", "rmdir", "unlink", "unlinkat",
    // memory
    "brk", "mmap", "mprotect", "munmap", "mremap", "madvise", "mincore", "membarrier", "get_mempolicy",
    // signals to itself, time
    "rt_sigaction", "rt_sigprocmask", "rt_sigreturn", "rt_sigpending", "rt_sigtimedwait", "rt_sigsuspend",
    "sigaltstack", "restart_syscall", "pause", "gettimeofday", "time", "clock_gettime", "clock_getres",
    "clock_nanosleep", "nanosleep", "getitimer", "setitimer", "alarm", "timerfd_create", "timerfd_settime",
    "timerfd_gettime", "times",
    // waiting
    "poll", "ppoll", "select", "pselect6", "epoll_create", "epoll_create1", "epoll_ctl", "epoll_wait", "epoll_pwait",
    "epoll_pwait2", "eventfd", "eventfd2", "signalfd", "signalfd4", "pipe", "pipe2", "wait4", "waitid",
    // about itself
    "getpid", "getppid", "gettid", "getuid", "geteuid", "getgid", "getegid", "getresuid", "getresgid", "getgroups",
    "getpgrp", "getpgid", "getsid", "uname", "sysinfo", "getrusage", "getrlimit", "setrlimit", "getcpu", "getrandom",
    "getpriority", "sched_yield", "sched_getaffinity", "sched_getparam", "sched_getscheduler", "sched_get_priority_max",
    "sched_get_priority_min", "exit", "exit_group",
    // threads
    "futex", "futex_waitv", "set_robust_list", "get_robust_list", "set_tid_address", "rseq", "arch_prctl",
    // connections that are open, or come in at a socket that listens already
    "accept", "accept4", "recvfrom", "recvmsg", "recvmmsg", "sendmsg", "shutdown", "getsockopt", "getsockname",
    "getpeername"};

/// Calls that a C library makes another way where the kernel does not have them.
constexpr const char* kAbsent[] = {"clone3", "fchmodat2", "mseal"};

class Filter {
 public:
  explicit Filter(std::uint32_t otherwise = SCMP_ACT_ERRNO(EPERM)) : context_(seccomp_init(otherwise)) {}
  ~Filter() { seccomp_release(context_); }
  Filter(const Filter&) = delete;
  Filter& operator=(const Filter&) = delete;

  /// A name that the library does not know is left out.
  template <class... Conditions>
  void add(std::uint32_t action, const char* name, Conditions... conditions) {
    const int number = seccomp_syscall_resolve_name(name);
    if (number == __NR_SCMP_ERROR || number < 0 || failed_ != 0) return;
    failed_ = -seccomp_rule_add(context_, action, number, sizeof...(conditions), conditions...);
  }
  template <class... Conditions>
  void allow(const char* name, Conditions... conditions) {
    add(SCMP_ACT_ALLOW, name, conditions...);
  }

  bool load() {
    if (context_ == nullptr || failed_ != 0) {
      errno = failed_ ? failed_ : ENOMEM;
      return false;
    }
    seccomp_attr_set(context_, SCMP_FLTATR_CTL_TSYNC, 1);
    seccomp_attr_set(context_, SCMP_FLTATR_CTL_OPTIMIZE, 2);
    seccomp_attr_set(context_, SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);
    errno = -seccomp_load(context_);
    return errno == 0;
  }

 private:
  scmp_filter_ctx context_;
  int failed_ = 0;
};

scmp_arg_cmp is(unsigned argument, std::uint64_t value) { return SCMP_CMP(argument, SCMP_CMP_EQ, value, 0); }
/// Compares the low 32 bits: the kernel ignores the other bits of an int.
scmp_arg_cmp is_int(unsigned argument, std::uint32_t value) {
  return SCMP_CMP(argument, SCMP_CMP_MASKED_EQ, 0xffffffff, value);
}
scmp_arg_cmp masked(unsigned argument, std::uint64_t mask, std::uint64_t value) {
  return SCMP_CMP(argument, SCMP_CMP_MASKED_EQ, mask, value);
}

Status raise_seccomp(const Wall& wall, int landlock) {
  Filter filter;
  for (const char* name : kCalls) filter.allow(name);
  for (const char* name : kAbsent) filter.add(SCMP_ACT_ERRNO(ENOSYS), name);

  // A file that is only read is not emptied: Landlock looks at that from version 3 on, and no run needs it.
  for (const std::uint64_t mode : {std::uint64_t{O_RDONLY}, std::uint64_t{O_WRONLY}, std::uint64_t{O_RDWR}}) {
    const std::uint64_t mask = mode == O_RDONLY ? O_ACCMODE | O_TRUNC : O_ACCMODE;
    filter.allow("open", masked(1, mask, mode));
    filter.allow("openat", masked(2, mask, mode));
  }
  filter.allow("creat");
  if (landlock >= 3)
    filter.allow("openat2");
  else
    filter.add(SCMP_ACT_ERRNO(ENOSYS), "openat2");
  if (!wall.links.empty() && landlock > 0)
    for (const char* name : {"symlink", "symlinkat"}) filter.allow(name);

  filter.allow("clone",
               masked(0, CLONE_THREAD | CLONE_NEWUSER | CLONE_NEWNS | CLONE_NEWNET | CLONE_NEWPID, CLONE_THREAD));
  if (wall.copies) {  // as `fork` asks for them, and nothing else
    filter.allow("clone", is(0, CLONE_CHILD_SETTID | CLONE_CHILD_CLEARTID | SIGCHLD));
    filter.allow("prctl", is_int(0, PR_SET_PDEATHSIG));
    filter.allow("prctl", is_int(0, PR_SET_SECCOMP));
    filter.allow("prctl", is_int(0, PR_SET_NO_NEW_PRIVS));
    filter.allow("seccomp");
  }
  const auto self = static_cast<std::uint32_t>(getpid());
  for (const char* name : {"kill", "tgkill", "rt_sigqueueinfo", "rt_tgsigqueueinfo"})
    filter.allow(name, is_int(0, self));
  filter.allow("prlimit64", is_int(0, 0));
  filter.allow("prlimit64", is_int(0, self));
  filter.allow("prctl", is_int(0, PR_SET_NAME));
  filter.allow("prctl", is_int(0, PR_GET_NAME));
  constexpr std::uint32_t kSetVma = 0x53564d41;  // a name for memory, by allocators
  filter.allow("prctl", is_int(0, kSetVma));

  // Neither the owner of a file's signals, nor leases.
  for (const int command : {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL, F_SETFL, F_GETLK, F_SETLK, F_SETLKW})
    filter.allow("fcntl", is_int(1, static_cast<std::uint32_t>(command)));
  constexpr std::uint32_t kTcgets2 = 0x802c542a;
  for (const std::uint32_t command :
       std::initializer_list<std::uint32_t>{TCGETS, kTcgets2, TIOCGWINSZ, FIONREAD, FIONBIO, FIOCLEX, FIONCLEX})
    filter.allow("ioctl", is_int(1, command));
  if (wall.pictures)
    for (const std::uint64_t kind : {std::uint64_t{'d'}, std::uint64_t{'F'}})
      filter.allow("ioctl", masked(1, 0xff00, kind << 8));

  if (wall.send_to)
    filter.allow("sendto");
  else
    filter.allow("sendto", is(4, 0));
  for (const int option :
       {SO_REUSEADDR, SO_ERROR, SO_KEEPALIVE, SO_LINGER, SO_RCVBUF, SO_SNDBUF, SO_RCVTIMEO, SO_SNDTIMEO})
    filter.allow("setsockopt", is_int(1, SOL_SOCKET), is_int(2, static_cast<std::uint32_t>(option)));
  constexpr std::uint32_t kTcp = 6, kNoDelay = 1;
  filter.allow("setsockopt", is_int(1, kTcp), is_int(2, kNoDelay));

  if (filter.load()) return {};
  return resource_error(std::string("seccomp refused: ") + std::strerror(errno));
}

/// On top of another filter, whose answers hold as well.
Status raise_filter_of_copies() {
  Filter filter(SCMP_ACT_ALLOW);
  constexpr std::uint32_t kRefuse = SCMP_ACT_ERRNO(EPERM);
  filter.add(kRefuse, "clone", masked(0, CLONE_THREAD, 0));
  for (const char* name : {"fork", "vfork", "clone3", "kill", "tgkill", "rt_sigqueueinfo", "rt_tgsigqueueinfo"})
    filter.add(kRefuse, name);
  for (const int option : {PR_SET_PDEATHSIG, PR_SET_SECCOMP, PR_SET_NO_NEW_PRIVS})
    filter.add(kRefuse, "prctl", is_int(0, static_cast<std::uint32_t>(option)));
  filter.add(kRefuse, "seccomp");
  if (filter.load()) return {};
  return resource_error(std::string("seccomp refused: ") + std::strerror(errno));
}

bool has_seccomp() { return prctl(PR_GET_SECCOMP, 0, 0, 0, 0) >= 0; }

}  // namespace

std::string WallParts::text() const {
  const std::string files = landlock > 0 ? "Landlock " + std::to_string(landlock) : "";
  if (!seccomp) return files.empty() ? "neither Landlock nor seccomp" : files + ", no seccomp";
  return files.empty() ? "seccomp, no Landlock" : files + " and seccomp";
}

WallParts wall_parts() { return {landlock_version(), has_seccomp()}; }

Status forbid_copies() { return raise_filter_of_copies(); }

Status raise_wall(const Wall& wall) {
  const WallParts parts = wall_parts();
  Status files =
      parts.landlock > 0 ? raise_landlock(wall, parts.landlock) : Status(resource_error("this kernel has no Landlock"));
  Status calls = raise_seccomp(wall, files ? parts.landlock : 0);
  if (files && calls) return {};
  const char* open = files   ? "start programs, open sockets and signal processes"
                     : calls ? "read and change all files of this user"
                             : "do what this user can";
  return resource_error(std::string("only cxlab checks the rules, and the kernel does not confine them as well (") +
                        (files ? calls : files).error().message + "): if a fault of cxlab lets them, they can " + open +
                        "; cxlab doctor shows what the kernel has");
}

}  // namespace cxlab
