#include "lab/control/server.h"

#include <sys/stat.h>

#include <algorithm>
#include <asio/generic/stream_protocol.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/local/stream_protocol.hpp>
#include <asio/posix/stream_descriptor.hpp>
#include <asio/post.hpp>
#include <asio/read_until.hpp>
#include <asio/steady_timer.hpp>
#include <asio/write.hpp>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "cx/base/number_text.h"
#include "cx/base/servant.h"
#include "lab/control/token.h"

namespace cxlab::lab {

namespace {

constexpr std::size_t kLongestLine = 1'000'000;
constexpr std::size_t kMostUnread = 64'000'000;  // bytes that wait for a client
constexpr std::size_t kMostClients = 8;
constexpr std::size_t kMostStrangers = 64;                 // connections that have not shown a token yet
constexpr auto kLongestSilence = std::chrono::seconds(5);  // until a stranger is sent away
constexpr const char* kFull =
    R"({"event":"refused","text":"eight are attached to this run already, which is the most"})";

using Socket = asio::generic::stream_protocol::socket;

/// Removes a socket that an ended run left behind. Fails if anything else is there.
Status make_room(const std::string& path) {
  std::error_code error;
  const auto there = std::filesystem::symlink_status(path, error);
  if (there.type() == std::filesystem::file_type::not_found) return {};
  if (there.type() != std::filesystem::file_type::socket)
    return resource_error("exists and is no socket; give --control-at another path", path);
  asio::io_context context;
  asio::local::stream_protocol::socket probe(context);
  probe.connect(asio::local::stream_protocol::endpoint(path), error);
  if (!error) return resource_error("another run listens there; give --control-at another path", path);
  std::filesystem::remove(path, error);
  return {};
}

}  // namespace

std::string ControlAddress::text() const { return path.empty() ? "127.0.0.1:" + std::to_string(port) : path; }

Expected<ControlAddress> ControlAddress::parse(const std::string& text) {
  ControlAddress address;
  for (const std::string_view host : {"127.0.0.1:", "localhost:"}) {
    if (!text.starts_with(host)) continue;
    const auto port = read_number<std::uint32_t>(std::string_view(text).substr(host.size()));
    if (!port || *port > 65535)
      return usage_error(found_text(text, "a port from 0 to 65535 behind " + std::string(host)));
    address.port = static_cast<std::uint16_t>(*port);
    return address;
  }
  const std::size_t colon = text.find('/') == text.npos ? text.rfind(':') : text.npos;
  if (colon != text.npos && text.find_first_not_of("0123456789", colon + 1) == text.npos)
    return usage_error(
        found_text(text, "127.0.0.1:PORT, because only programs of this machine may control a run, or a path"));
  constexpr std::size_t kLongestPath = 107;  // of a Unix socket
  if (text.size() > kLongestPath)
    return usage_error("a Unix socket's path has at most 107 characters, found '" + text +
                       "'; give a shorter one, as --control-at /tmp/run.sock");
  address.path = text;
  return address;
}

/// Runs on the server's thread, but for what `mutex` guards.
struct ControlServer::State {
  struct Client : std::enable_shared_from_this<Client> {
    Client(State& all, Socket s, std::uint64_t number)
        : state(all), socket(std::move(s)), silence(all.context), id(number) {}
    /// Until the token has come.
    void wait_for_token() {
      silence.expires_after(kLongestSilence);
      silence.async_wait([self = shared_from_this()](const std::error_code& error) {
        if (!error && !self->known) self->leave();
      });
    }
    void read() {
      asio::async_read_until(
          socket, asio::dynamic_buffer(unread, kLongestLine), '\n',
          [self = shared_from_this()](const std::error_code& error, std::size_t size) { self->has_read(error, size); });
    }
    void has_read(const std::error_code& error, std::size_t size) {
      if (error) return leave();
      std::string line = unread.substr(0, size - 1);
      unread.erase(0, size);
      if (line.ends_with('\r')) line.pop_back();
      if (known) {
        if (announced) state.put({id, std::move(line)});
      } else if (same_text(line, state.token)) {
        enter();
      } else {
        return leave();
      }
      read();
    }
    void enter() {
      silence.cancel();
      const bool full = state.count(/*known=*/true) >= kMostClients;
      known = true;
      if (full) {
        announced = false;
        write(kFull);
        return close_after_lines();
      }
      state.put({id, {}, true, false});
    }
    void write(const std::string& line) {
      if (!known || gone) return;
      waiting += line.size() + 1;
      if (waiting > kMostUnread) return leave();
      lines.push_back(line + '\n');
      if (lines.size() == 1) write_next();
    }
    void write_next() {
      asio::async_write(socket, asio::buffer(lines.front()),
                        [self = shared_from_this()](const std::error_code& error, std::size_t) {
                          if (error) return self->leave();
                          self->waiting -= self->lines.front().size();
                          self->lines.pop_front();
                          if (!self->lines.empty())
                            self->write_next();
                          else if (self->closing)
                            self->leave();
                        });
    }
    void close_after_lines() {
      closing = true;
      if (lines.empty()) leave();
    }
    void leave() {
      if (gone) return;
      gone = true;
      std::error_code ignored;
      socket.close(ignored);
      silence.cancel();
      if (known && announced) state.put({id, {}, false, true});
      state.clients.erase(id);
    }

    State& state;
    Socket socket;
    asio::steady_timer silence;
    std::uint64_t id;
    std::string unread;
    std::deque<std::string> lines;
    std::size_t waiting = 0;
    bool known = false, gone = false, closing = false;
    bool announced = true;  // to the run
  };

