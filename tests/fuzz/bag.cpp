// MCAP files, messages as CDR, and a whole bag that is played to an agent which uses all of it. A message that is read
// is the same after it was written and read again, and messages come in order of time.

#include "cx/bag/bag_server.h"
#include "cx/bag/recording.h"
#include "cx/bus/cdr.h"
#include "cx/journal/journal.h"
#include "cx/mcap/mcap_reader.h"
#include "cx/mcap/records.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/types.h"

namespace fuzz_bag {
namespace {

using namespace cxlab;

std::string cdr_of(const bus::Message& message) {
  std::string bytes;
  bus::CdrWriter(bytes).message(message);
  return bytes;
}

void read_message(const std::string& type_name, std::string_view bytes) {
  const auto type = fuzz::types().message(type_name);
  if (!type) return;
  const auto message = bus::read_cdr(**type, bytes);
  if (!message) return;
  const std::string written = cdr_of(*message);
  const auto again = bus::read_cdr(**type, written);
  fuzz::promise(again.ok() && cdr_of(*again) == written, "a message comes back from its CDR");
}

void read_file(const std::string& bytes) {
  auto file = mcap::Reader::from_bytes(bytes, "bag");
  fuzz::promise(file.ok(), "the magic is right");
  for (;;) {
    const auto message = file->next();
    if (!message || !*message) break;
    if ((*message)->channel->schema) read_message((*message)->channel->schema->name, (*message)->bytes);
  }
  const auto end = file->next();
  fuzz::promise(end.ok() && !*end, "there is nothing behind the end, or an error");
}

/// Subscribes to every topic, calls every service and sends a goal to every action of the bag whose type is known.
void use_all(bus::Bus& bus, bus::ParticipantId agent, const std::vector<bag::Topic>& topics) {
  for (const bag::Topic& topic : topics)
    if (const auto type = fuzz::types().message(topic.type)) (void)bus.subscribe(agent, topic.name, **type, {});
  for (const auto& info : bus.services())
    if (const auto type = fuzz::types().service(info.type))
      if (const auto client = bus.create_client(agent, info.name, **type, [](const bus::Delivery&) {}))
        bus.call(*client, std::make_shared<bus::Message>(*(*type)->request));
  for (const auto& info : bus.actions())
    if (const auto type = fuzz::types().action(info.type))
      if (const auto client = bus.create_action_client(agent, info.name, **type, {}))
        bus.cancel_goal(*client, bus.send_goal(*client, std::make_shared<bus::Message>(*(*type)->goal)));
}

void play(const std::string& bytes) {
  auto recording = bag::Recording::from_bytes(bytes, "bag");
  if (!recording) return;
  recording->begin({});
  std::uint64_t messages = 0;
  for (SimTime last{}; const auto message = recording->next(); ++messages) {
    if (!*message) break;
    fuzz::promise((*message)->t >= last, "messages come in order of time");
    last = (*message)->t;
  }
  fuzz::promise(messages == recording->messages(), "all messages come");
  const std::vector<bag::Topic> topics = recording->topics();
  Journal journal;
  bus::Bus bus(fuzz::types(), journal);
  bag::BagSetup setup{
      .spec = {}, .recording = *std::move(recording), .managers = {"/m"}, .log = [](bool, const std::string&) {}};
  const auto server = bag::BagServer::create(std::move(setup), bus, journal);
  if (!server) return;
  const auto agent = bus.join(bus::ParticipantKind::kEnvironment, {"agent", "/", {}}, journal.open_stream("agent"));
  use_all(bus, agent, topics);
  constexpr int kTicks = 100;
  for (int tick = 0; tick < kTicks && (*server)->next_due() != kNever; ++tick) {
    bus.begin_tick((*server)->next_due());
    if (!(*server)->sense(bus.now())) break;
    bus.deliver(agent);
    (void)(*server)->act(bus.now());
  }
  (void)(*server)->warnings();
}

}  // namespace

FUZZ_TARGET(bag) {
  if (size == 0) return 0;
  const std::string text = fuzz::text_of(data + 1, size - 1);
  const char* names[] = {"every/msg/Kind", "rcll_interfaces/msg/MachineInfo", "visualization_msgs/msg/Marker",
                         "example_interfaces/msg/WString"};
  if (data[0] % 2 == 0) read_message(names[data[0] / 2 % 4], text);
  const std::string bytes = std::string(mcap::kMagic, mcap::kMagicSize) + text;
  read_file(bytes);
  play(bytes);
  return 0;
}

}  // namespace fuzz_bag
