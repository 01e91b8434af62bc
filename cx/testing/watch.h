#pragma once
// Watches one environment through its journal: every fact that ever was, every firing. So a story also sees a fact that
// lives only within a run of the rules.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cx/base/record_sink.h"
#include "cx/testing/pattern.h"

namespace cxlab::testing {

/// A fact between two changes of it.
struct FactVersion {
  FactText fact;
  SimTime from{};
  SimTime until = kNever;  ///< retracted or changed then
};

struct Firing {
  SimTime t{};
  std::string rule;
};

class Watch final : public RecordSink {
 public:
  /// From now on only this environment's facts and firings are kept; before, none.
  void choose(const std::string& environment) { stream_name_ = "env/" + environment; }

  StreamId open_stream(std::string_view name) override;
  RecordRef write(StreamId stream, SimTime t, RecordKind kind, const RecordData& data,
                  std::span<const RecordRef> causes) override;

  /// In order of their beginning.
  const std::vector<FactVersion>& facts() const { return facts_; }
  const std::vector<Firing>& firings() const { return firings_; }

 private:
  void end_version(std::int64_t fact, SimTime t);

  std::string stream_name_;
  std::vector<std::string> streams_;
  std::vector<std::uint64_t> counts_;
  std::vector<FactVersion> facts_;
  std::map<std::int64_t, std::size_t> live_;  // number of the fact -> its last version
  std::vector<Firing> firings_;
};

}  // namespace cxlab::testing
