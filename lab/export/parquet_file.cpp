#include "lab/export/parquet_file.h"

#include <zstd.h>

#include <utility>

#include "cx/base/append_file.h"
#include "cx/base/byte_codec.h"
#include "lab/versions.h"

namespace cxlab::lab {

namespace {

constexpr std::string_view kParquetMagic = "PAR1";
constexpr std::size_t kGroupBytes = std::size_t{1} << 24;
constexpr int kPageLevel = 3;  // of zstd: its default

// Numbers of the format.
constexpr int kOptional = 1, kUtf8 = 0, kDataPage = 0, kPlain = 0, kRle = 3, kZstd = 6;
int type_number(TableColumn::Kind kind) {
  constexpr int kInt64 = 2, kDouble = 5, kByteArray = 6;
  return kind == TableColumn::Kind::kWhole ? kInt64 : kind == TableColumn::Kind::kReal ? kDouble : kByteArray;
}

/// A struct in the compact protocol of Thrift. Fields come in the order of their numbers.
class Thrift {
 public:
  Thrift& i32(int field, std::int64_t value) { return number(field, 5, value); }
  Thrift& i64(int field, std::int64_t value) { return number(field, 6, value); }
  Thrift& text(int field, std::string_view value) {
    head(field, 8);
    ByteWriter(out_).text(value);
    return *this;
  }
  Thrift& object(int field, const Thrift& value) {
    head(field, 12);
    out_ += value.whole();
    return *this;
  }
  Thrift& objects(int field, const std::vector<std::string>& wholes) {
    list(field, 12, wholes.size());
    for (const std::string& one : wholes) out_ += one;
    return *this;
  }
  Thrift& texts(int field, const std::vector<std::string>& values) {
    list(field, 8, values.size());
    for (const std::string& value : values) ByteWriter(out_).text(value);
    return *this;
  }
  Thrift& numbers(int field, const std::vector<int>& values) {
    list(field, 5, values.size());
    for (const int value : values) ByteWriter(out_).zigzag(value);
    return *this;
  }
  std::string whole() const { return out_ + '\0'; }

 private:
  void head(int field, int type) {
    out_ += static_cast<char>((field - last_) << 4 | type);
    last_ = field;
  }
  Thrift& number(int field, int type, std::int64_t value) {
    head(field, type);
    ByteWriter(out_).zigzag(value);
    return *this;
  }
  void list(int field, int type, std::size_t size) {
    head(field, 9);
    if (size < 15) {
      out_ += static_cast<char>(size << 4 | static_cast<std::size_t>(type));
    } else {
      out_ += static_cast<char>(0xf0 | type);
      ByteWriter(out_).varint(size);
    }
  }

  std::string out_;
  int last_ = 0;
};

class ParquetFile final : public TableFile {
 public:
  ParquetFile(AppendFile file, std::vector<TableColumn> columns)
      : file_(std::move(file)), columns_(std::move(columns)), data_(columns_.size()) {
    append(kParquetMagic);
  }

  Status close() override {
    end_group();
    std::vector<std::string> schema{
        Thrift().text(4, "table").i32(5, static_cast<std::int64_t>(columns_.size())).whole()};
    for (const TableColumn& column : columns_) {
      Thrift element;
      element.i32(1, type_number(column.kind)).i32(3, kOptional).text(4, column.key);
      if (column.kind == TableColumn::Kind::kText) element.i32(6, kUtf8);
      schema.push_back(element.whole());
    }
    std::string footer = Thrift()
                             .i32(1, 1)
                             .objects(2, schema)
                             .i64(3, static_cast<std::int64_t>(rows()))
                             .objects(4, groups_)
                             .text(6, std::string("cxlab ") + cxlab_version())
                             .whole();
    const auto size = static_cast<std::uint32_t>(footer.size());
    ByteWriter(footer).fixed(size).raw(kParquetMagic);
    append(footer);
    if (Status s = file_.close(); !s && status_) status_ = s;
    return status_;
  }

