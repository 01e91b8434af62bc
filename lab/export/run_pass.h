#pragma once
// One pass over a recorded run in order of time, for all that is made of it. Little is held in memory.

#include <functional>
#include <span>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/journal/journal_record.h"
#include "lab/host.h"
#include "lab/run.h"
#include "scenarios/scene.h"

namespace cxlab::lab {

/// From when to when a run is exported; what is at either time belongs to it.
struct Stretch {
  SimTime from = SimTime::min(), to = SimTime::max();
  bool has(SimTime t) const { return from <= t && t <= to; }
};

/// Is told what happened.
class PassListener {
 public:
  virtual ~PassListener() = default;
  virtual bool wants(RecordKind) const { return false; }
  /// A record, from the start of the run on: what came before the stretch explains what is in it.
  virtual Status hear(const JournalRecord&) { return {}; }
  /// Whether `see` is called.
  virtual bool wants_scenes() const { return false; }
  /// What there is to see, ten times in each second of the stretch, after all records up to then.
  virtual Status see(const Scene&) { return {}; }
};

/// Whether the run has a scene.
bool has_scenes(const Run& run);
/// Reads journal and scene up to the end of the stretch. A stop by the host ends it earlier.
Status pass_over(const Run& run, const Stretch& stretch, std::span<PassListener* const> listeners, const Host& host);
/// Only the scenes.
Status pass_over_scenes(const Run& run, const Stretch& stretch, const std::function<Status(const Scene&)>& see);

}  // namespace cxlab::lab
