#pragma once
// Records of parts that go by the floor's clock: they are written with simulated time.

#include "cx/base/record_sink.h"
#include "sim/world.h"

namespace cxlab::sim {

class FloorRecords final : public RecordSink {
 public:
  /// Both outlive it.
  FloorRecords(const WorldView& world, RecordSink& sink) : world_(world), sink_(sink) {}

  StreamId open_stream(std::string_view name) override { return sink_.open_stream(name); }
  RecordRef write(StreamId stream, SimTime time, RecordKind kind, const RecordData& data,
                  std::span<const RecordRef> causes = {}) override {
    return sink_.write(stream, world_.simulated(time), kind, data, causes);
  }

 private:
  const WorldView& world_;
  RecordSink& sink_;
};

}  // namespace cxlab::sim
