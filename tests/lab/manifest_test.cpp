#include "lab/manifest.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "folder.h"
#include "lab/run.h"
#include "lab/versions.h"

namespace cxlab::lab {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Json = nlohmann::json;

TEST(Surroundings, OfARunHaveChangedWhereTheyAreOthersNowOrWereNotKnown) {
  const auto now = versions();
  ASSERT_GE(now.size(), 2u);
  lab::Run run;
  for (const auto& [name, value] : machine()) run.manifest.machine[name] = value;
  for (const auto& [name, value] : now) run.manifest.versions[name] = value;
  EXPECT_THAT(run.changed_surroundings(), testing::IsEmpty());
  run.manifest.versions[now[0].first] = "another one";
  run.manifest.versions.erase(now[1].first);
  EXPECT_THAT(run.changed_surroundings(),
              testing::UnorderedElementsAre(now[0].first + ": another one, now " + now[0].second,
                                            now[1].first + ": not known, now " + now[1].second));
}

// --- Every field has a key, and each key its own value

/// Gives the n-th field of a struct another value, and counts the fields.
class Changer {
 public:
  explicit Changer(int n) : left_(n) {}
  template <class T>
  void required(const char*, T&& value) {
    ++count_;
    if (left_-- == 0) change(value);
  }
  template <class T>
  void operator()(const char* name, T&& value) {
    required(name, value);
  }
  template <class T>
  void unless_empty(const char* name, T& value) {
    required(name, value);
  }
  template <class T>
  void time(const char* name, T& value) {
    required(name, value);
  }
  int count() const { return count_; }

 private:
  static void change(bool& value) { value = !value; }
  static void change(double& value) { value += 1.25; }
  static void change(std::int64_t& value) { ++value; }
  static void change(std::uint64_t& value) { value = 18446744073709551615U; }
  static void change(std::string& value) { value = "another \"one\"\n"; }
  static void change(std::optional<double>& value) { value = 12.5; }
  static void change(std::map<std::string, std::string>& value) { value["a key"] = "another"; }
  template <class T>
  static void change(std::vector<T>& value) {
    change(value.emplace_back());
  }
  static void change(WhatIf& value) { value.at = 3; }
  static void change(Manifest::Agent& value) { value.config = "another.yaml"; }
  template <class Enum>
  static void change(NamedValue<Enum>& named) {
    ASSERT_TRUE(named.set(named.word() == named.begin[0] ? named.begin[1] : named.begin[0]));
  }

