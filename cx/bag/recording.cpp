#include "cx/bag/recording.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <fstream>

#include "cx/bag/bag_file.h"
#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/yaml/yaml.h"

namespace cxlab::bag {

namespace fs = std::filesystem;

namespace {

/// The type of a service event, if it has what was sent; CDR: a header, the type, a stamp, a client, a number, then a
/// request and a response, each there or not.
std::optional<unsigned> service_event_type(std::string_view bytes) {
  constexpr std::size_t kWithoutContent = 4 + 40 + 4 + 4, kType = 4;
  if (bytes.size() <= kWithoutContent) return std::nullopt;
  const auto type = static_cast<unsigned char>(bytes[kType]);
  return type < 8 ? std::optional<unsigned>(type) : std::nullopt;
}

/// "floor_10.mcap" comes after "floor_9.mcap".
bool comes_before_in_bag(const fs::path& a, const fs::path& b) {
  const std::string one = a.stem().string(), other = b.stem().string();
  return one.size() != other.size() ? one.size() < other.size() : one < other;
}

bool has_extension(const fs::path& path, const char* extension) { return path.extension() == extension; }

/// What metadata.yaml says of the files; none: nothing.
Expected<FilesOfBag> files_of_metadata(const fs::path& folder) {
  const fs::path file = folder / "metadata.yaml";
  FilesOfBag out;
  if (!path_exists(file)) return out;
  auto document = yaml::Document::load(file);
  if (!document) return document.error();
  const yaml::Value about = document->root().as_map().require("rosbag2_bagfile_information");
  if (!about) return document->status().error();
  yaml::Map map = about.as_map();
  std::string mode, format;
  map.read("compression_mode", mode).read("compression_format", format);
  out.packed_messages = mode == "MESSAGE" || mode == "message";
  if (!format.empty() && format != "zstd")
    return input_error(
        found_expected("the compression '" + format + "'", "zstd: rewrite the bag with ros2 bag convert"),
        file.string());
  if (const yaml::Value names = map.get("relative_file_paths"))
    for (const yaml::Value& name : names.as_list()) {
      const fs::path path(name.as_string());
      if (path != path.filename() || path.empty() || path == "..")
        name.fail(found_text(path.string(), "the name of a file in this folder"));
      else
        out.paths.push_back(folder / path);
    }
  if (Status s = document->status(); !s) return s.error();
  return out;
}

}  // namespace

bool keeps_last(const std::string& qos_profiles) {
  // A list of profiles, in which 1 and the word mean the same.
  for (std::size_t at = 0; (at = qos_profiles.find("durability:", at)) != std::string::npos;) {
    at = qos_profiles.find_first_not_of(" ", at + std::string_view("durability:").size());
    if (at == std::string::npos) return false;
    const std::string_view value = std::string_view(qos_profiles).substr(at);
    if (value.starts_with("transient_local") || value == "1" || value.starts_with("1\n")) return true;
  }
  return false;
}

Expected<FilesOfBag> files_of_bag(const fs::path& path) {
  if (!path_exists(path)) return input_error("there is no such file or folder", path.string());
  if (!is_folder(path)) return FilesOfBag{{path}};
  auto files = files_of_metadata(path);
  if (!files || !files->paths.empty()) return files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(path, ignored))
    if (has_extension(entry.path(), ".mcap") || has_extension(entry.path(), ".db3") ||
        has_extension(entry.path(), ".zstd"))
      files->paths.push_back(entry.path());
  std::ranges::sort(files->paths, comes_before_in_bag);
  if (files->paths.empty())
    return input_error("no file of a bag is in this folder, expected those of ros2 bag record: .mcap or .db3",
                       path.string());
  return files;
}

Expected<std::unique_ptr<BagFile>> open_plain(const fs::path& path) {
  return has_extension(path, ".db3") ? open_sqlite(path) : open_mcap(path);
}

struct Recording::Opened {
  std::unique_ptr<BagFile> file;
  std::vector<std::size_t> topics;  ///< of the recording, by place in the file's
  SimTime first = kNever;
  bool begun = false;
  std::optional<RecordedMessage> head = {};  ///< the next message; once begun none: it is over
};

Recording::Recording() = default;
Recording::Recording(Recording&&) noexcept = default;
Recording& Recording::operator=(Recording&&) noexcept = default;
Recording::~Recording() = default;

Expected<Recording> Recording::open(const fs::path& path) {
  const auto files = files_of_bag(path);
  if (!files) return files.error();
  Recording out;
  fs::path shown = path;
  out.name_ = (shown.has_filename() ? shown : shown.parent_path()).filename().string();
  for (const fs::path& file : files->paths) {
    auto opened = has_extension(file, ".zstd") ? open_packed(file) : open_plain(file);
    if (!opened) return opened.error();
    if (files->packed_messages) *opened = of_packed_messages(*std::move(opened));
    if (Status s = out.add(*std::move(opened)); !s) return s.error();
  }
  return out;
}

