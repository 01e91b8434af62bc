#pragma once
// The network of an episode: who receives on which port. Participants use hosts (host.h); what lies outside of the
// process is a gateway's (socket_gateway.h).

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "cx/base/record_sink.h"
#include "cx/bus/bus.h"
#include "cx/network/host.h"

namespace cxlab::net {

/// Told which ports hosts use. Each call is for the first, or the last, of a port.
class PortWatcher {
 public:
  virtual ~PortWatcher() = default;
  virtual void datagrams_opened(std::uint16_t port) = 0;
  virtual void datagrams_closed(std::uint16_t port) = 0;
  virtual void server_opened(std::uint16_t port) = 0;
  virtual void server_closed(std::uint16_t port) = 0;
};

class Network {
 public:
  /// Both outlive it.
  Network(bus::Bus& bus, RecordSink& sink) : bus_(bus), sink_(sink) {}
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  bus::Bus& bus() { return bus_; }
  /// Whether programs outside of the process take part.
  bool is_open() const { return gateway_ != nullptr; }

 private:
  friend class Host;
  friend class SocketGateway;

  void add(Host& host) { hosts_.push_back(&host); }
  void remove(Host& host);
  void opened(const Host::Link& link);
  void closed(const Host::Link& link);
  std::size_t users(Host::LinkKind kind, std::uint16_t port) const;
  bool others_receive(std::uint16_t port, const Host& host) const;
  /// The endpoints of the hosts that receive there, without `link` of `sender`; the gateway's if there is none.
  std::vector<bus::EndpointId> receivers(std::uint16_t port, const Host& sender, LinkId link) const;
  struct Server {
    const Host* host;
    LinkId link;  ///< none: the gateway may find one outside
  };
  std::optional<Server> server(std::uint16_t port, const Host& client) const;
  const Host* find(bus::ParticipantId participant) const;
  /// Tells a client that nobody listens.
  void refuse(const Host& client, LinkId link, std::uint16_t port);

  bus::Bus& bus_;
  RecordSink& sink_;
  std::vector<Host*> hosts_;  // in order of making; without the gateway
  Host* gateway_ = nullptr;
  PortWatcher* watcher_ = nullptr;
  std::optional<bus::EndpointId> refusals_;  // of a node of its own
};

}  // namespace cxlab::net
