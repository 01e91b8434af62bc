#pragma once
// A registry of the project's own interfaces, folders for definitions of a test, and a sink that keeps records as
// bytes.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "cx/base/record_sink.h"
#include "cx/bus/bus.h"

namespace cxlab::bus {

inline std::filesystem::path interfaces_folder() {
  return std::filesystem::path(std::getenv("CXLAB_SOURCE_DIR")) / "cx" / "interfaces";
}

inline void add_interfaces(Registry& registry) {
  const Status status = registry.add_packages_in(interfaces_folder());
  ASSERT_TRUE(status.ok()) << status.error().text();
}

/// A folder of packages that is gone with the test.
class TempPackages {
 public:
  TempPackages() {
    std::string pattern = (std::filesystem::temp_directory_path() / "cxlab-bus-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~TempPackages() { std::filesystem::remove_all(folder_); }

  /// `name` as in "pkg/msg/T". Returns the file.
  std::filesystem::path write(const std::string& name, const std::string& text) {
    const std::string kind = name.substr(name.find('/') + 1, name.rfind('/') - name.find('/') - 1);
    const auto file = folder_ / (name + '.' + kind);
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

/// Keeps all records, by stream.
class MemorySink : public RecordSink {
 public:
  struct Record {
    SimTime t;
    RecordKind kind;
    std::string data;
    std::vector<RecordRef> causes;
  };

  StreamId open_stream(std::string_view name) override {
    names_.emplace_back(name);
    records_.emplace_back();
    return static_cast<StreamId>(names_.size() - 1);
  }
  RecordRef write(StreamId stream, SimTime t, RecordKind kind, const RecordData& data,
                  std::span<const RecordRef> causes) override {
    auto& records = records_[static_cast<std::size_t>(stream)];
    records.push_back({t, kind, std::string(data.bytes()), {causes.begin(), causes.end()}});
    return {stream, records.size() - 1};
  }

  const std::vector<Record>& records(StreamId stream) const { return records_[static_cast<std::size_t>(stream)]; }
  /// All that the stream says, for comparison.
  std::string bytes(StreamId stream) const {
    std::string all;
    for (const Record& record : records(stream)) {
      all += std::to_string(record.t.count()) + ' ' + record.data;
      for (const RecordRef& cause : record.causes)
        all += names_[static_cast<std::size_t>(cause.stream)] + ':' + std::to_string(cause.n);
      all += '\n';
    }
    return all;
  }

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<Record>> records_;
};

}  // namespace cxlab::bus
