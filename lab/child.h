#pragma once
// Work done in a copy of this process, which may give up its rights for it (lab/confine.h) while this one keeps them.

#include <functional>
#include <string>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "cx/base/process.h"
#include "cx/base/servant.h"
#include "lab/host.h"

namespace cxlab::lab {

class Child {
 public:
  using Work = std::function<Expected<Json>()>;
  /// This process must have one thread only.
  static Expected<Child> start(const Work& work);
  /// Waits for what the work gave, or its error. A stop that the host asks for ends the copy.
  Expected<Json> finish(const Host& host);

 private:
  Child(Descriptor results, Process process) : results_(std::move(results)), process_(std::move(process)) {}
  Descriptor results_;
  Process process_;
};

}  // namespace cxlab::lab
