#pragma once
// Sinks for records: one keeps them, one counts them.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/record_sink.h"

namespace cxlab {

/// Keeps all records in the order of writing.
class KeptRecords final : public RecordSink {
 public:
  struct Record {
    StreamId stream{};
    SimTime t{};
    RecordKind kind{};
    std::string data;  ///< MessagePack
    std::vector<RecordRef> causes;
  };

  StreamId open_stream(std::string_view name) override {
    for (std::size_t i = 0; i < names_.size(); ++i)
      if (names_[i] == name) return static_cast<StreamId>(i);
    names_.emplace_back(name);
    counts_.push_back(0);
    return static_cast<StreamId>(names_.size() - 1);
  }
  RecordRef write(StreamId stream, SimTime t, RecordKind kind, const RecordData& data,
                  std::span<const RecordRef> causes) override {
    records_.push_back({stream, t, kind, std::string(data.bytes()), {causes.begin(), causes.end()}});
    return {stream, counts_[index(stream)]++};
  }
  /// Drops the records kept so far; their numbers go on.
  void forget() { std::vector<Record>().swap(records_); }

  const std::vector<std::string>& names() const { return names_; }  ///< of the streams, by id
  const std::vector<Record>& all() const { return records_; }
  std::vector<Record> of(StreamId stream) const {
    return select([&](const Record& r) { return r.stream == stream; });
  }
  std::vector<Record> of(RecordKind kind) const {
    return select([&](const Record& r) { return r.kind == kind; });
  }

  // For comparison: a line for each record, with time, kind, data and causes.
  std::string text() const {
    std::string lines;
    for (const Record& r : records_) lines += names_[index(r.stream)] + ' ' + line(r);
    return lines;
  }
  std::string text(StreamId stream) const {
    std::string lines;
    for (const Record& r : of(stream)) lines += line(r);
    return lines;
  }
  std::map<std::string, std::string> text_by_stream() const {
    std::map<std::string, std::string> texts;
    for (std::size_t i = 0; i < names_.size(); ++i) texts[names_[i]] = text(static_cast<StreamId>(i));
    return texts;
  }

 private:
  static std::size_t index(StreamId stream) { return static_cast<std::size_t>(stream); }
  template <class Condition>
  std::vector<Record> select(Condition condition) const {
    std::vector<Record> found;
    for (const Record& r : records_)
      if (condition(r)) found.push_back(r);
    return found;
  }
  std::string line(const Record& r) const {
    std::string text = std::to_string(r.t.count()) + ' ' + std::string(to_string(r.kind)) + ' ' + r.data;
    for (const RecordRef& cause : r.causes) text += ' ' + names_[index(cause.stream)] + ':' + std::to_string(cause.n);
    return text + '\n';
  }

  std::vector<std::string> names_;
  std::vector<std::uint64_t> counts_;
  std::vector<Record> records_;
};

/// Counts records and hashes their data, for runs that are too long to be kept.
class CountedRecords final : public RecordSink {
 public:
  StreamId open_stream(std::string_view) override { return StreamId{streams_++}; }
  RecordRef write(StreamId stream, SimTime, RecordKind, const RecordData& data, std::span<const RecordRef>) override {
    for (const char c : data.bytes()) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return {stream, count++};
  }
  std::uint64_t count = 0;
  std::uint64_t hash = 0xcbf29ce484222325ULL;

 private:
  std::uint16_t streams_ = 0;
};

}  // namespace cxlab
