#include "lab/child.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>

#include "lab/pipe.h"

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

}  // namespace

Expected<Child> Child::start(const Work& work) {
  auto pipe = make_pipe();
  if (!pipe) return pipe.error();
  auto process = Process::fork({}, [&] { return say_to(pipe->to, json_text(answer_of(work()))); }, pipe->to.number());
  if (!process) return process.error();
  return Child(std::move(pipe->from), *std::move(process));
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
