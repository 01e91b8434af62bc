#pragma once
// Which parts of a bag of ROS 2 are played, and when: `bag:` of a scenario (docs/reference/bag.md).

#include <string>
#include <utility>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/origin.h"

namespace cxlab::bag {

struct BagSpec {
  std::string file{};     ///< an MCAP file, or the folder that `ros2 bag record` made; empty: no bag
  double start_s = 0;     ///< s after the first message of the bag: what comes before is left out
  double offset_s = 0;    ///< simulated time at which that moment is played, s
  double rate = 1;        ///< seconds of the bag in a second of simulated time
  std::string topics{};   ///< a regular expression: only names in which it is found are played; empty: all
  std::string exclude{};  ///< a regular expression: names in which it is found are left out; empty: none
  std::vector<std::pair<std::string, std::string>> remap{};  ///< FROM := TO: whole names of topics, services, actions
  bool own = false;                                          ///< topics that this run publishes itself are played, too
  Origin origin{};

  explicit operator bool() const { return !file.empty(); }

  template <class Keys>
  void fields(Keys& keys) {
    keys.required("file", file);
    keys("start_s", start_s);
    keys("offset_s", offset_s);
    keys("rate", rate);
    keys("topics", topics);
    keys("exclude", exclude);
    keys("remap", remap);
    keys("own", own);
  }
};

/// Values that no bag can be played with; the error begins with the key.
Status validate(const BagSpec& spec);

}  // namespace cxlab::bag
