#include "lab/interfaces.h"

#include <algorithm>
#include <sstream>

#include "cx/base/file.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

Expected<Interfaces> Interfaces::load(const std::map<std::string, std::string>& packages) {
  Interfaces out;
  const fs::path own = find_share().interfaces;
  if (Status s = out.registry_.add_packages_in(own); !s) return s.error();
  for (const std::string& name : out.registry_.packages()) out.folders_[name] = {own / name};
  for (const auto& [name, folder] : packages) {
    if (!bus::holds_definitions(folder)) continue;
    if (Status s = out.registry_.add_package(name, folder); !s) return s.error();
    auto& folders = out.folders_[name];
    folders.insert(folders.begin(), folder);
  }
  return out;
}

std::vector<std::string> Interfaces::names() const {
  std::vector<std::string> out;
  for (const std::string& package : registry_.packages())
    for (std::string& name : registry_.interfaces(package)) out.push_back(std::move(name));
  return out;
}

Expected<std::string> Interfaces::show(const std::string& name) {
  std::string full = name, out;
  if (const std::size_t slash = full.find('/'); slash != full.npos && full.find('/', slash + 1) == full.npos)
    full.insert(slash, "/msg");
  const std::vector<std::string> known = names();
  if (std::ranges::find(known, full) == known.end())
    return input_error("there is no interface '" + name + "'" + did_you_mean(full, known));
  if (Status s = append(full, "", out); !s) return s.error();
  return out;
}

Status Interfaces::append(const std::string& name, const std::string& indent, std::string& out) {
  const std::size_t first = name.find('/'), second = name.find('/', first + 1);
  const std::string kind = name.substr(first + 1, second - first - 1);
  std::vector<const bus::MessageType*> sections;
  Status status;
  const auto take = [&](auto found, auto... parts) {
    if (found)
      (sections.push_back((**found).*parts), ...);
    else
      status = found.error();
  };
  if (kind == "srv")
    take(registry_.service(name), &bus::ServiceType::request, &bus::ServiceType::response);
  else if (kind == "action")
    take(registry_.action(name), &bus::ActionType::goal, &bus::ActionType::result, &bus::ActionType::feedback);
  else if (auto message = registry_.message(name); message)
    sections.push_back(*message);
  else
    status = message.error();
  if (!status) return status;

  fs::path file;
  for (const fs::path& folder : folders_[name.substr(0, first)])
    if (file = folder / kind / (name.substr(second + 1) + '.' + kind); is_file(file)) break;
  auto text = read_file(file);
  if (!text) return text.error();
  if (text->starts_with("\xef\xbb\xbf")) text->erase(0, 3);  // byte order mark
  std::istringstream lines(*text);
  std::size_t section = 0;
  for (std::string line; std::getline(lines, line);) {
    std::string code = line.substr(0, line.find('#'));
    code.erase(code.find_last_not_of(" \t\r") + 1);
    if (code == "---" && section + 1 < sections.size()) ++section;
    if (!indent.empty()) line = code;  // a nested type without its comments
    if (indent.empty() || !line.empty()) out += indent + line + '\n';
    std::istringstream words(code);
    std::string type, field_name;
    words >> type >> field_name;
    const bus::Field* field = sections[section]->find(field_name);
    if (field && field->nested)
      if (status = append(field->nested->name(), indent + '\t', out); !status) return status;
  }
  return {};
}

}  // namespace cxlab::lab
