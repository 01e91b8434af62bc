#include "cx/journal/journal.h"
#include "cx/base/named_value.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <sstream>

#include "cx/journal/journal_reader.h"
#include "tests/support/files.h"

namespace cxlab {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;

RecordData order(int id, std::string_view state) {
  RecordData data;
  data.begin().field("order", id).field("state", state);
  return data;
}

/// A short story in the stream of one environment; a skill's record is the cause of the second one.
void tell(Journal& journal, StreamId env, StreamId robot, int last_order = 2) {
  journal.write(env, milliseconds(20), RecordKind::kInput, order(1, "OPEN"));
  const RecordRef done = journal.write(robot, milliseconds(40), RecordKind::kSkill, order(1, "DONE"));
  journal.write(env, milliseconds(40), RecordKind::kDecision, order(last_order, "OPEN"), {{done}});
}

/// The journal.jsonl that `write` leaves at that level.
std::string exported(JournalLevel level, const std::function<void(Journal&)>& write) {
  TempFolder folder;
  Journal journal;
  EXPECT_TRUE(journal.export_to(folder / "journal.jsonl", level).ok());
  write(journal);
  EXPECT_TRUE(journal.close().ok());
  return content_of(folder / "journal.jsonl");
}

TEST(JournalHash, IsTheSameOnEveryMachineAndVersion) {
  Journal journal;
  tell(journal, journal.open_stream("env/a"), journal.open_stream("node/robot1"));
  EXPECT_EQ(journal.stream_hash("env/a"), "ba9c6b1b745b730ee41ff33bc937867c");
  EXPECT_EQ(journal.stream_hash("node/robot1"), "c541b739d4aa27df7986a3dbbcbaf395");
  EXPECT_EQ(journal.journal_hash(), "e91aa2761c82daeba73a1672067d0881");
}

TEST(JournalHash, OfAStreamDoesNotDependOnTheOrderOfOpening) {
  Journal one, other;
  const StreamId env = one.open_stream("env/a");
  tell(one, env, one.open_stream("node/robot1"));
  const StreamId robot = other.open_stream("node/robot1");
  tell(other, other.open_stream("env/a"), robot);
  EXPECT_EQ(one.stream_hash("env/a"), other.stream_hash("env/a"));
  EXPECT_EQ(one.journal_hash(), other.journal_hash());
}

TEST(JournalHash, OfAStreamDoesNotDependOnOtherStreams) {
  Journal alone, beside;
  tell(alone, alone.open_stream("env/a"), alone.open_stream("node/robot1"));
  const StreamId stranger = beside.open_stream("env/0");
  beside.write(stranger, seconds(0), RecordKind::kFire, order(7, "X"));
  tell(beside, beside.open_stream("env/a"), beside.open_stream("node/robot1"));
  beside.write(stranger, seconds(1), RecordKind::kFire, order(8, "X"));
  EXPECT_EQ(alone.stream_hash("env/a"), beside.stream_hash("env/a"));
  EXPECT_NE(alone.journal_hash(), beside.journal_hash());
}

TEST(JournalHash, ChangesWithEveryPartOfARecord) {
  const auto hash_after = [](std::string_view cause, std::uint64_t cause_records, SimTime t, RecordKind kind, int id) {
    Journal journal;
    const StreamId env = journal.open_stream("env/a");
    const StreamId from = journal.open_stream(cause);
    RecordRef last;
    for (std::uint64_t i = 0; i < cause_records; ++i) last = journal.write(from, {}, RecordKind::kBus, order(0, ""));
    journal.write(env, t, kind, order(id, "OPEN"), {{last}});
    return journal.stream_hash("env/a");
  };
  const std::string reference = hash_after("node/x", 1, seconds(1), RecordKind::kFire, 1);
  EXPECT_EQ(hash_after("node/x", 1, seconds(1), RecordKind::kFire, 1), reference);
  EXPECT_NE(hash_after("node/y", 1, seconds(1), RecordKind::kFire, 1), reference);
  EXPECT_NE(hash_after("node/x", 2, seconds(1), RecordKind::kFire, 1), reference);
  EXPECT_NE(hash_after("node/x", 1, seconds(2), RecordKind::kFire, 1), reference);
  EXPECT_NE(hash_after("node/x", 1, seconds(1), RecordKind::kAssert, 1), reference);
  EXPECT_NE(hash_after("node/x", 1, seconds(1), RecordKind::kFire, 2), reference);
}

TEST(JournalHash, IgnoresStreamsWithoutRecordsAndTheExport) {
  Journal quiet;
  tell(quiet, quiet.open_stream("env/a"), quiet.open_stream("node/robot1"));
  std::string hash;
  exported(JournalLevel::kFull, [&](Journal& journal) {
    journal.open_stream("env/idle");
    EXPECT_EQ(journal.stream_hash("env/idle"), "");
    EXPECT_EQ(journal.stream_hash("env/unknown"), "");
    tell(journal, journal.open_stream("env/a"), journal.open_stream("node/robot1"));
    hash = journal.journal_hash();
    ASSERT_EQ(journal.streams().size(), 2u);
  });
  EXPECT_EQ(hash, quiet.journal_hash());
}

/// The journal of an agent whose package lies in that folder and that keeps the folder in facts.
std::string hash_with_package_in(const std::string& folder, const std::string& known_as = "package://agent") {
  Journal journal;
  journal.name_folder("/opt/ros/share/other", "package://other");
  journal.name_folder(folder, known_as);
  const StreamId env = journal.open_stream("env/a");
  RecordData data;
  data.begin()
      .field("state", "/opt/ros/share/other")
      .name("slots")
      .open_map(2)
      .text_key("\"" + folder + "/clips/a.clp\"")
      .value(2.5)
      .text_key("list")
      .open_list(2)
      .value("see " + folder)
      .value(std::int64_t{7});
  journal.write(env, milliseconds(20), RecordKind::kAssert, data);
  return journal.journal_hash();
}

TEST(JournalHash, DoesNotDependOnWherePackagesLie) {
  EXPECT_EQ(hash_with_package_in("/a/agent"),
            hash_with_package_in("/home/somebody/with/a/long/way/to/the/sources/of/agent"));
  EXPECT_NE(hash_with_package_in("/a/agent"), hash_with_package_in("/a/agent", "package://other_agent"));
}

TEST(JournalExport, FoldersHaveTheirNames) {
  const std::string text = exported(JournalLevel::kFull, [](Journal& journal) {
    journal.name_folder("/a/agent", "package://agent");
    journal.name_folder("/a/agent/inner", "package://inner");
    RecordData data;
    data.begin()
        .field("file", "/a/agent/clips/a.clp")
        .field("inner", "\"/a/agent/inner\"")
        .field("both", "/a/agent:/a/agent/inner/x")
        .field("other", "/a/agent2")
        .field("below", "/b/a/agent")
        .field("topic", "/a")
        .field("uri", "file:///a/agent/b")
        .field("n", 3);
    journal.write(journal.open_stream("env/a"), milliseconds(20), RecordKind::kInput, data);
  });
  EXPECT_THAT(
      text,
      HasSubstr(
          R"({"file":"package://agent/clips/a.clp","inner":"\"package://inner\"","both":"package://agent:package://inner/x",)"
          R"("other":"/a/agent2","below":"/b/a/agent","topic":"/a","uri":"file://package://agent/b","n":3})"));
}

TEST(JournalExport, AFolderIsKnownInATextOfAnyLength) {
  FolderNames folders;
  folders.add("/a/agent", "package://agent");
  for (std::size_t length = 8; length < 300; ++length) {
    std::string path = "/a/agent", renamed, json;
    path.resize(length, '/');
    RecordData data;
    data.begin().field("file", path);
    ASSERT_TRUE(folders.rewrite(data.bytes(), renamed)) << length;
    ASSERT_TRUE(append_json(renamed, json).ok());
    EXPECT_EQ(json, "{\"file\":\"package://agent" + path.substr(8) + "\"}") << length;
  }
}

TEST(JournalExport, TruthsAndNestingAreWrittenAsTheyAre) {
  RecordData data;
  data.begin().field("no", false).field("yes", true);
  std::string json;
  ASSERT_TRUE(append_json(data.bytes(), json).ok());
  EXPECT_EQ(json, R"({"no":false,"yes":true})");
  for (const int depth : {1, 2, 63, 64, 65, 66, 1000}) {
    std::string nested, wanted;
    for (int i = 0; i < depth; ++i) nested += std::string("\xdd\0\0\0\1", 5);
    json.clear();
    EXPECT_EQ(append_json(nested + "\xc0", json).ok(), depth <= 64) << depth;
  }
}

TEST(JournalExport, AFolderEndsWhereANameEnds) {
  FolderNames folders;
  folders.add("/a/agent", "package://agent");
  for (int code = 1; code < 128; ++code) {
    const char c = static_cast<char>(code);
    const bool of_a_name = std::isalnum(code) != 0 || c == '_' || c == '-' || c == '.';
    for (const std::string& text : {std::string("/a/agent") + c, c + std::string("/a/agent")}) {
      RecordData data;
      data.begin().field("file", text);
      std::string renamed;
      EXPECT_EQ(folders.rewrite(data.bytes(), renamed), !of_a_name) << text;
    }
  }
}

TEST(JournalExport, AFolderThatIsKnownKeepsItsFirstName) {
  FolderNames folders;
  folders.add("/a/agent", "first");
  folders.add("/a/agent", "second");
  folders.add("/", "root");
  folders.add("relative", "relative");
  RecordData data;
  data.begin().field("file", "/a/agent / /b relative");
  std::string renamed, json;
  ASSERT_TRUE(folders.rewrite(data.bytes(), renamed));
  ASSERT_TRUE(append_json(renamed, json).ok());
  EXPECT_EQ(json, R"({"file":"first / /b relative"})");
}

/// Keeps what it hears of one stream.
class Listener final : public JournalListener {
 public:
  bool wants(std::string_view stream, RecordKind kind) const override {
    return stream == "env/a" && kind == RecordKind::kDecision;
  }
  void heard(const JournalRecord& record) override { records.push_back(record); }
  std::vector<JournalRecord> records;
};

TEST(Journal, ListenersHearOfWhatTheyWantWhateverIsExported) {
  Journal journal;
  Listener listener, second;
  journal.observe(listener);
  journal.observe(second);
  const StreamId env = journal.open_stream("env/a"), robot = journal.open_stream("node/robot1");
  tell(journal, env, robot);
  journal.ignore(listener);
  tell(journal, env, robot);
  EXPECT_EQ(second.records.size(), 2u);
  ASSERT_EQ(listener.records.size(), 1u);
  const JournalRecord& record = listener.records.front();
  EXPECT_EQ(record.stream, "env/a");
  EXPECT_EQ(record.n, 1u);
  EXPECT_EQ(record.t, milliseconds(40));
  EXPECT_EQ(record.kind, RecordKind::kDecision);
  EXPECT_EQ(record.data.integer("order"), 2);
  EXPECT_EQ(record.data.text("state"), "OPEN");
  EXPECT_THAT(record.causes, ElementsAre(JournalRecord::Cause{"node/robot1", 0}));
}

TEST(Journal, NumbersTheRecordsOfEachStreamFromZero) {
  Journal journal;
  const StreamId a = journal.open_stream("env/a");
  const StreamId b = journal.open_stream("env/b");
  EXPECT_EQ(journal.write(a, {}, RecordKind::kFire, order(1, "")).n, 0u);
  EXPECT_EQ(journal.write(b, {}, RecordKind::kFire, order(1, "")).n, 0u);
  EXPECT_EQ(journal.write(a, {}, RecordKind::kFire, order(1, "")).n, 1u);
  EXPECT_EQ(journal.open_stream("env/a"), a);
}

TEST(JournalExport, WritesOneLineOfJsonARecord) {
  const std::string text = exported(JournalLevel::kDecisions, [](Journal& journal) {
    tell(journal, journal.open_stream("env/a"), journal.open_stream("node/robot1"));
  });
  EXPECT_EQ(
      text,
      "{\"stream\":\"env/"
      "a\",\"n\":0,\"t\":20000000,\"kind\":\"input\",\"data\":{\"order\":1,\"state\":\"OPEN\"},\"cause\":[]}\n"
      "{\"stream\":\"node/"
      "robot1\",\"n\":0,\"t\":40000000,\"kind\":\"skill\",\"data\":{\"order\":1,\"state\":\"DONE\"},\"cause\":[]}\n"
      "{\"stream\":\"env/a\",\"n\":1,\"t\":40000000,\"kind\":\"decision\",\"data\":{\"order\":2,\"state\":\"OPEN\"},"
      "\"cause\":[\"node/robot1:0\"]}\n");
}

TEST(JournalExport, CausesAreAListOfStreamAndNumber) {
  const std::string text = exported(JournalLevel::kDecisions, [](Journal& journal) {
    const StreamId env = journal.open_stream("env/a"), node = journal.open_stream("node/b");
    RecordData data;
    data.begin().field("rule", "go");
    const RecordRef causes[] = {journal.write(node, {}, RecordKind::kBus, data), {node, 7}, {env, 12}};
    journal.write(env, {}, RecordKind::kDecision, data, causes);
  });
  EXPECT_EQ(text,
            "{\"stream\":\"env/a\",\"n\":0,\"t\":0,\"kind\":\"decision\",\"data\":{\"rule\":\"go\"},"
            "\"cause\":[\"node/b:0\",\"node/b:7\",\"env/a:12\"]}\n");
}

TEST(JournalExport, LevelsSelectKindsAndKeepTheNumbers) {
  const auto write_all_kinds = [](Journal& journal) {
    const StreamId stream = journal.open_stream("env/a");
    for (int kind = 0; kind <= static_cast<int>(RecordKind::kError); ++kind) {
      journal.write(stream, {}, static_cast<RecordKind>(kind), order(kind, ""));
    }
  };
  const auto kinds_at = [&](JournalLevel level) {
    TempFolder folder;
    put_file(folder / "j", exported(level, write_all_kinds));
    const auto records = read_journal(folder / "j");
    std::vector<std::string> kinds;
    for (const JournalRecord& record : *records) {
      EXPECT_EQ(record.n, static_cast<std::uint64_t>(record.kind));
      kinds.emplace_back(to_string(record.kind));
    }
    return kinds;
  };
  EXPECT_THAT(kinds_at(JournalLevel::kDecisions),
              ElementsAre("input", "skill", "referee", "decision", "control", "error"));
  EXPECT_THAT(kinds_at(JournalLevel::kFull), ElementsAre("input", "assert", "retract", "modify", "fire", "bus", "skill",
                                                         "referee", "decision", "control", "error"));
  EXPECT_THAT(kinds_at(JournalLevel::kNone), ElementsAre());
}

TEST(JournalExport, NumbersAreTheShortestThatReadBackTheSame) {
  RecordData data;
  data.begin()
      .field("tenth", 0.1)
      .field("one", 1.0)
      .field("tiny", 5e-324)
      .field("big", 1e300)
      .field("third", 1.0 / 3.0);
  data.field("least", std::numeric_limits<std::int64_t>::min())
      .field("minus", -5)
      .field("list", std::vector<double>{0.5, -0.0});
  data.field("unsigned", std::numeric_limits<std::uint64_t>::max());
  const std::string text = exported(JournalLevel::kFull, [&](Journal& journal) {
    journal.write(journal.open_stream("s"), {}, RecordKind::kControl, data);
  });
  EXPECT_THAT(
      text,
      HasSubstr("{\"tenth\":0.1,\"one\":1.0,\"tiny\":5e-324,\"big\":1e+300,\"third\":0.3333333333333333,"
                "\"least\":-9223372036854775808,\"minus\":-5,\"list\":[0.5,-0.0],\"unsigned\":18446744073709551615}"));
  const auto record = parse_journal_line(text);
  ASSERT_TRUE(record.ok());
  EXPECT_EQ(record->data, *decode_record_data(data.bytes()));
  EXPECT_EQ(std::get<std::uint64_t>(record->data.find("unsigned")->value), std::numeric_limits<std::uint64_t>::max());
}

TEST(JournalExport, NumbersThatJsonLacksBecomeWords) {
  RecordData data;
  data.begin()
      .field("a", std::numeric_limits<double>::quiet_NaN())
      .field("b", -std::numeric_limits<double>::infinity());
  std::string text;
  ASSERT_TRUE(append_json(data.bytes(), text).ok());
  EXPECT_EQ(text, R"({"a":"nan","b":"-inf"})");
}

TEST(JournalExport, TextIsAlwaysValidUtf8) {
  const auto json = [](std::string_view text) {
    std::string out;
    append_json_string(text, out);
    return out;
  };
  EXPECT_EQ(json("gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80"),
            "\"gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80\"");
  EXPECT_EQ(json("\xe0\xa4\x95"), "\"\xe0\xa4\x95\"") << "the smallest first byte of three";
  EXPECT_EQ(json("a\"b\\c\nd\x01\x1f\x20\x7f"), R"("a\"b\\c\nd\u0001\u001f \u007f")");
  const std::string unknown = "\xef\xbf\xbd";
  EXPECT_EQ(json("x\xff\x79"), "\"x" + unknown + "y\"");
  for (int c = 0; c < 128; ++c) {
    // Wherever in a longer text a character stands, it is written as where it stands alone.
    const std::string one(1, static_cast<char>(c)), alone = json(one);
    for (std::size_t at = 0; at < 9; ++at) {
      std::string text = "plain text", expected = "\"" + text + "\"";
      text.insert(at, one);
      expected.insert(at + 1, alone.substr(1, alone.size() - 2));
      EXPECT_EQ(json(text), expected) << c;
    }
  }
  EXPECT_EQ(json("\xc3"), "\"" + unknown + "\"") << "cut off";
  EXPECT_EQ(json("\xc0\x80"), "\"" + unknown + unknown + "\"") << "longer than needed";
  EXPECT_EQ(json("\xed\xa0\x80"), "\"" + unknown + unknown + unknown + "\"") << "half a surrogate pair";
  EXPECT_EQ(json("\xf4\x90\x80\x80"), "\"" + unknown + unknown + unknown + unknown + "\"") << "beyond U+10FFFF";
  EXPECT_EQ(json("\xe2\x82q"), "\"" + unknown + unknown + "q\"");
}

/// The characters of RFC 3629 at the front of `text`: how many bytes the first one has, 0 if it is none.
std::size_t character(std::string_view text) {
  for (std::size_t size = 1; size <= std::min<std::size_t>(4, text.size()); ++size) {
    constexpr unsigned kMark[] = {0, 0, 0xc0, 0xe0, 0xf0}, kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    const auto byte = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(text[i])); };
    unsigned code = byte(0) - kMark[size];
    if (byte(0) < kMark[size] || code > (size == 1 ? 0x7fU : 0xffU >> (size + 1))) continue;
    bool whole = true;
    for (std::size_t i = 1; i < size; ++i) {
      whole = whole && byte(i) >= 0x80 && byte(i) <= 0xbf;
      code = code * 64 + byte(i) % 64;
    }
    if (whole && code >= kLeast[size] && code <= 0x10ffff && (code < 0xd800 || code > 0xdfff)) return size;
  }
  return 0;
}

TEST(JournalExport, EveryInvalidByteBecomesTheReplacementCharacter) {
  // Bytes at the borders of RFC 3629's table, in all orders.
  constexpr std::string_view kBytes =
      "A\x7e\x80\x8f\x90\x9f\xa0\xbf\xc0\xc1\xc2\xdf\xe0\xe1\xec\xed\xee\xef\xf0\xf1\xf3\xf4\xf5\xff";
  std::string text(4, 'A');
  const std::size_t n = kBytes.size();
  for (std::size_t i = 0; i < n * n * n * n; ++i) {
    text = {kBytes[i % n], kBytes[i / n % n], kBytes[i / n / n % n], kBytes[i / n / n / n]};
    std::string expected = "\"", found;
    for (std::string_view rest = text; !rest.empty();) {
      const std::size_t size = character(rest);
      expected += size == 0 ? "\xef\xbf\xbd" : rest.substr(0, size);
      rest.remove_prefix(std::max<std::size_t>(size, 1));
    }
    append_json_string(text, found);
    ASSERT_EQ(found, expected + '"') << i;
  }
}

TEST(JournalExport, LinesReachTheFileWithinTenSimulatedSeconds) {
  TempFolder folder;
  Journal journal;
  ASSERT_TRUE(journal.export_to(folder / "j", JournalLevel::kFull).ok());
  const StreamId stream = journal.open_stream("s");
  journal.write(stream, seconds(1), RecordKind::kFire, order(1, ""));
  journal.write(stream, seconds(10), RecordKind::kFire, order(2, ""));
  EXPECT_EQ(read_journal(folder / "j")->size(), 2u);
  journal.write(stream, seconds(11), RecordKind::kFire, order(3, ""));
  ASSERT_TRUE(journal.flush().ok());
  EXPECT_EQ(read_journal(folder / "j")->size(), 3u);
}

TEST(JournalExport, FullDiskIsAnErrorAndLeavesWholeLines) {
  TempFolder folder;
  Journal journal, unlimited;
  ASSERT_TRUE(journal.export_to(folder / "j", JournalLevel::kFull).ok());
  const StreamId stream = journal.open_stream("s");
  const StreamId same = unlimited.open_stream("s");
  {
    FileSizeLimit limit(100'000);
    for (int i = 0; i < 3000; ++i) journal.write(stream, {}, RecordKind::kFire, order(i, "OPEN"));
  }
  for (int i = 0; i < 3000; ++i) unlimited.write(same, {}, RecordKind::kFire, order(i, "OPEN"));

  ASSERT_FALSE(journal.status().ok());
  EXPECT_EQ(journal.status().error().kind, ErrorKind::kResource);
  EXPECT_THAT(journal.status().error().text(), HasSubstr((folder / "j").string()));
  EXPECT_FALSE(journal.close().ok());

  const std::string text = content_of(folder / "j");
  EXPECT_GT(text.size(), 99'000u) << "lines that fit are kept";
  EXPECT_EQ(text.back(), '\n');
  const auto records = read_journal(folder / "j");
  ASSERT_TRUE(records.ok()) << records.error().text();
  for (std::size_t i = 0; i < records->size(); ++i) EXPECT_EQ((*records)[i].n, i);
  EXPECT_EQ(journal.journal_hash(), unlimited.journal_hash()) << "the hash goes on";
}

TEST(JournalExport, MissingFolderIsAResourceError) {
  Journal journal;
  const Status status = journal.export_to("/nowhere/at/all/journal.jsonl", JournalLevel::kFull);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().kind, ErrorKind::kResource);
}

TEST(JournalReader, GivesBackWhatWasWritten) {
  TempFolder folder;
  put_file(folder / "j", exported(JournalLevel::kDecisions, [](Journal& journal) {
             tell(journal, journal.open_stream("env/a"), journal.open_stream("node/robot1"));
           }));
  const auto records = read_journal(folder / "j");
  ASSERT_TRUE(records.ok()) << records.error().text();
  ASSERT_EQ(records->size(), 3u);
  const JournalRecord& last = records->back();
  EXPECT_EQ(last.stream, "env/a");
  EXPECT_EQ(last.n, 1u);
  EXPECT_EQ(last.t, milliseconds(40));
  EXPECT_EQ(last.kind, RecordKind::kDecision);
  EXPECT_EQ(last.data.integer("order"), 2);
  EXPECT_EQ(last.data.text("state"), "OPEN");
  EXPECT_EQ(last.data.text("order"), "") << "another type";
  EXPECT_EQ(last.data.integer("nothing"), 0);
  EXPECT_THAT(last.causes, ElementsAre(JournalRecord::Cause{"node/robot1", 0}));
}

TEST(JournalReader, ValuesHaveTheirTypes) {
  const auto record = parse_journal_line(
      R"({"stream":"s","n":0,"t":-5,"kind":"fire","data":{"minus":-5,"zero":0,"most":9223372036854775807,)"
      R"("more":9223372036854775808,"real":-2.5,"true":true,"false":false,"nothing":null,"text":"t","list":[1,[2]],)"
      R"("map":{"a":1}},"cause":["a:b:7"]})");
  ASSERT_TRUE(record.ok()) << record.error().text();
  const RecordValue& data = record->data;
  EXPECT_EQ(record->t, SimTime{-5});
  EXPECT_EQ(std::get<std::int64_t>(data.find("minus")->value), -5);
  EXPECT_EQ(std::get<std::int64_t>(data.find("zero")->value), 0);
  EXPECT_EQ(std::get<std::int64_t>(data.find("most")->value), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(std::get<std::uint64_t>(data.find("more")->value), std::uint64_t{1} << 63);
  EXPECT_EQ(std::get<double>(data.find("real")->value), -2.5);
  EXPECT_TRUE(std::get<bool>(data.find("true")->value));
  EXPECT_FALSE(std::get<bool>(data.find("false")->value));
  EXPECT_TRUE(std::holds_alternative<std::monostate>(data.find("nothing")->value));
  EXPECT_EQ(std::get<std::string>(data.find("text")->value), "t");
  EXPECT_EQ(std::get<RecordValue::List>(data.find("list")->value).size(), 2u);
  EXPECT_EQ(data.find("map")->integer("a"), 1);
  EXPECT_THAT(record->causes, ElementsAre(JournalRecord::Cause{"a:b", 7}));
}

TEST(JournalReader, ValuesNestUpTo64Deep) {
  const auto readable = [](int lists) {
    const auto deep = static_cast<std::size_t>(lists);
    return parse_journal_line(R"({"stream":"s","n":0,"t":0,"kind":"fire","data":{"a":)" + std::string(deep, '[') +
                              std::string(deep, ']') + R"(},"cause":[]})")
        .ok();
  };
  EXPECT_TRUE(readable(64));
  EXPECT_FALSE(readable(65));
}

TEST(JournalReader, LeavesOutKindsThatNobodyAskedFor) {
  TempFolder folder;
  // Another order of members, with a "kind" in the data, and one that is nobody's business.
  const std::string by_hand = R"({"data":{"kind":"fire"},"stream":"s","n":0,"t":0,"kind":"decision","cause":[]})"
                              "\n"
                              R"({"data":{"kind":"decision"},"stream":"s","n":1,"t":0,"kind":"fire","cause":[]})"
                              "\n";
  put_file(folder / "j", exported(JournalLevel::kDecisions, [](Journal& journal) {
                           tell(journal, journal.open_stream("env/{\"kind\":\"fire\""),
                                journal.open_stream("node/robot1"));
                         }) + by_hand);
  const auto records = read_journal(folder / "j", {.kinds = {RecordKind::kSkill, RecordKind::kDecision}});
  ASSERT_TRUE(records.ok()) << records.error().text();
  std::vector<std::string> found;
  for (const JournalRecord& record : *records)
    found.push_back(record.stream + ' ' + std::string(to_string(record.kind)));
  EXPECT_THAT(found, ElementsAre("node/robot1 skill", "env/{\"kind\":\"fire\" decision", "s decision"));
}

TEST(JournalReader, TakesOnlyWhatTheFilterAsksFor) {
  TempFolder folder;
  std::string lines;
  for (const char* stream : {"a", "b"})
    for (int t = 0; t < 4; ++t)
      for (const char* kind : {"fire", "skill"})
        lines += std::string(R"({"stream":")") + stream + R"(","n":0,"t":)" + std::to_string(t) + R"(,"kind":")" +
                 kind + R"(","data":{},"cause":[]})" + "\n";
  put_file(folder / "j", lines);
  const auto taken = [&](const RecordFilter& filter) {
    std::string out;
    const auto records = read_journal(folder / "j", filter);
    for (const JournalRecord& record : *records)
      out += record.stream + std::to_string(record.t.count()) + (record.kind == RecordKind::kFire ? "f " : "s ");
    return out;
  };
  EXPECT_EQ(taken({}), "a0f a0s a1f a1s a2f a2s a3f a3s b0f b0s b1f b1s b2f b2s b3f b3s ");
  EXPECT_EQ(taken({.stream = "b", .from = SimTime{1}, .to = SimTime{2}}), "b1f b1s b2f b2s ");
  EXPECT_EQ(taken({.kinds = {RecordKind::kSkill}, .from = SimTime{3}}), "a3s b3s ");
  EXPECT_EQ(taken({.kinds = {RecordKind::kFire, RecordKind::kSkill}, .stream = "a", .to = SimTime{0}}), "a0f a0s ");
}

TEST(JournalReader, ReportsACauseThatIsNone) {
  TempFolder folder;
  const auto error = [&](const std::string& cause) {
    put_file(folder / "j", R"({"stream":"s","n":0,"t":0,"kind":"decision","data":{},"cause":[)" + cause + "]}\n{}\n");
    return read_journal(folder / "j").error().message;
  };
  EXPECT_EQ(error("7"), R"(expected "cause", a list of stream:n, found 7)");
  EXPECT_EQ(error("\"s\""), R"(expected "cause", a list of stream:n, found "s")");
  for (const char* none : {"\"s:\"", "\"s:x\"", "\"s:-1\"", "\"s:1x\"", "\"s: 1\"", "\"s:18446744073709551616\""})
    EXPECT_EQ(error(none), R"(expected "cause", a list of stream:n, found )" + std::string(none));
  EXPECT_EQ(error("\"caf\u00e9\""), R"(expected "cause", a list of stream:n, found "caf\u00e9")");
}

TEST(JournalReader, LeavesOutALastLineThatIsCutOff) {
  TempFolder folder;
  const std::string text = exported(JournalLevel::kDecisions, [](Journal& journal) {
    tell(journal, journal.open_stream("env/a"), journal.open_stream("node/robot1"));
  });
  put_file(folder / "j", text.substr(0, text.size() - 7));
  const auto records = read_journal(folder / "j");
  ASSERT_TRUE(records.ok()) << records.error().text();
  EXPECT_EQ(records->size(), 2u);
}

TEST(JournalReader, AFolderAndAMissingFileCannotBeRead) {
  TempFolder folder;
  EXPECT_EQ(read_journal(folder / "none").error().text(), (folder / "none").string() + ": there is no such file");
  EXPECT_EQ(read_journal(folder.path()).error().text(),
            folder.path().string() + ": is no regular file, expected a journal");
}

TEST(JournalReader, DataBecomesTheTextThatItWasReadFrom) {
  const std::string data =
      R"({"b":true,"i":-3,"u":18446744073709551615,"r":1.5,"w":2.0,"t":"a\"b","l":[1,[],{}],"m":{"z":null,"a":"x"}})";
  const auto record =
      parse_journal_line(R"({"stream":"s","n":0,"t":0,"kind":"fire","data":)" + data + R"(,"cause":[]})");
  ASSERT_TRUE(record.ok()) << record.error().text();
  EXPECT_EQ(to_json(record->data), data);
}

