#include "lab/journal_difference.h"

#include <algorithm>
#include <deque>
#include <map>
#include <tuple>

#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/journal/input_log.h"
#include "cx/journal/journal_reader.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

constexpr const char* kNothing = "nothing like it";

/// The journal of a run; one that recorded none has no lines.
Expected<std::optional<JournalReader>> journal_of(const fs::path& run) {
  const fs::path file = run / "journal.jsonl";
  if (!path_exists(file)) return std::optional<JournalReader>();
  auto reader = JournalReader::open(file);
  if (!reader) return reader.error();
  return std::optional(*std::move(reader));
}

bool says_the_same(const JournalRecord& a, const JournalRecord& b) {
  return a.t == b.t && a.kind == b.kind && a.data == b.data;
}

Difference difference(const JournalRecord* then, const JournalRecord* now) {
  const bool first = then && (!now || then->t <= now->t);
  const JournalRecord& one = first ? *then : *now;
  const auto text = [&](const JournalRecord* record) {
    if (!record) return std::string(kNothing);
    return lab::shown(*record) + (record->t == one.t ? "" : " at " + fixed_text(to_seconds(record->t), 3) + " s");
  };
  return {one.stream, one.t, text(then), text(now)};
}

Expected<std::optional<Difference>> records_before(SimTime t, const fs::path& then, const fs::path& now, bool whole) {
  auto journal_then = journal_of(then), journal_now = journal_of(now);
  if (!journal_then) return journal_then.error();
  if (!journal_now) return journal_now.error();
  std::optional<JournalReader>&reader_then = *journal_then, &reader_now = *journal_now;
  while (true) {
    const bool has_then = reader_then && reader_then->next_line(), has_now = reader_now && reader_now->next_line();
    if (has_then && has_now && reader_then->line() == reader_now->line()) continue;
    if (!has_then && (!has_now || !whole)) return std::optional<Difference>();
    std::optional<JournalRecord> a, b;
    for (const auto& [has, reader, record] :
         {std::tuple(has_then, &reader_then, &a), std::tuple(has_now, &reader_now, &b)}) {
      if (!has) continue;
      auto read = (*reader)->record();
      if (!read) return read.error();
      *record = *std::move(read);
    }
    const Difference found = difference(a ? &*a : nullptr, b ? &*b : nullptr);
    return found.t < t ? std::optional(found) : std::nullopt;
  }
}

bool same(const LoggedDelivery& a, const LoggedDelivery& b) {
  const auto key = [](const LoggedDelivery& d) {
    const bus::Delivery& x = d.delivery;
    return std::tie(d.from, d.endpoint, d.type, d.message, d.cause_stream, x.kind, x.sequence, x.request_id, x.goal,
                    x.accepted, x.status, x.return_code, x.stamp, x.goals_canceling);
  };
  return key(a) == key(b);
}

struct Same {
  bool operator()(const LoggedTake& a, const LoggedTake& b) const {
    return a.t == b.t && a.to == b.to &&
           std::ranges::equal(a.deliveries, b.deliveries, [](const auto& x, const auto& y) { return same(x, y); });
  }
  bool operator()(const LoggedResult& a, const LoggedResult& b) const {
    return std::tie(a.t, a.environment, a.key, a.bytes) == std::tie(b.t, b.environment, b.key, b.bytes);
  }
  bool operator()(const LoggedWorld& a, const LoggedWorld& b) const {
    return std::tie(a.t, a.world, a.bytes) == std::tie(b.t, b.world, b.bytes);
  }
  template <class A, class B>
  bool operator()(const A&, const B&) const {
    return false;
  }
};

std::string stream_of(const LoggedInput& input) {
  if (const auto* take = std::get_if<LoggedTake>(&input)) return std::string(take->to);
  if (const auto* result = std::get_if<LoggedResult>(&input)) return std::string(result->environment);
  return std::string(std::get<LoggedWorld>(input).world);
}

