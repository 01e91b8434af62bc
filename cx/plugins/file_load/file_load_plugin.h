#pragma once

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// cx::FileLoadPlugin: docs/plugins/file_load.md.
PluginType file_load_plugin();

}  // namespace cxlab::cx
