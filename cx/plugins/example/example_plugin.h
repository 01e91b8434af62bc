#pragma once

#include "cx/executive/plugin.h"

namespace cxlab::cx {

/// cx::ExamplePlugin: docs/plugins/example.md.
PluginType example_plugin();

}  // namespace cxlab::cx
