#include "lab/view/players.h"

#include <algorithm>
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
#include "lab/control/client.h"
#include "lab/time_travel.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

Json error_json(const Error& error) { return {{"error", error.text()}, {"kind", static_cast<int>(error.kind)}}; }

Error error_from_starter(const Json& answer) {
  if (!answer.is_object()) return bug_error("the process that starts others does not answer");
  const char* key = answer.contains("ended") ? "ended" : "error";
  return Error{static_cast<ErrorKind>(answer.value("kind", 3)), answer.value(key, ""), {}, 0, {}};
}

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
  Starter(const fs::path& place, const Catalogue& catalogue, bool trust_programs, const Host& host)
      : place_(real(place)), catalogue_(catalogue), trust_programs_(trust_programs), host_(host) {}

  Servant::Answer carry_out(const Json& request) {
    for (const char* key : {"run", "a", "b"})
      if (request.contains(key) && !is_here(request.value(key, "")))
        return said(error_json(usage_error(found_text(request.value(key, ""), "a run of " + place_.string()))));
    const std::string verb = request.value("verb", "");
    if (verb == "play") return said(play(request.value("run", "")));
    if (verb == "compare") return said(compare(request.value("a", ""), request.value("b", "")));
    if (verb == "connect_to_run") return connect(fs::path(request.value("run", "")) / "control.sock");
    const auto found = playing_.find(request.value("number", 0));
    if (found == playing_.end()) return said(Json{{"ended", "the process is there no more"}});
    if (verb == "connect" && found->second.travel) return connect(found->second.travel->address().path);
    if (verb == "end") {
      playing_.erase(found);
      return said(Json::object());
    }
    return said(look(found));
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
  static std::string said_in(const fs::path& file) {
    const auto text = read_file(file);
    return text ? *text : std::string();
  }
  static Servant::Answer said(const Json& json) { return {json_text(json)}; }
  static Servant::Answer connect(const fs::path& socket) {
    auto connection = connect_to_socket(socket.string());
    if (!connection) return said(error_json(connection.error()));
    return {json_text(Json::object()), *std::move(connection)};
  }

  static fs::path real(const fs::path& path) {
    std::error_code error;
    fs::path found = fs::canonical(path, error);
    return error ? fs::path() : found;
  }
  bool is_here(const fs::path& run) const {
    const fs::path found = real(run);
    return !found.empty() && std::ranges::mismatch(place_, found).in1 == place_.end();
  }

  Json look(std::map<int, Playing>::iterator found) {
    Playing& playing = found->second;
    const auto code = playing.travel ? playing.travel->ended() : playing.comparison->wait_for(0);
    if (!code) return Json::object();
    const std::string said = playing.travel ? playing.travel->said() : said_in(playing.folder->path() / kSaid);
    Json answer{{"ended", last_words(said, *code)}};
    if (*code == 0 && playing.comparison) answer = {{"answer", said_in(playing.folder->path() / kAnswer)}};
    playing_.erase(found);
    return answer;
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
    Json answer = Json::object();
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

  const fs::path place_;
  const Catalogue& catalogue_;
  bool trust_programs_;
  Host host_;
  int last_ = 0;
  std::map<int, Playing> playing_;
};

}  // namespace

Expected<Players> Players::start(const fs::path& place, const Catalogue& catalogue, bool trust_programs,
                                 const Host& host) {
  auto starter =
      std::make_shared<std::unique_ptr<Starter>>(std::make_unique<Starter>(place, catalogue, trust_programs, host));
  auto servant = Servant::start(
      [starter](const std::string& request, const auto&) { return (*starter)->carry_out(parse_json(request)); },
      [starter] { starter->reset(); });
  if (!servant) return servant.error();
  return Players(*std::move(servant));
}

Servant::Answer Players::ask(const Json& request) {
  const std::lock_guard lock(mutex_);
  if (!starter_) return {json_text(error_json(resource_error("cxlab view has ended")))};
  auto answer = starter_->ask(json_text(request));
  return answer ? *std::move(answer) : Servant::Answer{json_text(error_json(answer.error()))};
}

Json Players::answer_to(const Json& request) { return parse_json(ask(request).text); }

Expected<Descriptor> Players::connection(const Json& request) {
  Servant::Answer answer = ask(request);
  if (answer.descriptor) return std::move(answer.descriptor);
  return error_from_starter(parse_json(answer.text));
}

Expected<Players::Player> Players::play(const fs::path& run) {
  const Json answer = answer_to(Json{{"verb", "play"}, {"run", run.string()}});
  if (!answer.is_object() || answer.contains("error")) return error_from_starter(answer);
  Player player{answer.value("number", 0), {}};
  if (answer.contains("end")) player.end = answer["end"].get<double>();
  return player;
}

Expected<Descriptor> Players::connect(int number) { return connection(Json{{"verb", "connect"}, {"number", number}}); }

Expected<Descriptor> Players::connect_to_run(const fs::path& run) {
  return connection(Json{{"verb", "connect_to_run"}, {"run", run.string()}});
}

std::optional<Error> Players::end_of(int number) {
  const Json answer = answer_to(Json{{"verb", "look"}, {"number", number}});
  if (!answer.is_object()) return error_from_starter(answer);
  for (const char* why : {"ended", "error"})
    if (answer.contains(why)) return run_error(answer.value(why, ""));
  return std::nullopt;
}

Expected<std::string> Players::compare(const fs::path& a, const fs::path& b) {
  Json answer = answer_to(Json{{"verb", "compare"}, {"a", a.string()}, {"b", b.string()}});
  const Json look{{"verb", "look"}, {"number", answer.is_object() ? answer.value("number", 0) : 0}};
  for (answer.erase("number"); answer.is_object() && answer.empty(); answer = answer_to(look))
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (!answer.is_object()) return error_from_starter(answer);
  if (answer.contains("answer")) return answer.value("answer", "");
  return run_error("the runs cannot be compared: " + answer.value(answer.contains("ended") ? "ended" : "error", ""));
}

void Players::end_all() {
  const std::lock_guard lock(mutex_);
  starter_.reset();
}

void Players::end(int number) { ask(Json{{"verb", "end"}, {"number", number}}); }

}  // namespace cxlab::lab
