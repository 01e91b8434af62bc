#pragma once
// The open connections of one environment on the network: peers for datagrams, a server for streams, clients of
// servers. Messages from them become facts (docs/reference/plugins/protobuf.md).

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/executive/environment.h"
#include "cx/network/host.h"
#include "cx/plugins/protobuf/fields.h"
#include "cx/protobuf/types.h"
#include "cx/protobuf/wire.h"

namespace cxlab::cx {

/// Ids of peers and clients are counted together, from 1.
class ProtobufPeers {
 public:
  /// Peers and streams together; opening one more is an error.
  static constexpr std::size_t kMost = 250;

  using Log = std::function<void(LogLevel, std::string_view text)>;

  /// `next`: facts as in the next CX.
  ProtobufPeers(Environment& environment, net::Network& network, const pb::Types& types, ProtobufMessages& messages,
                Log log, bool next)
      : environment_(environment),
        network_(network),
        types_(types),
        messages_(messages),
        log_(std::move(log)),
        next_(next) {}

  // --- Peers
  /// 0 where a port is none.
  Expected<std::int64_t> create_peer(std::int64_t send_port, std::int64_t receive_port);
  Status set_crypto(std::int64_t peer, const std::string& key, std::string_view cipher);
  void destroy_peer(std::int64_t peer);

  // --- Streams
  /// Nothing happens if there is one, or the port is none.
  Status enable_server(std::int64_t port);
  void disable_server();
  /// 0 where the port is none. The connection is asked for by `connect_now`, in the next tick: then a server is there
  /// that others open later in this one.
  Expected<std::int64_t> connect(const std::string& host, std::int64_t port);
  bool is_connecting() const { return !connecting_.empty(); }
  void connect_now();
  void disconnect(std::int64_t id);

  // --- Both
  void broadcast(std::int64_t peer, const google::protobuf::Message& message);
  /// To a peer, a server or a client; nothing happens if there is none of that id.
  void send(std::int64_t id, const google::protobuf::Message& message);

 private:
  struct Peer {
    net::LinkId link{};
    std::unique_ptr<pb::Crypto> crypto;  ///< may be none
  };
  struct Stream {
    net::LinkId link{};
    bool of_server = false;  ///< a client of the server here
    std::string host;        ///< of the other end
    std::int64_t port = 0;
    bool connected = false;
    pb::StreamReader reader = {};
  };
  /// The source of a message, as its facts name it.
  struct Source {
    std::string_view client_type, host;
    std::int64_t port = 0, id = 0;
  };

  /// To open one more peer or stream on.
  Expected<net::Host*> host();
  void take(const net::Event& event);
  void take_datagram(const net::Event& event);
  void take_bytes(const net::Event& event);
  void take_frame(const Expected<pb::Frame>& frame, const Source& source, RecordRef cause);
  void note(std::string_view name, std::string_view content, RecordRef cause);
  void assert_received(const pb::Frame& frame, pb::MessagePtr message, const Source& source, RecordRef cause);
  void assert_failed(pb::MessageKey key, const Source& source, const std::string& why, RecordRef cause);
  /// The address of a message's sender.
  Value address(const Source& source) const;
  void assert_ordered(const std::string& name, std::initializer_list<Value> values);
  std::map<std::int64_t, Stream>::iterator find(net::LinkId link);

  Environment& environment_;
  net::Network& network_;
  const pb::Types& types_;
  ProtobufMessages& messages_;
  Log log_;
  bool next_;
  std::unique_ptr<net::Host> host_;  ///< none before something is opened
  std::map<std::int64_t, Peer> peers_;
  std::map<std::int64_t, Stream> streams_;
  struct Connecting {
    std::int64_t id = 0;
    std::uint16_t port = 0;
    std::vector<RecordRef> causes;
  };
  std::vector<Connecting> connecting_;
  std::optional<net::LinkId> server_;
  std::int64_t last_id_ = 0;
};

}  // namespace cxlab::cx
