#include "cx/base/process.h"

#include <fcntl.h>
#include <linux/close_range.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <thread>

#include "cx/base/servant.h"

extern char** environ;

namespace cxlab {

namespace {

constexpr int kNotStarted = 127;

struct Pipe {
  int read = -1, write = -1;
};

std::optional<Pipe> make_pipe() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return std::nullopt;
  return Pipe{ends[0], ends[1]};
}

void close_fd(int& fd) {
  if (fd >= 0) close(fd);
  fd = -1;
}

/// In the child: only calls that are safe between fork and exec.
bool connect(const Stream& stream, int pipe_end, int fd) {
  const int mode = fd == STDIN_FILENO ? O_RDONLY : O_WRONLY | O_CREAT | O_TRUNC | O_APPEND;
  int from = -1;
  switch (stream.kind) {
    case Stream::Kind::kInherit: return true;
    case Stream::Kind::kNull: from = open("/dev/null", O_RDWR); break;
    case Stream::Kind::kPipe: from = pipe_end; break;
    case Stream::Kind::kFile: from = open(stream.path.c_str(), mode, 0644); break;
  }
  return from >= 0 && dup2(from, fd) >= 0;
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> out;
  for (std::string& word : words) out.push_back(word.data());
  out.push_back(nullptr);
  return out;
}

std::vector<std::string> environment_with(const std::vector<std::pair<std::string, std::string>>& changes) {
  std::vector<std::string> out;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    bool replaced = false;
    for (const auto& [name, value] : changes) replaced |= text.starts_with(name + '=');
    if (!replaced) out.push_back(text);
  }
  for (const auto& [name, value] : changes) out.push_back(name + '=' + value);
  return out;
}

/// What a new process has to do before its own work; false with errno set if it cannot.
bool set_up(const ProcessOptions& options, pid_t parent, int in) {
  if (setpgid(0, 0) != 0 || prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) return false;
  if (getppid() != parent) _exit(kNotStarted);  // the parent ended before the line above
  if (!options.folder.empty() && chdir(options.folder.c_str()) != 0) return false;
  if (!connect(options.in, in, STDIN_FILENO) || !connect(options.out, -1, STDOUT_FILENO)) return false;
  const bool shared = options.err.kind == Stream::Kind::kFile && options.out.kind == Stream::Kind::kFile &&
                      options.err.path == options.out.path;
  return shared ? dup2(STDOUT_FILENO, STDERR_FILENO) >= 0 : connect(options.err, -1, STDERR_FILENO);
}

}  // namespace

/// Forks; `work` runs in the child after its set-up and ends with an errno if it returns.
template <class Work>
Expected<Process> Process::fork_child(const ProcessOptions& options, const std::string& name, Work work) {
  const auto refused = [&](int number) {
    return resource_error("cannot start " + name + ": " + std::strerror(number));
  };
  std::optional<Pipe> in = Pipe{};
  if (options.in.kind == Stream::Kind::kPipe) in = make_pipe();
  std::optional<Pipe> trouble = make_pipe();  // closed by exec, or carries errno
  if (!in || !trouble) return refused(errno);
  std::fflush(nullptr);
  const pid_t parent = getpid(), pid = ::fork();
  if (pid == 0) {
    close_fd(in->write);
    const int number = set_up(options, parent, in->read) ? work(trouble->write) : errno;
    [[maybe_unused]] const auto sent = ::write(trouble->write, &number, sizeof number);
    _exit(kNotStarted);
  }
  const int number = errno;
  close_fd(in->read);
  close_fd(trouble->write);
  int reported = 0;
  if (pid > 0 && ::read(trouble->read, &reported, sizeof reported) != sizeof reported) reported = 0;
  close_fd(trouble->read);
  if (pid > 0 && reported == 0) {
    Process process;
    process.pid_ = pid;
    process.in_ = in->write;
    return process;
  }
  if (pid > 0) waitpid(pid, nullptr, 0);
  close_fd(in->write);
  return refused(pid > 0 ? reported : number);
}

Expected<Process> Process::start(const ProcessOptions& options) {
  std::vector<std::string> words = options.argv, variables = environment_with(options.environment);
  const std::vector<char*> argv = pointers(words), envp = pointers(variables);
  return fork_child(options, options.argv.front(), [&](int) {
    std::signal(SIGPIPE, SIG_DFL);
    std::signal(SIGXFSZ, SIG_DFL);
    close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
    execvpe(argv.front(), argv.data(), envp.data());
    return errno;
  });
}

Expected<Process> Process::fork(const ProcessOptions& options, const std::function<int()>& work, int kept) {
  return fork_child(options, "a copy of this process", [&](int) -> int {
    close_all_but(kept);  // the pipe of `fork_child` as well, which so reports a start
    const int code = work();
    std::fflush(nullptr);
    _exit(code);
  });
}

Process& Process::operator=(Process&& other) noexcept {
  std::swap(pid_, other.pid_);
  std::swap(code_, other.code_);
  std::swap(in_, other.in_);
  return *this;
}

Process::~Process() {
  kill();
  close_fd(in_);  // behind a wall this process may not kill it: it reads to the end of its input, and ends
  wait();
}

bool Process::reap(bool block) {
  if (pid_ < 0) return true;
  siginfo_t info{};
  int result = 0;
  do result = waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOWAIT | (block ? 0 : WNOHANG));
  while (result != 0 && errno == EINTR);
  if (result == 0 && info.si_pid == 0) return false;
  kill();  // what it has left running, while its number is still its own
  int status = 0;
  waitpid(pid_, &status, 0);
  code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  pid_ = -1;
  return true;
}

int Process::wait() {
  reap(/*block=*/true);
  return code_;
}

std::optional<int> Process::wait_for(double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!reap(/*block=*/false)) {
    if (std::chrono::steady_clock::now() >= end) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return code_;
}

void Process::kill(int signal) const {
  if (pid_ > 0) ::kill(-pid_, signal);
}

Status Process::write(std::string_view bytes) {
  // A program that reads no more must not end this process: the signal is blocked, and taken away if it came.
  sigset_t broken, before;
  sigemptyset(&broken);
  sigaddset(&broken, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &broken, &before);
  int failed = 0;
  while (!bytes.empty() && failed == 0) {
    const ssize_t n = ::write(in_, bytes.data(), bytes.size());
    if (n >= 0)
      bytes.remove_prefix(static_cast<std::size_t>(n));
    else if (errno != EINTR)
      failed = errno;
  }
  const timespec now{};
  if (failed == EPIPE) sigtimedwait(&broken, nullptr, &now);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (failed != 0) return resource_error(std::string("the process takes no more input: ") + std::strerror(failed));
  return {};
}

void Process::close_input() { close_fd(in_); }

bool is_on_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::stringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0) return true;
  return false;
}

}  // namespace cxlab
