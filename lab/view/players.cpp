#include "lab/view/players.h"

#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <thread>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/base/process.h"
#include "cx/base/scratch_folder.h"
#include "lab/comparison.h"
#include "lab/time_travel.h"

namespace cxlab::lab {

namespace {

Json error_json(const Error& error) { return {{"error", error.text()}, {"kind", static_cast<int>(error.kind)}}; }

/// What a process that ended has to say: the text of its error, or its exit code.
std::string last_words(const std::string& said, int code) {
  const std::size_t error = said.rfind("error: ");
  std::string text = error == said.npos ? said : said.substr(error + 7);
  while (text.ends_with('\n')) text.pop_back();
  if (!text.empty()) return text;
  return "the process that plays the run ended with " +
         (code > 128 ? "signal " + std::to_string(code - 128) : "exit code " + std::to_string(code));
}

Json comparison_json(const Comparison& found) {
  Json first;
  if (found.first)
    first = {{"t", to_seconds(found.first->t)},
             {"environment", found.first->environment},
             {"a", found.first->a.what},
             {"b", found.first->b.what}};
  return {{"same", found.same()},
          {"compared_s", to_seconds(found.compared)},
          {"first", std::move(first)},
          {"text", text_of(found)}};
}

/// What the starter does; it lives in that process only.
class Starter {
 public:
  Starter(const Catalogue& catalogue, bool trust_programs, const Host& host)
      : catalogue_(catalogue), trust_programs_(trust_programs), host_(host) {}

  Json carry_out(const Json& request) {
    const std::string verb = request.value("verb", "");
    if (verb == "play") return play(request.value("run", ""));
    if (verb == "compare") return compare(request.value("a", ""), request.value("b", ""));
    const auto found = playing_.find(request.value("number", 0));
    if (found == playing_.end()) return Json{{"ended", "the process is there no more"}};
    if (verb == "end") {
      playing_.erase(found);
      return Json::object();
    }
    Playing& playing = found->second;
    const auto code = playing.travel ? playing.travel->ended() : playing.comparison->wait_for(0);
    if (!code) return Json::object();
    const std::string said = playing.travel ? playing.travel->said() : said_in(playing.folder->path() / kSaid);
    Json answer{{"ended", last_words(said, *code)}};
    if (*code == 0 && playing.comparison) answer = {{"answer", said_in(playing.folder->path() / kAnswer)}};
    playing_.erase(found);
    return answer;
  }

 private:
  struct Playing {
    std::unique_ptr<Run> run = {};  // outlives what plays it
    std::unique_ptr<TimeTravel> travel = {};
    // Or two runs are compared
    std::unique_ptr<ScratchFolder> folder = {};
    std::optional<Process> comparison = {};
  };
  static constexpr const char *kSaid = "said.txt", *kAnswer = "answer.json";
  static std::string said_in(const std::filesystem::path& file) {
    const auto text = read_file(file);
    return text ? *text : std::string();
  }

  Json keep(Playing playing, Json answer) {
    answer["number"] = ++last_;
    playing_.emplace(last_, std::move(playing));
    return answer;
  }

  Json play(const std::string& folder) {
    auto run = Run::open(folder, catalogue_, trust_programs_);
    if (!run) return error_json(run.error());
    Playing playing{.run = std::make_unique<Run>(*std::move(run))};
    auto travel = TimeTravel::start(*playing.run, host_, {.counting = Counting::kUse, .quiet = true});
    if (!travel) return error_json(travel.error());
    playing.travel = *std::move(travel);
    Json answer{{"socket", playing.travel->address().path}};
    if (playing.run->finished) answer["end"] = to_seconds(playing.run->sim_time);
    return keep(std::move(playing), std::move(answer));
  }

  Json compare(const std::string& a, const std::string& b) {
    auto first = Run::open(a, catalogue_, trust_programs_), second = Run::open(b, catalogue_, trust_programs_);
    if (!first || !second) return error_json((first ? second : first).error());
    auto folder = ScratchFolder::create();
    if (!folder) return error_json(folder.error());
    ProcessOptions streams;
    streams.out = Stream::file((*folder)->path() / kAnswer);
    streams.err = Stream::file((*folder)->path() / kSaid);
    auto process = Process::fork(streams, [&] {
      const auto found = lab::compare(*first, *second, host_);
      if (!found) std::fprintf(stderr, "error: %s\n", found.error().text().c_str());
      if (!found) return static_cast<int>(found.error().kind);
      std::fputs(json_text(comparison_json(*found)).c_str(), stdout);
      return std::fflush(stdout) == 0 ? 0 : static_cast<int>(ErrorKind::kResource);
    });
    if (!process) return error_json(process.error());
    return keep({.folder = *std::move(folder), .comparison = *std::move(process)}, Json::object());
  }

  const Catalogue& catalogue_;
  bool trust_programs_;
  Host host_;
  int last_ = 0;
  std::map<int, Playing> playing_;
};

}  // namespace

Expected<Players> Players::start(const Catalogue& catalogue, bool trust_programs, const Host& host) {
  auto starter = std::make_shared<std::unique_ptr<Starter>>(std::make_unique<Starter>(catalogue, trust_programs, host));
  auto servant = Servant::start(
      [starter](const std::string& request, const auto&) {
        return Servant::Answer{json_text((*starter)->carry_out(parse_json(request)))};
      },
      [starter] { starter->reset(); });
  if (!servant) return servant.error();
  return Players(*std::move(servant));
}

std::string Players::ask(const std::string& request) {
  const std::lock_guard lock(mutex_);
  if (!starter_) return json_text(error_json(resource_error("cxlab view has ended")));
  auto answer = starter_->ask(request);
  return answer ? answer->text : json_text(error_json(answer.error()));
}

Expected<Players::Player> Players::play(const std::filesystem::path& run) {
  const Json answer = parse_json(ask(json_text(Json{{"verb", "play"}, {"run", run.string()}})));
  if (!answer.is_object()) return bug_error("the process that starts others does not answer");
  if (answer.contains("error"))
    return Error{static_cast<ErrorKind>(answer.value("kind", 3)), answer.value("error", ""), {}, 0, {}};
  Player player{answer.value("number", 0), answer.value("socket", ""), {}};
  if (answer.contains("end")) player.end = answer["end"].get<double>();
  return player;
}

std::optional<Error> Players::end_of(int number) {
  const Json answer = parse_json(ask(json_text(Json{{"verb", "look"}, {"number", number}})));
  if (!answer.is_object()) return bug_error("the process that starts others does not answer");
  for (const char* why : {"ended", "error"})
    if (answer.contains(why)) return run_error(answer.value(why, ""));
  return std::nullopt;
}

Expected<std::string> Players::compare(const std::filesystem::path& a, const std::filesystem::path& b) {
  Json answer = parse_json(ask(json_text(Json{{"verb", "compare"}, {"a", a.string()}, {"b", b.string()}})));
  const Json look{{"verb", "look"}, {"number", answer.is_object() ? answer.value("number", 0) : 0}};
  for (answer.erase("number"); answer.is_object() && answer.empty(); answer = parse_json(ask(json_text(look))))
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (!answer.is_object()) return bug_error("the process that starts others does not answer");
  if (answer.contains("answer")) return answer.value("answer", "");
  return run_error("the runs cannot be compared: " + answer.value(answer.contains("ended") ? "ended" : "error", ""));
}

void Players::end_all() {
  const std::lock_guard lock(mutex_);
  starter_.reset();
}

void Players::end(int number) { ask(json_text(Json{{"verb", "end"}, {"number", number}})); }

}  // namespace cxlab::lab
