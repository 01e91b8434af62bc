#include "scenarios/rcll/refbox/channel.h"

#include <google/protobuf/message.h>

#include <cassert>

namespace cxlab::rcll {

Channel::Channel(net::Host& host, std::string name, std::uint16_t send_port, std::uint16_t receive_port,
                 std::unique_ptr<pb::Crypto> crypto)
    : host_(host),
      name_(std::move(name)),
      send_port_(send_port),
      receive_port_(receive_port),
      crypto_(std::move(crypto)),
      link_(host.open_datagrams(send_port, receive_port)) {}

void Channel::share_port() { shared_ = host_.open_datagrams(send_port_, send_port_); }

void Channel::send(const google::protobuf::Message& message) {
  const auto bytes = pb::Types::write(message, crypto_.get());
  assert(bytes && "a message of the referee box lacks required fields");
  if (bytes->size() <= pb::kLargestDatagram) host_.send(link_, *bytes);
}

Expected<pb::MessagePtr> Channel::read(const pb::Types& types, const net::Event& event) const {
  if (event.link == shared_ && event.port == receive_port_) return pb::MessagePtr();
  const auto frame = pb::read_datagram(event.bytes, crypto_.get());
  if (!frame) return frame.error();
  return types.read(*frame);
}

}  // namespace cxlab::rcll
