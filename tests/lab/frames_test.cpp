#include "lab/frames.h"

#include <gmock/gmock.h>

#include <set>

#include "folder.h"
#include "lab/happenings.h"
#include "scenarios/shipped/catalogue.h"
#include "sim/mujoco/font.h"

namespace cxlab::lab {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(CameraNames, AreBetweenCommas) {
  EXPECT_THAT(camera_names("field,follow-robot1"), ElementsAre("field", "follow-robot1"));
  EXPECT_THAT(camera_names(""), IsEmpty());
  EXPECT_THAT(camera_names(",top,,"), ElementsAre("top"));
}

TEST(Tiles, CoverThePictureSideBySide) {
  for (const auto& [width, height] : {std::pair{960, 684}, {640, 480}, {641, 479}, {200, 900}, {1900, 300}})
    for (std::size_t count = 1; count <= 7; ++count) {
      const auto tiles = tile_places(count, width, height);
      ASSERT_EQ(tiles.size(), count);
      long area = 0;
      int right_most = 0, lowest = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const auto& [left, top, w, h] = tiles[i];
        EXPECT_TRUE(left >= 0 && top >= 0 && w > 0 && h > 0 && left + w <= width && top + h <= height);
        right_most = std::max(right_most, left + w);
        lowest = std::max(lowest, top + h);
        area += static_cast<long>(w) * h;
        EXPECT_LE(static_cast<long>(w) * h, static_cast<long>(tiles[0][2] + 1) * (tiles[0][3] + 1))
            << "the first is the largest";
        for (std::size_t k = 0; k < i; ++k)
          EXPECT_TRUE(left >= tiles[k][0] + tiles[k][2] || tiles[k][0] >= left + w ||
                      top >= tiles[k][1] + tiles[k][3] || tiles[k][1] >= top + h)
              << "they overlap";
      }
      EXPECT_EQ(right_most, width);
      EXPECT_EQ(lowest, height);
      EXPECT_GT(area, 0.93 * width * height) << count << ' ' << width << 'x' << height;
    }
  EXPECT_EQ(tile_places(2, 1280, 400)[1][1], 0) << "side by side where there is room for that";
  EXPECT_EQ(tile_places(2, 600, 700)[1][0], 0) << "else one below the other";
}

/// Draws its cameras in one colour each, with dark corners above on the left and below on the right, and has a
/// headline.
class Painted final : public View {
 public:
  Painted(int width, int height, std::vector<sim::ColouredText> words) : words_(std::move(words)) {
    picture_ = {width, height, {}};
    picture_.rgb.resize(static_cast<std::size_t>(3 * width * height));
  }
  Expected<const sim::Picture*> draw(std::string_view camera) override {
    if (camera != "red" && camera != "blue") return input_error("no camera");
    for (std::size_t i = 0; i < picture_.rgb.size(); ++i)
      picture_.rgb[i] =
          i % 3 == (camera == "red" ? 0u : 2u) ? 200 : static_cast<std::uint8_t>(now_.count() / 1'000'000'000);
    for (const auto corner : {picture_.rgb.begin(), picture_.rgb.end() - 3}) std::fill_n(corner, 3, std::uint8_t{1});
    return &picture_;
  }
  std::vector<std::string> cameras() const override { return {"red"}; }
  void set_time(SimTime t) override { now_ = t; }
  std::vector<sim::ColouredText> headline() override { return words_; }

 private:
  std::vector<sim::ColouredText> words_;
  sim::Picture picture_;
  SimTime now_{};
};

ViewMaker painted(std::vector<sim::ColouredText> words) {
  return [words](int width, int height) -> Expected<std::unique_ptr<View>> {
    return std::unique_ptr<View>(std::make_unique<Painted>(width, height, words));
  };
}

std::array<int, 3> pixel_at(const sim::Picture& picture, int x, int y) {
  const auto at = static_cast<std::size_t>(3 * (y * picture.width + x));
  return {picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]};
}

/// Rows from below in which neither camera is seen.
int rows_of_caption(const sim::Picture& picture) {
  int rows = 0;
  while (rows < picture.height && pixel_at(picture, 0, picture.height - 1 - rows)[0] < 100 &&
         pixel_at(picture, 0, picture.height - 1 - rows)[2] < 100)
    ++rows;
  return rows;
}

/// Pixels of the caption in which something is written.
int ink(const sim::Picture& picture, int rows) {
  int count = 0;
  for (int y = picture.height - rows; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) count += pixel_at(picture, x, y)[1] > 60;
  return count;
}

