#include "refbox_story.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/text_format.h>

namespace cxlab::rcll {

pb::MessagePtr RefboxStory::message(const std::string& type, const std::string& fields) const {
  auto made = types_->make("llsf_msgs." + type);
  EXPECT_TRUE(made) << type;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(fields, made.get())) << fields;
  return made;
}

std::shared_ptr<RefboxStory::Outcome> RefboxStory::send_goal(const std::string& action, const std::string& type,
                                                             const std::string& yaml) {
  auto outcome = std::make_shared<Outcome>();
  const bus::ActionType& known = **registry_.action(type);
  outcome->client = *bus_.create_action_client(
      agent_, action, known,
      {.goal_response = [outcome](const bus::Delivery& d) { outcome->rejected = !d.accepted; },
       .feedback = [outcome](const bus::Delivery& d) { outcome->feedback.push_back(d.message->view().to_string()); },
       .result =
           [outcome](const bus::Delivery& d) {
             outcome->ended = true;
             outcome->status = d.status;
             outcome->code = d.message->view().integer("error_code");
             outcome->text = d.message->view().to_string();
           },
       .cancel_response = [](const bus::Delivery&) {}});
  outcome->goal = bus_.send_goal(outcome->client,
                                 std::make_shared<const bus::Message>(*bus::Message::from_yaml(*known.goal, yaml)));
  return outcome;
}

std::shared_ptr<std::string> RefboxStory::listen(const std::string& topic, const std::string& type) {
  auto last = std::make_shared<std::string>();
  EXPECT_TRUE(bus_.subscribe(agent_, topic, **registry_.message(type),
                             [last](const bus::Delivery& d) { *last = d.message->view().to_string(); }));
  return last;
}

void RefboxStory::keep(Program& program, const Expected<pb::MessagePtr>& message) {
  ASSERT_TRUE(message) << message.error().message;
  program.heard.push_back({to_seconds(bus_.now()),
                           (*message)->GetDescriptor()->name(),
                           (*message)->ShortDebugString(),
                           {(*message)->New(), std::default_delete<google::protobuf::Message>()}});
  program.heard.back().message->CopyFrom(**message);
}

void RefboxStory::take(const net::Event& event) {
  const auto program = programs_.find(event.link);
  if (program == programs_.end()) return;
  if (event.kind == net::EventKind::kDatagram) {
    const auto frame = pb::read_datagram(event.bytes, program->second.crypto.get());
    ASSERT_TRUE(frame) << frame.error().message;
    return keep(program->second, types_->read(*frame));
  }
  if (event.kind != net::EventKind::kBytes) return;
  pb::StreamReader& reader = readers_[event.link];
  reader.add(event.bytes);
  for (auto frame = reader.next(); frame && *frame; frame = reader.next()) keep(program->second, types_->read(**frame));
}

}  // namespace cxlab::rcll
