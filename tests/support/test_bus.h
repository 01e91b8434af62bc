#pragma once
// The bus on which tests put their parts: it knows the project's own interfaces, and keeps all that is recorded.

#include <gtest/gtest.h>

#include <string>

#include "cx/bus/bus.h"
#include "tests/support/files.h"
#include "tests/support/records.h"

namespace cxlab::bus {

inline void add_interfaces(Registry& registry) {
  const Status status = registry.add_packages_in(interfaces_dir());
  ASSERT_TRUE(status.ok()) << status.error().text();
}

/// A base of what a test puts on the bus.
class TestBus {
 protected:
  TestBus() { add_interfaces(registry_); }
  ~TestBus() = default;

  /// `stream` is that of its records; the node is called so, if `node` has no name.
  ParticipantId join(ParticipantKind kind, const std::string& stream, NodeName node = {}) {
    if (node.name.empty()) node.name = stream;
    return bus_.join(kind, node, sink_.open_stream(stream));
  }

  Registry registry_;
  KeptRecords sink_;
  Bus bus_{registry_, sink_};
};

}  // namespace cxlab::bus
