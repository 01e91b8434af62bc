#include "cx/bus/transforms.h"

#include <algorithm>
#include <cmath>

#include "cx/base/number_text.h"
#include "cx/bus/needed.h"

namespace cxlab::bus {

namespace {

constexpr const char* kMessageType = "tf2_msgs/msg/TFMessage";
constexpr double kQuaternionTolerance = 1e-2;  // of the squared norm, as in tf2

/// Seconds with six digits, as tf2 prints times.
std::string seconds(SimTime t) { return fixed_text(to_seconds(t), 6); }

std::string_view without_slash(std::string_view frame) { return frame.starts_with('/') ? frame.substr(1) : frame; }

Error refused(std::string_view code, std::string_view child, const std::string& why) {
  return input_error(std::string(code) + ": Ignoring transform for child_frame_id \"" + std::string(child) +
                     "\" because " + why);
}

}  // namespace

Transform planar(double x, double y, double yaw) {
  return {{x, y, 0}, Eigen::Quaterniond(std::cos(yaw / 2), 0, 0, std::sin(yaw / 2))};
}

Transform operator*(const Transform& outer, const Transform& inner) {
  return {outer.rotation * inner.translation + outer.translation, outer.rotation * inner.rotation};
}

Transform inverse(const Transform& t) {
  const Eigen::Quaterniond back = t.rotation.conjugate();
  return {-(back * t.translation), back};
}

Transform interpolate(const Transform& from, const Transform& to, double part) {
  return {from.translation + part * (to.translation - from.translation), from.rotation.slerp(part, to.rotation)};
}

// --- The buffer

bool TransformBuffer::leads_to(const std::string* from, std::string_view to) const {
  for (std::size_t steps = 0; from != nullptr && steps <= frames_.size(); ++steps) {
    if (*from == to) return true;
    const auto& samples = frames_.find(*from)->second.samples;
    from = samples.empty() ? nullptr : samples.back().parent;
  }
  return false;
}

Status TransformBuffer::set(std::string_view parent, std::string_view child, SimTime stamp, const Transform& pose,
                            bool is_static) {
  parent = without_slash(parent);
  child = without_slash(child);
  if (child.empty()) return refused("TF_NO_CHILD_FRAME_ID", child, "child_frame_id not set");
  if (parent.empty()) return refused("TF_NO_FRAME_ID", child, "frame_id not set");
  if (child == parent) return refused("TF_SELF_TRANSFORM", child, "frame_id is the same");
  if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite())
    return refused("TF_NAN_INPUT", child, "of a nan value in the transform");
  if (std::abs(pose.rotation.squaredNorm() - 1) > kQuaternionTolerance)
    return refused("TF_DENORMALIZED_QUATERNION", child, "of an invalid quaternion in the transform");

  const auto parent_at = frames_.try_emplace(std::string(parent)).first;
  if (leads_to(&parent_at->first, child))
    return refused("TF_LOOP", child, "it already holds '" + std::string(parent) + "': the tree would have a loop");
  const auto [at, is_new] = frames_.try_emplace(std::string(child));
  Frame& frame = at->second;
  if (frame.samples.empty()) frame.is_static = is_static;
  const Sample added{stamp, &parent_at->first, pose};
  auto& samples = frame.samples;
  if (frame.is_static) {
    samples.assign(1, added);
    return {};
  }
  if (!samples.empty() && stamp < samples.back().stamp - keep_)
    return refused("TF_OLD_DATA", child, "it is from the past");
  const auto place =
      std::lower_bound(samples.begin(), samples.end(), stamp, [](const Sample& s, SimTime t) { return s.stamp < t; });
  if (place != samples.end() && place->stamp == stamp)
    *place = added;
  else
    samples.insert(place, added);
  const SimTime oldest = samples.back().stamp - keep_;
  samples.erase(samples.begin(),
                std::find_if(samples.begin(), samples.end(), [&](const Sample& s) { return s.stamp >= oldest; }));
  return {};
}

