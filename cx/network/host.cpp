#include "cx/network/host.h"

#include <algorithm>
#include <array>
#include <vector>

#include "cx/bus/needed.h"
#include "cx/network/network.h"
#include "cx/network/packet.h"

namespace cxlab::net {

namespace {

std::uint32_t number(LinkId link) { return static_cast<std::uint32_t>(link); }

/// A made-up port for the k-th client inside the episode that a host has accepted: such a client has no port of its
/// own.
std::uint16_t port_of_client(std::uint32_t k) { return static_cast<std::uint16_t>(49152 + k % 16384); }

}  // namespace

// --- Packets

Expected<const bus::MessageType*> packet_type(bus::Bus& bus) {
  return bus::needed_message(bus.registry(), "cxlab_msgs/msg/NetworkPacket");
}

bus::SharedMessage to_message(const Packet& packet, const bus::MessageType& type) {
  auto message = std::make_shared<bus::Message>(type);
  message->view()
      .set("kind", static_cast<int>(packet.kind))
      .set("from_link", static_cast<std::int64_t>(packet.from_link))
      .set("to_link", static_cast<std::int64_t>(packet.to_link))
      .set("to_port", static_cast<std::int64_t>(packet.to_port))
      .set("host", packet.host)
      .set("port", static_cast<std::int64_t>(packet.port))
      .set("bytes", packet.bytes);
  return message;
}

Packet to_packet(const bus::MessageView& message) {
  const auto integer = [&](std::string_view field) { return static_cast<std::uint32_t>(message.integer(field)); };
  return {static_cast<PacketKind>(message.integer("kind")),
          integer("from_link"),
          integer("to_link"),
          integer("to_port"),
          message.text("host"),
          integer("port"),
          message.text("bytes")};
}

// --- Life

Expected<std::unique_ptr<Host>> Host::create(Network& network, bus::ParticipantId participant, Handler handler) {
  auto type = packet_type(network.bus());
  if (!type) return type.error();
  std::unique_ptr<Host> host(new Host(network, participant, std::move(handler)));
  auto out = network.bus().advertise(participant, kNetworkTopic, **type);
  if (!out) return out.error();
  host->out_ = *out;
  auto in = network.bus().subscribe(participant, kNetworkTopic, **type,
                                    [self = host.get()](const bus::Delivery& delivery) { self->take(delivery); });
  if (!in) {
    network.bus().remove(*out);
    return in.error();
  }
  host->in_ = *in;
  network.add(*host);
  return host;
}

Host::~Host() {
  while (!links_.empty()) close(links_.begin()->first);
  network_.remove(*this);
  network_.bus().remove(out_);
  network_.bus().remove(in_);
}

LinkId Host::add(Link link) {
  const auto id = static_cast<LinkId>(++last_link_);
  network_.opened(link);
  links_.emplace(id, link);
  return id;
}

void Host::remove(LinkId id) {
  const auto found = links_.find(id);
  const Link link = found->second;
  links_.erase(found);
  network_.closed(link);
}

// --- Sending

void Host::post(const Packet& packet, std::span<const bus::EndpointId> to, bus::Causes causes) {
  auto type = packet_type(network_.bus());
  network_.bus().publish_to(out_, to, to_message(packet, **type), causes);
}

void Host::post(const Packet& packet, const Host* to, bus::Causes causes) {
  // Also to nobody: the record of the post does not depend on who is there.
  post(packet, to ? std::span(&to->in_, 1) : std::span<const bus::EndpointId>(), causes);
}

LinkId Host::open_datagrams(std::uint16_t send_port, std::uint16_t receive_port) {
  return add({.kind = LinkKind::kDatagrams, .port = receive_port, .to_port = send_port});
}

LinkId Host::listen(std::uint16_t port) { return add({.kind = LinkKind::kServer, .port = port}); }

LinkId Host::connect(std::uint16_t port, bus::Causes causes) { return connect_from(kLoopback, 0, port, causes); }

LinkId Host::connect_from(std::string_view host, std::uint16_t port, std::uint16_t to_port, bus::Causes causes) {
  const LinkId id = add({.kind = LinkKind::kStream});
  const auto server = network_.server(to_port, *this);
  Packet packet{.kind = PacketKind::kConnect, .from_link = number(id), .to_port = to_port, .host = host, .port = port};
  if (server) links_.at(id).remote = server->host->participant_;
  post(packet, server ? server->host : nullptr, causes);
  if (!server) network_.refuse(*this, id, to_port);
  return id;
}

bool Host::is_heard(LinkId id) const {
  const auto found = links_.find(id);
  return found != links_.end() && network_.others_receive(found->second.to_port, *this);
}

bool Host::send(LinkId id, std::string_view bytes, bus::Causes causes) {
  const auto found = links_.find(id);
  if (found == links_.end()) return false;
  const Link& link = found->second;
  if (link.kind == LinkKind::kDatagrams) {
    const Packet packet{.kind = PacketKind::kDatagram,
                        .from_link = number(id),
                        .to_port = link.to_port,
                        .host = kLoopback,
                        .port = link.port,
                        .bytes = bytes};
    post(packet, network_.receivers(link.to_port, *this, id), causes);
    return true;
  }
  if (link.remote_link == 0) return false;
  post({.kind = PacketKind::kBytes, .from_link = number(id), .to_link = link.remote_link, .bytes = bytes},
       network_.find(link.remote), causes);
  return true;
}

void Host::send_from(std::string_view host, std::uint16_t port, std::uint16_t to_port, std::string_view bytes) {
  post({.kind = PacketKind::kDatagram, .to_port = to_port, .host = host, .port = port, .bytes = bytes},
       network_.receivers(to_port, *this, LinkId::kNone), {});
}

void Host::confirm(LinkId id) {
  const Link& link = links_.at(id);
  post({.kind = PacketKind::kAccept, .from_link = number(id), .to_link = link.remote_link}, network_.find(link.remote),
       {});
}

void Host::close(LinkId id, bus::Causes causes) { close(id, "the other side has closed it", causes); }

void Host::close(LinkId id, std::string_view why, bus::Causes causes) {
  const auto found = links_.find(id);
  if (found == links_.end()) return;
  const Link link = found->second;
  if (link.kind == LinkKind::kServer) {
    std::vector<LinkId> clients;
    for (const auto& [client, of] : links_)
      if (of.server == id) clients.push_back(client);
    for (const LinkId client : clients) close(client, why, causes);
  }
  remove(id);
  if (link.kind == LinkKind::kStream)
    post({.kind = PacketKind::kClose, .from_link = number(id), .to_link = link.remote_link, .bytes = why},
         network_.find(link.remote), causes);
}

// --- Taking

void Host::take(const bus::Delivery& delivery) {
  const Packet packet = to_packet(delivery.message->view());
  Event event{.bytes = packet.bytes, .cause = delivery.cause};
  switch (packet.kind) {
    case PacketKind::kDatagram: return take_datagram(packet, delivery.from, event);
    case PacketKind::kConnect: return take_connect(packet, delivery.from, event);
    case PacketKind::kAccept: return take_accept(packet, delivery.from, event);
    case PacketKind::kBytes: event.kind = EventKind::kBytes; break;
    case PacketKind::kClose: event.kind = EventKind::kClosed; break;
    default: return;  // rules can publish anything on the topic
  }
  event.link = stream_of(packet, delivery.from);
  if (event.link == LinkId::kNone) return;
  if (event.kind == EventKind::kClosed) remove(event.link);
  handler_(event);
}

void Host::take_datagram(const Packet& packet, bus::ParticipantId from, Event event) {
  event.kind = EventKind::kDatagram;
  event.host = packet.host;
  event.port = static_cast<std::uint16_t>(packet.port);
  event.to_port = static_cast<std::uint16_t>(packet.to_port);
  if (this == network_.gateway_) return handler_(event);
  std::vector<LinkId> receivers;  // the handler may close links
  for (const auto& [id, link] : links_)
    if (link.kind == LinkKind::kDatagrams && link.port == event.to_port &&
        !(from == participant_ && number(id) == packet.from_link))
      receivers.push_back(id);
  for (const LinkId id : receivers) {
    event.link = id;
    if (has(id)) handler_(event);
  }
}

void Host::take_connect(const Packet& packet, bus::ParticipantId from, Event event) {
  event.kind = EventKind::kAccepted;
  event.to_port = static_cast<std::uint16_t>(packet.to_port);
  const bool gateway = this == network_.gateway_;
  for (const auto& [id, link] : links_)
    if (link.kind == LinkKind::kServer && link.port == event.to_port && event.server == LinkId::kNone)
      event.server = id;
  if (event.server == LinkId::kNone && !gateway)
    return post({.kind = PacketKind::kClose, .to_link = packet.from_link, .bytes = "nobody listens there any more"},
                network_.find(from), {});
  event.link =
      add({.kind = LinkKind::kStream, .remote = from, .remote_link = packet.from_link, .server = event.server});
  event.host = packet.host;
  event.port = packet.port != 0 ? static_cast<std::uint16_t>(packet.port) : port_of_client(accepted_++);
  if (!gateway) confirm(event.link);
  handler_(event);
}

void Host::take_accept(const Packet& packet, bus::ParticipantId from, Event event) {
  const auto found = links_.find(static_cast<LinkId>(packet.to_link));
  if (found == links_.end() || found->second.kind != LinkKind::kStream || found->second.remote_link != 0) return;
  found->second.remote = from;
  found->second.remote_link = packet.from_link;
  event.kind = EventKind::kConnected;
  event.link = found->first;
  handler_(event);
}

LinkId Host::stream_of(const Packet& packet, bus::ParticipantId from) const {
  // A client that closes before it was accepted does not know the number of the link here.
  if (packet.to_link == 0) {
    for (const auto& [id, link] : links_)
      if (link.kind == LinkKind::kStream && link.remote == from && link.remote_link == packet.from_link &&
          packet.from_link != 0)
        return id;
    return LinkId::kNone;
  }
  const auto found = links_.find(static_cast<LinkId>(packet.to_link));
  if (found == links_.end() || found->second.kind != LinkKind::kStream) return LinkId::kNone;
  const Link& link = found->second;
  const bool refused = link.remote_link == 0 && packet.kind == PacketKind::kClose;
  return refused || (link.remote == from && link.remote_link == packet.from_link) ? found->first : LinkId::kNone;
}

}  // namespace cxlab::net