Expected<Recording> Recording::from_bytes(std::string bytes, const std::string& name) {
  auto file = mcap_from_bytes(std::move(bytes), name);
  if (!file) return file.error();
  Recording out;
  out.name_ = name;
  if (Status s = out.add(*std::move(file)); !s) return s.error();
  return out;
}

Status Recording::add(std::unique_ptr<BagFile> file) {
  Opened& opened = files_.emplace_back();
  opened.file = std::move(file);
  struct Count {
    std::uint64_t messages = 0;
    std::uint8_t events = 0;
  };
  std::vector<Count> counts;
  Status scanned = opened.file->scan([&](const RecordedMessage& message) {
    if (message.topic >= counts.size()) counts.resize(message.topic + 1);
    Count& count = counts[message.topic];
    ++count.messages;
    if (opened.file->topics()[message.topic].name.ends_with(kServiceEvents))
      if (const auto type = service_event_type(message.bytes)) count.events |= static_cast<std::uint8_t>(1U << *type);
    opened.first = std::min(opened.first, message.t);
    last_ = std::max(last_, message.t);
    ++messages_;
  });
  if (!scanned) return scanned;
  first_ = std::min(first_, opened.first);
  if (const std::string warning = opened.file->warning(); !warning.empty())
    warnings_.push_back(opened.file->name() + ": " + warning);
  counts.resize(opened.file->topics().size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const Topic& topic = opened.file->topics()[i];
    auto known = std::ranges::find_if(topics_, [&](const Topic& t) {
      return t.name == topic.name && t.type == topic.type && t.encoding == topic.encoding &&
             t.definition == topic.definition;
    });
    if (known == topics_.end()) known = topics_.insert(known, topic);
    known->messages += counts[i].messages;
    known->events |= counts[i].events;
    known->latched = known->latched || topic.latched;
    opened.topics.push_back(static_cast<std::size_t>(known - topics_.begin()));
  }
  return {};
}

void Recording::begin(std::vector<bool> topics) {
  for (Opened& opened : files_) {
    std::vector<bool> wanted;
    if (!topics.empty())
      for (const std::size_t topic : opened.topics) wanted.push_back(topics[topic]);
    opened.file->begin(std::move(wanted));
    opened.begun = false;
    opened.head.reset();
  }
  given_ = files_.size();
}

Expected<std::optional<RecordedMessage>> Recording::next() {
  const auto advance = [&](std::size_t i) -> Status {
    Opened& opened = files_[i];
    opened.begun = true;
    auto found = opened.file->next();
    if (!found) return found.error();
    opened.head = *found;
    if (opened.head) {
      opened.head->topic = opened.topics[opened.head->topic];
      opened.head->file = i;
    }
    return {};
  };
  if (given_ < files_.size())
    if (Status s = advance(given_); !s) return s.error();
  std::size_t best = files_.size();
  // A file is read from once its time has come, so that a bag of many files holds a part of one or two.
  for (std::size_t i = 0; i < files_.size(); ++i) {
    Opened& opened = files_[i];
    if (!opened.begun && opened.first != kNever && (best == files_.size() || opened.first < files_[best].head->t))
      if (Status s = advance(i); !s) return s.error();
    if (opened.head && (best == files_.size() || opened.head->t < files_[best].head->t)) best = i;
  }
  given_ = best;
  return best == files_.size() ? std::optional<RecordedMessage>() : files_[best].head;
}

Error Recording::at(const RecordedMessage& message, const Error& error) const {
  const BagFile& file = *files_[message.file].file;
  return input_error("the message of " + topics_[message.topic].name + " at " +
                         general_text(to_seconds(message.t - first_), 9) + " s (" + file.unit() + ' ' +
                         std::to_string(message.place) + "): " + error.message,
                     file.name());
}

Expected<std::string> digest_of(const fs::path& path) {
  const auto files = files_of_bag(path);
  if (!files) return files.error();
  struct FreeState {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  const std::unique_ptr<XXH3_state_t, FreeState> state(XXH3_createState());
  XXH3_128bits_reset(state.get());
  std::string block(std::size_t{1} << 20, '\0');
  for (const fs::path& name : files->paths) {
    std::ifstream file(name, std::ios::binary);
    if (!file) return input_error("the file cannot be read", name.string());
    while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
      XXH3_128bits_update(state.get(), block.data(), static_cast<std::size_t>(file.gcount()));
  }
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state.get()));
  std::string digest;
  for (const unsigned char byte : canonical.digest) {
    digest += "0123456789abcdef"[byte >> 4];
    digest += "0123456789abcdef"[byte & 15];
  }
  return digest;
}

}  // namespace cxlab::bag
