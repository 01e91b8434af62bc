// A world of the test's own: what docs/how-to/write-a-world.md promises of a config struct, a stage and a row.

#include <algorithm>

#include "cx/journal/journal_reader.h"
#include "scenarios/question.h"
#include "scenarios/result.h"
#include "tests/support/episode_test.h"

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct BellConfig {
  double period_s = 1;
  int most = 3;

  template <class Keys>
  void fields(Keys& keys) {
    keys("period_s", period_s);
    keys("most", most);
  }
};
Status validate(const BellConfig& config) {
  return config.period_s > 0 ? Status() : Status(input_error("period_s: expected more than 0"));
}

/// Rings on /bell, and is over when it has rung often enough.
class Bell final : public Server, public Referee {
 public:
  Bell(const BellConfig& config, bus::Bus& bus, RecordSink& sink) : config_(config), bus_(bus) {
    const auto self = bus.join(bus::ParticipantKind::kNode, {"bell", "/", {}}, sink.open_stream("node/bell"));
    type_ = *bus.registry().message("std_msgs/msg/String");
    endpoint_ = *bus.advertise(self, "/bell", *type_);
  }
  Status sense(SimTime now) override {
    if (now < next_due()) return {};
    ++rung;
    bus::Message message(*type_);
    message->set("data", "ring " + std::to_string(rung));
    bus_.publish(endpoint_, std::make_shared<const bus::Message>(std::move(message)));
    return {};
  }
  Status act(SimTime) override { return {}; }
  Status judge(SimTime) override { return {}; }
  SimTime next_due() const override { return from_seconds(config_.period_s * (rung + 1)); }
  bool over() const override { return rung >= config_.most; }
  int rung = 0;

 private:
  BellConfig config_;
  bus::Bus& bus_;
  const bus::MessageType* type_ = nullptr;
  bus::EndpointId endpoint_{};
};

class OneColour final : public View {
 public:
  explicit OneColour(std::string name) : name_(std::move(name)) {}
  Expected<const sim::Picture*> draw(std::string_view camera) override {
    if (camera != name_ && camera != "hidden") return input_error("no camera " + std::string(camera));
    return &picture_;
  }
  std::vector<std::string> cameras() const override { return {name_}; }

 private:
  std::string name_;
  sim::Picture picture_{1, 1, {1, 2, 3}};
};

ViewMaker view_named(const std::string& name) {
  return [name](int, int) -> Expected<std::unique_ptr<View>> {
    return std::unique_ptr<View>(std::make_unique<OneColour>(name));
  };
}

class BellStage final : public Stage {
 public:
  explicit BellStage(const StageSetup& setup) {
    auto bell = std::make_unique<Bell>(setup.scenario.world.get<BellConfig>(), setup.bus, setup.sink);
    bell_ = bell.get();
    referee = bell.get();
    servers.push_back(std::move(bell));
    views.push_back(view_named("tower"));
    scenes.push_back([this](SceneList& list) {
      list.put({.number = 1, .kind = "bell", .name = "bell", .state = "rung " + std::to_string(bell_->rung)});
    });
  }
  void report(Result& result) const override {
    result.set("bell", "{\"rung\": " + std::to_string(bell_->rung) + "}");
    result.score_board += "rung " + std::to_string(bell_->rung) + " times\n";
  }

 private:
  const Bell* bell_ = nullptr;
};

Expected<RunPage> page_of_bell(const AskedRun& run, const Result& result) {
  PageLane lane{"bell", {}, {}};
  for (const JournalRecord& record : run.records)
    if (record.data.text("event") == "rung") lane.marks.push_back({"rung", to_seconds(record.t), "rang"});
  RunPage page;
  page.kinds = {{.name = "rung", .fill = "#f2b134", .ink = ""}};
  page.parts.emplace_back(PageTable{"The bell", {"rung"}, {{result.at("bell.rung")}}});
  page.parts.emplace_back(PageLanes{"When it rang", {{"", "rang"}}, {std::move(lane)}});
  return page;
}

constexpr ResultSection kBellSections[]{
    {.key = "bell", .what = "how often the bell rang", .initial = R"({"rung": 0})"}};
constexpr Metric kBellMetrics[]{
    {.name = "rung", .what = "how often the bell rang", .from = "bell.rung", .title = "rung"}};
constexpr WorldKind kBell{
    .name = "bell",
    .what = "a bell that rings",
    .settings = settings_of<BellConfig>(),
    .duration = std::chrono::seconds(20),
    .make_stage = [](const StageSetup& setup) -> Expected<std::unique_ptr<Stage>> {
      return std::unique_ptr<Stage>(std::make_unique<BellStage>(setup));
    },
    .sections = kBellSections,
    .metrics = kBellMetrics,
    .page = page_of_bell,
};

