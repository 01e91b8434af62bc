#include <sqlite3.h>

#include <map>

#include "cx/bag/bag_file.h"

namespace cxlab::bag {

namespace {

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

std::string_view text_at(sqlite3_stmt* row, int column) {
  const void* const bytes = sqlite3_column_blob(row, column);
  return bytes ? std::string_view(static_cast<const char*>(bytes),
                                  static_cast<std::size_t>(sqlite3_column_bytes(row, column)))
               : std::string_view();
}

/// The tables of rosbag2: topics, messages, and since ROS 2 Iron message_definitions.
class SqliteFile final : public BagFile {
 public:
  static Expected<std::unique_ptr<BagFile>> open(const std::filesystem::path& path) {
    std::unique_ptr<SqliteFile> file(new SqliteFile(path.string()));
    // Immutable: it is read without locks, journals and other files beside it.
    std::string uri = "file:";
    for (const char c : std::filesystem::absolute(path).string())
      uri += c == '%' ? "%25" : c == '?' ? "%3f" : c == '#' ? "%23" : std::string(1, c);
    uri += "?immutable=1";
    sqlite3* database = nullptr;
    const int code = sqlite3_open_v2(uri.c_str(), &database, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    file->database_.reset(database);
    if (code != SQLITE_OK) return file->failed();
    sqlite3_exec(database, "PRAGMA trusted_schema = OFF; PRAGMA temp_store = MEMORY", nullptr, nullptr, nullptr);
    if (Status s = file->read_topics(); !s) return s.error();
    return std::unique_ptr<BagFile>(std::move(file));
  }

  std::string name() const override { return name_; }
  const std::vector<Topic>& topics() const override { return topics_; }
  const char* unit() const override { return "row"; }

  Status scan(const std::function<void(const RecordedMessage&)>& see) override {
    begin({});
    while (true) {
      const auto message = next();
      if (!message) return message.error();
      if (!*message) return {};
      see(**message);
    }
  }

  void begin(std::vector<bool> topics) override {
    wanted_ = std::move(topics);
    rows_.reset();
    over_ = false;
  }

  Expected<std::optional<RecordedMessage>> next() override {
    // Contents are read one by one: a file without an index is sorted in memory.
    if (!rows_ && !over_) {
      auto rows = prepare("SELECT id, topic_id, timestamp FROM messages ORDER BY timestamp, id");
      if (!rows) return rows.error();
      auto content = prepare("SELECT data FROM messages WHERE id = ?");
      if (!content) return content.error();
      rows_ = *std::move(rows);
      content_ = *std::move(content);
    }
    while (!over_) {
      const int code = sqlite3_step(rows_.get());
      if (code != SQLITE_ROW) {
        over_ = true;
        const bool whole = code == SQLITE_DONE;
        if (!whole) return failed();
        rows_.reset();
        break;
      }
      sqlite3_stmt* const row = rows_.get();
      const auto number = sqlite3_column_int64(row, 0);
      const auto topic = places_.find(sqlite3_column_int64(row, 1));
      const auto where = [&] { return "row " + std::to_string(number) + " of the table messages: "; };
      if (topic == places_.end())
        return input_error(where() + found_expected("topic " + std::to_string(sqlite3_column_int64(row, 1)),
                                                    "one of the table topics"),
                           name_);
      const auto time = sqlite3_column_int64(row, 2);
      if (time < 0) return input_error(where() + "found the time " + std::to_string(time) + " ns", name_);
      if (!wanted_.empty() && !wanted_[topic->second]) continue;
      sqlite3_reset(content_.get());
      sqlite3_bind_int64(content_.get(), 1, number);
      if (sqlite3_step(content_.get()) != SQLITE_ROW) return failed();
      return std::optional(RecordedMessage{topic->second, SimTime(time), text_at(content_.get(), 0), 0,
                                           static_cast<std::uint64_t>(number)});
    }
    return std::optional<RecordedMessage>();
  }

 private:
  explicit SqliteFile(std::string name) : name_(std::move(name)) {}

  Error failed() const {
    return input_error(std::string("the file cannot be read as a bag of SQLite: ") +
                           (database_ ? sqlite3_errmsg(database_.get()) : "out of memory"),
                       name_);
  }
  Expected<Statement> prepare(const char* sql) const {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), sql, -1, &statement, nullptr) != SQLITE_OK) return failed();
    return Statement(statement);
  }
  Status each_row(const char* sql, const std::function<void(sqlite3_stmt*)>& take) const {
    auto rows = prepare(sql);
    if (!rows) return rows.error();
    int code = SQLITE_OK;
    while ((code = sqlite3_step(rows->get())) == SQLITE_ROW) take(rows->get());
    return code == SQLITE_DONE ? Status() : failed();
  }

  Status read_topics() {
    std::map<std::string, std::string> definitions;
    if (prepare("SELECT 1 FROM message_definitions"))
      if (Status s = each_row("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions",
                              [&](sqlite3_stmt* row) {
                                if (text_at(row, 1) == "ros2msg")
                                  definitions[std::string(text_at(row, 0))] = text_at(row, 2);
                              });
          !s)
        return s;
    return each_row("SELECT id, name, type, serialization_format, offered_qos_profiles FROM topics ORDER BY id",
                    [&](sqlite3_stmt* row) {
                      if (!places_.emplace(sqlite3_column_int64(row, 0), topics_.size()).second) return;
                      Topic topic{std::string(text_at(row, 1)), std::string(text_at(row, 2)),
                                  std::string(text_at(row, 3)), ""};
                      topic.definition = definitions[topic.type];
                      topic.latched = keeps_last(std::string(text_at(row, 4)));
                      topics_.push_back(std::move(topic));
                    });
  }

  std::string name_;
  std::unique_ptr<sqlite3, CloseDatabase> database_;
  std::vector<Topic> topics_;
  std::map<sqlite3_int64, std::size_t> places_;
  std::vector<bool> wanted_;
  Statement rows_, content_;
  bool over_ = false;
};

}  // namespace

Expected<std::unique_ptr<BagFile>> open_sqlite(const std::filesystem::path& path) { return SqliteFile::open(path); }

}  // namespace cxlab::bag
