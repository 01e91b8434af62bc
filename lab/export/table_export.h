#pragma once
// A run as tables: records of the journal, skills, points, and what its world tells (the tables of its questions).

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lab/export/run_pass.h"
#include "lab/export/story_tables.h"
#include "lab/export/table_file.h"

namespace cxlab::lab {

/// Of the table of records: data as JSON, causes as "a:1 b:2".
std::vector<TableColumn> record_columns();

/// Makes the file of a table.
using CreateTable =
    std::function<Expected<std::unique_ptr<TableFile>>(const std::string& name, std::vector<TableColumn> columns)>;

class TableExport final : public PassListener {
 public:
  static Expected<std::unique_ptr<TableExport>> create(const Run& run, const Stretch& stretch, CreateTable create);

  bool wants(RecordKind) const override { return true; }
  Status hear(const JournalRecord& record) override;
  /// Writes skills that have not ended and the tables of the world, and completes all files.
  Status close();
  /// Rows of each table, after that.
  const std::map<std::string, std::uint64_t>& rows() const { return rows_; }

 private:
  TableExport(const Run& run, const Stretch& stretch, CreateTable create)
      : run_(run), stretch_(stretch), create_(std::move(create)), story_(stretch) {}
  Status put_world_tables();
  Status put_table(const std::string& name, const PlainTable& table);

  const Run& run_;
  Stretch stretch_;
  CreateTable create_;
  std::unique_ptr<TableFile> records_;
  StoryTables story_;
  std::map<std::string, std::uint64_t> rows_;
};

}  // namespace cxlab::lab
