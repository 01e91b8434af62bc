#include "cx/network/socket_gateway.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "cx/base/number_text.h"

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

/// Sends to this machine only, whatever address a datagram names. Old kernels let only root set this.
void keep_on_this_machine(int socket) {
  constexpr char kDevice[] = "lo";
  (void)::setsockopt(socket, SOL_SOCKET, SO_BINDTODEVICE, kDevice, sizeof kDevice - 1);
}

constexpr char kSender = 'd', kDatagrams = 'D', kServer = 'S', kConnection = 'C';

/// What a servant opens: on the loopback interface only, whoever asks.
Servant::Answer open_socket(const std::string& request) {
  const auto refused = [] { return Servant::Answer{std::strerror(errno)}; };
  const char kind = request.empty() ? kSender : request.front();
  const auto port =
      read_number<std::uint16_t>(std::string_view(request).substr(std::min<std::size_t>(1, request.size())));
  if (kind != kSender && !port) return {"no port"};
  const bool stream = kind == kServer || kind == kConnection;
  Descriptor made(::socket(AF_INET, (stream ? SOCK_STREAM : SOCK_DGRAM) | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!made) return refused();
  keep_on_this_machine(made.number());
  const sockaddr_in address = loopback(port.value_or(0));
  const int yes = 1;
  // A server's port may be taken again right after a run; two programs never share one.
  if (kind == kServer) ::setsockopt(made.number(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (kind == kConnection && ::connect(made.number(), generic(address), sizeof address) != 0 && errno != EINPROGRESS)
    return refused();
  if ((kind == kServer || kind == kDatagrams) && ::bind(made.number(), generic(address), sizeof address) != 0)
    return refused();
  if (kind == kServer && ::listen(made.number(), SocketGateway::kConnectionsPerTick) != 0) return refused();
  return {"", std::move(made)};
}

}  // namespace

SocketGateway::Socket::~Socket() {
  if (fd_ >= 0) ::close(fd_);
}

Expected<std::unique_ptr<SocketGateway>> SocketGateway::create(Network& network, RecordSink& sink,
                                                               std::function<void(const std::string&)> complain) {
  auto opener = Servant::start([](const std::string& request, const auto&) { return open_socket(request); });
  if (!opener) return opener.error();
  std::unique_ptr<SocketGateway> gateway(new SocketGateway(network, *std::move(opener), std::move(complain)));
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
  gateway->sender_ = gateway->open(kSender, 0).first;
  gateway->buffer_.resize(1 << 16);
  return gateway;
}

SocketGateway::~SocketGateway() { network_.watcher_ = nullptr; }

// --- Ports

std::pair<SocketGateway::Socket, std::string> SocketGateway::open(char kind, std::uint16_t port) {
  auto answer = opener_.ask(kind + std::to_string(port));
  if (!answer) return {Socket(), answer.error().message};
  return {Socket(answer->descriptor.release()), answer->text};
}

SocketGateway::Socket SocketGateway::bound(char kind, std::uint16_t port) {
  auto [socket, trouble] = open(kind, port);
  if (!socket)
    complain_(std::string(kind == kDatagrams ? "UDP" : "TCP") + " port " + std::to_string(port) +
              " cannot be opened for programs outside: " + trouble);
  return std::move(socket);
}

void SocketGateway::datagrams_opened(std::uint16_t port) { datagrams_[port] = bound(kDatagrams, port); }
void SocketGateway::server_opened(std::uint16_t port) { servers_[port] = bound(kServer, port); }

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
  auto [socket, trouble] = open(kConnection, event.to_port);
  if (!socket) return host_->close(event.link, trouble);
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
