#include "cx/engine/version.h"

#include <clips_ns/clips.h>

namespace cxlab {

namespace {

std::string trimmed(const std::string& banner) {
  const auto begin = banner.find_first_not_of(" \n"), end = banner.find_last_not_of(" \n");
  return begin == std::string::npos ? std::string() : banner.substr(begin, end + 1 - begin);
}

/// The banner of the library in this process; BANNER_STRING is that of the headers.
std::string library_banner() {
  std::string banner;
  clips::Environment* env = clips::CreateEnvironment();
  if (env == nullptr) return banner;
  clips::AddRouter(
      env, "version", 40, [](clips::Environment*, const char*, void*) { return true; },
      [](clips::Environment*, const char*, const char* text, void* out) { *static_cast<std::string*>(out) += text; },
      nullptr, nullptr, nullptr, &banner);
  clips::PrintBanner(env);
  clips::DestroyEnvironment(env);
  return banner;
}

}  // namespace

std::string clips_version() { return trimmed(BANNER_STRING) + ", version " + VERSION_STRING; }

Status check_clips_library() {
  static const std::string found = trimmed(library_banner());
  const std::string expected = trimmed(BANNER_STRING);
  if (found == expected) return {};
  return resource_error(found_expected(
      "the CLIPS library '" + found + "'",
      "'" + expected + "' that cxlab was built with; $LD_LIBRARY_PATH and $LD_PRELOAD must not name another one"));
}

}  // namespace cxlab