constexpr ResultSection kChimeSections[]{{.key = "chime", .what = "how often it may ring", .initial = "0"}};
constexpr NodeKind kChime{
    .name = "chime",
    .what = "a second bell",
    .settings = settings_of<BellConfig>(),
    .add = [](const ServerSpec& spec, const StageSetup&, Stage& stage) -> Status {
      const int most = spec.get<BellConfig>().most;
      stage.views.push_back(view_named("tower"));
      stage.reports.push_back([most](Result& result) { result.set("chime", std::to_string(most)); });
      return {};
    },
    .sections = kChimeSections};

Catalogue bells() {
  Catalogue catalogue = shipped();
  catalogue.worlds.push_back(&kBell);
  catalogue.nodes.push_back(&kChime);
  return catalogue;
}

class OwnWorld : public EpisodeTest {
 protected:
  Expected<Scenario> read(const std::string& text) {
    return Scenario::parse("schema: 1\n" + text, folder_ / "s.yaml", catalogue_);
  }
  std::string error_of(const std::string& text) {
    const auto scenario = read(text);
    return scenario ? std::string() : scenario.error().message;
  }
  const Catalogue catalogue_ = bells();
  static std::string read_text(const std::filesystem::path& path) { return EpisodeTest::read(path); }
};

TEST_F(OwnWorld, PlaysWithARow) {
  const auto scenario = read("world: {kind: bell, period_s: 0.5, most: 4}\nexpect: [{path: bell.rung, min: 4}]\n");
  ASSERT_TRUE(scenario.ok()) << scenario.error().text();
  EXPECT_EQ(scenario->duration, from_seconds(20));
  EXPECT_EQ(scenario->tier_name(), "none");
  auto episode = load(*scenario);
  std::vector<std::string> heard;
  bus::Bus& bus = episode->bus();
  const auto me = bus.join(bus::ParticipantKind::kNode, {"ear", "/", {}}, episode->journal().open_stream("node/ear"));
  ASSERT_TRUE(bus.subscribe(me, "/bell", **bus.registry().message("std_msgs/msg/String"),
                            [&](const bus::Delivery& d) {
                              heard.push_back(std::to_string(to_seconds(bus.now())) + ' ' +
                                              std::string(d.message->view().text("data")));
                            })
                  .ok());
  begin(*episode);
  while (!episode->over()) {
    ASSERT_TRUE(episode->tick().ok());
    bus.deliver(me);
  }
  EXPECT_TRUE(episode->completed()) << "the referee has ended it";
  EXPECT_THAT(heard, ElementsAre("0.500000 ring 1", "1.000000 ring 2", "1.500000 ring 3", "2.000000 ring 4"));
  const Result result = episode->close(RunStatus::kCompleted);
  EXPECT_EQ(result.at("bell.rung"), "4");
  EXPECT_EQ(result.score_board, "rung 4 times\n");
  EXPECT_EQ(result.sim_time, from_seconds(2));
  EXPECT_EQ(measure(metrics_of(kBell), result.to_json()).front(), 4);
  const std::filesystem::path none;
  std::vector<JournalRecord> records(1);
  records[0].data.value = RecordValue::Map{{"event", {"rung"}}};
  const auto page = kBell.page({none, *scenario, records, {}, result.sim_time, true, {}}, result);
  ASSERT_TRUE(page.ok());
  EXPECT_EQ(std::get<PageTable>(page->parts[0]).rows[0][0].text, "4");
  EXPECT_EQ(std::get<PageLanes>(page->parts[1]).lanes[0].marks.size(), 1u);
  EXPECT_TRUE(check_expectations(scenario->expect, result.to_json()).ok());
}

TEST_F(OwnWorld, ItsKeysAreCheckedAsThoseOfTheShippedWorlds) {
  EXPECT_THAT(error_of("world: {kind: bel}\n"), HasSubstr("expected one of: none, rcll, turtlesim, story, bell"));
  EXPECT_THAT(error_of("world: {kind: bell, perod_s: 1}\n"), HasSubstr("did you mean 'period_s'?"));
  EXPECT_EQ(error_of("world: {kind: bell, period_s: 0}\n"), "world.period_s: expected more than 0");
  EXPECT_THAT(error_of("world: {kind: bell}\nexpect: [{path: bell.rang, min: 1}]\n"),
              HasSubstr("did you mean 'rung'?"));
  EXPECT_THAT(error_of("world: {kind: bell}\nexpect: [{path: chime, min: 1}]\n"), HasSubstr("no 'chime'"));
  EXPECT_EQ(error_of("world: {kind: bell}\nservers: [chime]\nexpect: [{path: chime, min: 1}]\n"), "");
  EXPECT_EQ(error_of("world: {kind: bell}\nfaults: [{kind: machine_breaks, at: 1, machine: C-BS}]\n"),
            "faults: this world has neither robots nor machines: expected world.kind rcll");
  EXPECT_EQ(Scenario::parse("schema: 1\nworld: {kind: bell}\n", "s.yaml", shipped()).error().message,
            "world.kind: found 'bell', expected one of: none, rcll, turtlesim, story")
      << "a catalogue of one's own changes no other";
}

