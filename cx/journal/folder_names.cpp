#include "cx/journal/folder_names.h"

#include <algorithm>

#include "cx/base/record_sink.h"

namespace cxlab {

namespace {

bool is_part_of_a_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
}

/// Of one value of `RecordData`'s MessagePack: bytes of its head, and of the text that follows.
struct Extent {
  std::size_t head = 1;
  std::size_t text = 0;
  bool is_text = false;
};

Extent extent(std::string_view rest) {
  const auto tag = static_cast<std::uint8_t>(rest.front());
  if (tag >= 0xa0 && tag < 0xc0) return {1, static_cast<std::size_t>(tag & 0x1f), true};
  switch (tag) {
    case 0xdb: {
      std::size_t size = 0;
      for (std::size_t i = 1; i <= 4 && i < rest.size(); ++i) size = size << 8 | static_cast<std::uint8_t>(rest[i]);
      return {5, size, true};
    }
    case 0xd2:
    case 0xdd:
    case 0xdf: return {5, 0, false};
    case 0xde: return {3, 0, false};
    case 0xcb:
    case 0xcf:
    case 0xd3: return {9, 0, false};
    default: return {};
  }
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
  for (std::string_view rest = bytes; !rest.empty();) {
    const Extent e = extent(rest);
    const std::size_t size = std::min(e.head + e.text, rest.size());
    if (e.is_text && e.head < size && in_text(rest.substr(e.head, size - e.head), renamed)) {
      any = true;
      text.begin().value(std::string_view(renamed));
      out.append(text.bytes().substr(3));  // without the map around it
    } else {
      out.append(rest.substr(0, size));
    }
    rest.remove_prefix(size);
  }
  return any;
}

}  // namespace cxlab
