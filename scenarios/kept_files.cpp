#include "scenarios/kept_files.h"

#include "cx/executive/files.h"
#include "scenarios/share.h"

namespace cxlab {

namespace fs = std::filesystem;

namespace {

std::string folder_of_agent(std::size_t agent) { return "agents/" + std::to_string(agent) + '/'; }

/// The file's path from that folder; empty where it lies elsewhere.
std::string inside(const fs::path& file, const fs::path& folder) {
  const fs::path relative = fs::absolute(file).lexically_normal().lexically_relative(folder);
  return relative.empty() || *relative.begin() == ".." ? std::string() : relative.generic_string();
}

}  // namespace

Expected<KeptFiles> KeptFiles::create(const fs::path& run_folder, std::vector<Shares> shares, const Shares& packages,
                                      FileRead file_read) {
  KeptFiles files;
  files.file_read_ = std::move(file_read);
  for (const auto& [name, folder] : packages) files.packages_[folder] = name;
  for (const Shares& of_agent : shares)
    for (const auto& [name, folder] : of_agent) files.packages_[folder] = name;
  files.shares_ = std::move(shares);
  files.own_ = own_packages();
  if (run_folder.empty()) return files;
  files.run_folder_ = fs::absolute(run_folder).lexically_normal();
  auto store = FileStore::create(run_folder);
  if (!store) return store.error();
  files.store_.emplace(*std::move(store));
  return files;
}

Status KeptFiles::keep(const std::string& name, const fs::path& file) {
  if (file_read_) file_read_(file);
  return store_ ? store_->add(name, file) : Status();
}

Status KeptFiles::keep_text(const std::string& name, const std::string& text) {
  return store_ ? store_->add_content(name, text) : Status();
}

Status KeptFiles::keep_for_agent(std::size_t agent, const fs::path& config, const fs::path& file) {
  if (!store_ && !file_read_) return {};
  const std::string folder = folder_of_agent(agent);
  if (file == config) return keep(folder + "config/" + file.filename().string(), file);
  if (store_ && !inside(file, run_folder_ / "written").empty()) return {};  // rules write it again
  bool in_package = false;
  for (const auto& [name, share] : shares_[agent]) {
    const std::string relative = inside(file, share);
    if (relative.empty()) continue;
    in_package = true;
    if (Status s = keep(folder + "packages/" + name + '/' + relative, file); !s) return s;
  }
  if (!in_package)
    for (const auto& [name, share] : own_)
      if (const std::string relative = inside(file, share); shares_[agent].contains(name) && !relative.empty())
        return keep(folder + "packages/" + name + '/' + relative, file);
  return in_package ? Status() : keep(folder + "outside/" + cx::outside_name(file).generic_string(), file);
}

Status KeptFiles::keep_interfaces(const bus::Registry& registry) {
  if (!store_ && !file_read_) return {};
  const std::vector<fs::path> files = registry.files_read();
  if (files.size() == interfaces_.size()) return {};
  for (const fs::path& file : files) {
    if (!interfaces_.insert(file).second) continue;
    fs::path folder = fs::absolute(file).parent_path().parent_path().lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();  // of a package "."
    const auto known = packages_.find(folder);
    const fs::path package = known != packages_.end() ? fs::path(known->second) : folder.filename();
    const fs::path name = "interfaces" / package / file.parent_path().filename() / file.filename();
    if (Status s = keep(name.generic_string(), file); !s) return s;
  }
  return {};
}

void read_from_copies(const fs::path& copies, std::size_t agent, cx::ManagerOptions& manager) {
  const fs::path folder = copies / folder_of_agent(agent);
  manager.config = folder / "config" / manager.config.filename();
  for (auto& [name, package] : manager.packages) package = {folder / "packages" / name, package.share};
  manager.outside_copies = folder / "outside";
}

std::string kept_name(const std::string& key, const NamedFile& file) {
  return "world/" + key + '/' + file.path.filename().string();
}

void read_from_copies(const fs::path& copies, Scenario& scenario) {
  for (auto& [key, file] : scenario.world_files) file.path = copies / kept_name(key, file);
}

fs::path interfaces_below(const fs::path& copies) { return copies / "interfaces"; }

}  // namespace cxlab