/// Both readers of a line give the same record for a line that can be split.
void expect_same_record(const std::string& line, const JournalLine& split) {
  const auto record = parse_journal_line(line);
  ASSERT_TRUE(record.ok()) << line << record.error().text();
  std::string causes;
  for (const JournalRecord::Cause& cause : record->causes)
    causes += (causes.empty() ? "\"" : ",\"") + cause.stream + ':' + std::to_string(cause.n) + '"';
  EXPECT_EQ(split.stream, record->stream);
  EXPECT_EQ(split.n, record->n);
  EXPECT_EQ(split.t, record->t);
  EXPECT_EQ(split.kind, record->kind);
  EXPECT_EQ(split.data, to_json(record->data));
  EXPECT_EQ(split.causes, causes);
}

TEST(JournalReader, EachLineOfAJournalCanBeSplit) {
  const std::string text = exported(JournalLevel::kFull, [](Journal& journal) {
    tell(journal, journal.open_stream("env/a"), journal.open_stream("node/robot1"));
    RecordData data;
    data.begin().field("text", R"(a "b", {"cause":["c:1"]} \ d)").field("list", std::vector<double>{1, 2.5});
    journal.write(journal.open_stream("s:t"), seconds(1), RecordKind::kBus, data);
  });
  std::istringstream lines(text);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const auto split = split_journal_line(line);
    ASSERT_TRUE(split) << line;
    expect_same_record(line, *split);
  }
  EXPECT_EQ(count, 4);
}

