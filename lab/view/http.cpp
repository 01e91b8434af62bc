// The only file that includes the HTTP library.

#include "lab/view/http.h"

#include <httplib.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <thread>

#include "cx/base/json.h"
#include "lab/control/token.h"
#include "lab/view/access.h"

namespace cxlab::lab {

namespace {

constexpr std::size_t kThreads = 16;
constexpr std::size_t kLongestBody = 1'000'000;
constexpr time_t kLongestWait = 5;  // s, for what a client sends

ViewRequest request_of(const httplib::Request& from) {
  ViewRequest out{from.method == "HEAD" ? "GET" : from.method, from.path, {}, {}, from.body};
  for (const auto& [name, value] : from.params) out.query.emplace(name, value);
  for (const auto& [name, value] : from.headers) {
    std::string small = name;
    std::ranges::transform(small, small.begin(), [](unsigned char c) { return std::tolower(c); });
    const auto [known, fresh] = out.headers.emplace(small, value);
    if (!fresh) known->second.clear();
  }
  return out;
}

void fill(ViewReply from, httplib::Response& out) {
  out.status = from.status;
  for (const auto& [name, value] : from.headers) out.set_header(name, value);
  out.set_header("Cache-Control", "no-store");
  out.set_header("X-Content-Type-Options", "nosniff");
  out.set_header("Referrer-Policy", "no-referrer");
  out.set_header("Cross-Origin-Resource-Policy", "same-origin");
  out.set_header("Content-Security-Policy",
                 "default-src 'none'; script-src 'self'; style-src 'unsafe-inline'; img-src 'self' data:; connect-src "
                 "'self'; frame-src 'self'; frame-ancestors 'self'; base-uri 'none'; form-action 'none'");
  if (from.body.empty()) return out.set_content("", from.type);
  // As a provider, so that the library does not compress it.
  auto body = std::make_shared<const std::string>(std::move(from.body));
  out.set_content_provider(body->size(), from.type, [body](std::size_t at, std::size_t size, httplib::DataSink& sink) {
    return sink.write(body->data() + at, size);
  });
}

}  // namespace

struct ViewServer::State {
  State(Viewer& of, std::uint16_t wanted, std::string token) : view(of), port(wanted), secret(std::move(token)) {}

  void handle(const httplib::Request& from, httplib::Response& out) {
    const ViewRequest request = request_of(from);
    if (auto admitted = access->admit(request)) return fill(*std::move(admitted), out);
    if (auto refused = access->refuse(request)) return fill(*std::move(refused), out);
    fill(view.answer(request), out);
  }

  Viewer& view;
  std::uint16_t port;
  std::string secret;
  std::optional<ViewAccess> access;
  httplib::Server http;
};

ViewServer::ViewServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
ViewServer::~ViewServer() = default;

Expected<std::unique_ptr<ViewServer>> ViewServer::open(Viewer& view, std::uint16_t port) {
  auto token = new_token();
  if (!token) return token.error();
  auto state = std::make_unique<State>(view, port, *std::move(token));
  httplib::Server& http = state->http;
  http.set_payload_max_length(kLongestBody);
  http.set_read_timeout(kLongestWait);
  http.set_keep_alive_max_count(1);  // else each connection that is kept open has a thread
  http.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  // The library would let another program of the machine listen at the same port.
  http.set_socket_options([](int socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  const auto answer = [at = state.get()](const httplib::Request& from, httplib::Response& out) {
    at->handle(from, out);
  };
  http.Get(".*", answer);
  http.Post(".*", answer);
  http.set_exception_handler([](const httplib::Request&, httplib::Response& out, std::exception_ptr thrown) {
    std::string what = "something that is no std::exception";
    try {
      std::rethrow_exception(thrown);
    } catch (const std::exception& e) {
      what = e.what();
    } catch (...) {
    }
    fill(view_error(500, "a bug of cxlab: " + what), out);
  });
  http.set_error_handler([](const httplib::Request&, httplib::Response& out) {
    if (!out.body.empty() || out.content_length_ > 0 || out.status < 400) return;
    const std::string why = out.status == 413 ? "the body has more than 1 MB" : "the request cannot be answered";
    fill(view_error(out.status, why), out);
  });
  if (port == 0) {
    const int free = http.bind_to_any_port("127.0.0.1");
    if (free <= 0) return resource_error("no port of 127.0.0.1 is free");
    state->port = static_cast<std::uint16_t>(free);
  } else if (!http.bind_to_port("127.0.0.1", port)) {
    return resource_error("cannot listen at 127.0.0.1:" + std::to_string(port) +
                          ", where another program may listen; --port gives another port, 0 one that is free");
  }
  state->access.emplace(state->secret, state->port);
  return std::unique_ptr<ViewServer>(new ViewServer(std::move(state)));
}

std::string ViewServer::address() const { return state_->access->address(); }

void ViewServer::serve(const std::function<bool()>& over) {
  constexpr auto kSlice = std::chrono::milliseconds(50);
  std::atomic<bool> ended = false;
  std::thread listener([&] {
    state_->http.listen_after_bind();
    ended = true;
  });
  while (!over() && !ended) std::this_thread::sleep_for(kSlice);
  state_->view.leave();
  for (; !ended; std::this_thread::sleep_for(kSlice)) state_->http.stop();  // which has no effect before it listens
  listener.join();
}

}  // namespace cxlab::lab
