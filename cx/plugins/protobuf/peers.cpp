#include "cx/plugins/protobuf/peers.h"

#include <algorithm>
#include <utility>

#include "cx/base/charge.h"
#include "cx/base/number_text.h"

namespace cxlab::cx {

namespace {

std::optional<std::uint16_t> port_of(std::int64_t number) {
  if (number <= 0 || number > UINT16_MAX) return std::nullopt;
  return static_cast<std::uint16_t>(number);
}

/// As CLIPS reads the word: a symbol, but for numbers.
Value host_word(std::string_view text) {
  if (const auto integer = read_number<std::int64_t>(text)) return Value::integer(*integer);
  if (const auto real = read_number<double>(text)) return Value::number(*real);
  return Value::symbol(std::string(text));
}

}  // namespace

Expected<net::Host*> ProtobufPeers::host() {
  if (peers_.size() + streams_.size() >= kMost)
    return run_error(std::to_string(kMost) + " peers and streams are open, which is the most");
  if (!host_) {
    auto made = net::Host::create(network_, environment_.participant(), [this](const net::Event& e) { take(e); });
    if (!made) return made.error();
    host_ = *std::move(made);
  }
  return host_.get();
}

// --- Opening and closing

Expected<std::int64_t> ProtobufPeers::create_peer(std::int64_t send_port, std::int64_t receive_port) {
  const auto to = port_of(send_port), from = port_of(receive_port == 0 ? send_port : receive_port);
  if (!to || !from) return 0;
  auto host = this->host();
  if (!host) return host.error();
  peers_[++last_id_].link = (*host)->open_datagrams(*to, *from);
  return last_id_;
}

Status ProtobufPeers::set_crypto(std::int64_t id, const std::string& key, std::string_view cipher_name) {
  const auto peer = peers_.find(id);
  if (peer == peers_.end()) return {};
  if (cipher_name.empty() || key.empty()) {
    peer->second.crypto.reset();
    return {};
  }
  const auto cipher = pb::cipher_of(cipher_name);
  if (!cipher) return cipher.error();
  auto crypto = pb::Crypto::create(*cipher, key);
  if (!crypto) return crypto.error();
  peer->second.crypto = *std::move(crypto);
  return {};
}

void ProtobufPeers::destroy_peer(std::int64_t id) {
  const auto peer = peers_.find(id);
  if (peer == peers_.end()) return;
  host_->close(peer->second.link, environment_.engine().cause());
  peers_.erase(peer);
}

Status ProtobufPeers::enable_server(std::int64_t number) {
  const auto port = port_of(number);
  if (server_ || !port) return {};
  auto host = this->host();
  if (!host) return host.error();
  server_ = (*host)->listen(*port);
  return {};
}

void ProtobufPeers::disable_server() {
  if (!server_) return;
  host_->close(*server_, environment_.engine().cause());
  server_.reset();
  std::erase_if(streams_, [](const auto& item) { return item.second.of_server; });
}

Expected<std::int64_t> ProtobufPeers::connect(const std::string& address, std::int64_t number) {
  const auto port = port_of(number);
  if (!port) return 0;
  auto host = this->host();
  if (!host) return host.error();
  streams_.emplace(++last_id_, Stream{.host = address, .port = number});
  const auto causes = environment_.engine().cause();
  connecting_.push_back({last_id_, *port, {causes.begin(), causes.end()}});
  return last_id_;
}

void ProtobufPeers::connect_now() {
  for (const Connecting& wanted : std::exchange(connecting_, {}))
    if (const auto stream = streams_.find(wanted.id); stream != streams_.end())
      stream->second.link = host_->connect(wanted.port, wanted.causes);
}

void ProtobufPeers::disconnect(std::int64_t id) {
  const auto stream = streams_.find(id);
  if (stream == streams_.end()) return;
  host_->close(stream->second.link, environment_.engine().cause());
  streams_.erase(stream);
}

// --- Sending

void ProtobufPeers::broadcast(std::int64_t id, const google::protobuf::Message& message) {
  const auto peer = peers_.find(id);
  if (peer == peers_.end()) return;
  auto bytes = pb::Types::write(message, peer->second.crypto.get());
  if (bytes && bytes->size() > pb::kLargestDatagram)
    bytes = input_error("found " + std::to_string(bytes->size()) + " bytes, a datagram has at most " +
                        std::to_string(pb::kLargestDatagram));
  if (!bytes)
    return log_(LogLevel::kWarn, "CLIPS-Protobuf: Failed to broadcast message of type " +
                                     message.GetDescriptor()->full_name() + ": " + bytes.error().message);
  host_->send(peer->second.link, *bytes, environment_.engine().cause());
}

void ProtobufPeers::send(std::int64_t id, const google::protobuf::Message& message) {
  const auto stream = streams_.find(id);
  if (stream == streams_.end()) return broadcast(id, message);
  Status sent;
  if (auto bytes = pb::Types::write(message); !bytes)
    sent = bytes.error();
  else if (!host_->send(stream->second.link, *bytes, environment_.engine().cause()))
    sent = input_error("not connected");
  if (!sent)
    log_(LogLevel::kWarn, "CLIPS-Protobuf: Failed to send message of type " + message.GetDescriptor()->full_name() +
                              ": " + sent.error().message);
}

// --- Taking

std::map<std::int64_t, ProtobufPeers::Stream>::iterator ProtobufPeers::find(net::LinkId link) {
  return std::ranges::find(streams_, link, [](const auto& item) { return item.second.link; });
}

void ProtobufPeers::take(const net::Event& event) {
  const Charge held;  // by the rules
  switch (event.kind) {
    case net::EventKind::kDatagram: return take_datagram(event);
    case net::EventKind::kBytes: return take_bytes(event);
    case net::EventKind::kAccepted: {
      if (peers_.size() + streams_.size() >= kMost) return host_->close(event.link, {&event.cause, 1});
      Stream& stream = streams_[++last_id_];
      stream.link = event.link;
      stream.of_server = stream.connected = true;
      stream.host = event.host;
      stream.port = event.port;
      note("client connected", stream.host + ':' + std::to_string(stream.port), event.cause);
      return assert_ordered("protobuf-server-client-connected",
                            {Value::integer(last_id_), host_word(stream.host), Value::integer(stream.port)});
    }
    case net::EventKind::kConnected: {
      const auto stream = find(event.link);
      if (stream == streams_.end()) return;
      stream->second.connected = true;
      note("connected", {}, event.cause);
      return assert_ordered("protobuf-client-connected", {Value::integer(stream->first)});
    }
    case net::EventKind::kClosed: {
      const auto stream = find(event.link);
      if (stream == streams_.end()) return;
      const auto [id, of_server] = std::pair(stream->first, stream->second.of_server);
      streams_.erase(stream);
      note("disconnected", event.bytes, event.cause);
      return assert_ordered(of_server ? "protobuf-server-client-disconnected" : "protobuf-client-disconnected",
                            {Value::integer(id)});
    }
  }
}

void ProtobufPeers::take_datagram(const net::Event& event) {
  const auto peer = std::ranges::find(peers_, event.link, [](const auto& item) { return item.second.link; });
  if (peer == peers_.end()) return;
  take_frame(pb::read_datagram(event.bytes, peer->second.crypto.get()),
             {.client_type = "PEER", .host = event.host, .port = event.port, .id = peer->first}, event.cause);
}

void ProtobufPeers::take_bytes(const net::Event& event) {
  const auto stream = find(event.link);
  if (stream == streams_.end()) return;
  const std::string host = stream->second.host;
  const Source source{.client_type = stream->second.of_server ? "SERVER" : "CLIENT",
                      .host = host,
                      .port = stream->second.port,
                      .id = stream->first};
  stream->second.reader.add(event.bytes);
  while (true) {
    auto frame = stream->second.reader.next();
    if (frame && !*frame) return;
    if (frame) {
      take_frame(**std::move(frame), source, event.cause);
      continue;
    }
    // What follows cannot be told apart any more.
    take_frame(frame.error(), source, event.cause);
    host_->close(event.link, {&event.cause, 1});
    const bool of_server = stream->second.of_server;
    streams_.erase(stream);
    return assert_ordered(of_server ? "protobuf-server-client-disconnected" : "protobuf-client-disconnected",
                          {Value::integer(source.id)});
  }
}

void ProtobufPeers::take_frame(const Expected<pb::Frame>& frame, const Source& source, RecordRef cause) {
  if (!frame) return assert_failed({}, source, frame.error().message, cause);
  auto message = types_.read(*frame);
  if (!message) return assert_failed(frame->key, source, message.error().message, cause);
  assert_received(*frame, *std::move(message), source, cause);
}

// --- Facts

void ProtobufPeers::note(std::string_view name, std::string_view content, RecordRef cause) {
  environment_.note_input("protobuf", name, content, cause);
}

namespace {

Value via(std::string_view client_type) { return Value::symbol(client_type == "PEER" ? "BROADCAST" : "STREAM"); }

}  // namespace

Value ProtobufPeers::address(const Source& source) const {
  return Value::multifield(
      {next_ ? Value::string(std::string(source.host)) : host_word(source.host), Value::integer(source.port)});
}

void ProtobufPeers::assert_received(const pb::Frame& frame, pb::MessagePtr message, const Source& source,
                                    RecordRef cause) {
  const std::string type = message->GetDescriptor()->full_name();
  note(type, message->ShortDebugString(), cause);
  const Handle handle = messages_.add(std::move(message));
  const auto fact = environment_.engine().assert_fact("protobuf-msg",
                                                      {{"type", Value::string(type)},
                                                       {"comp-id", Value::integer(frame.key.component_id)},
                                                       {"msg-type", Value::integer(frame.key.message_type)},
                                                       {"rcvd-via", via(source.client_type)},
                                                       {"rcvd-from", address(source)},
                                                       {"rcvd-at", Value::number(to_seconds(environment_.now()))},
                                                       {"client-type", Value::symbol(std::string(source.client_type))},
                                                       {"client-id", Value::integer(source.id)},
                                                       {"ptr", Value::handle(handle)}});
  if (fact) return;
  messages_.destroy(handle);
  log_(LogLevel::kError, fact.error().message);
}

void ProtobufPeers::assert_failed(pb::MessageKey key, const Source& source, const std::string& why, RecordRef cause) {
  note("receive failed", why, cause);
  const auto fact = environment_.engine().assert_fact(
      source.client_type == "SERVER" ? "protobuf-server-receive-failed" : "protobuf-receive-failed",
      {{"comp-id", Value::integer(key.component_id)},
       {"msg-type", Value::integer(key.message_type)},
       {"rcvd-via", via(source.client_type)},
       {"rcvd-from", address(source)},
       {"client-id", Value::integer(source.id)},
       {"message", Value::string(why)}});
  if (!fact) log_(LogLevel::kError, fact.error().message);
}

void ProtobufPeers::assert_ordered(const std::string& name, std::initializer_list<Value> values) {
  if (auto fact = environment_.engine().assert_ordered(name, {values.begin(), values.size()}); !fact)
    log_(LogLevel::kError, fact.error().message);
}

}  // namespace cxlab::cx
