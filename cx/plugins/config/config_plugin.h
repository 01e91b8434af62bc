#pragma once

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// cx::ConfigPlugin: docs/plugins/config.md.
PluginType config_plugin();

}  // namespace cxlab::cx