sim::Picture drawn(const ViewMaker& make, const FrameOptions& options, const std::vector<std::string>& cameras,
                   SimTime now = {}) {
  auto frames = Frames::create(make, options);
  EXPECT_TRUE(frames.ok()) << (frames ? "" : frames.error().text());
  auto picture = (*frames)->draw(cameras, now);
  EXPECT_TRUE(picture.ok());
  return **picture;
}

TEST(Frames, CamerasHaveTilesAboveACaption) {
  const auto make = painted({{"CYAN 12", {1, 1, 1}}});
  const sim::Picture picture = drawn(make, {.width = 400, .height = 300, .cameras = 2}, {"red", "blue"});
  ASSERT_EQ(picture.width, 400);
  ASSERT_EQ(picture.height, 300);
  EXPECT_EQ(pixel_at(picture, 5, 5)[0], 200);
  const int rows = rows_of_caption(picture);
  EXPECT_GT(rows, 20);
  EXPECT_LT(rows, 75);
  EXPECT_EQ(pixel_at(picture, 395, 300 - rows - 1)[2], 200);
  EXPECT_GT(ink(picture, rows), 50);
  const sim::Picture bare = drawn(make, {.width = 400, .height = 300, .cameras = 2, .caption = false}, {"red", "blue"});
  EXPECT_EQ(rows_of_caption(bare), 0);
}

TEST(Frames, EachTileShowsAPictureOfItsSize) {
  for (const std::size_t count : {1u, 2u, 3u, 5u, 6u}) {
    const std::vector<std::string> cameras(count, "red");
    std::multiset<std::pair<int, int>> made;
    const ViewMaker noted = [&](int width, int height) {
      made.emplace(width, height);
      return painted({})(width, height);
    };
    const sim::Picture picture =
        drawn(noted, {.width = 400, .height = 300, .cameras = count, .caption = false}, cameras);
    std::set<std::pair<int, int>> sizes;
    for (const auto& [left, top, width, height] : tile_places(count, 400, 300)) {
      sizes.emplace(width, height);
      EXPECT_EQ(pixel_at(picture, left, top)[0], 1) << count;
      EXPECT_EQ(pixel_at(picture, left + width - 1, top + height - 1)[0], 1) << count;
    }
    EXPECT_TRUE(std::ranges::equal(made, sizes)) << "tiles of one size share a view";
  }
}

TEST(Frames, ShowTheTimeThatIsAsked) {
  const auto make = painted({});
  auto frames = std::move(*Frames::create(make, {.width = 60, .height = 40}));
  const std::string camera = "red";
  const auto green_at = [&](int seconds) {
    return pixel_at(**frames->draw({&camera, 1}, std::chrono::seconds(seconds)), 3, 3)[1];
  };
  EXPECT_EQ(green_at(7), 7);
  EXPECT_EQ(green_at(9), 9);
}

TEST(Frames, WorldThatTellsNothingHasThePictureOfItsView) {
  const sim::Picture picture = drawn(painted({}), {.width = 60, .height = 40}, {"blue"});
  EXPECT_EQ(rows_of_caption(picture), 0);
  EXPECT_EQ(picture.width, 60);
}

TEST(Frames, CaptionLeavesOutWhatDoesNotFitAndKeepsToThePicture) {
  for (const std::string& name :
       {std::string(5000, 'W'), std::string("\x1b[31m\xff\xfe\0x\n%s", 13), std::string("\xe2\x80\xae")}) {
    const sim::Picture picture =
        drawn(painted({{name, {1, 1, 1}}, {"CYAN 12", {1, 1, 1}}}), {.width = 160, .height = 200}, {"red"});
    EXPECT_EQ(pixel_at(picture, 159, 100)[0], 200);
    const int rows = rows_of_caption(picture);
    EXPECT_GT(ink(picture, rows), 20);
    for (int y = picture.height - rows; y < picture.height; ++y)
      EXPECT_LT(pixel_at(picture, 0, y)[1], 60) << "a margin";
  }
  EXPECT_EQ(rows_of_caption(drawn(painted({{"x", {1, 1, 1}}}), {.width = 64, .height = 64}, {"red"})), 0)
      << "a small picture has no caption";
}

/// Errors of rules, as the journal of a game has them.
JournalRecord error_at(int seconds, const char* message) {
  const auto text = [](const char* value) { return RecordValue{std::string(value)}; };
  return {"env/main",
          0,
          std::chrono::seconds(seconds),
          RecordKind::kError,
          RecordValue{RecordValue::Map{{"message", text(message)},
                                       {"rule", text("r")},
                                       {"file", text("a.clp")},
                                       {"line", RecordValue{std::int64_t{3}}}}},
          {}};
}

