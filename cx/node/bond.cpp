#include "cx/node/bond.h"

#include <algorithm>

#include "cx/bus/needed.h"

namespace cxlab::cx {

std::string_view to_string(Bond::Loss loss) {
  static constexpr std::string_view kWords[] = {"said good-bye", "is silent", "never came"};
  return kWords[static_cast<std::size_t>(loss)];
}

Bond::Bond(bus::Bus& bus, Options options, std::function<void(Loss)> on_broken)
    : bus_(bus),
      options_(std::move(options)),
      on_broken_(std::move(on_broken)),
      start_(bus.now()),
      deadline_(options_.connect_timeout == kNever ? kNever : start_ + options_.connect_timeout) {}

Expected<std::unique_ptr<Bond>> Bond::create(bus::Bus& bus, bus::ParticipantId node, Options options,
                                             std::function<void(Loss)> on_broken) {
  if (options.period <= SimTime::zero()) return input_error("a bond needs a heartbeat period above 0");
  auto type = bus::needed_message(bus.registry(), "bond/msg/Status");
  if (!type) return type.error();
  std::unique_ptr<Bond> bond(new Bond(bus, std::move(options), std::move(on_broken)));
  bond->type_ = *type;
  auto out = bus.advertise(node, bond->options_.topic, **type);
  if (!out) return out.error();
  bond->out_ = *out;
  auto in = bus.subscribe(node, bond->options_.topic, **type,
                          [self = bond.get()](const bus::Delivery& d) { self->hear(d.message->view()); });
  if (!in) return in.error();
  bond->in_ = *in;
  return bond;
}

Bond::~Bond() {
  bus_.remove(in_);
  bus_.remove(out_);
}

void Bond::send(bool active) {
  auto message = std::make_shared<bus::Message>(*type_);
  const bus::MessageView status = message->view();
  const auto now = bus_.now().count();
  status.nested("header").nested("stamp").set("sec", now / 1'000'000'000).set("nanosec", now % 1'000'000'000);
  status.set("id", options_.id).set("instance_id", options_.instance).set("active", active);
  status.set("heartbeat_timeout", to_seconds(options_.timeout)).set("heartbeat_period", to_seconds(options_.period));
  bus_.publish(out_, std::move(message));
}

void Bond::hear(const bus::MessageView& status) {
  if (status.text("id") != options_.id || status.text("instance_id") == options_.instance || state_ == State::kBroken)
    return;
  if (!status.integer("active")) {
    break_up(Loss::kEnded);
    return;
  }
  state_ = State::kFormed;
  deadline_ = bus_.now() + options_.timeout;
}

void Bond::break_up(Loss loss) {
  state_ = State::kBroken;
  send(false);
  if (const auto report = on_broken_) report(loss);  // a copy: the owner may drop this bond
}

void Bond::act() {
  if (state_ == State::kBroken) return;
  if (bus_.now() >= deadline_) {
    break_up(state_ == State::kFormed ? Loss::kSilent : Loss::kNeverCame);
    return;
  }
  if (start_ + sent_ * options_.period > bus_.now()) return;
  while (start_ + sent_ * options_.period <= bus_.now()) ++sent_;  // heartbeats missed in a long tick
  send(true);
}

SimTime Bond::next_due() const {
  return state_ == State::kBroken ? kNever : std::min(deadline_, start_ + sent_ * options_.period);
}

void Bond::end() {
  if (state_ == State::kBroken) return;
  state_ = State::kBroken;
  send(false);
}

Status BondWatcher::watch(Bond::Options options) {
  const std::string id = options.id;
  if (std::any_of(watched_.begin(), watched_.end(), [&](const Watched& w) { return w.id == id; }))
    return input_error("the bond '" + id + "' is watched already");
  auto bond = Bond::create(bus_, node_, std::move(options), [this, id](Bond::Loss loss) {
    for (Watched& w : watched_) w.lost = w.lost || w.id == id;
    clean_up_(id, loss);
  });
  if (!bond) return bond.error();
  watched_.push_back({id, *std::move(bond)});
  return {};
}

void BondWatcher::forget(const std::string& id) {
  for (Watched& w : watched_)
    if (w.id == id) w.bond->end();
  std::erase_if(watched_, [&](const Watched& w) { return w.id == id; });
}

std::vector<std::string> BondWatcher::watched() const {
  std::vector<std::string> ids;
  for (const Watched& w : watched_)
    if (!w.lost) ids.push_back(w.id);
  return ids;
}

void BondWatcher::act() {
  for (std::size_t i = 0; i < watched_.size(); ++i) watched_[i].bond->act();
  std::erase_if(watched_, [](const Watched& w) { return w.lost; });
}

SimTime BondWatcher::next_due() const {
  SimTime due = kNever;
  for (const Watched& w : watched_) due = std::min(due, w.bond->next_due());
  return due;
}

}  // namespace cxlab::cx