  int left_, count_ = 0;
};

template <class T>
int keys_of() {
  T value;
  Changer count(-1);
  value.fields(count);
  return count.count();
}

struct Anything {
  template <class T>
  operator T() const;  // NOLINT(google-explicit-constructor)
};
/// How many members an aggregate has, a base counted as one.
template <class T, class... Values>
constexpr int members_of(Values... values) {
  if constexpr (requires { T{values..., Anything{}}; })
    return members_of<T>(values..., Anything{});
  else
    return sizeof...(Values);
}

TEST(RunSpecKeys, EveryFieldHasOneButThePermissionThatWhoOpensARunGives) {
  const int programs = 1, base = 1, limits = 3 - 1;  // of one field
  EXPECT_EQ(keys_of<RunSpec>() + programs, members_of<cx::Conduct>() + members_of<RunSpec>() - base + limits);
}

TEST(WhatIfKeys, EveryFieldHasOneButTheTextOfItsFile) { EXPECT_EQ(keys_of<WhatIf>() + 1, members_of<WhatIf>()); }

TEST(ManifestKeys, EveryFieldHasOne) {
  EXPECT_EQ(keys_of<Manifest>() - keys_of<RunSpec>() + 1, members_of<Manifest>());
  EXPECT_EQ(keys_of<Manifest::Agent>(), members_of<Manifest::Agent>());
}

class ManifestTest : public FolderTest {
 protected:
  static Manifest some() {
    Manifest manifest;
    manifest.scenario = "games/game.yaml";
    manifest.overrides = {"seed=7", "tier=timed"};
    manifest.seed = 7;
    manifest.versions = {{"cxlab", "0.1.0"}};
    manifest.machine = {{"architecture", "x86_64"}};
    manifest.tier = "timed";
    manifest.command = {"run", "games/game.yaml"};
    manifest.folder = "/home/me";
    manifest.out = "/home/me/runs/game-7";
    manifest.spec.prefixes = {"/opt/ros"};
    manifest.spec.what_if = {{.at = 2, .file = "/tmp/repair.clp", .set = {"a=b"}}, {.at = 4, .facts = {"(a)"}}};
    name_copies(manifest.spec.what_if);
    manifest.agents = {{"params/agent.yaml", {{"my_agent", "/home/me/my_agent"}}}, {"other.yaml", {}}};
    manifest.world_files = {{"game", "/home/me/game.yaml"}};
    manifest.repeat = "cxlab rerun runs/game-7";
    return manifest;
  }
  Expected<Manifest> from(const std::string& text) const {
    write("manifest.json", text);
    return Manifest::read(path("."));
  }
  std::string error_of(const Json& json) const {
    const auto manifest = from(json.dump());
    return manifest ? "none" : manifest.error().text();
  }
};

TEST_F(ManifestTest, EachFieldSurvivesAndShows) {
  const std::string before = some().to_json();
  std::set<std::string> seen{before};
  for (int n = 0; n < keys_of<Manifest>(); ++n) {
    Manifest changed = some();
    Changer one(n);
    changed.fields(one);
    const std::string text = changed.to_json();
    EXPECT_TRUE(seen.insert(text).second) << "field " << n << " does not show in\n" << text;
    const auto again = from(text);
    ASSERT_TRUE(again) << n << ": " << again.error().text();
    EXPECT_EQ(again->to_json(), text) << "field " << n;
  }
}

TEST_F(ManifestTest, IsReadAsItWasWritten) {
  Manifest written = some();
  written.spec.until = 12.5;
  written.spec.journal = JournalLevel::kFull;
  written.spec.keep_going = written.spec.strict = written.spec.sockets = true;
  written.spec.release = cx::RosRelease::kJazzy;
  const auto again = from(written.to_json());
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(again->spec.until, 12.5);
  EXPECT_EQ(again->spec.journal, JournalLevel::kFull);
  EXPECT_EQ(again->spec.release, cx::RosRelease::kJazzy);
  EXPECT_TRUE(again->spec.keep_going && again->spec.strict && again->spec.sockets);
  EXPECT_EQ(again->scenario_file(), "/home/me/games/game.yaml");
  EXPECT_EQ(again->shares(), (std::vector<Shares>{{{"my_agent", "/home/me/my_agent"}}, {}}));
  ASSERT_EQ(again->spec.what_if.size(), 2U);
  EXPECT_EQ(again->spec.what_if[0].copy, "what_if/0/repair.clp");
  EXPECT_EQ(again->spec.what_if[1].facts, std::vector<std::string>{"(a)"});
}

TEST_F(ManifestTest, FilesAreNamedFromTheRunAndTheScenario) {
  Manifest manifest = some();
  manifest.spec.limits = {.memory = 1, .disk = 2, .steps = 3};
  manifest.spec.prefixes = {"/home/me/ros", "/opt/ros", "/home/me/odd/../ros"};
  const auto json = Json::parse(manifest.to_json());
  EXPECT_EQ(json.at("out"), "/home/me/runs/game-7");
  EXPECT_EQ(json.at("folder"), "../..");
  EXPECT_EQ(json.at("scenario"), "games/game.yaml");
  EXPECT_EQ(json.at("agents")[0].at("packages").at("my_agent"), "../my_agent");
  EXPECT_EQ(json.at("world_files").at("game"), "../game.yaml");
  EXPECT_EQ(json.at("prefixes"), (Json{"../ros", "/opt/ros", "/home/me/odd/../ros"}));
  EXPECT_EQ((std::vector<int>{json.at("memory"), json.at("disk"), json.at("steps")}), (std::vector<int>{1, 2, 3}));
  const auto again = from(json.dump());
  EXPECT_EQ(again->folder, "/home/me");
  EXPECT_EQ(again->spec.prefixes, manifest.spec.prefixes);
  EXPECT_EQ(again->shares(), manifest.shares());
  EXPECT_EQ(again->world_files, manifest.world_files);

  manifest.scenario = "/home/me/games/game.yaml";
  EXPECT_EQ(Json::parse(manifest.to_json()).at("scenario"), "games/game.yaml");
  manifest.scenario = "/usr/share/cxlab/game.yaml";
  EXPECT_EQ(Json::parse(manifest.to_json()).at("scenario"), "/usr/share/cxlab/game.yaml");
  EXPECT_EQ(from(manifest.to_json())->shares(), manifest.shares());
}

TEST_F(ManifestTest, AnOldManifestWithAbsoluteNamesMeansTheSame) {
  auto json = Json::parse(some().to_json());
  json["folder"] = "/home/me";
  json["agents"][0]["packages"]["my_agent"] = "/home/me/my_agent";
  json["world_files"]["game"] = "/home/me/game.yaml";
  for (const char* key : {"memory", "disk", "steps"}) json.erase(key);
  EXPECT_EQ(from(json.dump())->to_json(), some().to_json());
}

TEST_F(ManifestTest, ARunWithoutAnEndOfItsOwnHasNone) {
  const std::string text = some().to_json();
  EXPECT_TRUE(Json::parse(text).at("until").is_null());
  EXPECT_FALSE(from(text)->spec.until);
}

TEST_F(ManifestTest, WhatARunDoesNotSayItIsWithout) {
  Manifest manifest = some();
  manifest.spec.what_if.clear();
  manifest.spec.programs = false;
  EXPECT_THAT(manifest.to_json(), AllOf(testing::Not(HasSubstr("what_if")), testing::Not(HasSubstr("programs"))));
}

TEST_F(ManifestTest, WithoutAKeyThatAnOldRunLacksTheDefaultCounts) {
  auto json = Json::parse(some().to_json());
  for (const char* key : {"release", "sockets", "machine", "out", "world_files", "seed", "repeat", "what_if"})
    json.erase(key);
  const auto manifest = from(json.dump());
  ASSERT_TRUE(manifest) << manifest.error().text();
  EXPECT_EQ(manifest->spec.release, cx::RosRelease::kKilted);
  EXPECT_FALSE(manifest->spec.sockets);
  EXPECT_TRUE(manifest->spec.what_if.empty());
}

TEST_F(ManifestTest, TheCopyOfAFileIsWhereEachRunKeepsIt) {
  auto json = Json::parse(some().to_json());
  json["what_if"][0]["copy"] = "../../secret";
  EXPECT_EQ(from(json.dump())->spec.what_if[0].copy, "what_if/0/repair.clp");
}

TEST_F(ManifestTest, AMissingKeyIsNamed) {
  const auto whole = Json::parse(some().to_json());
  for (const char* key : {"scenario", "overrides", "until", "journal", "keep_going", "strict_cx", "prefixes", "agents",
                          "versions", "folder"}) {
    auto json = whole;
    json.erase(key);
    EXPECT_THAT(error_of(json), AllOf(HasSubstr("manifest.json: not the manifest of a run"), HasSubstr(key)));
  }
  auto json = whole;
  json["agents"][0].erase("packages");
  EXPECT_THAT(error_of(json), HasSubstr("packages"));
}

TEST_F(ManifestTest, AWrongValueIsAnError) {
  const std::vector<std::pair<std::pair<std::string, Json>, std::string>> rows{
      {{"release", "lunar"}, "'release': found 'lunar', expected one of: humble, jazzy, kilted"},
      {{"journal", "all"}, "'journal': found 'all', expected one of: none, decisions, full"},
      {{"journal", 3}, "type must be string"},
      {{"until", -1}, "'until': found -1, expected s from 0 to 1e9"},
      {{"until", "x"}, "type must be number"},
      {{"overrides", "x"}, "type must be array"},
      {{"overrides", {3}}, "type must be string"},
      {{"sockets", 1}, "type must be boolean"},
      {{"what_if", "x"}, "type must be array"},
      {{"what_if", {3}}, "at"},
      {{"what_if", {{{"at", 1e300}}}}, "'at': found 1e+300"},
      {{"agents", Json::array({{{"config", "x"}}})}, "packages"},
      {{"versions", {3}}, "type must be object"},
  };
  for (const auto& [change, wanted] : rows) {
    auto json = Json::parse(some().to_json());
    json[change.first] = change.second;
    EXPECT_THAT(error_of(json), AllOf(HasSubstr("not the manifest of a run"), HasSubstr(wanted)))
        << change.first << ": " << change.second;
  }
  EXPECT_THAT(error_of(Json::array()), HasSubstr("expected an object in JSON"));
}

}  // namespace
}  // namespace cxlab::lab
