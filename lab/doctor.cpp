#include "lab/doctor.h"

#include <dlfcn.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>

#include "cx/base/process.h"
#include "cx/engine/version.h"
#include "cx/wall/wall.h"
#include "lab/versions.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;
using Verdict = Finding::Verdict;

bool loads(const char* library) {
  void* handle = dlopen(library, RTLD_LAZY | RTLD_LOCAL);
  if (!handle) return false;
  dlclose(handle);
  return true;
}

std::string gigabytes(double bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f GB", bytes / 1e9);
  return text;
}

Finding memory() {
  const double bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  const bool enough = bytes > 1e9;
  return {"memory", enough ? Verdict::kGood : Verdict::kOptional, gigabytes(bytes),
          enough ? "" : "an episode takes up to 80 MB, 250 MB with pictures; building takes 1.5 GB: use -j1"};
}

Finding disk() {
  struct statvfs info{};
  const double bytes =
      statvfs(".", &info) == 0 ? static_cast<double>(info.f_bavail) * static_cast<double>(info.f_frsize) : 0;
  const bool enough = bytes > 200e6;
  return {"disk here", enough ? Verdict::kGood : Verdict::kMissing, gigabytes(bytes) + " free",
          enough ? "" : "a run writes up to 25 MB: free some space or use --out of cxlab run"};
}

Finding writable() {
  const bool ok = access(".", W_OK) == 0;
  return {"this folder", ok ? Verdict::kGood : Verdict::kOptional, ok ? "can be written" : "cannot be written",
          ok ? "" : "use --out DIR of cxlab run, or --out none"};
}

Finding share(const char* what, const fs::path& folder) {
  std::error_code ignored;
  const bool ok = fs::is_directory(folder, ignored);
  return {what, ok ? Verdict::kGood : Verdict::kMissing, folder.string(),
          ok ? "" : "set CXLAB_SHARE to the share/cxlab folder of the installation"};
}

Finding tool(const char* program, const char* without, const char* package) {
  const bool ok = is_on_path(program);
  return {program, ok ? Verdict::kGood : Verdict::kOptional, ok ? "found" : "not found",
          ok ? "" : std::string(without) + ": apt-get install " + package};
}

Finding wall() {
  const WallParts parts = wall_parts();
  return {"wall", parts.whole() ? Verdict::kGood : Verdict::kOptional, parts.text(),
          parts.whole()
              ? ""
              : "rules are not confined by the kernel as well: play those of strangers on Linux 5.13 or newer, "
                "outside of containers that forbid it"};
}

Finding administrator() {
  const bool ok = geteuid() == 0 || is_on_path("sudo");
  return {"root or sudo", ok ? Verdict::kGood : Verdict::kOptional, ok ? "found" : "neither",
          ok ? "" : "./dev --no-install prints the packages that somebody with root rights has to install"};
}

}  // namespace

std::vector<Finding> examine_machine() {
  std::vector<Finding> findings;
  for (const auto& [name, version] : versions()) findings.push_back({name, Verdict::kGood, version, ""});
  if (const Status clips = check_clips_library(); !clips)
    findings.push_back({"CLIPS library", Verdict::kMissing, "another version", clips.error().message});
  const Share folders = find_share();
  findings.push_back(share("interfaces", folders.interfaces));
  findings.push_back(share("models", folders.models));
  findings.push_back(share("scenarios", folders.scenarios));
  findings.push_back(share("pages", folders.pages));
  const bool osmesa = loads("libOSMesa.so.8") || loads("libOSMesa.so");
  const bool egl = loads("libEGL.so.1");
  findings.push_back({"OSMesa", osmesa ? Verdict::kGood : Verdict::kOptional, osmesa ? "found" : "not found",
                      osmesa ? ""
                      : egl  ? "pictures go through EGL instead; to have OSMesa: apt-get install libosmesa6"
                             : "no pictures (--snapshot, render, --video): apt-get install libosmesa6"});
  findings.push_back(tool("ffmpeg", "no --video", "ffmpeg"));
  findings.push_back(memory());
  findings.push_back(disk());
  findings.push_back(writable());
  findings.push_back({"cores", Verdict::kGood, std::to_string(sysconf(_SC_NPROCESSORS_ONLN)), ""});
  findings.push_back(tool("cargo", "CLIPS and minijinja cannot be fetched again (a built tree goes on)", "cargo-web"));
  findings.push_back(wall());
  findings.push_back(administrator());
  return findings;
}

}  // namespace cxlab::lab
