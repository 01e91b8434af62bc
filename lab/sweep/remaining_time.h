#pragma once
// How long a sweep still takes, from how long its games have taken so far: by scenario and strategy, since one may take
// many times as long as another.

#include <cstddef>
#include <map>
#include <optional>
#include <string>

namespace cxlab::lab {

class RemainingTime {
 public:
  /// Games of this kind are still to be played.
  void add(const std::string& kind, std::size_t games = 1) { kinds_[kind].open += games; }
  void begun(const std::string& kind);
  void ended(const std::string& kind, double seconds);
  /// While so many games are played at once, and those that play have played for so many seconds in all. None before
  /// the first one has ended.
  std::optional<double> estimate(int jobs, double playing_s) const;

 private:
  struct Kind {
    std::size_t open = 0, playing = 0, ended = 0;
    double seconds = 0;  // of those that have ended
  };
  std::map<std::string, Kind> kinds_;
};

}  // namespace cxlab::lab
