#include "cx/journal/input_log.h"

#include <xxhash.h>

#include <bit>
#include <cassert>
#include <cstring>
#include <limits>

#include "cx/journal/file_store.h"

namespace cxlab {
namespace {

constexpr std::string_view kMagic = "CXLABIN1";
constexpr std::size_t kChunkHeader = 12;  // length (4), checksum (8), little-endian
constexpr std::size_t kChunkBytes = 32 * 1024;
constexpr SimTime kFlushInterval = std::chrono::seconds(10);

enum EntryType : std::uint8_t { kTake = 1, kResult = 2, kWorld = 3, kReached = 4 };

/// Which optional fields of a delivery follow.
enum DeliveryField : std::uint8_t {
  kHasMessage = 1,
  kHasRequest = 2,
  kHasGoal = 4,
  kHasOutcome = 8,
  kHasStamp = 16,
  kHasGoalsCanceling = 32,
  kIsAccepted = 64
};

static_assert(std::endian::native == std::endian::little);

// Integers: 7 bits a byte, lowest first, the high bit says that more follow; signed ones with the sign in bit 0.
void put_unsigned(std::string& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<char>(value | 0x80));
  out.push_back(static_cast<char>(value));
}

void put_signed(std::string& out, std::int64_t value) {
  const auto sign = static_cast<std::uint64_t>(value >> 63);
  put_unsigned(out, (static_cast<std::uint64_t>(value) << 1) ^ sign);
}

void put_bytes(std::string& out, std::string_view bytes) {
  put_unsigned(out, bytes.size());
  out.append(bytes);
}

void put_goal(std::string& out, const std::array<std::uint8_t, 16>& goal) {
  out.append(reinterpret_cast<const char*>(goal.data()), goal.size());
}

/// Takes values from the front of a chunk; after the first that is not whole, `ok` is false and all are zero.
class EntryReader {
 public:
  EntryReader(std::string_view& rest, std::deque<std::string>& names) : rest_(rest), names_(names) {}

  bool ok() const { return ok_; }
  void refuse() { ok_ = false; }

  std::uint8_t byte() {
    const std::string_view one = take(1);
    return one.empty() ? 0 : static_cast<std::uint8_t>(one.front());
  }

  std::uint64_t unsigned_integer() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const std::uint8_t next = byte();
      value |= static_cast<std::uint64_t>(next & 0x7f) << shift;
      if (next < 0x80) return ok_ ? value : 0;
    }
    ok_ = false;
    return 0;
  }

  std::int64_t signed_integer() {
    const std::uint64_t value = unsigned_integer();
    return static_cast<std::int64_t>(value >> 1 ^ (0 - (value & 1)));
  }

  std::string_view bytes() { return take(unsigned_integer()); }

  std::string_view name() {
    const std::uint64_t number = unsigned_integer();
    if (number == 0 || !ok_) return {};
    if (number <= names_.size()) return names_[number - 1];
    if (number != names_.size() + 1) {
      ok_ = false;
      return {};
    }
    const std::string_view text = bytes();
    return ok_ ? std::string_view(names_.emplace_back(text)) : std::string_view{};
  }

  std::array<std::uint8_t, 16> goal() {
    std::array<std::uint8_t, 16> id{};
    const std::string_view text = take(id.size());
    if (ok_) std::memcpy(id.data(), text.data(), id.size());
    return id;
  }

 private:
  std::string_view take(std::uint64_t size) {
    if (!ok_ || size > rest_.size()) {
      ok_ = false;
      return {};
    }
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }

  std::string_view& rest_;
  std::deque<std::string>& names_;
  bool ok_ = true;
};

