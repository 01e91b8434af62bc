#include "cx/journal/input_log.h"

#include <algorithm>
#include <limits>

#include "cx/base/byte_codec.h"
#include "cx/base/charge.h"
#include "cx/base/file.h"
#include "cx/journal/chunk.h"

namespace cxlab {
namespace {

constexpr std::string_view kMagic = "CXLABIN2";
constexpr std::size_t kChunkBytes = 32 * 1024, kMostWaiting = 512;  // chunks
constexpr SimTime kInputFlushInterval = std::chrono::seconds(10);

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

std::string_view bytes_of(const bus::GoalId& goal) { return {reinterpret_cast<const char*>(goal.data()), goal.size()}; }

/// Reads entries of a chunk; knows the names that were spelt before.
class EntryReader : public ByteReader {
 public:
  EntryReader(std::string_view bytes, std::deque<std::string>& names) : ByteReader(bytes), names_(names) {}

  std::string_view name() {
    const std::uint64_t number = varint();
    if (number == 0 || !ok()) return {};
    if (number <= names_.size()) return names_[number - 1];
    if (number != names_.size() + 1) {
      refuse();
      return {};
    }
    const std::string_view spelt = text();
    return ok() ? std::string_view(names_.emplace_back(spelt)) : std::string_view{};
  }

  bus::GoalId goal() {
    bus::GoalId id{};
    std::ranges::copy(raw(id.size()), reinterpret_cast<char*>(id.data()));
    return id;
  }

 private:
  std::deque<std::string>& names_;
};

LoggedDelivery read_delivery(EntryReader& in) {
  LoggedDelivery logged;
  bus::Delivery& d = logged.delivery;
  d.kind = in.fixed<bus::DeliveryKind>();
  const std::uint8_t fields = in.fixed<std::uint8_t>();
  logged.from = in.name();
  d.sequence = in.varint();
  const std::uint64_t endpoint = in.varint();
  if (endpoint > std::numeric_limits<std::uint32_t>::max()) in.refuse();
  logged.endpoint = static_cast<std::uint32_t>(endpoint);
  d.accepted = fields & kIsAccepted;
  if (fields & kHasMessage) {
    logged.type = in.name();
    logged.message = in.text();
  }
  if (fields & kHasRequest) d.request_id = in.varint();
  if (fields & kHasGoal) d.goal = in.goal();
  if (fields & kHasOutcome) {
    d.status = in.fixed<bus::GoalStatus>();
    d.return_code = in.fixed<std::int8_t>();
  }
  if (fields & kHasStamp) d.stamp = SimTime{in.zigzag()};
  if (fields & kHasGoalsCanceling) {
    const std::uint64_t count = in.varint();
    for (std::uint64_t i = 0; i < count && in.ok(); ++i) {
      const auto goal = in.goal();
      d.goals_canceling.emplace_back(goal, SimTime{in.zigzag()});
    }
  }
  logged.cause_stream = in.name();
  d.cause.n = in.varint();
  return logged;
}

}  // namespace

// --- Writer

Expected<InputLogWriter> InputLogWriter::create(const std::filesystem::path& path) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  if (Status s = file->append(kMagic); !s) return s.error();
  InputLogWriter log(std::move(*file));
  if (Status s = log.flush(); !s) return s.error();
  return log;
}

void InputLogWriter::put_name(std::string_view name) {
  ByteWriter out(chunk_);
  if (name.empty()) {
    out.varint(0);
  } else if (const auto known = names_.find(name); known != names_.end()) {
    out.varint(known->second);
  } else {
    const std::uint64_t number = names_.size() + 1;
    names_.emplace(name, number);
    out.varint(number).text(name);
  }
}

void InputLogWriter::begin(std::uint8_t entry, SimTime t) {
  begun_at_ = chunk_.size();
  ByteWriter(chunk_).fixed(entry).zigzag((t - last_t_).count());
  last_t_ = t;
}

void InputLogWriter::finish() {
  if (Charge::is_on()) Charge::written(chunk_.size() - begun_at_);
  if (chunk_.size() >= kChunkBytes) end_chunk();
  if (framed_.size() == kMostWaiting) (void)flush();
}

