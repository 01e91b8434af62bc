#include "cx/network/network.h"

#include <algorithm>
#include <string>

#include "cx/network/packet.h"

namespace cxlab::net {

void Network::remove(Host& host) {
  std::erase(hosts_, &host);
  if (gateway_ == &host) gateway_ = nullptr;
}

std::size_t Network::users(Host::LinkKind kind, std::uint16_t port) const {
  std::size_t count = 0;
  for (const Host* host : hosts_)
    for (const auto& [id, link] : host->links_) count += link.kind == kind && link.port == port;
  return count;
}

void Network::opened(const Host::Link& link) {
  if (!watcher_ || link.kind == Host::LinkKind::kStream || users(link.kind, link.port) > 0) return;
  if (link.kind == Host::LinkKind::kServer)
    watcher_->server_opened(link.port);
  else
    watcher_->datagrams_opened(link.port);
}

void Network::closed(const Host::Link& link) {
  if (!watcher_ || link.kind == Host::LinkKind::kStream || users(link.kind, link.port) > 0) return;
  if (link.kind == Host::LinkKind::kServer)
    watcher_->server_closed(link.port);
  else
    watcher_->datagrams_closed(link.port);
}

bool Network::others_receive(std::uint16_t port, const Host& host) const {
  return (gateway_ && gateway_ != &host) || std::ranges::any_of(hosts_, [&](const Host* other) {
           return other != &host && std::ranges::any_of(other->links_, [&](const auto& item) {
                    return item.second.kind == Host::LinkKind::kDatagrams && item.second.port == port;
                  });
         });
}

std::vector<bus::EndpointId> Network::receivers(std::uint16_t port, const Host& sender, LinkId sending) const {
  std::vector<bus::EndpointId> out;
  for (const Host* host : hosts_)
    if (std::ranges::any_of(host->links_, [&](const auto& item) {
          const auto& [id, link] = item;
          return link.kind == Host::LinkKind::kDatagrams && link.port == port && !(host == &sender && id == sending);
        }))
      out.push_back(host->in_);
  if (out.empty() && gateway_ && gateway_ != &sender) out.push_back(gateway_->in_);
  return out;
}

std::optional<Network::Server> Network::server(std::uint16_t port, const Host& client) const {
  for (const Host* host : hosts_)
    for (const auto& [id, link] : host->links_)
      if (link.kind == Host::LinkKind::kServer && link.port == port) return Server{host, id};
  if (gateway_ && gateway_ != &client) return Server{gateway_, LinkId::kNone};
  return std::nullopt;
}

const Host* Network::find(bus::ParticipantId participant) const {
  if (gateway_ && gateway_->participant_ == participant) return gateway_;
  const auto found = std::ranges::find(hosts_, participant, [](const Host* host) { return host->participant_; });
  return found == hosts_.end() ? nullptr : *found;
}

void Network::refuse(const Host& client, LinkId link, std::uint16_t port) {
  auto type = packet_type(bus_);
  if (!type) return;
  if (!refusals_) {
    bus::NodeName name;
    name.name = "cxlab_network";
    const auto node = bus_.join(bus::ParticipantKind::kNode, std::move(name), sink_.open_stream("network"));
    auto publisher = bus_.advertise(node, kNetworkTopic, **type);
    if (!publisher) return;
    refusals_ = *publisher;
  }
  const std::string why = "nobody listens on port " + std::to_string(port);
  const Packet packet{.kind = PacketKind::kClose, .to_link = static_cast<std::uint32_t>(link), .bytes = why};
  bus_.publish_to(*refusals_, {&client.in_, 1}, to_message(packet, **type));
}

}  // namespace cxlab::net
