#include <deque>
#include <optional>

#include "cx/bag/part.h"

namespace cxlab::bag {

namespace {

/// The k-th call of this run gets the k-th answer of the recording, when it came there, or at once where that time has
/// passed.
class ServicePart final : public Part {
 public:
  ServicePart(Playing& playing, const std::string& name, const bus::ServiceType& type, std::uint8_t events)
      : Part(playing, name), type_(type), kinds_(events) {}

  const char* noun() const override { return "service"; }

  std::string why_left_out() override {
    std::string why;
    const Role role = role_of(bus::NameKind::kService, why);
    if (role == Role::kServer && !kinds_.has_responses) why = "the bag has no responses of it";
    if (role == Role::kClient && !kinds_.has_requests) why = "the bag has no requests of it";
    return why;
  }

  Status open() override {
    if (!kinds_.has_responses) return {};
    auto made = playing_.bus.serve(
        playing_.self, name_, type_, [this](const bus::Delivery& call) { on_call(call); }, bus::Bus::Rank::kStandIn);
    if (!made) return made.error();
    server_ = *made;
    return {};
  }

  Status take(const Topic&, std::string_view bytes) override {
    std::string why;
    const Role role = role_of(bus::NameKind::kService, why);
    if (role == Role::kNone) {
      note_left_out(why);
      return {};
    }
    bus::Message request(*type_.request), response(*type_.response);
    const auto event = read_service_event(
        bytes, [&](bus::CdrReader& in) { in.message(request.view()); },
        [&](bus::CdrReader& in) { in.message(response.view()); });
    if (!event) return event.error();
    if (event->kind == kinds_.request && event->has_request) {
      auto shared = std::make_shared<const bus::Message>(std::move(request));
      if (role == Role::kClient) return call(std::move(shared));
      add({event->client, event->number, std::move(shared)});
    } else if (event->kind == kinds_.response && event->has_response && role == Role::kServer) {
      Exchange* exchange = asked(*event);
      if (!exchange) exchange = &add({event->client, event->number, nullptr});
      exchange->response = std::make_shared<const bus::Message>(std::move(response));
      answer();
    }
    return {};
  }

  void open_ends(std::vector<std::string>& warnings) const override {
    const auto open = static_cast<std::size_t>(
        std::ranges::count_if(exchanges_, [](const Exchange& e) { return e.call.has_value(); }));
    if (const std::size_t calls = calls_.size() + open; calls > 0)
      warnings.push_back(name_ + ": " + std::to_string(calls) +
                         (calls == 1 ? " call of this run has" : " calls of this run have") +
                         " no response in the bag");
  }

 private:
  /// A request of the recording, and the call of this run that gets its response.
  struct Exchange {
    std::string client;
    std::int64_t number = 0;
    bus::SharedMessage request, response = nullptr;
    std::optional<bus::Delivery> call = {};
  };

  Status call(bus::SharedMessage request) {
    if (!client_) {
      auto made = playing_.bus.create_client(playing_.self, name_, type_, [](const bus::Delivery&) {});
      if (!made) return made.error();
      client_ = *made;
    }
    playing_.bus.call(*client_, std::move(request));
    return {};
  }

  Exchange& add(Exchange exchange) {
    exchanges_.push_back(std::move(exchange));
    if (!calls_.empty()) {
      bind(exchanges_.back(), calls_.front());
      calls_.pop_front();
    }
    return exchanges_.back();
  }

  /// The exchange that this response belongs to.
  Exchange* asked(const ServiceEvent& event) {
    const auto open = [](const Exchange& e) { return !e.response; };
    auto found = std::ranges::find_if(
        exchanges_, [&](const Exchange& e) { return open(e) && e.client == event.client && e.number == event.number; });
    if (found == exchanges_.end() && kinds_.of_two_sides()) found = std::ranges::find_if(exchanges_, open);
    return found == exchanges_.end() ? nullptr : &*found;
  }

  void on_call(const bus::Delivery& call) {
    const auto open = std::ranges::find_if(exchanges_, [](const Exchange& e) { return !e.call; });
    if (open == exchanges_.end()) {
      calls_.push_back(call);
      return;
    }
    bind(*open, call);
    answer();
  }

  void bind(Exchange& exchange, const bus::Delivery& call) {
    exchange.call = call;
    ++bound_;
    if (differs_ || !exchange.request || exchange.request->view().equals(call.message->view())) return;
    differs_ = true;
    playing_.warn(name_ + ": call " + std::to_string(bound_) + " of this run is not that of the recording: found " +
                  call.message->view().to_string() + ", recorded " + exchange.request->view().to_string() +
                  "; it gets the recorded response");
  }

  void answer() {
    std::erase_if(exchanges_, [this](const Exchange& e) {
      return e.call && e.response && playing_.bus.respond(server_, *e.call, e.response);
    });
  }

  const bus::ServiceType& type_;
  EventKinds kinds_;
  bus::EndpointId server_{};
  std::optional<bus::EndpointId> client_;
  std::deque<Exchange> exchanges_;   ///< without a response, or without a call yet
  std::deque<bus::Delivery> calls_;  ///< that came before their request in the recording
  std::size_t bound_ = 0;
  bool differs_ = false;
};

}  // namespace

std::unique_ptr<Part> make_service_part(Playing& playing, const std::string& name, const bus::ServiceType& type,
                                        std::uint8_t events) {
  return std::make_unique<ServicePart>(playing, name, type, events);
}

}  // namespace cxlab::bag
