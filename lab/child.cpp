#include "lab/child.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace cxlab::lab {

namespace {

Json answer_of(const Expected<Json>& done) {
  if (done) return {{"done", *done}};
  const Error& error = done.error();
  return {{"error",
           {{"kind", static_cast<int>(error.kind)},
            {"message", error.message},
            {"file", error.file},
            {"line", error.line},
            {"code", error.code}}}};
}

bool write_all(int to, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = write(to, text.data() + done, text.size() - done);
    if (n < 0 && errno != EINTR) return false;
    if (n > 0) done += static_cast<std::size_t>(n);
  }
  return true;
}

}  // namespace

Expected<Child> Child::start(const Work& work) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return resource_error(std::string("cannot make a pipe: ") + std::strerror(errno));
  Descriptor from(ends[0]), to(ends[1]);
  auto process = Process::fork({}, [&] {
    return write_all(to.number(), json_text(answer_of(work()))) ? 0 : static_cast<int>(ErrorKind::kResource);
  });
  if (!process) return process.error();
  return Child(std::move(from), *std::move(process));
}

Expected<Json> Child::finish(const Host& host) {
  std::string said;
  constexpr int kLookAtHost = 100;  // ms
  while (true) {
    pollfd end{results_.number(), POLLIN, 0};
    if (host.stopped()) {
      process_.kill();
      return run_error("stopped");
    }
    if (poll(&end, 1, kLookAtHost) <= 0) continue;
    char bytes[1 << 16];
    const ssize_t n = read(results_.number(), bytes, sizeof bytes);
    if (n == 0 || (n < 0 && errno != EINTR)) break;
    if (n > 0) said.append(bytes, static_cast<std::size_t>(n));
  }
  const int code = process_.wait();
  const Json answer = parse_json(said);
  if (code != 0 || answer.is_discarded())
    return run_error("the process that played it ended with " +
                     (code > 128 ? "signal " + std::to_string(code - 128) : "exit code " + std::to_string(code)));
  if (const auto done = answer.find("done"); done != answer.end()) return *done;
  const Json& error = answer.at("error");
  return Error{static_cast<ErrorKind>(error.at("kind").get<int>()), error.at("message"), error.at("file"),
               error.at("line"), error.at("code")};
}

}  // namespace cxlab::lab