TEST_F(OwnWorld, ItsSettingsAreInTheCopyOfTheScenario) {
  Scenario built;
  built.set_world({&kBell, BellConfig{.period_s = 0.25, .most = 3}});
  built.servers.push_back({&kChime, BellConfig{.most = 7}});
  EXPECT_THAT(built.to_yaml(), HasSubstr("world:\n  kind: bell\n  period_s: 0.25\n"));
  EXPECT_THAT(built.to_yaml(), HasSubstr("servers:\n  - node: chime\n    most: 7\n"));
  const auto read_in = Scenario::parse(built.to_yaml(), "s.yaml", catalogue_);
  ASSERT_TRUE(read_in.ok()) << read_in.error().text();
  EXPECT_EQ(read_in->world.get<BellConfig>().period_s, 0.25);
  EXPECT_EQ(read_in->servers[0].get<BellConfig>().most, 7);
}

TEST_F(OwnWorld, NodesAddTheirViewsAndSections) {
  const auto scenario = read("world: {kind: bell}\nservers: [chime, {node: chime, most: 9}]\n");
  auto episode = load(*scenario);
  begin(*episode);
  auto view = view_of(episode->stage(), 10, 10);
  ASSERT_TRUE(view.ok());
  EXPECT_THAT((*view)->cameras(), ElementsAre("tower", "tower2", "tower3"));
  EXPECT_TRUE((*view)->draw("tower3").ok());
  EXPECT_TRUE((*view)->draw("hidden").ok()) << "the first view may know more cameras than it lists";
  EXPECT_FALSE((*view)->draw("tower4").ok());
  EXPECT_EQ(episode->result().at("chime"), "9");
  Stage empty;
  EXPECT_EQ(view_of(empty, 10, 10).error().message, "the world is empty: there is nothing to look at");
}

Expected<WorldAnswer> answer_rings(const AskedRun& run) {
  Table rings{"rings", "", {{"t_s", "time", Column::Kind::kTime}, {"bell", "bell"}}, {}};
  for (const JournalRecord& record : run.records)
    if (record.data.text("event") == "rung" && record.t >= run.from)
      rings.rows.push_back({record.t, record.data.text("bell")});
  return WorldAnswer{{std::move(rings)}, {}};
}
constexpr WorldQuestion kRings[]{{.name = "rings", .what = "Lists when a bell rang", .ask = answer_rings}};

TEST(WorldQuestions, AreAnsweredFromRecords) {
  std::vector<JournalRecord> records;
  for (const int second : {1, 3}) {
    const auto line =
        parse_journal_line(R"({"stream":"referee","n":0,"t":)" + std::to_string(second) +
                           R"(000000000,"kind":"referee","data":{"event":"rung","bell":"big"},"cause":[]})");
    ASSERT_TRUE(line) << line.error().text();
    records.push_back(*line);
  }
  const Scenario scenario;
  const std::filesystem::path folder;
  const auto answer =
      kRings[0].ask({folder, scenario, records, from_seconds(2), from_seconds(4), /*ended=*/true, /*about=*/{}});
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->tables[0].rows.size(), 1u);
  EXPECT_EQ(std::get<double>(answer->tables[0].rows[0][0].value), 3);
  EXPECT_EQ(std::get<std::string>(answer->tables[0].rows[0][1].value), "big");
}

TEST(WorldQuestions, TimesAreShownAsOptionsTakeThem) {
  EXPECT_EQ(time_text(0.0), "0:00.0");
  EXPECT_EQ(time_text(312.44), "5:12.4");
  EXPECT_EQ(time_text(59.96), "1:00.0");
  EXPECT_EQ(time_text(3600), "60:00.0");
}

/// Without its white space: the formatter may break lines elsewhere.
std::string dense(const std::string& text) {
  std::string out;
  std::ranges::copy_if(text, std::back_inserter(out), [](unsigned char c) { return !std::isspace(c); });
  return out;
}

TEST_F(OwnWorld, IsWhatTheDocumentationShows) {
  const std::string page = read_text(source_dir() / "docs/how-to/write-a-world.md"),
                    code = dense(read_text(source_dir() / "tests/scenarios/world_test.cpp"));
  int blocks = 0;
  for (std::size_t at = 0; (at = page.find("```cpp\n", at)) != std::string::npos; ++blocks) {
    const std::size_t end = page.find("```", at + 7);
    const std::string block = page.substr(at + 7, end - at - 7);
    EXPECT_NE(code.find(dense(block)), std::string::npos) << block;
    at = end;
  }
  EXPECT_EQ(blocks, 8);
}

}  // namespace
}  // namespace cxlab