void InputLogWriter::add(const LoggedTake& take) {
  if (!status()) return;
  begin(kTake, take.t);
  put_name(take.to);
  ByteWriter out(chunk_);
  out.varint(take.deliveries.size());
  for (const LoggedDelivery& logged : take.deliveries) {
    const bus::Delivery& d = logged.delivery;
    std::uint8_t fields = 0;
    if (!logged.type.empty()) fields |= kHasMessage;
    if (d.request_id != 0) fields |= kHasRequest;
    if (d.goal != bus::GoalId{}) fields |= kHasGoal;
    if (d.status != bus::GoalStatus{} || d.return_code != 0) fields |= kHasOutcome;
    if (d.stamp != SimTime{}) fields |= kHasStamp;
    if (!d.goals_canceling.empty()) fields |= kHasGoalsCanceling;
    if (d.accepted) fields |= kIsAccepted;
    out.fixed(d.kind).fixed(fields);
    put_name(logged.from);
    out.varint(d.sequence).varint(logged.endpoint);
    if (fields & kHasMessage) {
      put_name(logged.type);
      out.text(logged.message);
    }
    if (fields & kHasRequest) out.varint(d.request_id);
    if (fields & kHasGoal) out.raw(bytes_of(d.goal));
    if (fields & kHasOutcome) out.fixed(d.status).fixed(d.return_code);
    if (fields & kHasStamp) out.zigzag(d.stamp.count());
    if (fields & kHasGoalsCanceling) {
      out.varint(d.goals_canceling.size());
      for (const auto& [goal, stamp] : d.goals_canceling) out.raw(bytes_of(goal)).zigzag(stamp.count());
    }
    put_name(logged.cause_stream);
    out.varint(d.cause.n);
  }
  finish();
}

void InputLogWriter::add(const LoggedResult& result) {
  if (!status()) return;
  begin(kResult, result.t);
  put_name(result.environment);
  put_name(result.key);
  ByteWriter(chunk_).text(result.bytes);
  finish();
}

void InputLogWriter::add(const LoggedWorld& world) {
  if (!status()) return;
  begin(kWorld, world.t);
  put_name(world.world);
  ByteWriter(chunk_).text(world.bytes);
  finish();
}

void InputLogWriter::reach(SimTime t) {
  if (!status() || !writes_at(t)) return;
  begin(kReached, t);
  (void)flush();
  flush_due_ = t + std::clamp(t, SimTime{1}, kInputFlushInterval);
}

void InputLogWriter::end_chunk() {
  if (chunk_.empty()) return;
  framed_.push_back(framed_chunk(chunk_));
  chunk_.clear();
}

Status InputLogWriter::flush() {
  end_chunk();
  const Charge counted(false);  // by finish
  for (const std::string& chunk : framed_) (void)file_.append(chunk);
  framed_.clear();
  return file_.flush();
}

Status InputLogWriter::close(SimTime end) {
  if (status()) begin(kReached, end);
  (void)flush();
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
  ByteReader in(rest);
  const auto chunk = read_chunk(in);
  if (!chunk) {
    fail(chunk.error().message);
    return false;
  }
  chunk_ = *chunk;
  position_ += in.position();
  return true;
}

std::optional<LoggedInput> InputLogReader::next() {
  while (true) {
    while (chunk_.empty()) {
      if (!status_ || !open_chunk()) return std::nullopt;
    }
    EntryReader in(chunk_, *names_);
    const std::uint8_t type = in.fixed<std::uint8_t>();
    // Sums of times wrap in unsigned numbers: those of a broken log may be anything.
    last_t_ = SimTime{static_cast<std::int64_t>(static_cast<std::uint64_t>(last_t_.count()) +
                                                static_cast<std::uint64_t>(in.zigzag()))};
    std::optional<LoggedInput> entry;
    switch (type) {
      case kTake: {
        LoggedTake take{last_t_, in.name(), {}};
        const std::uint64_t count = in.varint();
        for (std::uint64_t i = 0; i < count && in.ok(); ++i) take.deliveries.push_back(read_delivery(in));
        entry = std::move(take);
        break;
      }
      case kResult: {
        LoggedResult result{last_t_, in.name(), {}, {}};
        result.key = in.name();
        result.bytes = in.text();
        entry = result;
        break;
      }
      case kWorld: {
        LoggedWorld world{last_t_, in.name(), {}};
        world.bytes = in.text();
        entry = world;
        break;
      }
      case kReached: break;
      default: in.refuse();
    }
    chunk_.remove_prefix(in.position());
    if (!in.ok()) {
      fail("an entry that no writer makes");
      return std::nullopt;
    }
    // The tick of an entry may have had more, and so may the start, whose time is that of the first tick.
    if (type == kReached || last_t_ > SimTime::zero())
      reached_ = std::max(reached_, type == kReached ? last_t_ : last_t_ - SimTime{1});
    if (entry) return entry;
  }
}

}  // namespace cxlab