TEST(Frames, EventsStandOnTheTwoLinesOfTheCaptionAndNoFurther) {
  auto scenario = Scenario::parse("schema: 1\nworld: {kind: rcll}\ntier: timed\n", "game.yaml", shipped());
  ASSERT_TRUE(scenario.ok());
  const int line = sim::Font::load(false)->height();
  for (const int count : {1, 2, 3, 8}) {
    Happenings events(*scenario);
    for (int i = 0; i < count; ++i) events.heard(error_at(i, "the conveyor belt of a machine does not move"));
    const sim::Picture picture =
        drawn(painted({{"CYAN 12", {1, 1, 1}}}), {.width = 400, .height = 300, .cameras = 1, .events = &events},
              {"red"}, std::chrono::seconds(9));
    const int rows = rows_of_caption(picture);
    EXPECT_GE(rows, 2 * line);
    EXPECT_EQ(ink(picture, (rows - 2 * line) / 2), 0) << "a margin below, with " << count << " events";
    EXPECT_GT(ink(picture, rows / 2), 50) << "the second line, with " << count << " events";
  }
}

/// Pictures of a run that is over show what its journal has.
class RecordedHappenings : public FolderTest {};

TEST_F(RecordedHappenings, AreThoseOfTheJournal) {
  scenario("game", "(defrule wrong (time ?) => (+ 1 (nth$ 1 (create$ one))))\n");
  play("game");
  const Scenario played = loaded("game");
  Happenings events(played);
  events.read(run());
  const std::vector<PageEvent> all = events.last(2, 9);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].kind + ' ' + all[0].who, "error main");
  EXPECT_THAT(all[0].reason, testing::MatchesRegex(".*wrong, .*rules.clp:1"));
}

TEST(Font, TextThatIsTooWideEndsInDots) {
  const auto font = sim::Font::load(false);
  ASSERT_TRUE(font.ok()) << font.error().text();
  const int wide = font->width("robot1 failed");
  EXPECT_EQ(font->fitted("robot1 failed", wide), "robot1 failed");
  const std::string shorter = font->fitted("robot1 failed", wide - 1);
  EXPECT_THAT(shorter, testing::EndsWith("..."));
  EXPECT_LT(font->width(shorter), wide);
  EXPECT_EQ(font->fitted("robot1", 3), "");
  EXPECT_EQ(font->width("\xc3\xa4"), font->width("?")) << "a character is one mark";
}

TEST(Happenings, AreThoseUpToATimeTheLastFirst) {
  auto scenario = Scenario::parse("schema: 1\nworld: {kind: rcll}\ntier: timed\n", "game.yaml", shipped());
  ASSERT_TRUE(scenario.ok());
  Happenings events(*scenario);
  EXPECT_TRUE(events.told_by_world());
  const auto map = [](std::vector<RecordValue::Entry> entries) {
    return RecordValue{RecordValue::Map(std::move(entries))};
  };
  const auto text = [](const char* value) { return RecordValue{std::string(value)}; };
  const auto skill = [&](int seconds, std::int64_t code) {
    return JournalRecord{"node/skills",
                         0,
                         std::chrono::seconds(seconds),
                         RecordKind::kSkill,
                         map({{"robot", text("robot1")},
                              {"skill", text("pick")},
                              {"target", text("C-BS-OUTPUT")},
                              {"event", text("end")},
                              {"code", RecordValue{code}},
                              {"error", text("no piece")}}),
                         {}};
  };
  events.heard(skill(3, 201));
  events.heard(skill(4, 0));
  events.heard(error_at(5, "wrong"));
  events.heard({"referee",
                0,
                std::chrono::seconds(6),
                RecordKind::kReferee,
                map({{"event", text("score")},
                     {"team", text("CYAN")},
                     {"kind", text("ring")},
                     {"points", RecordValue{std::int64_t{5}}}}),
                {}});
  events.heard({"world",
                0,
                std::chrono::seconds(7),
                RecordKind::kControl,
                map({{"fault", text("skill_fails")}, {"robot", text("robot2")}}),
                {}});
  const auto words = [&](double t, std::size_t most) {
    std::vector<std::string> out;
    for (const PageEvent& event : events.last(t, most))
      out.push_back(event.kind + ' ' + event.who + ' ' + event.text + ' ' + event.reason);
    return out;
  };
  EXPECT_THAT(words(100, 9), ElementsAre("fault robot2 skill_fails ", "error main wrong r, a.clp:3",
                                         "failed robot1 pick C-BS-OUTPUT failed code 201: no piece"));
  EXPECT_THAT(words(6.5, 1), ElementsAre("error main wrong r, a.clp:3"));
  EXPECT_THAT(words(2, 9), IsEmpty());
}

}  // namespace
}  // namespace cxlab::lab
