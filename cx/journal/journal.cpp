#include "cx/journal/journal.h"

#include <xxhash.h>
#if defined(__x86_64__) && __has_include(<xxh_x86dispatch.h>)
#include <xxh_x86dispatch.h>  // the same hashes with the widest instructions that the machine has
#endif

#include <array>
#include <cassert>
#include <charconv>
#include <cstring>
#include <limits>

#include "cx/base/byte_codec.h"
#include "cx/base/charge.h"
#include "cx/journal/hash_text.h"
#include "cx/journal/journal_record.h"

namespace cxlab {
namespace {

constexpr SimTime kFlushInterval = std::chrono::seconds(10);

void append_integer(std::string& out, std::int64_t value) {
  char digits[24];
  out.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

std::string hash_text(XXH128_hash_t hash) { return cxlab::hash_text(hash.high64) + cxlab::hash_text(hash.low64); }

bool is_exported(RecordKind kind, JournalLevel level) {
  const bool detail = kind == RecordKind::kAssert || kind == RecordKind::kRetract || kind == RecordKind::kModify ||
                      kind == RecordKind::kFire || kind == RecordKind::kBus;
  return level == JournalLevel::kFull || (level == JournalLevel::kDecisions && !detail);
}

struct FreeState {
  void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

}  // namespace

struct Journal::Stream {
  explicit Stream(std::string_view stream_name)
      : name(stream_name),
        name_hash(XXH3_64bits(name.data(), name.size())),
        state(XXH3_createState()),
        unhashed(kHashedAtOnce, 0) {
    XXH3_128bits_reset(state.get());
    append_json_string(name, json_name);
  }

  /// Where the next bytes to be hashed go: room for that many. `took` is called with their end.
  char* room(std::size_t bytes) {
    if (unhashed.size() - size < bytes) {
      hash_waiting();
      if (unhashed.size() < bytes) unhashed.resize(bytes);
    }
    return unhashed.data() + size;
  }
  void took(const char* end) { size = static_cast<std::size_t>(end - unhashed.data()); }
  void hash_waiting() {
    XXH3_128bits_update(state.get(), unhashed.data(), size);
    size = 0;
  }
  /// The hash of all records so far.
  std::string hash() {
    hash_waiting();
    return hash_text(XXH3_128bits_digest(state.get()));
  }

  std::string name;
  std::string json_name;  // in quotes
  std::uint64_t name_hash;
  std::uint64_t records = 0;

 private:
  static constexpr std::size_t kHashedAtOnce = 2048;
  std::unique_ptr<XXH3_state_t, FreeState> state;
  std::string unhashed;  // the first `size` bytes wait
  std::size_t size = 0;
};

Journal::Journal() = default;
Journal::~Journal() = default;

Status Journal::export_to(const std::filesystem::path& path, JournalLevel level) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  file_ = std::move(*file);
  level_ = level;
  flush_due_ = kFlushInterval;
  return {};
}

StreamId Journal::open_stream(std::string_view name) {
  if (const auto found = ids_.find(name); found != ids_.end()) return found->second;
  assert(streams_.size() <= std::numeric_limits<std::uint16_t>::max());
  const auto id = static_cast<StreamId>(streams_.size());
  streams_.push_back(std::make_unique<Stream>(name));
  ids_.emplace(name, id);
  return id;
}

RecordRef Journal::write(StreamId id, SimTime t, RecordKind kind, const RecordData& data,
                         std::span<const RecordRef> causes) {
  assert(static_cast<std::size_t>(id) < streams_.size());
  Stream& stream = *streams_[static_cast<std::size_t>(id)];

  std::string_view bytes = data.bytes();
  if (!folders_.empty() && folders_.rewrite(bytes, renamed_)) bytes = renamed_;
  char* out = stream.room(29 + 16 * causes.size() + bytes.size());
  const auto put = [&out](auto value) {
    std::memcpy(out, &value, sizeof value);
    out += sizeof value;
  };
  put(stream.records);
  put(static_cast<std::int64_t>(t.count()));
  put(static_cast<std::uint8_t>(kind));
  put(static_cast<std::uint32_t>(causes.size()));
  for (const RecordRef& cause : causes) {
    assert(static_cast<std::size_t>(cause.stream) < streams_.size());
    put(streams_[static_cast<std::size_t>(cause.stream)]->name_hash);
    put(cause.n);
  }
  put(static_cast<std::uint32_t>(bytes.size()));
  std::memcpy(out, bytes.data(), bytes.size());
  stream.took(out + bytes.size());

  if (file_.is_open() && is_exported(kind, level_)) export_line(stream, t, kind, bytes, causes);
  if (!listeners_.empty()) notify_listeners(stream, t, kind, bytes, causes);
  return {id, stream.records++};
}

void Journal::notify_listeners(const Stream& stream, SimTime t, RecordKind kind, std::string_view data,
                               std::span<const RecordRef> causes) {
  const Charge charge(false);
  const WrittenRecord record{*this, stream.name, stream.records, t, kind, data, causes};
  for (JournalListener* listener : listeners_)
    if (listener->wants(stream.name, kind)) listener->written(record);
}

JournalRecord WrittenRecord::read() const {
  JournalRecord record{std::string(stream), n, t, kind, {}, {}};
  auto value = decode_record_data(data);
  assert(value.ok() && "RecordData: a list or map without as many values as it announced");
  record.data = *std::move(value);
  for (const RecordRef& cause : causes) record.causes.push_back({journal.stream_name(cause.stream), cause.n});
  return record;
}

void Journal::export_line(const Stream& stream, SimTime t, RecordKind kind, std::string_view data,
                          std::span<const RecordRef> causes) {
  line_.assign("{\"stream\":");
  line_ += stream.json_name;
  line_ += ",\"n\":";
  append_integer(line_, static_cast<std::int64_t>(stream.records));
  line_ += ",\"t\":";
  append_integer(line_, t.count());
  line_ += ",\"kind\":\"";
  line_ += to_string(kind);
  line_ += "\",\"data\":";
  const Status well_formed = append_json(data, line_);
  assert(well_formed.ok() && "RecordData: a list or map without as many values as it announced");
  line_ += ",\"cause\":[";
  for (std::size_t i = 0; i < causes.size(); ++i) {
    if (i > 0) line_ += ',';
    line_ += streams_[static_cast<std::size_t>(causes[i].stream)]->json_name;
    line_.back() = ':';
    append_integer(line_, static_cast<std::int64_t>(causes[i].n));
    line_ += '"';
  }
  line_ += "]}\n";
  (void)file_.append(line_);
  if (t >= flush_due_) {
    (void)file_.flush();
    flush_due_ = t + kFlushInterval;
  }
}

const std::string& Journal::stream_name(StreamId stream) const {
  assert(static_cast<std::size_t>(stream) < streams_.size());
  return streams_[static_cast<std::size_t>(stream)]->name;
}

std::vector<Journal::StreamSummary> Journal::streams() const {
  std::vector<StreamSummary> summaries;
  for (const auto& [name, id] : ids_) {
    Stream& stream = *streams_[static_cast<std::size_t>(id)];
    if (stream.records > 0) summaries.push_back({name, stream.records, stream.hash()});
  }
  return summaries;
}

std::string Journal::stream_hash(std::string_view name) const {
  const auto found = ids_.find(name);
  if (found == ids_.end()) return {};
  Stream& stream = *streams_[static_cast<std::size_t>(found->second)];
  return stream.records == 0 ? std::string{} : stream.hash();
}

std::string Journal::journal_hash() const {
  std::string all;
  for (const StreamSummary& stream : streams()) {
    ByteWriter(all).fixed(static_cast<std::uint32_t>(stream.name.size())).raw(stream.name).raw(stream.hash);
  }
  return hash_text(XXH3_128bits(all.data(), all.size()));
}

}  // namespace cxlab
