#include "cx/network/socket_gateway.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

namespace cxlab::net {

namespace {

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

const sockaddr* generic(const sockaddr_in& address) { return reinterpret_cast<const sockaddr*>(&address); }
sockaddr* generic(sockaddr_in& address) { return reinterpret_cast<sockaddr*>(&address); }

std::string host_of(const sockaddr_in& address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  return inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size()) ? text.data() : std::string(kLoopback);
}

bool would_wait() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

int make_socket(int type) { return ::socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0); }

}  // namespace

SocketGateway::Socket::~Socket() {
  if (fd_ >= 0) ::close(fd_);
}

Expected<std::unique_ptr<SocketGateway>> SocketGateway::create(Network& network, RecordSink& sink,
                                                               std::function<void(const std::string&)> complain) {
  std::unique_ptr<SocketGateway> gateway(new SocketGateway(network, std::move(complain)));
  bus::NodeName name;
  name.name = "cxlab_sockets";
  const auto node = network.bus().join(bus::ParticipantKind::kNode, std::move(name), sink.open_stream("sockets"));
  auto host = Host::create(network, node, [self = gateway.get()](const Event& event) { self->take(event); });
  if (!host) return host.error();
  gateway->host_ = *std::move(host);
  network.hosts_.pop_back();  // it is the host of all that is not inside
  network.gateway_ = gateway->host_.get();
  network.watcher_ = gateway.get();
  for (const Host* inside : network.hosts_)
    for (const auto& [id, link] : inside->links_) {
      if (link.kind == Host::LinkKind::kDatagrams && !gateway->datagrams_.contains(link.port))
        gateway->datagrams_opened(link.port);
      if (link.kind == Host::LinkKind::kServer && !gateway->servers_.contains(link.port))
        gateway->server_opened(link.port);
    }
  gateway->sender_ = Socket(make_socket(SOCK_DGRAM));
  gateway->buffer_.resize(1 << 16);
  return gateway;
}

SocketGateway::~SocketGateway() { network_.watcher_ = nullptr; }

// --- Ports

