#include "cx/journal/input_log.h"

#include <gmock/gmock.h>
#include <xxhash.h>

#include <cstring>
#include <random>

#include "tests/support/files.h"

namespace cxlab {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

LoggedDelivery topic(std::string_view message) {
  LoggedDelivery d;
  d.delivery.kind = bus::DeliveryKind::kTopic;
  d.from = "node/referee";
  d.delivery.sequence = 300;
  d.endpoint = 2;
  d.type = "llsf_msgs/msg/GameState";
  d.message = message;
  d.cause_stream = "node/referee";
  d.delivery.cause.n = 1'000'000;
  return d;
}

LoggedDelivery goal_result() {
  LoggedDelivery d;
  d.delivery.kind = bus::DeliveryKind::kResult;
  d.from = "node/robot1";
  d.endpoint = 70'000;
  d.delivery.goal = {1, 2, 3};
  d.delivery.accepted = true;
  d.delivery.status = bus::GoalStatus::kAborted;
  d.delivery.return_code = -1;
  d.delivery.stamp = seconds(3);
  d.delivery.request_id = 9;
  d.delivery.goals_canceling = {{{9}, seconds(1)}, {{8}, seconds(-2)}};
  d.cause_stream = "node/robot1";
  return d;
}

void add_some(InputLogWriter& log, int rounds = 1) {
  for (int i = 0; i < rounds; ++i) {
    const SimTime t = milliseconds(20) * i;
    log.add(LoggedTake{t, "env/a", {topic("hello"), goal_result()}});
    log.add(LoggedTake{t, "env/b", {}});
    log.add(LoggedResult{t, "env/a", "read-line", "typed"});
    log.add(LoggedWorld{t, "world", std::string_view("\0\1\2", 3)});
  }
}

std::string bytes_of(int rounds = 1) {
  TempFolder temp;
  auto log = InputLogWriter::create(temp / "inputs.bin");
  add_some(*log, rounds);
  EXPECT_TRUE(log->close(SimTime{}).ok());
  return content_of(temp / "inputs.bin");
}

struct Read {
  std::size_t entries = 0;
  Status status;
};

Read read_all(std::string bytes) {
  auto reader = InputLogReader::from_bytes(std::move(bytes), "inputs.bin");
  if (!reader) return {0, reader.error()};
  Read read;
  while (reader->next()) ++read.entries;
  read.status = reader->status();
  return read;
}

TEST(InputLog, GivesBackEveryFieldOfEveryEntry) {
  auto reader = InputLogReader::from_bytes(bytes_of(2), "inputs.bin");
  ASSERT_TRUE(reader.ok());
  for (int i = 0; i < 2; ++i) {
    const auto take = std::get<LoggedTake>(*reader->next());
    EXPECT_EQ(take.t, milliseconds(20) * i);
    EXPECT_EQ(take.to, "env/a");
    ASSERT_EQ(take.deliveries.size(), 2u);

    const LoggedDelivery& message = take.deliveries[0];
    EXPECT_EQ(message.delivery.kind, bus::DeliveryKind::kTopic);
    EXPECT_EQ(message.from, "node/referee");
    EXPECT_EQ(message.delivery.sequence, 300u);
    EXPECT_EQ(message.endpoint, 2u);
    EXPECT_EQ(message.type, "llsf_msgs/msg/GameState");
    EXPECT_EQ(message.message, "hello");
    EXPECT_FALSE(message.delivery.accepted);
    EXPECT_TRUE(message.delivery.goals_canceling.empty());
    EXPECT_EQ(message.cause_stream, "node/referee");
    EXPECT_EQ(message.delivery.cause.n, 1'000'000u);

    const LoggedDelivery& result = take.deliveries[1];
    const LoggedDelivery expected = goal_result();
    EXPECT_EQ(result.type, "");
    EXPECT_EQ(result.endpoint, expected.endpoint);
    EXPECT_EQ(result.delivery.goal, expected.delivery.goal);
    EXPECT_TRUE(result.delivery.accepted);
    EXPECT_EQ(result.delivery.status, expected.delivery.status);
    EXPECT_EQ(result.delivery.return_code, expected.delivery.return_code);
    EXPECT_EQ(result.delivery.stamp, expected.delivery.stamp);
    EXPECT_EQ(result.delivery.request_id, expected.delivery.request_id);
    EXPECT_EQ(result.delivery.goals_canceling, expected.delivery.goals_canceling);

    EXPECT_EQ(std::get<LoggedTake>(*reader->next()).to, "env/b");
    const auto typed = std::get<LoggedResult>(*reader->next());
    EXPECT_EQ(typed.t, milliseconds(20) * i);
    EXPECT_EQ(typed.environment, "env/a");
    EXPECT_EQ(typed.key, "read-line");
    EXPECT_EQ(typed.bytes, "typed");
    const auto world = std::get<LoggedWorld>(*reader->next());
    EXPECT_EQ(world.world, "world");
    EXPECT_EQ(world.bytes, std::string_view("\0\1\2", 3));
  }
  EXPECT_FALSE(reader->next());
  EXPECT_TRUE(reader->status().ok());
}

TEST(InputLog, NamesMayBeEmpty) {
  TempFolder temp;
  auto log = InputLogWriter::create(temp / "inputs.bin");
  LoggedDelivery nobody;
  nobody.delivery.return_code = 1;
  log->add(LoggedTake{seconds(1), "", {nobody}});
  log->add(LoggedResult{seconds(1), "env/a", "", ""});
  ASSERT_TRUE(log->close(SimTime{}).ok());
  auto reader = InputLogReader::open(temp / "inputs.bin");
  ASSERT_TRUE(reader.ok());
  const auto take = reader->next();
  ASSERT_TRUE(take && std::holds_alternative<LoggedTake>(*take));
  EXPECT_EQ(std::get<LoggedTake>(*take).to, "");
  ASSERT_EQ(std::get<LoggedTake>(*take).deliveries.size(), 1u);
  EXPECT_EQ(std::get<LoggedTake>(*take).deliveries[0].from, "");
  EXPECT_EQ(std::get<LoggedTake>(*take).deliveries[0].delivery.return_code, 1);
  const auto result = reader->next();
  ASSERT_TRUE(result && std::holds_alternative<LoggedResult>(*result));
  EXPECT_EQ(std::get<LoggedResult>(*result).environment, "env/a");
  EXPECT_EQ(std::get<LoggedResult>(*result).key, "");
  EXPECT_FALSE(reader->next());
  EXPECT_TRUE(reader->status().ok());
}

TEST(InputLog, SpellsANameOnce) {
  const std::string bytes = bytes_of(100);
  EXPECT_EQ(bytes.find("llsf_msgs", bytes.find("llsf_msgs") + 1), std::string::npos);
  EXPECT_LT(bytes.size(), 100 * 130u);
}

TEST(InputLog, AnEndThatIsCutOffLosesOnlyItsChunk) {
  TempFolder temp;
  auto log = InputLogWriter::create(temp / "inputs.bin");
  add_some(*log);
  ASSERT_TRUE(log->flush().ok());
  const auto whole = std::filesystem::file_size(temp / "inputs.bin");
  add_some(*log);
  ASSERT_TRUE(log->close(SimTime{}).ok());
  const std::string bytes = content_of(temp / "inputs.bin");

  for (std::size_t size = whole + 1; size < bytes.size(); ++size) {
    const Read read = read_all(bytes.substr(0, size));
    EXPECT_EQ(read.entries, 4u) << size;
    ASSERT_FALSE(read.status.ok()) << size;
    EXPECT_THAT(read.status.error().text(), HasSubstr("inputs.bin: broken at byte " + std::to_string(whole)));
    EXPECT_THAT(read.status.error().text(), HasSubstr("cut off"));
  }
  EXPECT_TRUE(read_all(bytes.substr(0, whole)).status.ok());
  EXPECT_EQ(read_all(bytes).entries, 8u);
}

TEST(InputLog, EntriesReachTheFileWithinTenSimulatedSeconds) {
  TempFolder temp;
  auto log = InputLogWriter::create(temp / "inputs.bin");
  const auto entries = [&] { return read_all(content_of(temp / "inputs.bin")).entries; };
  log->add(LoggedWorld{{}, "world", "start"});
  EXPECT_EQ(entries(), 0u);
  log->reach(kStarted);
  EXPECT_EQ(entries(), 1u);
  log->reach(SimTime{});
  for (int i = 1; i <= 16; ++i) {
    log->add(LoggedWorld{seconds(i), "world", "early"});
    log->reach(seconds(i));
    EXPECT_GE(entries(), 1u + static_cast<std::size_t>(i) / 2) << "at most half of a short run is lost";
  }
  EXPECT_EQ(entries(), 17u);
  log->add(LoggedWorld{milliseconds(25'980), "world", "a"});
  log->reach(milliseconds(25'980));
  EXPECT_EQ(entries(), 17u);
  log->add(LoggedWorld{seconds(26), "world", "b"});
  EXPECT_EQ(entries(), 17u) << "the tick may have more";
  log->reach(seconds(26));
  EXPECT_EQ(entries(), 19u);
}

TEST(InputLog, SaysHowFarItHasAllInputs) {
  TempFolder temp;
  auto log = InputLogWriter::create(temp / "inputs.bin");
  const auto read = [&] {
    auto reader = InputLogReader::open(temp / "inputs.bin");
    EXPECT_TRUE(reader.ok()) << "a run that was killed at once has a log";
    while (reader->next()) continue;
    EXPECT_TRUE(reader->status().ok());
    return reader->reached();
  };
  EXPECT_LT(read(), kStarted);
  log->add(LoggedWorld{{}, "world", "start"});
  ASSERT_TRUE(log->flush().ok());
  EXPECT_LT(read(), kStarted) << "the start may have more";
  log->reach(kStarted);
  EXPECT_EQ(read(), kStarted);
  log->reach(SimTime{});
  EXPECT_EQ(read(), SimTime{});
  for (int i = 0; i <= 1500; ++i) log->reach(milliseconds(20) * i);
  EXPECT_GE(read(), SimTime(seconds(20)));
  EXPECT_LE(read(), SimTime(seconds(30)));
  log->add(LoggedWorld{seconds(31), "world", "a"});
  ASSERT_TRUE(log->flush().ok());
  EXPECT_EQ(read(), SimTime(seconds(31)) - SimTime{1}) << "its tick may have more";
  ASSERT_TRUE(log->close(seconds(31)).ok());
  EXPECT_EQ(read(), SimTime(seconds(31))) << "the end";
}

TEST(InputLog, AFullDiskIsAnErrorAndLeavesWholeChunks) {
  TempFolder temp;
  auto log = InputLogWriter::create(temp / "inputs.bin");
  {
    FileSizeLimit limit(100'000);
    add_some(*log, 5000);
    EXPECT_FALSE(log->close(SimTime{}).ok());
  }
  EXPECT_EQ(log->status().error().kind, ErrorKind::kResource);
  const Read read = read_all(content_of(temp / "inputs.bin"));
  EXPECT_GT(read.entries, 1000u);
  EXPECT_TRUE(read.status.ok()) << read.status.error().text();
}

TEST(InputLog, AnyChangedByteIsNoticed) {
  const std::string bytes = bytes_of();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ 0x20);
    EXPECT_FALSE(read_all(changed).status.ok()) << "byte " << i;
  }
}

TEST(InputLog, ContentThatNoWriterMakesIsAnErrorEvenWithARightChecksum) {
  const std::string bytes = bytes_of(3);
  constexpr std::size_t kHeader = 8 + 12;
  std::mt19937_64 random(2026);
  int refused = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::string payload = bytes.substr(kHeader);
    for (int change = 0; change < 3; ++change) payload[random() % payload.size()] = static_cast<char>(random());
    if (round % 2) payload.resize(random() % payload.size());
    const auto length = static_cast<std::uint32_t>(payload.size());
    const std::uint64_t checksum = XXH3_64bits(payload.data(), payload.size());
    std::string changed = bytes.substr(0, kHeader) + payload;
    std::memcpy(changed.data() + 8, &length, sizeof length);
    std::memcpy(changed.data() + 12, &checksum, sizeof checksum);
    const Read read = read_all(changed);
    EXPECT_LE(read.entries, payload.size());
    if (!read.status) ++refused;
  }
  EXPECT_GT(refused, 10'000);
}

/// A log of one chunk with these entries and the right checksum.
std::string log_of(std::string_view entries) {
  const auto length = static_cast<std::uint32_t>(entries.size());
  const std::uint64_t checksum = XXH3_64bits(entries.data(), entries.size());
  std::string log = "CXLABIN2";
  log.append(reinterpret_cast<const char*>(&length), sizeof length);
  log.append(reinterpret_cast<const char*>(&checksum), sizeof checksum);
  return log.append(entries);
}

TEST(InputLog, EntriesThatNoWriterMakesAreErrors) {
  // type, time, names by number (a new one is spelt), texts with their length: a result of "env/a" for "key"
  const auto log = [](std::string_view entries) { return read_all(log_of(entries)); };
  using std::string_view_literals::operator""sv;
  EXPECT_EQ(log("\2\0\1\5env/a\2\3key\5typed"sv).entries, 1u);
  EXPECT_TRUE(log("\2\0\1\5env/a\2\3key\5typed"sv).status.ok());
  for (const std::string_view wrong : {
           "\0\0\1\5env/a\2\3key\5typed"sv,                      // no type
           "\5\0\1\5env/a\2\3key\5typed"sv,                      // another type
           "\2\0\2\5env/a\3\3key\5typed"sv,                      // names that do not begin with 1
           "\2\0\1\5env/a\3\3key\5typed"sv,                      // a name whose number comes too early
           "\2\0\1\5env/a\2\3key\6typed"sv,                      // longer than the rest
           "\1\0\1\5env/a\2"sv,                                  // two deliveries announced
           "\1\0\1\5env/a\1\7\0\0\1\xff\xff\xff\xff\x1f\0\0"sv,  // number of an endpoint beyond 32 bits
       }) {
    const Read read = log(wrong);
    EXPECT_EQ(read.entries, 0u);
    ASSERT_FALSE(read.status.ok());
    EXPECT_EQ(read.status.error().kind, ErrorKind::kInput);
    EXPECT_THAT(read.status.error().text(), HasSubstr("an entry that no writer makes"));
  }
}

TEST(InputLog, AnotherFileIsRefused) {
  EXPECT_FALSE(InputLogReader::from_bytes("", "x").ok());
  EXPECT_THAT(InputLogReader::from_bytes("{\"stream\"", "x").error().text(), HasSubstr("x: expected an input log"));
  EXPECT_FALSE(InputLogReader::open("/nowhere/inputs.bin").ok());
}

}  // namespace
}  // namespace cxlab
