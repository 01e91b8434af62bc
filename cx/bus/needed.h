#pragma once
// Checks the definitions of a run for what cxlab's own code needs. This code fills and reads fields by name, and was
// written for the definitions that come with cxlab. A package of the user may define the same types differently.

#include <filesystem>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/bus/interface.h"

namespace cxlab::bus {

/// Where the packages that come with cxlab lie. It is the same for all that a process plays, and set before that.
void set_own_definitions(const std::filesystem::path& folder);

/// Fails where the type "pkg/srv/T" of the registry lacks a field that cxlab's own definition has, or has it as another
/// type. A field with a default may be lacking. A type that cxlab does not have is never refused.
Status check_needed(Registry& registry, const std::string& name);

/// Whether a node can offer `what` ("service /n/get") of that type. If not, the registry notes it.
bool can_offer(Registry& registry, const std::string& what, const std::string& type);

// As the functions of `Registry`, but for types that were refused.
Expected<const MessageType*> needed_message(Registry& registry, const std::string& name);
Expected<const ServiceType*> needed_service(Registry& registry, const std::string& name);
Expected<const ActionType*> needed_action(Registry& registry, const std::string& name);

}  // namespace cxlab::bus