TEST(JournalReader, OnlyARecordIsSplit) {
  const std::string good = R"({"stream":"s","n":10,"t":-3,"kind":"fire","data":{"a":[1]},"cause":["b:2","c:d:3"]})";
  ASSERT_TRUE(split_journal_line(good));
  expect_same_record(good, *split_journal_line(good));
  // One character less, or another one in its place: what is split is a record all the same.
  for (std::size_t i = 0; i < good.size(); ++i)
    for (const std::string& with : {std::string(), std::string("\""), std::string("0"), std::string("\\"),
                                    std::string("]"), std::string(","), std::string("\xff")}) {
      std::string line = good;
      line.replace(i, 1, with);
      if (const auto split = split_journal_line(line)) expect_same_record(line, *split);
    }
}

TEST(JournalReader, NamesTheLineThatIsWrong) {
  const std::string good = R"({"stream":"s","n":0,"t":0,"kind":"fire","data":{},"cause":[]})"
                           "\n";
  const auto error_of = [&](const std::string& second_line) {
    TempFolder folder;
    put_file(folder / "j", good + second_line + "\n");
    const auto records = read_journal(folder / "j");
    return records.ok() ? std::string() : records.error().text();
  };
  EXPECT_THAT(error_of("{"), HasSubstr("j:2: expected a record"));
  EXPECT_THAT(error_of(R"({"stream":"s","n":-1,"t":0,"kind":"fire","data":{},"cause":[]})"), HasSubstr("\"n\""));
  for (const char* t : {"1.5", "\"0\"", "null"})
    EXPECT_THAT(error_of(R"({"stream":"s","n":0,"t":)" + std::string(t) + R"(,"kind":"fire","data":{},"cause":[]})"),
                HasSubstr("\"t\""))
        << t;
  EXPECT_THAT(error_of(R"({"stream":1,"n":0,"t":0,"kind":"fire","data":{},"cause":[]})"), HasSubstr("\"stream\""));
  EXPECT_THAT(error_of(R"({"stream":"s","n":0.5,"t":0,"kind":"fire","data":{},"cause":[]})"), HasSubstr("\"n\""));
  EXPECT_THAT(error_of(R"({"stream":"s","n":0,"t":0,"kind":7,"data":{},"cause":[]})"), HasSubstr("\"kind\""));
  EXPECT_THAT(error_of(R"({"stream":"s","n":0,"t":0,"kind":"fire","data":[],"cause":[]})"), HasSubstr("\"data\""));
  EXPECT_THAT(error_of(R"({"stream":"s","n":0,"t":0,"kind":"fire","data":{},"cause":{}})"), HasSubstr("\"cause\""));
  EXPECT_THAT(error_of(R"({"stream":"s","n":0,"t":0,"kind":"fired","data":{},"cause":[]})"),
              HasSubstr("j:2: 'fired' is no kind of record"));
  EXPECT_THAT(error_of(R"({"stream":"s","n":0,"t":0,"kind":"fire","data":{},"cause":["s"]})"), HasSubstr("stream:n"));
  EXPECT_THAT(error_of(R"({"stream":"s","n":0,"t":0,"kind":"fire","cause":[]})"), HasSubstr("\"data\""));
}