  template <class Acceptor>
  void accept(Acceptor& acceptor) {
    acceptor.async_accept([this, &acceptor](const std::error_code& error, auto socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error) {
        if (count(/*known=*/false) >= kMostStrangers) oldest_stranger()->leave();
        auto client = std::make_shared<Client>(*this, Socket(std::move(socket)), ++last_client);
        clients.emplace(client->id, client);
        if (token.empty())
          client->enter();
        else
          client->wait_for_token();
        client->read();
      }
      accept(acceptor);
    });
  }

  std::size_t count(bool known) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(clients, [known](const auto& client) { return client.second->known == known; }));
  }
  std::shared_ptr<Client> oldest_stranger() const {
    return std::ranges::find_if(clients, [](const auto& client) { return !client.second->known; })->second;
  }

  void put(Line line) {
    const std::lock_guard lock(mutex);
    taken.push_back(std::move(line));
    any = true;
    came.notify_one();
  }

  Status open_at(const ControlAddress& wanted) {
    address = wanted;
    std::error_code error;
    if (!address.path.empty()) {
      if (Status s = make_room(address.path); !s) return s;
      const asio::local::stream_protocol::endpoint here(address.path);
      unix_acceptor.open(here.protocol(), error);
      // Only the user may connect: the file gets the mode of the socket.
      if (!error && fchmod(unix_acceptor.native_handle(), 0600) != 0) error = {errno, std::system_category()};
      if (!error) unix_acceptor.bind(here, error);
      if (!error) unix_acceptor.listen(asio::socket_base::max_listen_connections, error);
      if (error) return resource_error("cannot open the socket for --control: " + error.message(), address.path);
      // Behind a wall (cx/wall/wall.h) this process removes it only from the run's folder.
      auto made = Servant::start([path = address.path](const std::string&, const auto&) {
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
        return Servant::Answer();
      });
      if (!made) return made.error();
      remover.emplace(*std::move(made));
      accept(unix_acceptor);
    } else {
      auto made = new_token();
      if (!made) return made.error();
      token = *made;
      const asio::ip::tcp::endpoint here(asio::ip::address_v4::loopback(), address.port);
      tcp_acceptor.open(here.protocol(), error);
      if (!error) tcp_acceptor.set_option(asio::socket_base::reuse_address(true), error);
      if (!error) tcp_acceptor.bind(here, error);
      if (!error) tcp_acceptor.listen(asio::socket_base::max_listen_connections, error);
      if (error) return resource_error("cannot listen at " + address.text() + " for --control: " + error.message());
      address.port = tcp_acceptor.local_endpoint().port();
      accept(tcp_acceptor);
    }
    thread = std::thread([this] {
      context.run();
      const std::lock_guard lock(mutex);
      ended = true;
      came.notify_all();
    });
    return {};
  }

  void close() {
    if (!thread.joinable()) return;
    asio::post(context, [this] {
      std::error_code ignored;
      unix_acceptor.close(ignored);
      tcp_acceptor.close(ignored);
      const auto all = clients;
      for (const auto& [id, client] : all) client->close_after_lines();
    });
    std::unique_lock lock(mutex);
    came.wait_for(lock, std::chrono::seconds(1), [this] { return ended; });
    lock.unlock();
    context.stop();
    thread.join();
    if (remover) (void)remover->ask("remove");
    remover.reset();
  }

  asio::io_context context{1};
  asio::local::stream_protocol::acceptor unix_acceptor{context};
  asio::ip::tcp::acceptor tcp_acceptor{context};
  std::map<std::uint64_t, std::shared_ptr<Client>> clients;
  std::uint64_t last_client = 0;
  ControlAddress address;
  std::string token;
  std::optional<Servant> remover;  ///< of the socket at `address.path`
  std::thread thread;

  std::atomic<bool> any{false};
  std::mutex mutex;
  std::condition_variable came;
  std::deque<Line> taken;  // to be taken by the run
  bool ended = false;
};

ControlServer::ControlServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
ControlServer::~ControlServer() { state_->close(); }

Expected<std::unique_ptr<ControlServer>> ControlServer::open(const ControlAddress& address) {
  auto state = std::make_unique<State>();
  if (Status s = state->open_at(address); !s) return s.error();
  return std::unique_ptr<ControlServer>(new ControlServer(std::move(state)));
}

const ControlAddress& ControlServer::address() const { return state_->address; }
const std::string& ControlServer::token() const { return state_->token; }

std::optional<ControlServer::Line> ControlServer::take(std::chrono::milliseconds wait) {
  if (wait.count() == 0 && !state_->any.load(std::memory_order_relaxed)) return {};
  std::unique_lock lock(state_->mutex);
  if (!state_->came.wait_for(lock, wait, [this] { return !state_->taken.empty(); })) return {};
  Line line = std::move(state_->taken.front());
  state_->taken.pop_front();
  state_->any = !state_->taken.empty();
  return line;
}

void ControlServer::send(std::uint64_t client, const std::string& line) {
  asio::post(state_->context, [state = state_.get(), client, line] {
    const auto found = state->clients.find(client);
    if (found != state->clients.end()) std::shared_ptr(found->second)->write(line);
  });
}

void ControlServer::send_all(const std::string& line) {
  asio::post(state_->context, [state = state_.get(), line] {
    const auto all = state->clients;
    for (const auto& [id, client] : all) client->write(line);
  });
}

}  // namespace cxlab::lab
