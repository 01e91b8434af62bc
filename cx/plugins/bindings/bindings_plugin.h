#pragma once

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// cx::CX<Pkg><Name>Plugin for every interface that the bus knows: docs/plugins/bindings.md.
PluginType bindings_plugin();

}  // namespace cxlab::cx
