#include "cx/bag/bag_server.h"

#include <cmath>
#include <regex>

#include "cx/bag/schema.h"
#include "cx/base/number_text.h"
#include "cx/bus/names.h"

namespace cxlab::bag {

namespace {

constexpr std::size_t kLongestName = 1024;
constexpr SimTime kLatest = std::chrono::seconds(1'000'000'000);  // no run is longer

/// What each node of ROS 2, the recorder or the time of the run has anyway.
constexpr std::string_view kNotPlayed[]{"/rosout", "/parameter_events", "/clock", "/events/write_split"};

bool matches(const std::string& name, const std::string& expression) {
  return std::regex_search(name, std::regex(expression, std::regex::ECMAScript | std::regex::optimize));
}

/// The name without that end; empty if it has another one.
std::string before_end(std::string_view name, std::string_view end) {
  return name.ends_with(end) ? std::string(name.substr(0, name.size() - end.size())) : std::string();
}

/// Since 1970.
SimTime first_played(const Recording& recording, const BagSpec& spec) {
  return recording.messages() == 0 ? SimTime::zero() : recording.first() + from_seconds(spec.start_s);
}

SimTime time_in_run(SimTime recorded, SimTime first, const BagSpec& spec) {
  const SimTime since = recorded - first;
  const double seconds = to_seconds(since) / spec.rate;
  if (seconds >= to_seconds(kLatest)) return kLatest;
  return from_seconds(spec.offset_s) + (spec.rate == 1 ? since : from_seconds(seconds));
}

std::string seconds_of_bag(SimTime t) { return general_text(to_seconds(t), 9); }

std::string listed(const std::vector<std::string>& items) { return some_of(items, 12); }

}  // namespace

Status validate(const BagSpec& spec) {
  const auto fail = [](const char* key, const std::string& what) {
    return input_error(std::string(key) + ": " + what);
  };
  const auto number = [](double value) { return general_text(value, 9); };
  if (!(spec.start_s >= 0 && spec.start_s <= 1e9))
    return fail("start_s", found_expected(number(spec.start_s), "s from 0 to 1e9"));
  if (!(spec.offset_s >= 0 && spec.offset_s <= 1e9))
    return fail("offset_s", found_expected(number(spec.offset_s), "s from 0 to 1e9"));
  if (!(spec.rate >= 0.001 && spec.rate <= 1000))
    return fail("rate", found_expected(number(spec.rate), "a number from 0.001 to 1000"));
  for (const auto& [key, expression] : {std::pair("topics", &spec.topics), std::pair("exclude", &spec.exclude)}) {
    try {
      (void)matches("/", *expression);
    } catch (const std::regex_error& error) {
      return fail(key, found_text(*expression, std::string("a regular expression (ECMAScript): ") + error.what()));
    }
  }
  for (const auto& remap : spec.remap)
    if (const std::string fault = bus::remap_fault(remap); !fault.empty()) return fail("remap", fault);
  return {};
}

/// Topics of one action.
struct BagServer::ActionOfBag {
  std::string name, type;
  ActionTopics topics;
  std::vector<std::size_t> places;
};

BagServer::BagServer(BagSetup setup, bus::Bus& bus)
    : spec_(std::move(setup.spec)),
      recording_(std::move(setup.recording)),
      managers_(std::move(setup.managers)),
      playing_{.bus = bus, .log = std::move(setup.log), .beside = std::move(setup.beside)} {}

BagServer::~BagServer() = default;

Expected<std::unique_ptr<BagServer>> BagServer::create(BagSetup setup, bus::Bus& bus, RecordSink& sink) {
  std::unique_ptr<BagServer> server(new BagServer(std::move(setup), bus));
  server->playing_.self =
      bus.join(bus::ParticipantKind::kNode, bus::NodeName{"bag", "/", {}}, sink.open_stream("node/bag"));
  server->playing_.first = first_played(server->recording_, server->spec_);
  if (Status s = server->make_parts(); !s) return s.error();
  if (Status s = server->skip(); !s) return s.error();
  return server;
}

std::string BagServer::remapped(const std::string& name) const {
  for (const auto& [from, to] : spec_.remap)
    if (name == from) return to;
  return name;
}

std::string BagServer::left_out_for_good(const Topic& topic, const std::string& name) const {
  if (std::ranges::find(kNotPlayed, name) != std::end(kNotPlayed)) return "every run has its own";
  for (const std::string& manager : managers_)
    if (name.starts_with(manager + '/')) return "it belongs to " + manager;
  if (topic.encoding != "cdr") return "its messages are in '" + topic.encoding + "', expected 'cdr'";
  return {};
}

void BagServer::leave_out(const Topic& topic, const std::string& why) {
  left_out_.push_back(topic.name + " (" + why + ')');
}

Status BagServer::make_parts() {
  part_of_.assign(recording_.topics().size(), nullptr);
  for (std::size_t i = 0; i < recording_.topics().size(); ++i) {
    const Topic& topic = recording_.topics()[i];
    const std::string fault = topic.name.size() > kLongestName ? "is too long" : bus::name_fault(topic.name);
    if (!fault.empty() || !topic.name.starts_with('/')) {
      left_out_.push_back("'" + topic.name.substr(0, 40) + "' (its name " +
                          (fault.empty() ? "is not absolute" : fault) + ')');
      continue;
    }
    bool filtered = false;
    try {
      filtered = (!spec_.topics.empty() && !matches(topic.name, spec_.topics)) ||
                 (!spec_.exclude.empty() && matches(topic.name, spec_.exclude));
    } catch (const std::regex_error& error) {
      return input_error(std::string("a filter is too complex for ") + topic.name + ": " + error.what(),
                         recording_.name());
    }
    if (filtered) {
      ++filtered_;
      continue;
    }
    bool of_action = false;
    for (const std::string_view end :
         {kFeedbackTopic, kStatusTopic, kSendGoalEvents, kGetResultEvents, kCancelGoalEvents}) {
      const std::string base = before_end(topic.name, end);
      if (base.empty()) continue;
      of_action = true;
      const std::string name = remapped(base);
      if (const std::string why = left_out_for_good(topic, name); !why.empty()) {
        leave_out(topic, why);
        break;
      }
      auto action = std::ranges::find(actions_, name, &ActionOfBag::name);
      if (action == actions_.end()) action = actions_.insert(action, {name, "", {}, {}});
      action->places.push_back(i);
      ActionTopics& has = action->topics;
      const auto type = [&](std::string_view type_end) {
        if (const std::string found = before_end(topic.type, type_end); !found.empty()) action->type = found;
      };
      if (end == kFeedbackTopic) has.feedback = true, type("_FeedbackMessage");
      if (end == kStatusTopic) has.status = true;
      if (end == kSendGoalEvents) has.send_goal = topic.events, type("_SendGoal_Event");
      if (end == kGetResultEvents) has.get_result = topic.events, type("_GetResult_Event");
      if (end == kCancelGoalEvents) has.cancel_goal = topic.events;
    }
    if (of_action) continue;
    const std::string service = before_end(topic.name, kServiceEvents);
    const std::string name = remapped(service.empty() ? topic.name : service);
    if (const std::string why = left_out_for_good(topic, name); !why.empty()) {
      leave_out(topic, why);
      continue;
    }
    if (Status s = service.empty() ? make_topic(topic, name, i) : make_service(topic, name, i); !s) return s;
  }
  return make_actions();
}

Error BagServer::differs(const Topic& topic, const std::string& type, const std::string& difference) const {
  return input_error(topic.name + " has type " + type + ", and " + difference +
                         "; play it with the definitions of the "
                         "recording (a package of that time), or leave it out: --bag-exclude '^" +
                         topic.name + "$'",
                     recording_.name());
}

Status BagServer::make_topic(const Topic& topic, const std::string& name, std::size_t place) {
  const auto type = playing_.bus.registry().message(topic.type);
  if (!type) {
    unknown_.push_back(topic.name + " (" + topic.type + ')');
    return {};
  }
  if (const std::string found = Schema(topic.definition).difference(**type); !found.empty())
    return differs(topic, topic.type, found);
  add(make_topic_part(playing_, name, **type, spec_.own, topic.latched), {place});
  return {};
}

Status BagServer::make_service(const Topic& topic, const std::string& name, std::size_t place) {
  const std::string type_name = before_end(topic.type, "_Event");
  const auto type = playing_.bus.registry().service(type_name);
  if (!type) {
    unknown_.push_back(topic.name + " (" + (type_name.empty() ? topic.type : type_name) + ')');
    return {};
  }
  const Schema schema(topic.definition);
  for (const bus::MessageType* part : {(*type)->request, (*type)->response})
    if (const std::string found = schema.difference_of_part(*part); !found.empty())
      return differs(topic, type_name, found);
  if (topic.events == 0) {
    leave_out(topic, "its events are without what was sent: service introspection was 'metadata', expected 'contents'");
    return {};
  }
  auto part = make_service_part(playing_, name, **type, topic.events);
  if (Status s = part->open(); !s) return s;
  add(std::move(part), {place});
  return {};
}

Status BagServer::make_actions() {
  for (const ActionOfBag& action : actions_) {
    const Topic& first = recording_.topics()[action.places.front()];
    if (action.type.empty()) {
      leave_out(first,
                "the bag does not tell the type of the action: neither its feedback nor its goals were recorded");
      continue;
    }
    const auto type = playing_.bus.registry().action(action.type);
    if (!type) {
      unknown_.push_back(action.name + " (" + action.type + ')');
      continue;
    }
    for (const std::size_t place : action.places) {
      const Topic& topic = recording_.topics()[place];
      const Schema schema(topic.definition);
      for (const bus::MessageType* part : {(*type)->goal, (*type)->result, (*type)->feedback})
        if (const std::string found = schema.difference_of_part(*part); !found.empty())
          return differs(topic, action.type, found);
    }
    auto part = make_action_part(playing_, action.name, **type, action.topics);
    if (Status s = part->open(); !s) return s;
    add(std::move(part), action.places);
  }
  return {};
}

void BagServer::add(std::unique_ptr<Part> part, const std::vector<std::size_t>& places) {
  for (const std::size_t place : places) part_of_[place] = part.get();
  parts_.push_back(std::move(part));
}

// --- Playing

SimTime end_of(const Recording& recording, const BagSpec& spec) {
  const SimTime first = first_played(recording, spec);
  return time_in_run(std::max(recording.last(), first), first, spec);
}

Status BagServer::advance() {
  auto found = recording_.next();
  if (!found) return found.error();
  next_ = *found;
  return {};
}

/// To the first message that is played; topics that keep their last message hold it.
Status BagServer::skip() {
  std::vector<bool> wanted;
  for (const Part* part : part_of_) wanted.push_back(part != nullptr);
  if (std::ranges::find(wanted, true) == wanted.end()) return {};
  recording_.begin(std::move(wanted));
  if (Status s = advance(); !s) return s;
  while (next_ && next_->t < playing_.first) {
    part_of_[next_->topic]->hold(next_->bytes);
    if (Status s = advance(); !s) return s;
  }
  return {};
}

void BagServer::report() {
  std::map<std::string, std::size_t> played;
  for (const auto& part : parts_) {
    const std::string why = part->why_left_out();
    if (why.empty()) {
      ++played[part->noun()];
      continue;
    }
    left_out_.push_back(part->name() + " (" + why + ')');
    part->keep_quiet();
  }
  std::string text =
      recording_.name() + ": " + std::to_string(recording_.messages()) + " messages in " +
      seconds_of_bag(recording_.messages() > 0 ? recording_.last() - recording_.first() : SimTime::zero()) + " s; ";
  std::string what;
  for (const auto& [noun, count] : played)
    what += (what.empty() ? "" : ", ") + std::to_string(count) + ' ' + noun + (count == 1 ? "" : "s");
  text += what.empty() ? "nothing of it is played"
                       : what + (played.size() == 1 && played.begin()->second == 1 ? " is" : " are") + " played";
  if (!left_out_.empty()) text += "; left out: " + listed(left_out_);
  if (filtered_ > 0) text += "; " + std::to_string(filtered_) + " by the filters";
  playing_.log(false, text);
  if (!unknown_.empty())
    playing_.warn(recording_.name() + ": left out, because no package of this run has the type: " + listed(unknown_));
  for (const std::string& warning : recording_.warnings()) playing_.warn(warning);
  if (recording_.messages() == 0 || recording_.last() < playing_.first)
    playing_.warn(recording_.name() + ": the bag has no message after its start at " + general_text(spec_.start_s, 9) +
                  " s");
}

Status BagServer::sense(SimTime now) {
  ++playing_.turn;
  if (!std::exchange(reported_, true)) report();
  begun_ = begun_ || now >= begins();
  if (!begun_) return {};
  while (next_ && next_due() <= now) {
    const RecordedMessage& message = *next_;
    if (Status s = part_of_[message.topic]->take(recording_.topics()[message.topic], message.bytes); !s)
      return recording_.at(message, s.error());
    if (Status s = advance(); !s) return s;
  }
  for (const auto& part : parts_)
    if (Status s = part->tend(); !s) return s;
  return {};
}

Status BagServer::act(SimTime) {
  playing_.bus.deliver(playing_.self);
  return {};
}

SimTime BagServer::begins() const { return from_seconds(spec_.offset_s); }

SimTime BagServer::next_due() const {
  if (!begun_ && !parts_.empty()) return begins();  // with what topics hold from before
  return next_ ? time_in_run(next_->t, playing_.first, spec_) : kNever;
}

std::vector<std::string> BagServer::warnings() const {
  std::vector<std::string> all = playing_.warnings;
  for (const auto& part : parts_) part->open_ends(all);
  return all;
}

}  // namespace cxlab::bag
