#include "cx/base/servant.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <utility>

namespace cxlab {

namespace {

constexpr std::uint64_t kLongest = std::uint64_t{1} << 30;  // bytes

/// A length, and beside its first byte a descriptor where there is one; then so many bytes.
bool send_message(int line, const std::string& text, int descriptor) {
  std::uint64_t size = text.size();
  iovec head{&size, sizeof size};
  alignas(cmsghdr) char space[CMSG_SPACE(sizeof descriptor)]{};
  msghdr message{};
  message.msg_iov = &head;
  message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = space;
    message.msg_controllen = sizeof space;
    cmsghdr* beside = CMSG_FIRSTHDR(&message);
    beside->cmsg_level = SOL_SOCKET;
    beside->cmsg_type = SCM_RIGHTS;
    beside->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(beside), &descriptor, sizeof descriptor);
  }
  ssize_t sent = 0;
  do sent = sendmsg(line, &message, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  if (sent != static_cast<ssize_t>(sizeof size)) return false;
  for (std::size_t done = 0; done < text.size();) {
    sent = send(line, text.data() + done, text.size() - done, MSG_NOSIGNAL);
    if (sent < 0 && errno != EINTR) return false;
    if (sent > 0) done += static_cast<std::size_t>(sent);
  }
  return true;
}

bool take_message(int line, std::string& text, Descriptor& descriptor) {
  std::uint64_t size = 0;
  iovec head{&size, sizeof size};
  alignas(cmsghdr) char space[CMSG_SPACE(sizeof(int))]{};
  msghdr message{};
  message.msg_iov = &head;
  message.msg_iovlen = 1;
  message.msg_control = space;
  message.msg_controllen = sizeof space;
  ssize_t got = 0;
  do got = recvmsg(line, &message, MSG_WAITALL | MSG_CMSG_CLOEXEC);
  while (got < 0 && errno == EINTR);
  if (const cmsghdr* beside = CMSG_FIRSTHDR(&message);
      got > 0 && beside && beside->cmsg_type == SCM_RIGHTS && beside->cmsg_len == CMSG_LEN(sizeof(int))) {
    int number = -1;
    std::memcpy(&number, CMSG_DATA(beside), sizeof number);
    descriptor = Descriptor(number);
  }
  if (got != static_cast<ssize_t>(sizeof size) || size > kLongest) return false;
  text.resize(size);
  for (std::size_t done = 0; done < size;) {
    got = recv(line, text.data() + done, size - done, 0);
    if (got == 0 || (got < 0 && errno != EINTR)) return false;
    if (got > 0) done += static_cast<std::size_t>(got);
  }
  return true;
}

/// Closes all descriptors but the line, and leads the standard streams nowhere: their readers then do not wait for the
/// servant.
void leave_behind(int line) {
  setsid();
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGALRM}) std::signal(number, SIG_IGN);
  for (const int number : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGSYS}) std::signal(number, SIG_DFL);
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, stream);
  close_all_but(line);
}

[[noreturn]] void serve(int line, const Servant::Work& work, const std::function<void()>& at_end) {
  leave_behind(line);
  const auto gone = [line] {
    pollfd other{line, POLLRDHUP, 0};
    return poll(&other, 1, 0) > 0 && (other.revents & (POLLRDHUP | POLLHUP)) != 0;
  };
  std::string request;
  Descriptor none;
  while (take_message(line, request, none)) {
    const Servant::Answer answer = work ? work(request, gone) : Servant::Answer();
    if (!send_message(line, answer.text, answer.descriptor.number())) break;
  }
  if (at_end) at_end();
  _exit(0);
}

}  // namespace

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}

Descriptor::~Descriptor() {
  if (number_ >= 0) close(number_);
}

void close_all_but(int kept) {
  constexpr unsigned kFirst = STDERR_FILENO + 1;
  const unsigned own = kept < static_cast<int>(kFirst) ? kFirst - 1 : static_cast<unsigned>(kept);
  if (own > kFirst) close_range(kFirst, own - 1, 0);
  close_range(own + 1, ~0U, 0);
}

Expected<Servant> Servant::start(Work work, std::function<void()> at_end) {
  const auto refused = [] {
    return resource_error(std::string("cannot start a process that serves this one: ") + std::strerror(errno));
  };
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return refused();
  Descriptor ours(ends[0]), theirs(ends[1]);
  std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid < 0) return refused();
  if (pid == 0) serve(theirs.number(), work, at_end);
  return Servant(std::move(ours), pid);
}

Servant::Servant(Servant&& other) noexcept : line_(std::move(other.line_)), pid_(std::exchange(other.pid_, -1)) {}

Servant& Servant::operator=(Servant&& other) noexcept {
  std::swap(line_, other.line_);
  std::swap(pid_, other.pid_);
  return *this;
}

Servant::~Servant() { end(); }

void Servant::end() {
  if (pid_ < 0) return;
  shutdown(line_.number(), SHUT_RDWR);  // also where a copy of this process has the line, too
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
}

Expected<Servant::Answer> Servant::ask(const std::string& request) {
  Answer answer;
  if (send_message(line_.number(), request, -1) && take_message(line_.number(), answer.text, answer.descriptor))
    return answer;
  return resource_error("the process that serves this one has ended");
}

}  // namespace cxlab
