#include "lab/view/viewer.h"

#include <utility>

#include "cx/base/json.h"
#include "cx/base/number_text.h"
#include "lab/confine.h"
#include "lab/report.h"
#include "lab/view/page.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

constexpr std::size_t kMostVisits = 4;  // runs that are kept ready to be asked

ViewReply no_such_page(const ViewRequest& request) {
  return view_error(404, "there is nothing at " + request.method + ' ' + request.path);
}

ViewReply redirection(const std::string& to) { return {303, "text/plain; charset=utf-8", {}, {{"Location", to}}}; }

}  // namespace

Expected<std::unique_ptr<Viewer>> Viewer::open(const std::filesystem::path& place, const Catalogue& catalogue,
                                               bool trust_programs, const Host& host) {
  auto runs = ViewedRuns::open(place, catalogue);
  if (!runs) return runs.error();
  auto players = Players::start(runs->place(), catalogue, trust_programs, host);
  if (!players) return players.error();
  return std::unique_ptr<Viewer>(new Viewer(*std::move(runs), *std::move(players), catalogue, trust_programs));
}

void Viewer::confine(const Host& host) const {
  Wall wall;
  const Share share = find_share();
  wall.read = {runs_.place(), share.interfaces, share.models, share.pages};
  lab::confine(host, wall);
}

Viewer::~Viewer() { leave(); }

void Viewer::leave() {
  std::list<std::pair<std::string, std::shared_ptr<Visit>>> gone;
  {
    const std::lock_guard lock(mutex_);
    left_ = true;
    gone.swap(visits_);
  }
  for (const auto& [id, one] : gone) one->leave();
  players_.end_all();
}

/// What answers for that run; of many the one that was not asked for the longest time goes.
std::shared_ptr<Visit> Viewer::visit(const std::string& id, const std::filesystem::path& folder) {
  std::shared_ptr<Visit> gone;  // ends when nobody waits for it any more, and outside of the lock
  const std::lock_guard lock(mutex_);
  if (left_) return nullptr;
  const auto known = std::ranges::find_if(visits_, [&](const auto& one) { return one.first == id; });
  if (known != visits_.end()) {
    visits_.splice(visits_.begin(), visits_, known);
    return visits_.front().second;
  }
  auto fresh = std::make_shared<Visit>(folder, players_);
  visits_.emplace_front(id, fresh);
  if (visits_.size() > kMostVisits) {
    gone = std::move(visits_.back().second);
    visits_.pop_back();
    gone->leave();
  }
  fresh->begin();
  return fresh;
}

ViewReply Viewer::answer(const ViewRequest& request) {
  const std::string& path = request.path;
  const bool get = request.method == "GET";
  if (get && path == "/") return only() ? redirection("/run/" + *only() + '/') : view_page("runs.html");
  if (get && path == "/two") return view_page("two.html");
  if (get && (path == "/run.js" || path == "/runs.js" || path == "/two.js" || path == "/three.js"))
    return view_script(path.substr(1));
  if (get && path == "/api/runs") {
    const std::lock_guard lock(reading_);
    return {200, "application/json", json_text(runs_.table(players_))};
  }
  if (get && path == "/api/two") return answer_two(request);
  constexpr std::string_view kRun = "/run/";
  if (!path.starts_with(kRun)) return no_such_page(request);
  const std::size_t end = path.find('/', kRun.size());
  if (end == path.npos)
    return get && runs_.find(path.substr(kRun.size())) ? redirection(path + '/') : no_such_page(request);
  return answer_run(request, path.substr(kRun.size(), end - kRun.size()), path.substr(end + 1));
}

ViewReply Viewer::answer_run(const ViewRequest& request, const std::string& id, const std::string& rest) {
  const auto folder = runs_.find(id);
  if (!folder) return view_error(404, "there is no run '" + id + "'; GET /api/runs lists them");
  if (request.method == "POST") {
    if (rest != "ask" && rest != "go") return no_such_page(request);
    const Json asked = parse_json(request.body);
    if (asked.is_discarded()) return view_error(400, "the body is no JSON");
    const auto run = visit(id, *folder);
    if (!run) return view_error(500, "cxlab view has ended");
    return rest == "ask" ? run->ask(asked) : run->go(asked);
  }
  if (rest == "events") {
    const auto after = read_number<std::uint64_t>(request.query.contains("after") ? request.parameter("after") : "0");
    if (!after) return view_error(400, "after: " + found_text(request.parameter("after"), "a number"));
    const auto run = visit(id, *folder);
    return run ? run->events(*after) : view_error(500, "cxlab view has ended");
  }
  if (rest == "scene.bin") {
    const auto from = read_number<std::size_t>(request.query.contains("from") ? request.parameter("from") : "0");
    if (!from) return view_error(400, "from: " + found_text(request.parameter("from"), "a number of bytes"));
    return view_scene(*folder, *from);
  }
  if (!rest.empty() && rest != "data.json") return view_file(*folder, rest);
  const std::lock_guard lock(reading_);
  const auto run = Run::open(*folder, catalogue_, trust_programs_);
  if (!run) return view_error(500, run.error().text());
  const bool is_data = rest == "data.json";
  if (is_data && page_data_ && page_data_->first == id)
    return {200, "application/json", std::exchange(page_data_, std::nullopt)->second};
  auto parts = page_of_recorded(*run);
  if (!parts) return view_error(500, parts.error().text());
  if (is_data) return {200, "application/json", json_text(parts->run)};
  if (!run->unfinished) page_data_.emplace(id, json_text(parts->run));
  (void)visit(id, *folder);  // the reader of the page asks soon
  parts->head["in_folder"] = !only();
  parts->head["live"] = run->unfinished && players_.is_live(*folder);
  return view_run_page(std::move(parts->head));
}

ViewReply Viewer::answer_two(const ViewRequest& request) {
  std::string folders[2];
  for (const auto& [i, name] : {std::pair(0, "a"), {1, "b"}}) {
    const auto folder = runs_.find(request.parameter(name));
    if (!folder) return view_error(404, "there is no run '" + request.parameter(name) + "'; GET /api/runs lists them");
    folders[i] = folder->string();
  }
  const auto compared = players_.compare(folders[0], folders[1]);
  if (!compared) return view_error(500, compared.error().text());
  return {200, "application/json", *compared};
}

}  // namespace cxlab::lab
