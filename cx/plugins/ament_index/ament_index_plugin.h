#pragma once

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// cx::AmentIndexPlugin: docs/plugins/ament_index.md.
PluginType ament_index_plugin();

}  // namespace cxlab::cx
