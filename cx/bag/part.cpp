#include "cx/bag/part.h"

namespace cxlab::bag {

Role Part::role_of(bus::NameKind kind, std::string& why) const {
  const auto providers = playing_.bus.providers(kind, name_);
  if (providers.empty() || providers.front() == playing_.self) return Role::kServer;
  const std::string who = playing_.bus.described(providers.front());
  if (!playing_.is_agent(providers.front())) {
    why = who + " serves it in this run";
    return Role::kNone;
  }
  for (const bus::ParticipantId user : playing_.bus.users(kind, name_))
    if (playing_.is_agent(user)) {
      why = who + " serves it in this run, and " + playing_.bus.described(user) + " asks for it";
      return Role::kNone;
    }
  return Role::kClient;
}

EventKinds::EventKinds(std::uint8_t mask) {
  const auto has = [mask](unsigned kind) { return ((static_cast<unsigned>(mask) >> kind) & 1U) != 0; };
  if (has(1)) request = 1;
  if (has(2)) response = 2;
  has_requests = has(request);
  has_responses = has(response);
}

Expected<ServiceEvent> read_service_event(std::string_view bytes, const ReadPart& request, const ReadPart& response) {
  ServiceEvent event;
  bus::CdrReader in(bytes);
  std::int32_t seconds = 0;
  std::uint32_t nanoseconds = 0, count = 0;
  in.number(event.kind).number(seconds).number(nanoseconds).bytes(event.client, 16).number(event.number);
  in.size(count, 1);
  event.has_request = in.status() && count == 1;
  if (event.has_request) request(in);
  count = 0;
  in.size(count, 1);
  event.has_response = in.status() && count == 1;
  if (event.has_response) response(in);
  if (!in.status()) return in.status().error();
  return event;
}

}  // namespace cxlab::bag
