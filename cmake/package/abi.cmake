# Writes `out`: the version and one digest over the headers that plugins are compiled with. A library that was built with
# others is refused when it is opened.
file(READ "${list}" headers)
set(digests "")
foreach(header IN LISTS headers)
  file(SHA256 "${header}" digest)
  string(APPEND digests "${digest}\n")
endforeach()
string(SHA256 digest "${digests}")
string(SUBSTRING "${digest}" 0 12 digest)
file(CONFIGURE OUTPUT "${out}" @ONLY CONTENT [[
#pragma once
// Made by cmake/package/abi.cmake.

namespace cxlab::cx {

/// Version of cxlab, and a digest of the headers that plugins are compiled with.
inline constexpr const char* kPluginAbi = "@version@ (headers @digest@)";

}  // namespace cxlab::cx
]])
