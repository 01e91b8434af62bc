#include "lab/new_package.h"

#include <openssl/evp.h>

#include <filesystem>
#include <utility>
#include <vector>

#include "cx/base/file.h"
#include "cx/plugins/bindings/names.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

bool is_letter(char c) { return c >= 'a' && c <= 'z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The name nearest to `text` that a package can have.
std::string nearest_name(std::string_view text) {
  std::string name;
  for (char c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (is_letter(c) || (is_digit(c) && !name.empty()))
      name += c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

/// A package is named as ROS 2 wants it, so that the project can go there: lower case, no '_' at an end or twice in a
/// row. Empty if that name can be had, else why not.
std::string objection(const std::string& name) {
  const std::string nearest = nearest_name(name);
  if (name != nearest)
    return "its last part names the package: " +
           found_text(name, "lower-case letters, digits and single '_', a letter first" +
                                (nearest.empty() ? "" : ", as in '" + nearest + "'"));
  if (name == "null") return "its last part names the package: found 'null', which is no name in YAML";
  std::error_code error;
  if (fs::is_directory(find_share().interfaces / name, error) || own_packages().contains(name))
    return "its last part names the package: '" + name + "' comes with cxlab, expected a name of its own";
  return {};
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

using Replacements = std::vector<std::pair<std::string, std::string>>;

/// Copies the files of a template, with each of the replacements made.
Status copy_template(const fs::path& origin, const fs::path& to, const Replacements& replacements) {
  std::error_code error;
  if (!fs::is_directory(origin, error)) return resource_error("the files to begin from are missing", origin.string());
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(origin)) {
    const fs::path file = to / entry.path().lexically_relative(origin);
    if (entry.is_directory()) {
      fs::create_directories(file, error);
      continue;
    }
    auto text = read_file(entry.path());
    if (!text) return text.error();
    for (const auto& [from, into] : replacements) replace_all(*text, from, into);
    if (Status s = write_file(file, *text); !s) return s.error();
  }
  return {};
}

/// As sha256sum prints it.
std::string sha256_of(std::string_view bytes) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  EVP_Digest(bytes.data(), bytes.size(), digest, &size, EVP_sha256(), nullptr);
  std::string out;
  for (unsigned int i = 0; i < size; ++i) {
    constexpr char kDigits[] = "0123456789abcdef";
    out += {kDigits[digest[i] >> 4], kDigits[digest[i] & 15]};
  }
  return out;
}

/// Why the pipelines cannot use this tarball; empty if they can.
std::string objection(const NewPackage::Tarball& tarball) {
  if (tarball.address.find_first_of(" \t\r\n") != std::string::npos)
    return "the address of the tarball: " + found_text(tarball.address, "one without blanks");
  const bool is_hash =
      tarball.sha256.size() == 64 && tarball.sha256.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (!tarball.sha256.empty() && !is_hash)
    return "the SHA-256 of the tarball: " +
           found_text(tarball.sha256, "64 hexadecimal digits, as sha256sum prints them");
  if (const auto file = read_file(tarball.address); file && !tarball.sha256.empty())
    if (const std::string hash = sha256_of(*file); hash != tarball.sha256)
      return "the SHA-256 of the tarball: " + found_text(tarball.sha256, hash + ", the one of " + tarball.address);
  return {};
}

}  // namespace

Status make_package(const NewPackage& package, const std::string& folder) {
  fs::path path = fs::absolute(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // "DIR/"
  const std::string name = path.filename().string();
  if (const std::string why = objection(name); !why.empty()) return usage_error(why, folder);
  if (package.continuous)
    if (const std::string why = objection(*package.continuous); !why.empty()) return usage_error(why);
  std::error_code error;
  if (fs::exists(path, error) && !(fs::is_directory(path, error) && fs::is_empty(path, error)))
    return usage_error("exists already and is not an empty folder", folder);
  fs::create_directories(path, error);
  if (error) return resource_error(error.message(), folder);

  const NewPackage::Tarball tarball = package.continuous.value_or(NewPackage::Tarball{});
  // A repository names no place of this machine: ci/get_cxlab.sh unpacks cxlab there.
  const std::string scenarios = package.continuous ? ".cxlab/share/cxlab/scenarios" : find_share().scenarios.string();
  const Replacements replacements{{"{scenarios}", scenarios},
                                  {"{address}", tarball.address},
                                  {"{sha256}", tarball.sha256},
                                  {"my_" + package.kind, name},
                                  {cx::camel_case("my_" + package.kind), cx::camel_case(name)}};
  const std::string own = package.variant.empty() ? package.kind : package.kind + '_' + package.variant;
  std::vector<std::string> origins{own};
  if (package.continuous) origins.insert(origins.end(), {"ci", own + "_ci"});
  for (const std::string& origin : origins)
    if (Status s = copy_template(find_share().docs / "templates" / origin, path, replacements); !s) return s;
  return {};
}

}  // namespace cxlab::lab
