#include "lab/file_names.h"

#include "lab/packages.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kScheme = "://";

fs::path plain(const fs::path& path) {
  const fs::path out = fs::absolute(path).lexically_normal();
  return out.has_filename() ? out : out.parent_path();
}

/// `file` from `folder`, which it lies in; else empty.
std::string below(const fs::path& folder, const fs::path& file) {
  const std::string relative = file.lexically_relative(folder).generic_string();
  return relative.empty() || relative == "." || relative.starts_with("..") ? std::string() : relative;
}

}  // namespace

std::string name_from(const fs::path& folder, const fs::path& file) {
  const fs::path from = plain(folder), to = plain(file);
  const auto first_of = [](const fs::path& path) {  // below the root
    const auto first = std::next(path.begin());
    return first == path.end() ? fs::path() : *first;
  };
  const bool related = !first_of(from).empty() && first_of(from) == first_of(to);
  return (related ? to.lexically_relative(from) : to).generic_string();
}

FileNames::FileNames(const fs::path& scenario) : home_(plain(scenario).parent_path()) {
  const Share share = find_share();
  for (const auto& [name, folder] : {std::pair("interfaces", share.interfaces),
                                     {"models", share.models},
                                     {"packages", share.packages},
                                     {"scenarios", share.scenarios},
                                     {"engines", share.engines}})
    if (!folder.empty()) roots_["cxlab" + std::string(kScheme) + name + '/'] = plain(folder);
}

void FileNames::use_packages(const Scenario& scenario) {
  const auto use = [this](const std::map<std::string, std::string>& packages) {
    for (const auto& [name, folder] : packages)
      roots_.try_emplace("package" + std::string(kScheme) + name + '/', plain(folder));
  };
  for (const AgentSpec& agent : scenario.agents) use(scenario.shares(agent));
  if (const auto installed = installed_packages({})) use(*installed);
}

std::string FileNames::name_of(const fs::path& file) const {
  const fs::path path = plain(file);
  std::string shortest;
  const std::string* of = nullptr;
  for (const auto& [beginning, folder] : roots_) {
    const std::string rest = below(folder, path);
    if (!rest.empty() && (!of || rest.size() < shortest.size())) {
      shortest = rest;
      of = &beginning;
    }
  }
  if (of) return *of + shortest;
  return name_from(home_, path);
}

fs::path FileNames::path_of(const std::string& name) const {
  const std::size_t scheme = name.find(kScheme);
  if (scheme == name.npos) return (home_ / name).lexically_normal();
  const std::size_t end = name.find('/', scheme + kScheme.size());
  const auto root = roots_.find(name.substr(0, end == name.npos ? end : end + 1));
  return root == roots_.end() ? fs::path() : root->second / name.substr(end + 1);
}

}  // namespace cxlab::lab
