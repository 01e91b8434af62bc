#pragma once
// The journal: numbers and hashes what happened, stream by stream, and exports it as lines of JSON
// (docs/reference/journal.md).

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/append_file.h"
#include "cx/base/expected.h"
#include "cx/base/record_sink.h"
#include "cx/journal/record_bytes.h"

namespace cxlab {

/// The records that are exported: none; input, skill, referee, decision, control and error; or all. The hash always
/// covers all.
enum class JournalLevel : std::uint8_t { kNone, kDecisions, kFull };
inline constexpr std::string_view kJournalLevels[] = {"none", "decisions", "full"};

class JournalListener;

/// The records of one episode. A stream's hash covers number, time, kind, causes (name of the stream and number) and
/// data of each of its records. It does not depend on other streams or on the order in which streams are opened.
class Journal final : public RecordSink {
 public:
  Journal();
  ~Journal() override;
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// From now on writes the records of that level to `path` as lines of JSON. Lines reach the file when 64 KiB have
  /// come together, at least every 10 s of simulated time, and with `flush`.
  Status export_to(const std::filesystem::path& path, JournalLevel level);

  /// From now on this listener hears of records, after the earlier listeners. It outlives the journal, or `ignore`
  /// takes it out before.
  void observe(JournalListener& listener) { listeners_.push_back(&listener); }
  void ignore(JournalListener& listener) { std::erase(listeners_, &listener); }

  /// From now on, texts of records have this name, for example "package://agent", in place of the folder.
  void name_folder(const std::string& folder, const std::string& name) { folders_.add(folder, name); }

  StreamId open_stream(std::string_view name) override;
  RecordRef write(StreamId stream, SimTime t, RecordKind kind, const RecordData& data,
                  std::span<const RecordRef> causes = {}) override;

  /// Whether the export went well so far (kResource if not); ask once a tick.
  const Status& status() const { return file_.status(); }
  Status flush() { return file_.flush(); }
  /// Ends the export; numbering and hashes go on.
  Status close() { return file_.close(); }

  const std::string& stream_name(StreamId stream) const;

  struct StreamSummary {
    std::string name;
    std::uint64_t records = 0;
    std::string hash;  ///< 32 hex digits
  };
  /// Streams that have records, in order of names.
  std::vector<StreamSummary> streams() const;
  /// The hash of that stream, or empty if it has no record.
  std::string stream_hash(std::string_view name) const;
  /// Over names and hashes of the streams that have records, in order of names: 32 hex digits.
  std::string journal_hash() const;

 private:
  struct Stream;
  void notify_listeners(const Stream& stream, SimTime t, RecordKind kind, std::string_view data,
                        std::span<const RecordRef> causes);
  void export_line(const Stream& stream, SimTime t, RecordKind kind, std::string_view data,
                   std::span<const RecordRef> causes);

  std::vector<std::unique_ptr<Stream>> streams_;  // by id
  std::map<std::string, StreamId, std::less<>> ids_;
  FolderNames folders_;
  std::string renamed_;  // data of a record with names of folders
  JournalLevel level_ = JournalLevel::kNone;
  std::vector<JournalListener*> listeners_;
  AppendFile file_;
  SimTime flush_due_{};
  std::string line_;
};

}  // namespace cxlab
