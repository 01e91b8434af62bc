#include "lab/packages.h"

#include <filesystem>

#include "cx/base/file.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

Expected<std::map<std::string, std::string>> named_packages(const std::vector<std::string>& named) {
  std::map<std::string, std::string> packages;
  for (const std::string& text : named) {
    const std::size_t at = text.find('=');
    if (at == std::string::npos || at == 0 || at + 1 == text.size())
      return usage_error("--package: " + found_text(text, "NAME=DIR"));
    const std::string folder = text.substr(at + 1);
    if (!is_folder(folder)) return input_error("--package " + text + ": there is no folder " + folder);
    packages[text.substr(0, at)] = fs::absolute(folder).lexically_normal().string();
  }
  return packages;
}

Expected<std::map<std::string, std::string>> installed_packages(const std::vector<std::string>& prefixes) {
  std::vector<std::string> all;
  for (const std::string& prefix : prefixes) all.push_back(fs::absolute(prefix).lexically_normal().string());
  for (std::string& prefix : default_prefixes()) all.push_back(std::move(prefix));
  auto packages = packages_below(all);
  if (packages) packages->merge(own_packages());
  return packages;
}

Expected<std::map<std::string, std::string>> find_packages(const PackageOptions& options) {
  auto packages = named_packages(options.named);
  if (!packages) return packages;
  auto installed = installed_packages(options.prefixes);
  if (!installed) return installed;
  packages->merge(*installed);
  return packages;
}

}  // namespace cxlab::lab