LoggedDelivery read_delivery(EntryReader& in) {
  LoggedDelivery d;
  d.kind = in.byte();
  const std::uint8_t fields = in.byte();
  d.from = in.name();
  d.sequence = in.unsigned_integer();
  const std::uint64_t endpoint = in.unsigned_integer();
  if (endpoint > std::numeric_limits<std::uint32_t>::max()) in.refuse();
  d.endpoint = static_cast<std::uint32_t>(endpoint);
  d.accepted = fields & kIsAccepted;
  if (fields & kHasMessage) {
    d.type = in.name();
    d.message = in.bytes();
  }
  if (fields & kHasRequest) d.request_id = in.unsigned_integer();
  if (fields & kHasGoal) d.goal = in.goal();
  if (fields & kHasOutcome) {
    d.status = static_cast<std::int8_t>(in.byte());
    d.return_code = static_cast<std::int8_t>(in.byte());
  }
  if (fields & kHasStamp) d.stamp = SimTime{in.signed_integer()};
  if (fields & kHasGoalsCanceling) {
    const std::uint64_t count = in.unsigned_integer();
    for (std::uint64_t i = 0; i < count && in.ok(); ++i) {
      const auto goal = in.goal();
      d.goals_canceling.emplace_back(goal, SimTime{in.signed_integer()});
    }
  }
  d.cause_stream = in.name();
  d.cause_n = in.unsigned_integer();
  return d;
}

}  // namespace

// --- Writer

Expected<InputLogWriter> InputLogWriter::create(const std::filesystem::path& path) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  if (Status s = file->append(kMagic); !s) return s.error();
  InputLogWriter log(std::move(*file));
  log.flush_due_ = kFlushInterval;
  if (Status s = log.flush(); !s) return s.error();
  return log;
}

void InputLogWriter::put_name(std::string_view name) {
  if (name.empty()) return put_unsigned(chunk_, 0);
  if (const auto known = names_.find(name); known != names_.end()) return put_unsigned(chunk_, known->second);
  const std::uint64_t number = names_.size() + 1;
  names_.emplace(name, number);
  put_unsigned(chunk_, number);
  put_bytes(chunk_, name);
}

void InputLogWriter::begin(std::uint8_t entry, SimTime t) {
  chunk_.push_back(static_cast<char>(entry));
  put_signed(chunk_, (t - last_t_).count());
  last_t_ = t;
}

void InputLogWriter::finish(SimTime t) {
  if (t >= flush_due_) {
    (void)flush();
    flush_due_ = t + kFlushInterval;
  } else if (chunk_.size() >= kChunkBytes) {
    end_chunk();
  }
}

void InputLogWriter::add(const LoggedTake& take) {
  if (!status()) return;
  begin(kTake, take.t);
  put_name(take.to);
  put_unsigned(chunk_, take.deliveries.size());
  for (const LoggedDelivery& d : take.deliveries) {
    std::uint8_t fields = 0;
    if (!d.type.empty()) fields |= kHasMessage;
    if (d.request_id != 0) fields |= kHasRequest;
    if (d.goal != std::array<std::uint8_t, 16>{}) fields |= kHasGoal;
    if (d.status != 0 || d.return_code != 0) fields |= kHasOutcome;
    if (d.stamp != SimTime{}) fields |= kHasStamp;
    if (!d.goals_canceling.empty()) fields |= kHasGoalsCanceling;
    if (d.accepted) fields |= kIsAccepted;
    chunk_.push_back(static_cast<char>(d.kind));
    chunk_.push_back(static_cast<char>(fields));
    put_name(d.from);
    put_unsigned(chunk_, d.sequence);
    put_unsigned(chunk_, d.endpoint);
    if (fields & kHasMessage) {
      put_name(d.type);
      put_bytes(chunk_, d.message);
    }
    if (fields & kHasRequest) put_unsigned(chunk_, d.request_id);
    if (fields & kHasGoal) put_goal(chunk_, d.goal);
    if (fields & kHasOutcome) {
      chunk_.push_back(static_cast<char>(d.status));
      chunk_.push_back(static_cast<char>(d.return_code));
    }
    if (fields & kHasStamp) put_signed(chunk_, d.stamp.count());
    if (fields & kHasGoalsCanceling) {
      put_unsigned(chunk_, d.goals_canceling.size());
      for (const auto& [goal, stamp] : d.goals_canceling) {
        put_goal(chunk_, goal);
        put_signed(chunk_, stamp.count());
      }
    }
    put_name(d.cause_stream);
    put_unsigned(chunk_, d.cause_n);
  }
  finish(take.t);
}

void InputLogWriter::add(const LoggedResult& result) {
  if (!status()) return;
  begin(kResult, result.t);
  put_name(result.environment);
  put_name(result.key);
  put_bytes(chunk_, result.bytes);
  finish(result.t);
}

void InputLogWriter::add(const LoggedWorld& world) {
  if (!status()) return;
  begin(kWorld, world.t);
  put_name(world.world);
  put_bytes(chunk_, world.bytes);
  finish(world.t);
}