Expected<std::optional<TransformBuffer::Sample>> TransformBuffer::sample(const Frame& frame, SimTime at) const {
  const auto& samples = frame.samples;
  if (samples.empty()) return std::optional<Sample>{};
  if (frame.is_static) return std::optional<Sample>{samples.front()};
  const auto after =
      std::lower_bound(samples.begin(), samples.end(), at, [](const Sample& s, SimTime t) { return s.stamp < t; });
  if (after != samples.end() && after->stamp == at) return std::optional<Sample>{*after};
  if (samples.size() == 1)
    return input_error("Lookup would require extrapolation at time " + seconds(at) + ", but only time " +
                       seconds(samples.front().stamp) + " is in the buffer");
  if (after == samples.end())
    return input_error("Lookup would require extrapolation into the future.  Requested time " + seconds(at) +
                       " but the latest data is at time " + seconds(samples.back().stamp));
  if (after == samples.begin())
    return input_error("Lookup would require extrapolation into the past.  Requested time " + seconds(at) +
                       " but the earliest data is at time " + seconds(samples.front().stamp));
  Sample between = *(after - 1);
  if (between.parent == after->parent) {  // else it moved to another parent: the earlier one holds until then
    const auto length = static_cast<double>((after->stamp - between.stamp).count());
    between.pose = interpolate(between.pose, after->pose, static_cast<double>((at - between.stamp).count()) / length);
  }
  return std::optional<Sample>{between};
}

Expected<std::vector<TransformBuffer::Step>> TransformBuffer::way_up(std::string_view name, SimTime at,
                                                                     std::optional<Error>& stopped) const {
  std::vector<Step> way;
  const std::string* frame = &frames_.find(name)->first;
  Transform pose;
  while (true) {
    way.push_back({frame, pose});
    if (way.size() > frames_.size()) return input_error("The tf tree is invalid because it contains a loop.");
    auto found = sample(frames_.find(*frame)->second, at);
    if (!found) {
      stopped = found.error();
      return way;
    }
    if (!*found) return way;
    pose = (*found)->pose * pose;
    frame = (*found)->parent;
  }
}

std::optional<SimTime> TransformBuffer::latest_common_time(std::string_view target, std::string_view source) const {
  struct Stop {
    const std::string* frame;
    SimTime latest;  // until here
  };
  const auto climb = [this](std::string_view name) {
    std::vector<Stop> way;
    SimTime latest = kNever;
    const std::string* frame = &frames_.find(name)->first;
    while (way.size() <= frames_.size()) {
      way.push_back({frame, latest});
      const Frame& f = frames_.find(*frame)->second;
      if (f.samples.empty()) break;
      if (!f.is_static) latest = std::min(latest, f.samples.back().stamp);
      frame = f.samples.back().parent;
    }
    return way;
  };
  const auto up = climb(source), down = climb(target);
  for (const Stop& a : up)
    for (const Stop& b : down)
      if (a.frame == b.frame) return std::min(a.latest, b.latest);
  return std::nullopt;
}

Expected<TransformBuffer::Stamped> TransformBuffer::lookup(std::string_view target, std::string_view source,
                                                           std::optional<SimTime> at) const {
  for (const auto& [argument, name] : {std::pair{"target_frame", target}, std::pair{"source_frame", source}}) {
    const std::string which = std::string("lookupTransform argument ") + argument;
    if (name.empty()) return input_error("Invalid argument passed to " + which + " in tf2 frame_ids cannot be empty");
    if (name.starts_with('/'))
      return input_error("Invalid argument \"" + std::string(name) + "\" passed to " + which +
                         " in tf2 frame_ids cannot start with a '/' like: ");
    if (frames_.find(name) == frames_.end())
      return input_error('"' + std::string(name) + "\" passed to " + which + " does not exist. ");
  }
  const Error apart =
      input_error("Could not find a connection between '" + std::string(source) + "' and '" + std::string(target) +
                  "' because they are not part of the same tree.Tf has two or more unconnected trees.");
  if (!at) {
    at = latest_common_time(target, source);
    if (!at) return apart;
  }
  std::optional<Error> stopped;
  auto up = way_up(source, *at, stopped);
  if (!up) return up.error();
  auto down = way_up(target, *at, stopped);
  if (!down) return down.error();
  for (const Step& a : *up)
    for (const Step& b : *down)
      if (a.frame == b.frame) return Stamped{inverse(b.pose) * a.pose, *at == kNever ? SimTime{} : *at};
  if (!stopped) return apart;
  return input_error(stopped->message + ", when looking up transform from frame [" + std::string(source) +
                     "] to frame [" + std::string(target) + ']');
}

