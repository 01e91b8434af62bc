// The page of a run, taken apart again: what it has inside, and what it does not.

#include "lab/run_page.h"

#include <gmock/gmock.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "cx/base/file.h"
#include "scenarios/scene_log.h"
#include "scenarios/share.h"
#include "tests/support/files.h"

namespace cxlab::lab {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::string from_base64(const std::string& text) {
  std::string out;
  unsigned value = 0;
  int bits = 0;
  for (const char c : text) {
    static const std::string kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const std::size_t digit = kAlphabet.find(c);
    if (digit == std::string::npos) break;
    value = value << 6 | static_cast<unsigned>(digit);
    if ((bits += 6) >= 8) out += static_cast<char>(value >> (bits -= 8) & 255);
  }
  return out;
}

std::string unpacked(const std::string& text) {
  const std::string bytes = from_base64(text);
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, 16 + 15), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::string out;
  std::array<char, 65536> part{};
  for (int state = Z_OK; state == Z_OK;) {
    stream.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.avail_out = static_cast<uInt>(part.size());
    state = inflate(&stream, Z_NO_FLUSH);
    EXPECT_TRUE(state == Z_OK || state == Z_STREAM_END) << state;
    out.append(part.data(), part.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  return out;
}

/// What the page has inside under that id; nothing if there is no such element.
std::string island(const std::string& page, const std::string& id) {
  const std::string opening = "<script type=\"text/plain\" id=\"" + id + "\">";
  const std::size_t at = page.find(opening);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + opening.size();
  return unpacked(page.substr(begin, page.find('<', begin) - begin));
}

Json head() {
  return {{"result",
           {{"scenario", "s"},
            {"seed", 1},
            {"tier", "none"},
            {"status", "completed"},
            {"reason", nullptr},
            {"sim_time_s", 100},
            {"real_time_factor", 7.6}}},
          {"reason", ""},
          {"kinds", Json::array()},
          {"tables", Json::array()},
          {"film", ""},
          {"files", Json::array()},
          {"pictures", Json::array()}};
}

std::string made(const RunPage& page, std::string scene = {}) {
  const auto html = run_page(head(), {run_data(page, 100), std::move(scene)});
  return html ? *html : "error " + html.error().text();
}

TEST(Packed, BytesComeBack) {
  std::string all;
  for (int i = 0; i < 70000; ++i) all += static_cast<char>(i * i % 251);
  for (const std::string& bytes : {std::string(), std::string("a"), std::string("ab"), std::string("\0\xff", 2), all})
    EXPECT_EQ(unpacked(packed(bytes)), bytes);
  EXPECT_EQ(packed(all), packed(all));
}

TEST(RunPageFile, HasWhatTheWorldDeclared) {
  RunPage page;
  page.kinds = {{"pick", "#e69f00", "", true}};
  page.shades = {{"pause", 40, 60, "paused"}};
  page.parts.emplace_back(PageTable{"t", {"a"}, {{"b"}}});
  page.parts.emplace_back(PageChart{"points", {{"CYAN", {{1.23456, 2}, {3, 4.5}}, "cyan", true}}});
  page.parts.emplace_back(PageLanes{
      "who",
      {{"pick", "picks"}},
      {{"r1", {{PageBar::Shape::kInset, "pick", 1, 2.0004, "pick a", ", failed", "5"}}, {{"fault", 7, "breaks"}}}}});
  PageTask task;
  task.id = "5";
  task.begin = 10;
  task.end = 20;
  task.begun = 12.5;
  task.reason = "late by 3 s";
  task.steps = {{"cap", "m1", 13.0, std::nullopt, 2, "m1 was down"}};
  page.parts.emplace_back(PageTasks{"Orders", "order", {task}});
  page.events = {{7, "fault", "r1", "breaks"}, {-1, "warning", "", "of the whole run"}};
  const Json run = parse_json(island(made(page), "run-data"));
  EXPECT_EQ(run["end"], 100);
  EXPECT_EQ(run["kinds"], parse_json(R"([{"name": "pick", "fill": "#e69f00", "ink": "", "hatched": true}])"));
  EXPECT_EQ(run["shades"], parse_json(R"([{"kind": "pause", "begin": 40, "end": 60, "text": "paused"}])"));
  ASSERT_EQ(run["parts"].size(), 3u) << "tables are in the page itself";
  EXPECT_EQ(run["parts"][0]["lines"],
            parse_json(R"([{"kind": "CYAN", "text": "cyan", "part": true, "steps": [[1.235, 2], [3, 4.5]]}])"));
  EXPECT_EQ(run["parts"][1]["lanes"],
            parse_json(R"([{"name": "r1", "bars": [{"shape": "inset", "kind": "pick", "begin": 1, "end": 2,
              "text": "pick a", "remark": ", failed", "task": "5"}], "marks": [{"kind": "fault", "t": 7, "text": "breaks"}]}])"));
  EXPECT_EQ(run["parts"][2]["word"], "order");
  const Json& shown = run["parts"][2]["tasks"][0];
  EXPECT_EQ(shown["begun"], 12.5);
  EXPECT_EQ(shown["done"], nullptr);
  EXPECT_EQ(shown["reason"], "late by 3 s");
  EXPECT_EQ(shown["steps"], parse_json(R"([{"text": "cap", "begin": 13, "end": null, "waited_s": 2, "where": "m1",
              "reason": "m1 was down"}])"));
  EXPECT_EQ(run["events"], parse_json(R"([{"t": 7, "kind": "fault", "text": "breaks", "who": "r1"},
              {"t": null, "kind": "warning", "text": "of the whole run"}])"));
}

