#pragma once
// A table as Apache Parquet (https://parquet.apache.org/docs/file-format): columns that may be empty, plain values,
// pages compressed with zstd, groups of rows of about 16 MB. Lists, dictionaries and statistics are left out.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cx/base/expected.h"
#include "lab/export/table_file.h"

namespace cxlab::lab {

Expected<std::unique_ptr<TableFile>> create_parquet(const std::filesystem::path& path,
                                                    std::vector<TableColumn> columns);

}  // namespace cxlab::lab