TEST(JournalExport, BytesThatAreNoRecordAreAnError) {
  const auto accepted = [](std::string_view bytes) {
    std::string json;
    return append_json(bytes, json).ok();
  };
  RecordData data;
  data.begin().field("text", "a longer text than thirty-two bytes, so that its length has four");
  data.field("list", std::vector<double>{1, 2});
  const std::string whole(data.bytes());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(accepted(std::string_view(whole).substr(0, size))) << size;
  }
  EXPECT_FALSE(accepted(whole + "x"));
  EXPECT_FALSE(accepted("\xdd\xff\xff\xff\xff")) << "a list longer than the bytes";
  std::string json = "before ";
  EXPECT_FALSE(append_json(std::string("\xdd\0\0\0\2\xc0\xdf\0\0\0\1", 11), json).ok());
  EXPECT_EQ(json, "before [null,") << "the map has no room for its value";
  std::string nested;
  for (int i = 0; i < 100'000; ++i) nested += std::string("\xdd\x00\x00\x00\x01", 5);
  EXPECT_FALSE(accepted(nested + "\xc0"));
}

TEST(JournalLevel, IsOneOfThreeWords) {
  JournalLevel level{};
  auto words = named(level, kJournalLevels);
  EXPECT_TRUE(words.set("full"));
  EXPECT_EQ(level, JournalLevel::kFull);
  EXPECT_FALSE(words.set("all"));
  EXPECT_EQ(words.word(), "full");
  EXPECT_TRUE(words.set("none"));
  EXPECT_EQ(level, JournalLevel::kNone);
}

}  // namespace
}  // namespace cxlab
