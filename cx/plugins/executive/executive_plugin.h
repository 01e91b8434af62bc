#pragma once

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// cx::ExecutivePlugin: docs/plugins/executive.md.
PluginType executive_plugin();

}  // namespace cxlab::cx
