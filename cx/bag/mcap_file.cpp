#include <algorithm>
#include <map>

#include "cx/bag/bag_file.h"
#include "cx/mcap/mcap_reader.h"

namespace cxlab::bag {

namespace {

/// How many bytes of messages that lie outside of chunks are read together.
constexpr std::size_t kTogether = std::size_t{1} << 20;
/// How many bytes are held where parts of the file overlap in time.
constexpr std::size_t kMostHeld = std::size_t{256} << 20;

/// Recorders write chunks roughly in order of time. A part is a chunk, or a series of messages outside of chunks. The
/// first pass notes the time at which each part begins. The second pass reads a part when its time has come, and gives
/// the messages of all open parts in order.
class McapFile final : public BagFile {
 public:
  explicit McapFile(mcap::Reader reader) : reader_(std::move(reader)) {}

  std::string name() const override { return reader_.name(); }
  const std::vector<Topic>& topics() const override { return topics_; }
  const char* unit() const override { return "byte"; }
  std::string warning() const override {
    return reader_.cut_off() ? "the file has no end: its recorder was killed. It is played up to there" : "";
  }

  Status scan(const std::function<void(const RecordedMessage&)>& see) override {
    bool in_chunk = false;
    std::size_t bytes = 0;
    while (true) {
      const auto found = reader_.next();
      if (!found) return found.error();
      if (!*found) break;
      const mcap::ReadMessage& message = **found;
      const bool same = !parts_.empty() && in_chunk == message.in_chunk &&
                        (in_chunk ? message.place == parts_.back().place : bytes < kTogether);
      if (!same) {
        parts_.push_back({message.place, 0, message.t});
        in_chunk = message.in_chunk;
        bytes = 0;
      }
      Part& part = parts_.back();
      ++part.messages;
      part.first = std::min(part.first, message.t);
      bytes += message.bytes.size();
      see({topic_of(*message.channel), message.t, message.bytes, 0, message.place});
    }
    std::ranges::stable_sort(parts_, {}, &Part::first);
    return {};
  }

  void begin(std::vector<bool> topics) override {
    wanted_ = std::move(topics);
    next_part_ = 0;
    open_.clear();
    held_ = 0;
  }

  Expected<std::optional<RecordedMessage>> next() override {
    for (auto part = open_.begin(); part != open_.end();) {
      if (part->given < part->messages.size()) {
        ++part;
        continue;
      }
      held_ -= part->bytes.size();
      part = open_.erase(part);
    }
    while (next_part_ < parts_.size() && (open_.empty() || parts_[next_part_].first <= earliest()->time())) {
      if (Status s = read(parts_[next_part_++]); !s) return s.error();
      if (open_.back().messages.empty()) open_.pop_back();
    }
    if (open_.empty()) return std::optional<RecordedMessage>();
    OpenPart& part = *earliest();
    const Held& held = part.messages[part.given++];
    return std::optional(
        RecordedMessage{held.topic, held.t, std::string_view(part.bytes).substr(held.begin, held.size), 0, part.place});
  }

 private:
  struct Part {
    std::uint64_t place = 0, messages = 0;
    SimTime first{};
  };
  struct Held {
    std::size_t topic = 0;
    SimTime t{};
    std::size_t begin = 0, size = 0;
  };
  struct OpenPart {
    std::uint64_t place = 0;
    std::string bytes;
    std::vector<Held> messages;
    std::size_t given = 0;
    SimTime time() const { return messages[given].t; }
  };

  std::size_t topic_of(const mcap::Channel& channel) {
    const auto [at, added] = places_.try_emplace(&channel, topics_.size());
    if (!added) return at->second;
    Topic topic{channel.topic, "", channel.message_encoding, ""};
    if (channel.schema) {
      topic.type = channel.schema->name;
      if (channel.schema->encoding == "ros2msg") topic.definition = channel.schema->text;
    }
    if (const auto qos = channel.metadata.find("offered_qos_profiles"); qos != channel.metadata.end())
      topic.latched = keeps_last(qos->second);
    topics_.push_back(std::move(topic));
    return at->second;
  }

  /// The open part whose next message is the earliest; among equal times, the one that comes first in the file.
  std::vector<OpenPart>::iterator earliest() {
    return std::ranges::min_element(open_, {}, [](const OpenPart& part) { return std::pair(part.time(), part.place); });
  }

  Status read(const Part& part) {
    OpenPart& to = open_.emplace_back();
    to.place = part.place;
    reader_.go_to(part.place);
    for (std::uint64_t i = 0; i < part.messages; ++i) {
      const auto found = reader_.next();
      if (!found) return found.error();
      if (!*found) return input_error("the file has changed since the run began", name());
      const mcap::ReadMessage& message = **found;
      const std::size_t topic = topic_of(*message.channel);
      if (!wanted_.empty() && !wanted_[topic]) continue;
      to.messages.push_back({topic, message.t, to.bytes.size(), message.bytes.size()});
      to.bytes += message.bytes;
    }
    std::ranges::stable_sort(to.messages, {}, &Held::t);
    held_ += to.bytes.size();
    if (held_ > kMostHeld && open_.size() > 1)
      return input_error("more than " + std::to_string(kMostHeld >> 20) +
                             " MiB of messages are not in order of time, expected a file as ros2 bag record writes it: "
                             "mcap sort puts them in order",
                         name());
    return {};
  }

  mcap::Reader reader_;
  std::vector<Topic> topics_;
  std::map<const mcap::Channel*, std::size_t> places_;
  std::vector<Part> parts_;
  std::vector<bool> wanted_;
  std::size_t next_part_ = 0, held_ = 0;
  std::vector<OpenPart> open_;
};

Expected<std::unique_ptr<BagFile>> as_file(Expected<mcap::Reader> reader) {
  if (!reader) return reader.error();
  return std::unique_ptr<BagFile>(std::make_unique<McapFile>(*std::move(reader)));
}

}  // namespace

Expected<std::unique_ptr<BagFile>> open_mcap(const std::filesystem::path& path) {
  return as_file(mcap::Reader::open(path));
}

Expected<std::unique_ptr<BagFile>> mcap_from_bytes(std::string bytes, const std::string& name) {
  return as_file(mcap::Reader::from_bytes(std::move(bytes), name));
}

}  // namespace cxlab::bag