TEST(RunPageFile, TextsOfTheRunEndNoElement) {
  const std::string hostile = "</script><script>alert(1)</script><img src=x onerror=alert(1)>";
  RunPage page;
  page.parts.emplace_back(PageLanes{hostile, {}, {{hostile, {{PageBar::Shape::kBar, hostile, 0, 1, hostile}}, {}}}});
  page.events = {{1, hostile, hostile, hostile, hostile, hostile}};
  const std::string text = made(page);
  EXPECT_THAT(text, Not(HasSubstr("alert(1)")));
  EXPECT_EQ(parse_json(island(text, "run-data"))["events"][0]["text"], hostile);
}

TEST(RunPageFile, AsksForNothingElse) {
  std::string text = made({}, "");
  EXPECT_THAT(text, HasSubstr("default-src 'none'"));
  // Comments name types as imports.
  for (std::size_t at = text.find("/**"); at != std::string::npos; at = text.find("/**"))
    text.erase(at, text.find("*/", at) + 2 - at);
  static const std::regex kLoads(
      R"re((?:src|href)=(?!["']?data:)|url\(|@import|<link|\bfetch\(|XMLHttpRequest|\bimport\()re");
  std::smatch found;
  EXPECT_FALSE(std::regex_search(text, found, kLoads)) << found[0];
}

TEST(RunPageFile, ScriptsAreOneModule) {
  const std::string text = made({});
  const std::size_t begin = text.find("<script type=\"module\">");
  ASSERT_NE(begin, std::string::npos);
  const std::string script = text.substr(begin, text.find("</script>", begin) - begin);
  for (const char* file : {"data", "time", "scene", "draw", "field", "field3d", "axis", "lanes", "orders", "chart",
                           "table", "now", "main"}) {
    const auto source = read_file(std::string(std::getenv("CXLAB_SOURCE_DIR")) + "/lab/pages/run/" + file + ".js");
    ASSERT_TRUE(source);
    EXPECT_THAT(*source, Not(HasSubstr("</script")));
    EXPECT_THAT(script, HasSubstr(source->substr(0, source->find('\n')))) << file;
  }
  EXPECT_EQ(script.find("\nimport "), std::string::npos);
  EXPECT_EQ(script.find("\nexport "), std::string::npos);
}

TEST(RunPageFile, HasTheScene) {
  EXPECT_THAT(made({}), Not(HasSubstr("id=\"run-scene\"")));
  EXPECT_EQ(island(made({}, "CXSCENE1 and so on"), "run-scene"), "CXSCENE1 and so on");
}

/// A scene of that many seconds in which `count` things move so that nothing can be guessed.
std::string restless_scene(const std::filesystem::path& file, int seconds, EntityId count) {
  auto writer = SceneWriter::create(file);
  std::uint32_t chance = 1;
  const SceneLister lister = [&](SceneList& list) {
    for (EntityId id = 1; id <= count; ++id) {
      const auto draw = [&chance] {
        chance = chance * 1664525 + 1013904223;
        return static_cast<double>(chance >> 8) / 1e4;
      };
      const sim::Vec3 position{draw(), draw(), draw()};
      list.put({.number = id, .kind = "thing", .name = "thing" + std::to_string(id), .pose = {position, {0, 0, 0}}});
    }
  };
  for (SimTime t{}; t < std::chrono::seconds(seconds); t += kScenePeriod)
    writer->look(t, t + kScenePeriod, {&lister, 1});
  EXPECT_TRUE(writer->close());
  return *read_file(file);
}

TEST(RunPageFile, LargeScenesAreCutAtAChunk) {
  const TempFolder folder;
  const std::string whole = restless_scene(folder.path() / "scene.bin", 200, 150);
  ASSERT_GT(packed(whole).size(), kLargestPage) << "else it proves nothing";
  const std::string text = made({}, whole);
  EXPECT_LE(text.size(), kLargestPage);
  EXPECT_GT(text.size(), kLargestPage / 4) << "more would have fitted in";
  const std::string shown = island(text, "run-scene");
  EXPECT_EQ(shown, whole.substr(0, shown.size()));
  const auto reader = SceneReader::from_bytes(shown, "shown");
  ASSERT_TRUE(reader);
  EXPECT_TRUE(reader->status()) << reader->status().error().text();
  EXPECT_GT(reader->end(), SimTime{});
}

// --- Pages that are served

/// Names that a script declares outside of everything, in order.
std::vector<std::string> declared_in(const std::string& script) {
  static const std::regex kDeclaration("(?:^|\\n)(?:async )?(?:const|let|class|function) (\\w+)");
  std::vector<std::string> names;
  for (std::sregex_iterator found(script.begin(), script.end(), kDeclaration), end; found != end; ++found)
    names.push_back((*found)[1]);
  std::ranges::sort(names);
  return names;
}

TEST(ServedPages, ScriptsHaveAllFilesAndEachNameOnce) {
  std::string all;
  for (const char* name : {"run.js", "runs.js", "two.js"}) {
    const auto script = served_script(name);
    ASSERT_TRUE(script) << script.error().text();
    EXPECT_THAT(*script, Not(HasSubstr("\nimport "))) << name;
    EXPECT_THAT(*script, Not(HasSubstr("\nexport "))) << name;
    const std::vector<std::string> names = declared_in(*script);
    EXPECT_GT(names.size(), 5u);
    EXPECT_EQ(std::ranges::adjacent_find(names), names.end()) << name << " declares a name twice";
    all += *script;
  }
  for (const char* folder : {"run", "view"})
    for (const auto& entry : std::filesystem::directory_iterator(find_share().pages / folder)) {
      if (entry.path().extension() != ".js") continue;
      const std::string text = *read_file(entry.path());
      EXPECT_THAT(all, HasSubstr(text.substr(0, text.find('\n')))) << entry.path() << " is part of no script";
    }
  EXPECT_FALSE(served_script("three.js"));
  EXPECT_FALSE(served_script("../run/main.js"));
}

TEST(ServedPages, APageOfARunLoadsItsScriptAndHasNoPolicyOfItsOwn) {
  Json head{{"result",
             {{"scenario", "<script>bad()</script>"},
              {"seed", 1},
              {"status", "completed"},
              {"tier", "none"},
              {"sim_time_s", 5.0},
              {"real_time_factor", 10.0},
              {"warnings", Json::array()}}},
            {"reason", ""},
            {"files", Json::array()},
            {"film", ""},
            {"pictures", Json::array()},
            {"tables", Json::array()},
            {"kinds", Json::array()},
            {"live", true}};
  const auto page = served_run_page(head);
  ASSERT_TRUE(page) << page.error().text();
  EXPECT_THAT(*page, HasSubstr("src=\"/run.js\""));
  EXPECT_THAT(*page, HasSubstr("data-live=\"true\""));
  EXPECT_THAT(*page, Not(HasSubstr("Content-Security-Policy")));
  EXPECT_THAT(*page, Not(HasSubstr("<script>bad()")));
  head["live"] = false;
  EXPECT_THAT(*served_run_page(head), Not(HasSubstr("data-live")));
  for (const char* name : {"runs", "two"})
    EXPECT_THAT(*served_page(name + std::string(".html")), HasSubstr("src=\"/" + (name + std::string(".js\""))));
}

}  // namespace
}  // namespace cxlab::lab
