#pragma once
// The end of a plugin library's source, once a library:
//
//   CXLAB_PLUGINS(my::Greeter, my::Bridge)      // names with their namespaces, as configurations write them

#include <array>
#include <memory>
#include <type_traits>
#include <utility>

#include "cx/executive/abi.h"
#include "cx/executive/plugin.h"

namespace cxlab::cx {

using PluginMaker = std::unique_ptr<Plugin> (*)(PluginContext);

/// The description of a library. The first member shows whether the others can be read.
struct PluginExports {
  const char* abi;          ///< `kPluginAbi` of the headers that it was built with
  const char* names;        ///< "my::Greeter, my::Bridge"
  const PluginMaker* make;  ///< one a name
};

template <class T>
std::unique_ptr<Plugin> make_exported(PluginContext context) {
  static_assert(std::is_base_of_v<Plugin, T>, "a plugin derives from cxlab::cx::Plugin");
  static_assert(!std::is_abstract_v<T>, "clips_env_init is missing");
  static_assert(std::is_constructible_v<T, PluginContext>,
                "a plugin is made from a PluginContext: using Plugin::Plugin;");
  return std::make_unique<T>(std::move(context));
}

template <class... Ts>
constexpr std::array<PluginMaker, sizeof...(Ts)> exported_makers() {
  return {&make_exported<Ts>...};
}

}  // namespace cxlab::cx

#define CXLAB_PLUGINS(...)                                                                                   \
  extern "C" __attribute__((visibility("default"))) const cxlab::cx::PluginExports* cxlab_plugin_exports() { \
    static constexpr auto make = cxlab::cx::exported_makers<__VA_ARGS__>();                                  \
    static constexpr cxlab::cx::PluginExports exports{cxlab::cx::kPluginAbi, #__VA_ARGS__, make.data()};     \
    return &exports;                                                                                         \
  }                                                                                                          \
  static_assert(true)
