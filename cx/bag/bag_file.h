#pragma once
// A file of a bag: first all its messages in the order of the file, then those that are wanted in order of time.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cx/bag/recording.h"

namespace cxlab::bag {

class BagFile {
 public:
  virtual ~BagFile() = default;
  virtual std::string name() const = 0;
  /// The topics of this file, known once `scan` is over.
  virtual const std::vector<Topic>& topics() const = 0;
  /// Calls `see` with each message, whose `topic` is a place in `topics`. Checks all that can be checked.
  virtual Status scan(const std::function<void(const RecordedMessage&)>& see) = 0;
  /// What a person should know; empty: nothing.
  virtual std::string warning() const { return {}; }
  /// What a place is: "byte", "row".
  virtual const char* unit() const = 0;
  /// From the first message on, those of these topics.
  virtual void begin(std::vector<bool> topics) = 0;
  virtual Expected<std::optional<RecordedMessage>> next() = 0;
};

Expected<std::unique_ptr<BagFile>> open_mcap(const std::filesystem::path& path);
Expected<std::unique_ptr<BagFile>> mcap_from_bytes(std::string bytes, const std::string& name);
Expected<std::unique_ptr<BagFile>> open_sqlite(const std::filesystem::path& path);
/// One of both, by its extension.
Expected<std::unique_ptr<BagFile>> open_plain(const std::filesystem::path& path);
/// A file whose name ends with .zstd, unpacked into the system's temporary folder as long as it is open.
Expected<std::unique_ptr<BagFile>> open_packed(const std::filesystem::path& path);
/// The same file, of which each message is a zstd frame.
std::unique_ptr<BagFile> of_packed_messages(std::unique_ptr<BagFile> file);

struct FilesOfBag {
  std::vector<std::filesystem::path> paths = {};  ///< in their order
  bool packed_messages = false;
};
Expected<FilesOfBag> files_of_bag(const std::filesystem::path& path);

/// Whether QoS profiles, as bags write them, say that the last message is kept for those who come later.
bool keeps_last(const std::string& qos_profiles);

}  // namespace cxlab::bag
