#include "cx/journal/folder_names.h"

#include <algorithm>

#include "cx/base/record_sink.h"
#include "cx/journal/record_items.h"

namespace cxlab {

namespace {

bool is_part_of_a_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
}

}  // namespace

void FolderNames::add(const std::string& folder, const std::string& name) {
  if (folder.size() < 2 || folder.front() != '/') return;
  for (const auto& known : names_)
    if (known.first == folder) return;
  names_.emplace_back(folder, name);
  std::stable_sort(names_.begin(), names_.end(),
                   [](const auto& a, const auto& b) { return a.first.size() > b.first.size(); });
}

const std::pair<std::string, std::string>* FolderNames::find(std::string_view text, std::size_t slash) const {
  if (slash > 0 && is_part_of_a_name(text[slash - 1])) return nullptr;
  for (const auto& name : names_) {
    const std::size_t end = slash + name.first.size();
    if (text.substr(slash).starts_with(name.first) && (end == text.size() || !is_part_of_a_name(text[end])))
      return &name;
  }
  return nullptr;
}

bool FolderNames::in_text(std::string_view text, std::string& out) const {
  out.clear();
  std::size_t done = 0;
  for (std::size_t at = text.find('/'); at != std::string_view::npos; at = text.find('/', at)) {
    const auto* name = find(text, at);
    if (name == nullptr) {
      ++at;
      continue;
    }
    out.append(text.substr(done, at - done)).append(name->second);
    done = at += name->first.size();
  }
  out.append(text.substr(done));
  return done > 0;
}

bool FolderNames::rewrite(std::string_view bytes, std::string& out) const {
  // Most records hold none: look at the slashes before anything is copied. Heads of texts are no part of names, but one
  // may look like it: the exact test follows.
  const auto may_begin = [&](std::size_t at) {
    return std::any_of(names_.begin(), names_.end(),
                       [&](const auto& name) { return bytes.substr(at).starts_with(name.first); });
  };
  std::size_t slash = bytes.find('/');
  while (slash != std::string_view::npos && !may_begin(slash)) slash = bytes.find('/', slash + 1);
  if (slash == std::string_view::npos) return false;

  RecordData text;
  std::string renamed;
  bool any = false;
  out.clear();
  for (ItemReader in(bytes); !in.at_end();) {
    const std::size_t begin = in.position();
    const Item item = in.next();
    if (item.type == ItemType::kText && in_text(item.text, renamed)) {
      any = true;
      text.begin().value(std::string_view(renamed));
      out.append(text.bytes().substr(3));  // without the map around it
    } else {
      out.append(bytes.substr(begin, in.position() - begin));
    }
    if (item.type == ItemType::kBad) return false;  // no record is
  }
  return any;
}

}  // namespace cxlab
