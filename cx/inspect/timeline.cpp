#include "cx/inspect/timeline.h"

#include <algorithm>
#include <cassert>

#include "cx/explain/fact_record.h"
#include "cx/journal/journal.h"
#include "cx/journal/record_bytes.h"

namespace cxlab::inspect {

namespace {

bool is_about_a_fact(RecordKind kind) {
  return kind == RecordKind::kAssert || kind == RecordKind::kModify || kind == RecordKind::kRetract ||
         kind == RecordKind::kDecision;
}

}  // namespace

std::uint32_t Timeline::number_of(std::string_view name) {
  if (const auto known = numbers_.find(name); known != numbers_.end()) return known->second;
  names_.emplace_back(name);
  return numbers_.emplace(std::string(name), static_cast<std::uint32_t>(names_.size() - 1)).first->second;
}

void Timeline::add(const WrittenRecord& record) {
  if (entries_.empty()) {
    first_ = record.n;
    stream_ = record.stream;
  }
  assert(record.n == end());
  Entry entry{record.t, data_.size(), causes_.size(), 0, 0, record.kind};
  data_ += record.data;
  for (const RecordRef& cause : record.causes)
    causes_.push_back({number_of(record.journal.stream_name(cause.stream)), cause.n});
  if (record.kind == RecordKind::kFire) {
    const std::string_view module = text_in(record.data, "module"), rule = text_in(record.data, "rule");
    entry.name = module.empty() ? number_of(rule) : number_of(std::string(module) + "::" + std::string(rule));
    firings_.push_back(record.n);
  } else if (is_about_a_fact(record.kind)) {
    entry.fact = integer_in(record.data, "fact");
    entry.name = number_of(text_in(record.data, "template"));
    const auto fact = static_cast<std::size_t>(entry.fact);
    if (fact >= changes_.size()) changes_.resize(fact + 1);
    changes_[fact].push_back(record.n);
  }
  entries_.push_back(entry);
}

std::span<const Timeline::StoredCause> Timeline::causes_of(std::uint64_t n) const {
  const std::size_t begin = entry(n).causes, end = n + 1 < this->end() ? entry(n + 1).causes : causes_.size();
  return std::span(causes_).subspan(begin, end - begin);
}

std::vector<Timeline::Cause> Timeline::causes(std::uint64_t n) const {
  std::vector<Cause> out;
  for (const StoredCause& cause : causes_of(n)) {
    const std::string& stream = names_[cause.stream];
    out.push_back({cause.n, stream == stream_ ? nullptr : &stream});
  }
  return out;
}

std::string_view Timeline::data_of(std::uint64_t n) const {
  const std::size_t end = n + 1 < this->end() ? entry(n + 1).data : data_.size();
  return std::string_view(data_).substr(entry(n).data, end - entry(n).data);
}

bool Timeline::same(std::uint64_t n, const Timeline& other, std::uint64_t m) const {
  if (time(n) != other.time(m) || kind(n) != other.kind(m) || data_of(n) != other.data_of(m)) return false;
  return std::ranges::equal(causes_of(n), other.causes_of(m), [&](const StoredCause& a, const StoredCause& b) {
    const std::string& stream = names_[a.stream];
    return stream == other.names_[b.stream] && (a.n == b.n || (stream == stream_ && b.n - a.n == m - n));
  });
}

bool Timeline::is_planned(std::uint64_t n) const {
  return kind(n) == RecordKind::kControl && cxlab::is_planned(read(n));
}

JournalRecord Timeline::read(std::uint64_t n) const {
  JournalRecord record{stream_, n, time(n), kind(n), {}, {}};
  record.data = *decode_record_data(data_of(n));
  for (const Cause& cause : causes(n)) record.causes.push_back({cause.stream ? *cause.stream : stream_, cause.n});
  return record;
}

std::span<const std::uint64_t> Timeline::changes(std::int64_t fact) const {
  const auto number = static_cast<std::size_t>(fact);
  return number < changes_.size() ? std::span(changes_[number]) : std::span<const std::uint64_t>();
}

const FactCopy& Timeline::fact_after(std::uint64_t n) const {
  if (const auto known = facts_.find(n); known != facts_.end()) return known->second;
  // Forward from the last change that was asked for before: each is read once.
  const std::span<const std::uint64_t> all = changes(fact(n));
  const auto last = std::ranges::upper_bound(all, n);
  auto from = last;
  FactCopy copy;
  while (from != all.begin() && copy.template_name.empty()) {
    --from;
    if (const auto known = facts_.find(*from); known != facts_.end()) {
      copy = known->second;
      ++from;
    }
  }
  for (auto change = from; change != last; ++change) {
    if (kind(*change) != RecordKind::kRetract) {
      if (kind(*change) != RecordKind::kModify) copy = {};
      explain::apply(read(*change), copy);
    }
    facts_.emplace(*change, copy);
  }
  return facts_.at(n);
}

std::uint64_t Timeline::end_of(SimTime t) const {
  const auto later = std::ranges::upper_bound(entries_, t, {}, &Entry::t);
  return first_ + static_cast<std::uint64_t>(later - entries_.begin());
}

void Timelines::written(const WrittenRecord& record) {
  auto known = by_stream_.find(record.stream);
  if (known == by_stream_.end()) {
    known = by_stream_.try_emplace(std::string(record.stream)).first;
    if (started_) known->second.start_is_over();
  }
  known->second.add(record);
}

const Timeline& Timelines::of(std::string_view stream) {
  return by_stream_.try_emplace(std::string(stream)).first->second;
}

}  // namespace cxlab::inspect