std::vector<std::string> TransformBuffer::frames() const {
  std::vector<std::string> out;
  for (const auto& [name, frame] : frames_) out.push_back(name);
  return out;
}

// --- On the bus

Expected<std::unique_ptr<TransformListener>> TransformListener::create(
    Bus& bus, ParticipantId participant, std::function<void(const std::string&)> on_refused) {
  auto type = needed_message(bus.registry(), kMessageType);
  if (!type) return type.error();
  std::unique_ptr<TransformListener> listener(new TransformListener(bus, std::move(on_refused)));
  for (const bool is_static : {false, true}) {
    auto subscription =
        bus.subscribe(participant, is_static ? "/tf_static" : "/tf", **type,
                      [self = listener.get(), is_static](const Delivery& d) { self->take(d, is_static); });
    if (!subscription) return subscription.error();
    listener->subscriptions_.push_back(*subscription);
  }
  return listener;
}

TransformListener::~TransformListener() {
  for (const EndpointId subscription : subscriptions_) bus_.remove(subscription);
}

void TransformListener::take(const Delivery& delivery, bool is_static) {
  const MessageView message = delivery.message->view();
  for (std::size_t i = 0; i < message.size("transforms"); ++i) {
    const MessageView stamped = message.nested("transforms", i);
    const MessageView header = stamped.nested("header"), stamp = header.nested("stamp");
    const MessageView position = stamped.nested("transform").nested("translation"),
                      turn = stamped.nested("transform").nested("rotation");
    const Transform pose{{position.real("x"), position.real("y"), position.real("z")},
                         {turn.real("w"), turn.real("x"), turn.real("y"), turn.real("z")}};
    const std::string &parent = header.text("frame_id"), &child = stamped.text("child_frame_id");
    const SimTime t = std::chrono::seconds(stamp.integer("sec")) + SimTime{stamp.integer("nanosec")};
    if (Status s = buffer_.set(parent, child, t, pose, is_static); !s && on_refused_)
      on_refused_("Failure to set received transform from " + child + " to " + parent +
                  " with error: " + s.error().message);
  }
}

Expected<TransformBroadcaster> TransformBroadcaster::create(Bus& bus, ParticipantId participant) {
  auto type = needed_message(bus.registry(), kMessageType);
  if (!type) return type.error();
  TransformBroadcaster out(bus, **type);
  auto tf = bus.advertise(participant, "/tf", **type);
  if (!tf) return tf.error();
  auto tf_static = bus.advertise(participant, "/tf_static", **type);
  if (!tf_static) return tf_static.error();
  out.tf_ = *tf;
  out.tf_static_ = *tf_static;
  return out;
}

void TransformBroadcaster::post() {
  post(tf_, moving_);
  post(tf_static_, fixed_);
}

void TransformBroadcaster::post(EndpointId publisher, Poses& poses) {
  if (poses.empty()) return;
  Message message(*type_);
  const std::int64_t now = bus_->now().count();
  for (const auto& [child, placed] : poses) {
    const MessageView stamped = message->append("transforms");
    stamped.set("child_frame_id", child)
        .nested("header")
        .set("frame_id", placed.parent)
        .nested("stamp")
        .set("sec", now / 1'000'000'000)
        .set("nanosec", now % 1'000'000'000);
    const MessageView transform = stamped.nested("transform");
    const auto& [position, turn] = placed.pose;
    transform.nested("translation").set("x", position.x()).set("y", position.y()).set("z", position.z());
    transform.nested("rotation").set("x", turn.x()).set("y", turn.y()).set("z", turn.z()).set("w", turn.w());
  }
  poses.clear();
  bus_->publish(publisher, std::make_shared<const Message>(std::move(message)));
}

bool is_kept_topic(std::string_view topic, const MessageType& type) {
  return topic.ends_with("/tf_static") && type.name() == kMessageType;
}

std::string placed_frames(const MessageView& message) {
  std::string out;
  for (std::size_t i = 0; i < message.size("transforms"); ++i)
    out += message.nested("transforms", i).text("child_frame_id") + '\n';
  return out;
}

}  // namespace cxlab::bus
