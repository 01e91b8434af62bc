#pragma once
// Frames and their poses in each other, as in tf2 of ROS: a buffer of stamped transforms that the topics /tf and
// /tf_static fill, and a broadcaster that publishes them. Names of frames have no leading '/'.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "cx/base/expected.h"
#include "cx/base/time.h"
#include "cx/bus/bus.h"

namespace cxlab::bus {

/// Where a child frame lies in its parent: a point p of the child is `rotation * p + translation` in the parent.
struct Transform {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< of norm 1
};
/// On the floor, turned by `yaw` (rad).
Transform planar(double x, double y, double yaw);
/// First `inner`, then `outer`: the pose of c in a from b in a (`outer`) and c in b (`inner`).
Transform operator*(const Transform& outer, const Transform& inner);
Transform inverse(const Transform& t);
/// Between two poses, `part` from 0 to 1: translations on a line, rotations on the shorter great arc (slerp).
Transform interpolate(const Transform& from, const Transform& to, double part);

/// The transforms of the last seconds. Looks up through common ancestors; the messages of its errors are those of tf2.
class TransformBuffer {
 public:
  /// Forgets transforms that are more than `keep` older than the frame's latest (10 s, as in tf2).
  explicit TransformBuffer(SimTime keep = SimTime{10'000'000'000}) : keep_(keep) {}

  /// Rejects, with the reason: empty names, a child that is its parent, NaN, a quaternion without norm 1, a stamp older
  /// than the buffer keeps, and a loop. Where two transforms have one stamp, the one given last holds.
  Status set(std::string_view parent, std::string_view child, SimTime stamp, const Transform& pose,
             bool is_static = false);

  struct Stamped {
    Transform pose;
    SimTime stamp{};  ///< 0 where only static transforms lie between
  };
  /// The pose of frame `source` in frame `target` at that time, or at the latest time that all of the chain have.
  Expected<Stamped> lookup(std::string_view target, std::string_view source, std::optional<SimTime> at = {}) const;

  /// Every frame that was named, sorted.
  std::vector<std::string> frames() const;

 private:
  struct Sample {
    SimTime stamp{};
    const std::string* parent = nullptr;
    Transform pose;
  };
  struct Frame {
    std::vector<Sample> samples;  ///< by stamp; one of a static frame; none of a root
    bool is_static = false;
  };
  using Frames = std::map<std::string, Frame, std::less<>>;
  /// A frame on the way up; `pose` is where the first frame of the way lies in it.
  struct Step {
    const std::string* frame = nullptr;
    Transform pose;
  };
  Expected<std::optional<Sample>> sample(const Frame& frame, SimTime at) const;
  Expected<std::vector<Step>> way_up(std::string_view frame, SimTime at, std::optional<Error>& stopped) const;
  std::optional<SimTime> latest_common_time(std::string_view target, std::string_view source) const;
  bool leads_to(const std::string* from, std::string_view to) const;

  SimTime keep_;
  Frames frames_;
};

/// Keeps a buffer that is filled by what its participant takes from /tf and /tf_static. Remaps of the participant hold.
class TransformListener {
 public:
  /// `on_refused` is called with the reason for each transform that the buffer rejects.
  static Expected<std::unique_ptr<TransformListener>> create(Bus& bus, ParticipantId participant,
                                                             std::function<void(const std::string&)> on_refused);
  ~TransformListener();
  TransformListener(const TransformListener&) = delete;
  TransformListener& operator=(const TransformListener&) = delete;

  const TransformBuffer& buffer() const { return buffer_; }

 private:
  TransformListener(Bus& bus, std::function<void(const std::string&)> on_refused)
      : bus_(bus), on_refused_(std::move(on_refused)) {}
  void take(const Delivery& delivery, bool is_static);

  Bus& bus_;
  std::function<void(const std::string&)> on_refused_;
  TransformBuffer buffer_;
  std::vector<EndpointId> subscriptions_;
};

/// For worlds and servers: gathers poses and posts them as one message each on /tf and /tf_static. A server calls `set`
/// in `sense` and `post` at its end: environments have the transforms in the same tick.
class TransformBroadcaster {
 public:
  static Expected<TransformBroadcaster> create(Bus& bus, ParticipantId participant);

  /// A pose as of now. Kept until `post`; the last one given for a child holds.
  void set(const std::string& parent, const std::string& child, const Transform& pose) {
    moving_[child] = {parent, pose};
  }
  /// A pose that holds at all times. Later subscribers receive it, too.
  void set_static(const std::string& parent, const std::string& child, const Transform& pose) {
    fixed_[child] = {parent, pose};
  }
  void post();

 private:
  struct Placed {
    std::string parent;
    Transform pose;
  };
  using Poses = std::map<std::string, Placed>;
  TransformBroadcaster(Bus& bus, const MessageType& type) : bus_(&bus), type_(&type) {}
  void post(EndpointId publisher, Poses& poses);

  Bus* bus_;
  const MessageType* type_;
  EndpointId tf_{}, tf_static_{};
  Poses moving_, fixed_;
};

/// A topic whose messages are kept for those who subscribe later (`.../tf_static` of TFMessage), as the transient-local
/// publishers of ROS do.
bool is_kept_topic(std::string_view topic, const MessageType& type);
/// The frames that a message of such a topic places: a later message about the same ones replaces it.
std::string placed_frames(const MessageView& message);

}  // namespace cxlab::bus
