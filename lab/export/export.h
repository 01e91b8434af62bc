#pragma once
// A recorded run in the formats of other tools: MCAP for Foxglove, PlotJuggler and ROS 2, a trace for Perfetto, tables
// as CSV and Parquet. The same run and the same build give the same bytes.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "cx/base/json.h"
#include "lab/export/picture_channel.h"
#include "lab/export/run_pass.h"
#include "lab/host.h"
#include "lab/run.h"

namespace cxlab::lab {

struct ExportOptions {
  bool mcap = false, trace = false, csv = false, parquet = false;  ///< at least one
  /// Empty: the folder `export` of the run. With one format it is the file (mcap, trace) or folder (csv, parquet)
  /// itself, else a folder for all.
  std::filesystem::path out;
  Stretch stretch;
  PictureChoice pictures;  ///< of the bag
};

struct Exported {
  struct File {
    std::string path, format;
    std::uint64_t bytes = 0;
    std::uint64_t entries = 0;  ///< messages, events or rows
  };
  std::vector<File> files;
  std::vector<std::string> notes;  ///< what is missing, and how to get it
};

/// A stop by the host leaves no unfinished file.
Expected<Exported> export_run(const Run& run, const ExportOptions& options, const Host& host);
Json json_of(const Exported& exported);

}  // namespace cxlab::lab