SocketGateway::Socket SocketGateway::bound(int type, std::uint16_t port) {
  Socket socket(make_socket(type));
  const int yes = 1;
  // A server's port may be taken again right after a run; two programs never share one.
  if (type == SOCK_STREAM) ::setsockopt(socket.fd(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  const sockaddr_in address = loopback(port);
  if (socket && ::bind(socket.fd(), generic(address), sizeof address) == 0 &&
      (type == SOCK_DGRAM || ::listen(socket.fd(), kConnectionsPerTick) == 0))
    return socket;
  complain_(std::string(type == SOCK_DGRAM ? "UDP" : "TCP") + " port " + std::to_string(port) +
            " cannot be opened for programs outside: " + std::strerror(errno));
  return {};
}

void SocketGateway::datagrams_opened(std::uint16_t port) { datagrams_[port] = bound(SOCK_DGRAM, port); }
void SocketGateway::server_opened(std::uint16_t port) { servers_[port] = bound(SOCK_STREAM, port); }

// --- In

Status SocketGateway::sense(SimTime now) {
  now_ = now;
  for (const auto& [port, socket] : datagrams_)
    if (socket) read_datagrams(port, socket);
  for (const auto& [port, socket] : servers_)
    if (socket) accept_clients(port, socket);
  std::vector<LinkId> ended;
  for (auto& [link, stream] : streams_)
    if (!read_stream(link, stream)) ended.push_back(link);
  for (const LinkId link : ended) {
    host_->close(link, "the program outside has closed it");
    streams_.erase(link);
  }
  return {};
}

void SocketGateway::read_datagrams(std::uint16_t port, const Socket& socket) {
  for (int i = 0; i < kDatagramsPerTick; ++i) {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t size = ::recvfrom(socket.fd(), buffer_.data(), buffer_.size(), 0, generic(from), &length);
    if (size < 0) {
      if (would_wait()) return;
      continue;  // an answer to something that was sent before
    }
    host_->send_from(host_of(from), ntohs(from.sin_port), port, {buffer_.data(), static_cast<std::size_t>(size)});
  }
}

void SocketGateway::accept_clients(std::uint16_t port, const Socket& socket) {
  for (int i = 0; i < kConnectionsPerTick; ++i) {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    Socket client(::accept4(socket.fd(), generic(from), &length, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!client) return;
    if (streams_.size() >= kMostConnections) continue;
    const LinkId link = host_->connect_from(host_of(from), ntohs(from.sin_port), port);
    streams_[link].socket = std::move(client);
  }
}

bool SocketGateway::read_stream(LinkId link, Stream& stream) {
  if (!stream.reached) {
    if (!stream.outgoing) return true;  // until the server inside has accepted it
    int error = 0;
    socklen_t length = sizeof error;
    sockaddr_in peer{};
    socklen_t peer_length = sizeof peer;
    if (::getsockopt(stream.socket.fd(), SOL_SOCKET, SO_ERROR, &error, &length) != 0 || error != 0) return false;
    if (::getpeername(stream.socket.fd(), generic(peer), &peer_length) != 0) return true;  // not connected yet
    stream.reached = true;
    host_->confirm(link);
  }
  if (!write_stream(stream)) return false;
  for (std::size_t taken = 0; taken < kStreamBytesPerTick;) {
    const ssize_t size = ::recv(stream.socket.fd(), buffer_.data(), buffer_.size(), 0);
    if (size < 0) return would_wait();
    if (size == 0) return false;
    taken += static_cast<std::size_t>(size);
    host_->send(link, {buffer_.data(), static_cast<std::size_t>(size)});
  }
  return true;
}

// --- Out

Status SocketGateway::act(SimTime) {
  network_.bus().deliver(host_->participant());
  return {};
}

void SocketGateway::take(const Event& event) {
  switch (event.kind) {
    case EventKind::kDatagram: return send_datagram(event);
    case EventKind::kAccepted: return reach_out(event);
    case EventKind::kConnected: streams_[event.link].reached = true; return;
    case EventKind::kBytes: {
      Stream& stream = streams_[event.link];
      stream.unsent += event.bytes;
      (void)write_stream(stream);  // an error is found when it is read next
      if (stream.unsent.size() > kMostUnsent) {
        complain_("a program outside reads too slowly: its connection was closed");
        host_->close(event.link, "it reads too slowly");
        streams_.erase(event.link);
      }
      return;
    }
    case EventKind::kClosed: streams_.erase(event.link); return;
  }
}

void SocketGateway::send_datagram(const Event& event) {
  const auto found = datagrams_.find(event.port);
  const Socket& socket = found != datagrams_.end() && found->second ? found->second : sender_;
  const sockaddr_in to = loopback(event.to_port);
  // As with any datagram, nobody is told that it did not arrive.
  (void)::sendto(socket.fd(), event.bytes.data(), event.bytes.size(), MSG_NOSIGNAL, generic(to), sizeof to);
}

void SocketGateway::reach_out(const Event& event) {
  Socket socket(make_socket(SOCK_STREAM));
  const sockaddr_in to = loopback(event.to_port);
  if (!socket || (::connect(socket.fd(), generic(to), sizeof to) != 0 && errno != EINPROGRESS))
    return host_->close(event.link, std::strerror(errno));
  Stream& stream = streams_[event.link];
  stream.socket = std::move(socket);
  stream.outgoing = true;
}

bool SocketGateway::write_stream(Stream& stream) {
  while (!stream.unsent.empty()) {
    const ssize_t size = ::send(stream.socket.fd(), stream.unsent.data(), stream.unsent.size(), MSG_NOSIGNAL);
    if (size < 0) return would_wait();
    stream.unsent.erase(0, static_cast<std::size_t>(size));
  }
  return true;
}

}  // namespace cxlab::net
