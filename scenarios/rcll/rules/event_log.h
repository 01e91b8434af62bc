#pragma once
// The one writer of a game's events. Referee, pauses and maintenance tell it what happened; it writes that to the
// stream "referee" and calls those who listen.

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "cx/base/record_sink.h"
#include "scenarios/rcll/rules/event.h"
#include "sim/world.h"

namespace cxlab::rcll {

class EventLog {
 public:
  using Listener = std::function<void(SimTime, const Event&)>;

  /// Both outlive it. Without a floor its clock is simulated time.
  explicit EventLog(RecordSink& sink, const sim::WorldView* floor = nullptr)
      : sink_(sink), floor_(floor), stream_(sink.open_stream("referee")) {}
  EventLog(const EventLog&) = delete;
  EventLog& operator=(const EventLog&) = delete;

  /// `listener` is called with each event from now on and with its simulated time, as a journal has it.
  void listen(Listener listener) { listeners_.push_back(std::move(listener)); }

  /// At that time of the floor's clock.
  void write(SimTime at, Event event) { write_simulated(floor_ ? floor_->simulated(at) : at, std::move(event)); }
  void write_simulated(SimTime now, Event event, std::span<const RecordRef> causes = {}) {
    for (const Listener& listener : listeners_) listener(now, event);
    sink_.write(stream_, now, RecordKind::kReferee, rcll::write(std::move(event), data_), causes);
  }

 private:
  RecordSink& sink_;
  const sim::WorldView* floor_;
  StreamId stream_;
  RecordData data_;
  std::vector<Listener> listeners_;
};

}  // namespace cxlab::rcll
