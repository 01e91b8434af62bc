// Reads files that ros2 bag record --compression-mode writes: a file is one zstd stream, or each message is one zstd
// frame.

#include <zstd.h>

#include <fstream>
#include <memory>
#include <utility>

#include "cx/bag/bag_file.h"
#include "cx/base/scratch_folder.h"

namespace cxlab::bag {

namespace {

namespace fs = std::filesystem;

constexpr unsigned long long kMostMessageBytes = 1ULL << 30;

struct FreeStream {
  void operator()(ZSTD_DStream* stream) const { ZSTD_freeDStream(stream); }
};

Error zstd_error(const char* what, const std::string& name) {
  return input_error(std::string("the compressed file cannot be unpacked: ") + what, name);
}

Status unpack_file(const fs::path& from, const fs::path& to) {
  std::ifstream in(from, std::ios::binary);
  if (!in) return input_error("the file cannot be read", from.string());
  std::ofstream out(to, std::ios::binary);
  const std::unique_ptr<ZSTD_DStream, FreeStream> stream(ZSTD_createDStream());
  std::string packed(ZSTD_DStreamInSize(), '\0'), plain(ZSTD_DStreamOutSize(), '\0');
  std::size_t left = 1;
  while (in.read(packed.data(), static_cast<std::streamsize>(packed.size())) || in.gcount() > 0) {
    ZSTD_inBuffer taken{packed.data(), static_cast<std::size_t>(in.gcount()), 0};
    bool full = false;
    while (taken.pos < taken.size || full) {
      ZSTD_outBuffer made{plain.data(), plain.size(), 0};
      left = ZSTD_decompressStream(stream.get(), &made, &taken);
      if (ZSTD_isError(left)) return zstd_error(ZSTD_getErrorName(left), from.string());
      out.write(plain.data(), static_cast<std::streamsize>(made.pos));
      full = left != 0 && made.pos == made.size;
    }
  }
  if (left != 0) return zstd_error("it ends too early", from.string());
  out.close();
  if (!out) return resource_error("no space to unpack " + from.string() + " in " + to.parent_path().string());
  return {};
}

/// A file that was unpacked. Its name and errors are those of the compressed one.
class UnpackedFile final : public BagFile {
 public:
  UnpackedFile(std::string name, std::unique_ptr<BagFile> file) : name_(std::move(name)), file_(std::move(file)) {}

  std::string name() const override { return name_; }
  const std::vector<Topic>& topics() const override { return file_->topics(); }
  std::string warning() const override { return file_->warning(); }
  const char* unit() const override { return file_->unit(); }
  void begin(std::vector<bool> topics) override { file_->begin(std::move(topics)); }
  Status scan(const std::function<void(const RecordedMessage&)>& see) override {
    if (Status s = file_->scan(see); !s) return named(s.error());
    return {};
  }
  Expected<std::optional<RecordedMessage>> next() override {
    auto message = file_->next();
    if (!message) return named(message.error());
    return message;
  }

 private:
  Error named(Error error) const {
    error.file = name_;
    return error;
  }

  std::string name_;
  std::unique_ptr<BagFile> file_;
};

class FileOfPackedMessages final : public BagFile {
 public:
  explicit FileOfPackedMessages(std::unique_ptr<BagFile> file) : file_(std::move(file)) {}

  std::string name() const override { return file_->name(); }
  const std::vector<Topic>& topics() const override { return file_->topics(); }
  std::string warning() const override { return file_->warning(); }
  const char* unit() const override { return file_->unit(); }
  void begin(std::vector<bool> topics) override { file_->begin(std::move(topics)); }
  Status scan(const std::function<void(const RecordedMessage&)>& see) override {
    Status unpacked;
    Status scanned = file_->scan([&](RecordedMessage message) {
      if (unpacked) unpacked = unpack(message);
      if (unpacked) see(message);
    });
    return scanned ? unpacked : scanned;
  }
  Expected<std::optional<RecordedMessage>> next() override {
    auto message = file_->next();
    if (message && *message)
      if (Status s = unpack(**message); !s) return s.error();
    return message;
  }

 private:
  Status unpack(RecordedMessage& message) {
    const auto failed = [&](const std::string& why) {
      return input_error("the compressed message (" + std::string(unit()) + ' ' + std::to_string(message.place) +
                             ") cannot be unpacked: " + why,
                         name());
    };
    const unsigned long long size = ZSTD_getFrameContentSize(message.bytes.data(), message.bytes.size());
    if (size == ZSTD_CONTENTSIZE_ERROR) return failed("found no zstd");
    if (size == ZSTD_CONTENTSIZE_UNKNOWN || size > kMostMessageBytes)
      return failed("its frame does not tell a size of at most " + std::to_string(kMostMessageBytes) + " bytes");
    plain_.resize(size);
    const std::size_t made = ZSTD_decompress(plain_.data(), plain_.size(), message.bytes.data(), message.bytes.size());
    if (ZSTD_isError(made)) return failed(ZSTD_getErrorName(made));
    message.bytes = std::string_view(plain_).substr(0, made);
    return {};
  }

  std::unique_ptr<BagFile> file_;
  std::string plain_;
};

}  // namespace

Expected<std::unique_ptr<BagFile>> open_packed(const fs::path& path) {
  auto folder = ScratchFolder::create();
  if (!folder) return folder.error();
  const fs::path plain = (*folder)->path() / path.stem();
  if (Status s = unpack_file(path, plain); !s) return s.error();
  // The open file outlives its name, so nothing is left to remove when the run is over.
  auto file = open_plain(plain);
  if (!file) {
    Error error = file.error();
    error.file = path.string();
    return error;
  }
  return std::unique_ptr<BagFile>(std::make_unique<UnpackedFile>(path.string(), *std::move(file)));
}

std::unique_ptr<BagFile> of_packed_messages(std::unique_ptr<BagFile> file) {
  return std::make_unique<FileOfPackedMessages>(std::move(file));
}

}  // namespace cxlab::bag
