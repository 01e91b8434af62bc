#pragma once
// A bag of ROS 2, read as one stream of messages in order of time. It is an MCAP file, an SQLite file, or a folder with
// metadata.yaml and several such files. `open` reads all of it once, so damage is found before a run begins. The memory
// in use does not grow with the bag's length.
//
//   auto recording = Recording::open("floor");
//   recording->begin({});
//   while (true) {
//     auto message = recording->next();
//     if (!message || !*message) break;
//     use(recording->topics()[(*message)->topic], (*message)->t, (*message)->bytes);
//   }

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/time.h"

namespace cxlab::bag {

/// All messages of one name and type.
struct Topic {
  std::string name, type;
  std::string encoding;    ///< of the messages: "cdr"
  std::string definition;  ///< of the type, in the encoding ros2msg; empty: the bag has none
  bool latched = false;    ///< its publisher kept the last message for those who come later (transient_local)
  std::uint64_t messages = 0;
  /// Bit k is set if the topic has service events of type k with what was sent.
  std::uint8_t events = 0;
};

/// How the name of a topic of service events ends.
inline constexpr std::string_view kServiceEvents = "/_service_event";

/// What it points to is there until the next call of `Recording::next`.
struct RecordedMessage {
  std::size_t topic = 0;  ///< its place in `Recording::topics`
  SimTime t{};            ///< when it was recorded, since 1970
  std::string_view bytes;
  std::size_t file = 0;
  std::uint64_t place = 0;  ///< in that file: a byte, or the number of a row
};

/// One file of a bag.
class BagFile;

class Recording {
 public:
  /// kInput, with file and place, if something in it is damaged. A file without its end is read up to there.
  static Expected<Recording> open(const std::filesystem::path& path);
  /// The same from the content of an MCAP file.
  static Expected<Recording> from_bytes(std::string bytes, const std::string& name);
  Recording(Recording&&) noexcept;
  Recording& operator=(Recording&&) noexcept;
  ~Recording();

  const std::string& name() const { return name_; }
  const std::vector<Topic>& topics() const { return topics_; }
  std::uint64_t messages() const { return messages_; }
  SimTime first() const { return first_; }  ///< since 1970, as `last`
  SimTime last() const { return last_; }
  /// What a person should know of it: where it ends early.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// `next` begins at the first message again, and gives those of these topics only; without any: of all.
  void begin(std::vector<bool> topics);
  /// The next message in order of time, those of one time in the order of the files; none at the end.
  Expected<std::optional<RecordedMessage>> next();
  /// "floor_0.mcap: the message of /chatter at 12.3 s (byte 4711)"; the error with this place.
  Error at(const RecordedMessage& message, const Error& error) const;

 private:
  struct Opened;
  Recording();
  Status add(std::unique_ptr<BagFile> file);

  std::string name_;
  std::vector<Topic> topics_;
  std::vector<Opened> files_;
  std::vector<std::string> warnings_;
  std::uint64_t messages_ = 0;
  SimTime first_ = kNever, last_{};
  std::size_t given_ = 0;  ///< the file whose message `next` gave last
};

/// 32 hex digits over the bytes of all files of a bag (XXH3, 128 bit).
Expected<std::string> digest_of(const std::filesystem::path& path);

}  // namespace cxlab::bag
