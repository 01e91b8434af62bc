#pragma once
// Real sockets on the loopback interface, for what lies outside of the process: `--sockets`. Ports that hosts of the
// episode use are opened for programs outside; what hosts send to other ports goes to programs outside. Nothing ever
// leaves the machine, whatever address rules name.
//
// The queues of the kernel are read at ticks, and written at their end. There is no thread.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/base/servant.h"
#include "cx/network/host.h"
#include "cx/network/network.h"
#include "cx/run/parts.h"

namespace cxlab::net {

class SocketGateway final : public Server, private PortWatcher {
 public:
  // What one tick takes at most, so that a flood does not starve it: the rest waits in the kernel, which drops
  // datagrams that it has no room for.
  static constexpr int kDatagramsPerTick = 1000;               ///< of a port
  static constexpr std::size_t kStreamBytesPerTick = 1 << 20;  ///< of a connection
  static constexpr int kConnectionsPerTick = 16;               ///< of a port
  static constexpr std::size_t kMostConnections = 256;         ///< further ones are closed at once
  static constexpr std::size_t kMostUnsent = 16 << 20;         ///< bytes; a program that reads too slowly is cut off

  /// The last of an episode's servers. `complain` takes a line for people where a port cannot be opened.
  static Expected<std::unique_ptr<SocketGateway>> create(Network& network, RecordSink& sink,
                                                         std::function<void(const std::string&)> complain);
  ~SocketGateway() override;

  Status sense(SimTime now) override;
  Status act(SimTime now) override;
  SimTime next_due() const override { return now_; }  // each tick

 private:
  /// A socket that closes itself.
  class Socket {
   public:
    Socket() = default;
    explicit Socket(int fd) : fd_(fd) {}
    Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    Socket& operator=(Socket&& other) noexcept {
      std::swap(fd_, other.fd_);
      return *this;
    }
    ~Socket();
    int fd() const { return fd_; }
    explicit operator bool() const { return fd_ >= 0; }

   private:
    int fd_ = -1;
  };
  struct Stream {
    Socket socket;
    bool reached = false;   ///< both ends are connected
    bool outgoing = false;  ///< of a client inside
    std::string unsent;
  };

  SocketGateway(Network& network, Servant opener, std::function<void(const std::string&)> complain)
      : network_(network), opener_(std::move(opener)), complain_(std::move(complain)) {}
  void datagrams_opened(std::uint16_t port) override;
  void datagrams_closed(std::uint16_t port) override { datagrams_.erase(port); }
  void server_opened(std::uint16_t port) override;
  void server_closed(std::uint16_t port) override { servers_.erase(port); }
  /// A socket of that kind, or none and why.
  std::pair<Socket, std::string> open(char kind, std::uint16_t port);
  /// Bound to that port of the loopback interface, or nothing.
  Socket bound(char kind, std::uint16_t port);

  void take(const Event& event);
  void send_datagram(const Event& event);
  void reach_out(const Event& event);
  void read_datagrams(std::uint16_t port, const Socket& socket);
  void accept_clients(std::uint16_t port, const Socket& socket);
  /// False once the stream has ended.
  bool read_stream(LinkId link, Stream& stream);
  bool write_stream(Stream& stream);

  Network& network_;
  Servant opener_;  ///< of sockets, which this process cannot open behind a wall (cx/wall/wall.h)
  std::function<void(const std::string&)> complain_;
  std::unique_ptr<Host> host_;
  std::map<std::uint16_t, Socket> datagrams_, servers_;  // by port; those that could not be bound are empty
  Socket sender_;                                        // of datagrams from ports that could not be bound
  std::map<LinkId, Stream> streams_;
  std::string buffer_;
  SimTime now_{};
};

}  // namespace cxlab::net
