#include "lab/control/client.h"

#include <poll.h>
#include <sys/socket.h>

#include <asio/buffer.hpp>
#include <asio/generic/stream_protocol.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/read_until.hpp>
#include <asio/write.hpp>

#include "cx/base/json.h"

namespace cxlab::lab {

namespace {

std::string text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

bool flag_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_boolean() && found->get<bool>();
}

Error nobody_there(const std::error_code& error, const std::string& address) {
  return resource_error("nothing to attach to: " + error.message() +
                            "; a run that is played with --control or --break can be attached to while it lasts",
                        address);
}

}  // namespace

struct ControlClient::State {
  asio::io_context context;
  asio::generic::stream_protocol::socket socket{context};
  std::string unread;
  std::uint64_t last_id = 0;
  std::function<void(const Event&)> on_event = [](const Event&) {};
  std::optional<Event> last_stop;  // that nobody waited for yet

  static Error gone() { return resource_error("the run ended or closed the connection"); }

  Status send(const Json& request) {
    std::error_code error;
    asio::write(socket, asio::buffer(json_text(request) + '\n'), error);
    return error ? Status(gone()) : Status();
  }

  /// The next line, as an object.
  Expected<Json> receive() {
    std::error_code error;
    const std::size_t size = asio::read_until(socket, asio::dynamic_buffer(unread), '\n', error);
    if (error) return gone();
    Json line = parse_json(unread.substr(0, size));
    unread.erase(0, size);
    if (!line.is_object()) return input_error("found a line that is no JSON object; is a cxlab there?");
    return line;
  }

  std::optional<Event> take(const Json& line) {
    const std::string kind = text_of(line, "event");
    Event event;
    if (kind == "stopped")
      event.kind = Event::Kind::kStopped;
    else if (kind == "end")
      event.kind = Event::Kind::kEnd;
    else if (kind == "log")
      event.kind = Event::Kind::kLog;
    else if (kind == "hello")
      event.kind = Event::Kind::kHello;
    else
      return {};
    event.text = text_of(line, "text");
    event.level = text_of(line, "level");
    event.logger = text_of(line, "logger");
    if (const auto t = line.find("t"); t != line.end() && t->is_number()) event.t = t->get<double>();
    if (event.kind == Event::Kind::kStopped || event.kind == Event::Kind::kEnd) last_stop = event;
    on_event(event);
    return event;
  }

  Expected<Json> ask(const char* what, const std::string& text) { return ask({{what, text}}); }

  Expected<Json> ask(Json request) {
    const std::uint64_t id = ++last_id;
    request["id"] = id;
    if (Status s = send(request); !s) return s.error();
    while (true) {
      auto line = receive();
      if (!line) return line.error();
      if (line->contains("id") && (*line)["id"] == id) return line;
      take(*line);
    }
  }
};

ControlClient::ControlClient(std::unique_ptr<State> state) : state_(std::move(state)) {}
ControlClient::~ControlClient() = default;

Expected<Descriptor> connect_to_socket(const std::string& path) {
  if (const auto address = ControlAddress::parse(path); !address) return address.error();  // a path that is too long
  asio::io_context context;
  asio::local::stream_protocol::socket socket(context);
  std::error_code error;
  socket.connect(asio::local::stream_protocol::endpoint(path), error);
  if (error) return nobody_there(error, path);
  return Descriptor(socket.release());
}

Expected<std::unique_ptr<ControlClient>> ControlClient::over(Descriptor connection, const std::string& path) {
  auto state = std::make_unique<State>();
  std::error_code error;
  state->socket.assign(asio::generic::stream_protocol(AF_UNIX, 0), connection.number(), error);
  if (error) return resource_error("cannot use the connection to the run: " + error.message(), path);
  (void)connection.release();
  return greeted(std::move(state), {.path = path});
}

Expected<std::unique_ptr<ControlClient>> ControlClient::connect(const ControlAddress& address,
                                                                const std::string& token) {
  if (!address.path.empty()) {
    auto connection = connect_to_socket(address.path);
    return connection ? over(*std::move(connection), address.path) : connection.error();
  }
  auto state = std::make_unique<State>();
  std::error_code error;
  state->socket.connect(asio::ip::tcp::endpoint(asio::ip::address_v4::loopback(), address.port), error);
  if (error) return nobody_there(error, address.text());
  asio::write(state->socket, asio::buffer(token + '\n'), error);
  return greeted(std::move(state), address);
}

/// Waits for the greeting.
Expected<std::unique_ptr<ControlClient>> ControlClient::greeted(std::unique_ptr<State> state,
                                                                const ControlAddress& address) {
  auto client = std::unique_ptr<ControlClient>(new ControlClient(std::move(state)));
  while (true) {
    const auto line = client->state_->receive();
    if (!line && !address.path.empty()) return line.error();
    // It greets only those who know the token.
    if (!line)
      return usage_error("the run at " + address.text() +
                         " does not take this --token; `cxlab run` printed the right one when it began");
    if (text_of(*line, "event") == "refused")
      return resource_error(text_of(*line, "text") + "; one of them has to go first", address.text());
    const auto event = client->state_->take(*line);
    if (event && event->kind == Event::Kind::kHello) return client;
  }
}

void ControlClient::on_event(std::function<void(const Event&)> call) { state_->on_event = std::move(call); }

Expected<ControlClient::Answer> ControlClient::carry_out(const std::string& line) {
  auto answer = state_->ask("line", line);
  if (!answer) return answer.error();
  const bool goes_on = flag_of(*answer, "goes_on");
  if (goes_on) state_->last_stop.reset();
  return Answer{flag_of(*answer, "ok"), text_of(*answer, "text"), goes_on};
}

Expected<std::string> ControlClient::ask(const std::string& question) {
  const auto answer = state_->ask(parse_json(question));
  if (!answer) return answer.error();
  if (!flag_of(*answer, "ok")) return input_error(text_of(*answer, "text"));
  return json_text((*answer)["answer"]);
}

Expected<std::vector<std::string>> ControlClient::completions(const std::string& begun) {
  auto answer = state_->ask("complete", begun);
  if (!answer) return answer.error();
  std::vector<std::string> words;
  for (const auto& word : (*answer)["words"])
    if (word.is_string()) words.push_back(word.get<std::string>());
  return words;
}

Expected<ControlClient::Event> ControlClient::wait_for_stop() {
  while (!state_->last_stop) {
    auto line = state_->receive();
    if (!line) return line.error();
    state_->take(*line);
  }
  return *std::exchange(state_->last_stop, std::nullopt);
}

Status ControlClient::take_events() {
  pollfd socket{descriptor(), POLLIN, 0};
  // At the end of the stream there is something to read as well: receive returns an error then.
  while (state_->unread.find('\n') != std::string::npos || poll(&socket, 1, 0) > 0) {
    auto line = state_->receive();
    if (!line) return line.error();
    state_->take(*line);
  }
  return {};
}

void ControlClient::hang_up() { shutdown(state_->socket.native_handle(), SHUT_RDWR); }

int ControlClient::descriptor() const { return state_->socket.native_handle(); }

}  // namespace cxlab::lab
