#include "cx/bag/part.h"
#include "cx/bus/transforms.h"

namespace cxlab::bag {

namespace {

class TopicPart final : public Part {
 public:
  TopicPart(Playing& playing, const std::string& name, const bus::MessageType& type, bool own, bool latched)
      : Part(playing, name), type_(type), own_(own), latched_(latched), always_heard_(bus::is_kept_topic(name, type)) {}

  const char* noun() const override { return "topic"; }

  std::string why_left_out() override {
    if (own_) return {};
    for (const bus::ParticipantId p : playing_.bus.providers(bus::NameKind::kTopic, name_))
      if (p != playing_.self && std::ranges::find(playing_.beside, p) == playing_.beside.end())
        return playing_.bus.described(p) + " publishes it in this run";
    return {};
  }

  Status take(const Topic&, std::string_view bytes) override {
    look();
    if (!why_.empty()) {
      note_left_out(why_);
      return {};
    }
    if (heard_) return publish(bytes);
    hold(bytes);
    return {};
  }

  void hold(std::string_view bytes) override {
    if (latched_) held_ = bytes;
  }

  Status tend() override {
    if (held_.empty()) return {};
    look();
    if (!heard_ || !why_.empty()) return {};
    return publish(std::exchange(held_, {}));
  }

 private:
  /// Who is there does not change while the bag plays a tick.
  void look() {
    if (turn_ == playing_.turn) return;
    turn_ = playing_.turn;
    why_ = why_left_out();
    heard_ = always_heard_ || !playing_.bus.users(bus::NameKind::kTopic, name_).empty();
  }

  Status publish(std::string_view bytes) {
    auto message = bus::read_cdr(type_, bytes);
    if (!message) return message.error();
    if (!publisher_) {
      auto made = playing_.bus.advertise(playing_.self, name_, type_);
      if (!made) return made.error();
      publisher_ = *made;
    }
    held_.clear();
    playing_.bus.publish(*publisher_, std::make_shared<const bus::Message>(*std::move(message)));
    return {};
  }

  const bus::MessageType& type_;
  bool own_, latched_, always_heard_, heard_ = false;
  std::uint64_t turn_ = 0;
  std::string why_, held_;
  std::optional<bus::EndpointId> publisher_;
};

}  // namespace

std::unique_ptr<Part> make_topic_part(Playing& playing, const std::string& name, const bus::MessageType& type, bool own,
                                      bool latched) {
  return std::make_unique<TopicPart>(playing, name, type, own, latched);
}

}  // namespace cxlab::bag
