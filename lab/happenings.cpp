#include "lab/happenings.h"

#include <algorithm>

#include "lab/run.h"
#include "scenarios/catalogue.h"

namespace cxlab::lab {

void tell(const Scenario& scenario, const JournalRecord& record, std::vector<PageEvent>& out) {
  if (record.kind == RecordKind::kError && record.stream.starts_with("env/"))
    out.push_back({to_seconds(record.t), "error", record.stream.substr(4), std::string(record.data.text("message")),
                   std::string(record.data.text("rule")) + ", " + std::string(record.data.text("file")) + ':' +
                       std::to_string(record.data.integer("line"))});
  if (const auto happened = scenario.world.kind->happened) happened(scenario, record, out);
}

void Happenings::read(const Run& run) {
  const auto records = run.records({.kinds = kRecordsOfQuestions});
  if (!records) return;
  for (const JournalRecord& record : *records) heard(record);
}

bool Happenings::wants(std::string_view, RecordKind kind) const {
  return std::ranges::find(kRecordsOfQuestions, kind) != kRecordsOfQuestions.end();
}

bool Happenings::told_by_world() const { return scenario_.world.kind->happened != nullptr; }

std::vector<PageEvent> Happenings::last(double t, std::size_t most) const {
  std::vector<PageEvent> out;
  auto at = std::ranges::upper_bound(events_, t, {}, &PageEvent::t);
  while (at != events_.begin() && out.size() < most)
    if (--at; !at->minor) out.push_back(*at);
  return out;
}

}  // namespace cxlab::lab
