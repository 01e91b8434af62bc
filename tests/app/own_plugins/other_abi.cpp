#include <cx/executive/export_plugins.h>

extern "C" const cxlab::cx::PluginExports* cxlab_plugin_exports() {
  static const cxlab::cx::PluginExports exports{"0.0.1 (headers 000000000000)", "test::Old", nullptr};
  return &exports;
}
