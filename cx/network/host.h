#pragma once
// One participant's place in the network of an episode: datagrams to ports, and streams of bytes between a server and
// its clients. Environments and nodes use it alike.
//
//   auto host = net::Host::create(network, participant, [&](const net::Event& event) { ... });
//   const net::LinkId peer = (*host)->open_datagrams(4444, 4445);
//   (*host)->send(peer, bytes);
//
// Everything travels as posts of the participant on the bus. It arrives when other posts do
// (docs/reference/contracts.md) and is part of the input log. The handler runs when the participant takes its waiting
// deliveries. There is one machine: every name of a host means it, and its address is 127.0.0.1.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "cx/base/expected.h"
#include "cx/bus/bus.h"

namespace cxlab::net {

class Network;
struct Packet;

/// A link of one host: 1, 2, 3 ... in order of making, never used again. 0 = none.
enum class LinkId : std::uint32_t { kNone = 0 };

/// The address of all hosts.
inline constexpr std::string_view kLoopback = "127.0.0.1";

enum class EventKind : std::uint8_t {
  kDatagram,   ///< `bytes` came to the port that `link` receives on
  kConnected,  ///< `link`, a client, has reached its server
  kAccepted,   ///< `link` is a new one, of a client that has reached `server`
  kBytes,      ///< the next bytes of a stream; where they are cut means nothing
  kClosed,     ///< by the other side, or it was never reached: `link` is gone; `bytes` says why, for people
};

/// What a host takes. It is valid as long as the handler runs.
struct Event {
  EventKind kind{};
  LinkId link{};
  LinkId server{};          ///< kAccepted
  std::string_view host{};  ///< kDatagram, kAccepted: where it comes from
  std::uint16_t port = 0;   ///< the same
  std::uint16_t to_port{};  ///< kDatagram, kAccepted: where it was sent to
  std::string_view bytes{};
  RecordRef cause{};  ///< the record of the post
};

class Host {
 public:
  using Handler = std::function<void(const Event&)>;

  /// The network outlives the host.
  static Expected<std::unique_ptr<Host>> create(Network& network, bus::ParticipantId participant, Handler handler);
  ~Host();
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  /// Sends to all links that receive on `send_port`, itself excluded, and receives what is sent to `receive_port`.
  LinkId open_datagrams(std::uint16_t send_port, std::uint16_t receive_port);
  /// Opens a server. If a port has several servers, the first one gets the clients.
  LinkId listen(std::uint16_t port);
  /// kConnected or kClosed follows.
  LinkId connect(std::uint16_t port, bus::Causes causes = {});

  /// A datagram, or the next bytes of a stream. False if there is no such link, or its stream is not connected.
  bool send(LinkId link, std::string_view bytes, bus::Causes causes = {});
  /// Whether anybody else, inside or outside of the episode, would receive a datagram of this link now.
  bool is_heard(LinkId link) const;
  /// Nothing more comes from the link. The other side of a stream is told; a server closes its streams.
  void close(LinkId link, bus::Causes causes = {});
  bool has(LinkId link) const { return links_.contains(link); }

  bus::ParticipantId participant() const { return participant_; }

 private:
  friend class Network;
  friend class SocketGateway;

  enum class LinkKind : std::uint8_t { kDatagrams, kServer, kStream };
  struct Link {
    LinkKind kind{};
    std::uint16_t port = 0;         // that it receives or listens on
    std::uint16_t to_port = 0;      // of datagrams
    bus::ParticipantId remote{};    // of streams: who is at the other end
    std::uint32_t remote_link = 0;  // of streams: 0 = not connected yet
    LinkId server{};                // of streams: that has accepted it
  };

  Host(Network& network, bus::ParticipantId participant, Handler handler)
      : network_(network), participant_(participant), handler_(std::move(handler)) {}
  LinkId add(Link link);
  void remove(LinkId link);
  void post(const Packet& packet, std::span<const bus::EndpointId> to, bus::Causes causes);
  void post(const Packet& packet, const Host* to, bus::Causes causes);
  void send_close(LinkId id, const Link& link, std::string_view why, bus::Causes causes);
  void take(const bus::Delivery& delivery);
  void take_datagram(const Packet& packet, bus::ParticipantId from, Event event);
  void take_connect(const Packet& packet, bus::ParticipantId from, Event event);
  void take_accept(const Packet& packet, bus::ParticipantId from, Event event);
  /// The link of a stream that the packet is for, or none.
  LinkId stream_of(const Packet& packet, bus::ParticipantId from) const;

  // --- For a gateway, which is the host of all that is outside
  void send_from(std::string_view host, std::uint16_t port, std::uint16_t to_port, std::string_view bytes);
  LinkId connect_from(std::string_view host, std::uint16_t port, std::uint16_t to_port, bus::Causes causes = {});
  /// Tells the client of an accepted link that it is connected; a gateway does so when it has reached the outside.
  void confirm(LinkId link);
  void close(LinkId link, std::string_view why, bus::Causes causes = {});

  Network& network_;
  bus::ParticipantId participant_;
  Handler handler_;
  bus::EndpointId out_{}, in_{};
  std::map<LinkId, Link> links_;
  std::uint32_t last_link_ = 0, accepted_ = 0;
};

}  // namespace cxlab::net
