#pragma once
// The post that carries what one host sends to another: cxlab_msgs/msg/NetworkPacket.

#include <cstdint>
#include <string_view>

#include "cx/bus/bus.h"

namespace cxlab::net {

enum class PacketKind : std::uint8_t { kDatagram, kConnect, kAccept, kBytes, kClose };

struct Packet {
  PacketKind kind{};
  std::uint32_t from_link = 0, to_link = 0, to_port = 0;
  std::string_view host{};
  std::uint32_t port = 0;
  std::string_view bytes{};
};

/// The topic of all hosts. Each packet goes to some of them only.
inline constexpr const char* kNetworkTopic = "/cxlab/network";

Expected<const bus::MessageType*> packet_type(bus::Bus& bus);
bus::SharedMessage to_message(const Packet& packet, const bus::MessageType& type);
/// Views the message.
Packet to_packet(const bus::MessageView& message);

}  // namespace cxlab::net