 private:
  /// A column of the current group.
  struct ColumnData {
    std::string values;
    std::string levels;     ///< runs of cells that are there (1) or empty (0)
    std::uint64_t run = 0;  ///< length of the last one, which is not in `levels` yet
    bool there = false;     ///< what it is a run of

    void end_run() {
      if (run > 0) ByteWriter(levels).varint(run << 1).fixed(static_cast<char>(there ? 1 : 0));
      run = 0;
    }
  };

  Status put(std::span<const TableCell> cells) override {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      ColumnData& data = data_[i];
      const auto& value = cells[i].value;
      const std::size_t before = data.values.size();
      ByteWriter out(data.values);
      if (const auto* text = std::get_if<std::string>(&value))
        out.fixed(static_cast<std::uint32_t>(text->size())).raw(*text);
      else if (const auto* whole = std::get_if<std::int64_t>(&value))
        out.fixed(*whole);
      else if (const auto* real = std::get_if<double>(&value))
        out.fixed(*real);
      const bool there = data.values.size() > before;
      if (there != data.there) data.end_run();
      data.there = there;
      ++data.run;
      group_bytes_ += data.values.size() - before;
    }
    ++group_rows_;
    if (group_bytes_ >= kGroupBytes) end_group();
    return status_;
  }

  void end_group() {
    if (group_rows_ == 0) return;
    std::vector<std::string> chunks;
    std::uint64_t group_size = 0;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      ColumnData& data = data_[i];
      data.end_run();
      std::string page;
      ByteWriter(page).fixed(static_cast<std::uint32_t>(data.levels.size())).raw(data.levels).raw(data.values);
      std::string packed(ZSTD_compressBound(page.size()), '\0');
      const std::size_t size = ZSTD_compress(packed.data(), packed.size(), page.data(), page.size(), kPageLevel);
      if (ZSTD_isError(size)) {
        if (status_) status_ = resource_error(std::string("zstd: ") + ZSTD_getErrorName(size));
        return;
      }
      packed.resize(size);
      const std::uint64_t start = file_.size();
      const std::string head = Thrift()
                                   .i32(1, kDataPage)
                                   .i32(2, static_cast<std::int64_t>(page.size()))
                                   .i32(3, static_cast<std::int64_t>(size))
                                   .object(5, Thrift().i32(1, group_rows_).i32(2, kPlain).i32(3, kRle).i32(4, kRle))
                                   .whole();
      append(head);
      append(packed);
      const auto unpacked_size = static_cast<std::int64_t>(head.size() + page.size());
      const auto packed_size = static_cast<std::int64_t>(file_.size() - start);
      Thrift about;
      about.i32(1, type_number(columns_[i].kind)).numbers(2, {kPlain, kRle}).texts(3, {columns_[i].key}).i32(4, kZstd);
      about.i64(5, group_rows_).i64(6, unpacked_size).i64(7, packed_size).i64(9, static_cast<std::int64_t>(start));
      chunks.push_back(Thrift().i64(2, static_cast<std::int64_t>(start)).object(3, about).whole());
      group_size += static_cast<std::uint64_t>(unpacked_size);
      data = {};
    }
    groups_.push_back(
        Thrift().objects(1, chunks).i64(2, static_cast<std::int64_t>(group_size)).i64(3, group_rows_).whole());
    group_rows_ = 0;
    group_bytes_ = 0;
  }

  void append(std::string_view bytes) {
    if (Status s = file_.append(bytes); !s && status_) status_ = s;
  }

  AppendFile file_;
  std::vector<TableColumn> columns_;
  std::vector<ColumnData> data_;
  std::vector<std::string> groups_;  ///< what the footer says of each
  std::int64_t group_rows_ = 0;
  std::size_t group_bytes_ = 0;
  Status status_;
};

}  // namespace

Expected<std::unique_ptr<TableFile>> create_parquet(const std::filesystem::path& path,
                                                    std::vector<TableColumn> columns) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<TableFile>(new ParquetFile(*std::move(file), std::move(columns)));
}

}  // namespace cxlab::lab