std::string shown(const LoggedInput& input) {
  if (const auto* take = std::get_if<LoggedTake>(&input)) {
    std::string text;
    for (const LoggedDelivery& delivery : take->deliveries)
      text += (text.empty() ? "" : ", ") + std::string(delivery.type.empty() ? "an answer" : delivery.type) + " from " +
              std::string(delivery.from);
    return "it takes " + text;
  }
  if (const auto* result = std::get_if<LoggedResult>(&input)) return "a result of " + std::string(result->key);
  return "a write to the world";
}

Expected<std::optional<Difference>> inputs_before(SimTime t, const fs::path& then, const fs::path& now, bool whole) {
  auto log_then = InputLogReader::open(then / "inputs.bin"), log_now = InputLogReader::open(now / "inputs.bin");
  if (!log_then) return log_then.error();
  if (!log_now) return log_now.error();
  const auto time_of = [](const LoggedInput& input) { return std::visit([](const auto& i) { return i.t; }, input); };
  while (true) {
    const auto a = log_then->next(), b = log_now->next();
    if (a && b && std::visit(Same(), *a, *b)) {
      if (time_of(*a) >= t) return std::optional<Difference>();
      continue;
    }
    if (!a && (!b || !whole)) return std::optional<Difference>();
    const bool first = a && (!b || time_of(*a) <= time_of(*b));
    const LoggedInput& one = first ? *a : *b;
    if (time_of(one) >= t) return std::optional<Difference>();
    return std::optional(Difference{stream_of(one), time_of(one), a ? shown(*a) : kNothing, b ? shown(*b) : kNothing});
  }
}

}  // namespace

std::string Difference::text() const {
  return stream + " at " + fixed_text(to_seconds(t), 3) + " s: then " + then + ", now " + now;
}

std::string shown(const JournalRecord& record) {
  return std::string(to_string(record.kind)) + ' ' + to_json(record.data);
}

Expected<std::optional<Difference>> difference_before(SimTime t, const fs::path& then, const fs::path& now,
                                                      bool then_whole) {
  auto found = records_before(t, then, now, then_whole);
  return !found || *found ? found : inputs_before(t, then, now, then_whole);
}

Expected<std::vector<Difference>> first_differences(const fs::path& then, const fs::path& now, SimTime end) {
  struct Stream {
    std::deque<JournalRecord> then, now;  // that have no partner yet; one of them is empty
    bool parted = false;
  };
  std::map<std::string, Stream> streams;
  std::vector<Difference> out;
  auto journal_then = journal_of(then), journal_now = journal_of(now);
  if (!journal_then) return journal_then.error();
  if (!journal_now) return journal_now.error();
  std::optional<JournalReader>&reader_then = *journal_then, &reader_now = *journal_now;
  const auto add = [&](const JournalReader& reader, std::deque<JournalRecord> Stream::* side,
                       std::deque<JournalRecord> Stream::* other) -> Status {
    auto record = reader.record();
    if (!record) return record.error();
    Stream& stream = streams[record->stream];
    if (stream.parted || record->t > end || is_planned(*record)) return {};
    if ((stream.*other).empty()) {
      (stream.*side).push_back(*std::move(record));
      return {};
    }
    const JournalRecord partner = std::move((stream.*other).front());
    (stream.*other).pop_front();
    if (says_the_same(partner, *record)) return {};
    const bool is_then = side == &Stream::then;
    out.push_back(difference(is_then ? &*record : &partner, is_then ? &partner : &*record));
    stream = {{}, {}, true};
    return {};
  };
  bool alike = true;
  while (true) {
    const bool has_then = reader_then && reader_then->next_line(), has_now = reader_now && reader_now->next_line();
    if (!has_then && !has_now) break;
    alike = alike && has_then && has_now && reader_then->line() == reader_now->line();
    if (alike) continue;
    if (has_then)
      if (Status s = add(*reader_then, &Stream::then, &Stream::now); !s) return s.error();
    if (has_now)
      if (Status s = add(*reader_now, &Stream::now, &Stream::then); !s) return s.error();
  }
  for (const auto& [name, stream] : streams) {
    if (!stream.then.empty()) out.push_back(difference(&stream.then.front(), nullptr));
    if (!stream.now.empty()) out.push_back(difference(nullptr, &stream.now.front()));
  }
  std::ranges::stable_sort(out, {}, &Difference::t);
  return out;
}

}  // namespace cxlab::lab