void InputLogWriter::reach(SimTime t) {
  if (!status() || t < flush_due_) return;
  begin(kReached, t);
  finish(t);
}

void InputLogWriter::end_chunk() {
  if (chunk_.empty()) return;
  const auto length = static_cast<std::uint32_t>(chunk_.size());
  const std::uint64_t checksum = XXH3_64bits(chunk_.data(), chunk_.size());
  assert(chunk_.size() == length);
  framed_.resize(kChunkHeader);
  std::memcpy(framed_.data(), &length, sizeof length);
  std::memcpy(framed_.data() + sizeof length, &checksum, sizeof checksum);
  framed_ += chunk_;
  (void)file_.append(framed_);
  chunk_.clear();
}

Status InputLogWriter::flush() {
  end_chunk();
  return file_.flush();
}

Status InputLogWriter::close() {
  end_chunk();
  return file_.close();
}

// --- Reader

Expected<InputLogReader> InputLogReader::open(const std::filesystem::path& path) {
  auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return from_bytes(std::move(*bytes), path.string());
}

Expected<InputLogReader> InputLogReader::from_bytes(std::string bytes, std::string path) {
  if (!bytes.starts_with(kMagic))
    return input_error("expected an input log, which begins with " + std::string(kMagic), path);
  InputLogReader reader;
  reader.path_ = std::move(path);
  reader.bytes_ = std::make_shared<const std::string>(std::move(bytes));
  reader.names_ = std::make_shared<std::deque<std::string>>();
  reader.position_ = kMagic.size();
  return reader;
}

void InputLogReader::fail(const std::string& what) {
  status_ = input_error("broken at byte " + std::to_string(chunk_start_) + " of " + std::to_string(bytes_->size()) +
                            ": " + what + "; what comes before is whole",
                        path_);
  chunk_ = {};
  position_ = bytes_->size();
}

bool InputLogReader::open_chunk() {
  chunk_start_ = position_;
  const std::string_view rest = std::string_view(*bytes_).substr(position_);
  if (rest.empty()) return false;
  std::uint32_t length = 0;
  std::uint64_t checksum = 0;
  if (rest.size() >= kChunkHeader) {
    std::memcpy(&length, rest.data(), sizeof length);
    std::memcpy(&checksum, rest.data() + sizeof length, sizeof checksum);
  }
  if (rest.size() < kChunkHeader || rest.size() - kChunkHeader < length) {
    fail("the last chunk is cut off");
    return false;
  }
  chunk_ = rest.substr(kChunkHeader, length);
  if (XXH3_64bits(chunk_.data(), chunk_.size()) != checksum) {
    fail("the chunk does not have its checksum");
    return false;
  }
  position_ += kChunkHeader + length;
  return true;
}

std::optional<LoggedInput> InputLogReader::next() {
  while (true) {
    while (chunk_.empty()) {
      if (!status_ || !open_chunk()) return std::nullopt;
    }
    EntryReader in(chunk_, *names_);
    const std::uint8_t type = in.byte();
    // Sums of times wrap in unsigned numbers: those of a broken log may be anything.
    last_t_ = SimTime{static_cast<std::int64_t>(static_cast<std::uint64_t>(last_t_.count()) +
                                                static_cast<std::uint64_t>(in.signed_integer()))};
    std::optional<LoggedInput> entry;
    switch (type) {
      case kTake: {
        LoggedTake take{last_t_, in.name(), {}};
        const std::uint64_t count = in.unsigned_integer();
        for (std::uint64_t i = 0; i < count && in.ok(); ++i) take.deliveries.push_back(read_delivery(in));
        entry = std::move(take);
        break;
      }
      case kResult: {
        LoggedResult result{last_t_, in.name(), {}, {}};
        result.key = in.name();
        result.bytes = in.bytes();
        entry = result;
        break;
      }
      case kWorld: {
        LoggedWorld world{last_t_, in.name(), {}};
        world.bytes = in.bytes();
        entry = world;
        break;
      }
      case kReached: break;
      default: in.refuse();
    }
    if (!in.ok()) {
      fail("an entry that no writer makes");
      return std::nullopt;
    }
    reached_ = last_t_;
    if (entry) return entry;
  }
}

}  // namespace cxlab
