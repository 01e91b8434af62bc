#pragma once
// A channel of the league's protocol: frames to one port and from another, plain or encrypted.

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "cx/network/host.h"
#include "cx/protobuf/types.h"
#include "cx/protobuf/wire.h"

namespace cxlab::rcll {

class Channel {
 public:
  /// The host outlives it. `crypto` may be none; `name` is for people.
  Channel(net::Host& host, std::string name, std::uint16_t send_port, std::uint16_t receive_port,
          std::unique_ptr<pb::Crypto> crypto = nullptr);

  /// Takes what is sent to its send port as well: agents of a real network send and receive on one port.
  void share_port();
  bool owns(net::LinkId link) const { return link == link_ || (link == shared_ && link != net::LinkId::kNone); }
  /// Whether anybody else listens.
  bool is_heard() const { return host_.is_heard(link_); }
  const std::string& name() const { return name_; }

  void send(const google::protobuf::Message& message);
  /// What came on one of its links; none for what it has sent itself.
  Expected<pb::MessagePtr> read(const pb::Types& types, const net::Event& event) const;

 private:
  net::Host& host_;
  std::string name_;
  std::uint16_t send_port_, receive_port_;
  std::unique_ptr<pb::Crypto> crypto_;
  net::LinkId link_{}, shared_{};
};

}  // namespace cxlab::rcll
