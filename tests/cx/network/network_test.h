#pragma once
// Hosts on a bus that write down what they take.

#include <gmock/gmock.h>

#include "cx/network/network.h"
#include "tests/support/bus_test.h"

namespace cxlab::net {

class NetworkTest : public bus::BusTest {
 protected:
  struct Listener {
    std::unique_ptr<Host> host;
    std::vector<std::string> log;
    LinkId accepted{};  ///< the last
  };

  Listener& at(bus::ParticipantId participant) {
    auto listener = std::make_unique<Listener>();
    Listener& l = *listener;
    l.host = *Host::create(network_, participant, [&l](const Event& e) {
      const std::string link = std::to_string(static_cast<int>(e.link)), bytes(e.bytes), host(e.host);
      const std::string from = host + ':' + std::to_string(e.port);
      switch (e.kind) {
        case EventKind::kDatagram: l.log.push_back(link + " gets " + bytes + " from " + from); break;
        case EventKind::kConnected: l.log.push_back(link + " is connected"); break;
        case EventKind::kAccepted:
          l.log.push_back(link + " of " + std::to_string(static_cast<int>(e.server)) + " is accepted from " + from);
          l.accepted = e.link;
          break;
        case EventKind::kBytes: l.log.push_back(link + " reads " + bytes); break;
        case EventKind::kClosed: l.log.push_back(link + " is closed: " + bytes); break;
      }
    });
    listeners_.push_back(std::move(listener));
    return l;
  }
  Listener& environment_host(const std::string& name) { return at(environment(name)); }
  Listener& node_host(const std::string& name) { return at(node(name)); }

  std::vector<std::string> take(Listener& listener) {
    bus_.deliver(listener.host->participant());
    return std::exchange(listener.log, {});
  }
  std::vector<std::string> next(Listener& listener) {
    tick();
    return take(listener);
  }

  Network network_{bus_, sink_};
  std::vector<std::unique_ptr<Listener>> listeners_;
};

using ::testing::ElementsAre;
using ::testing::IsEmpty;

}  // namespace cxlab::net
