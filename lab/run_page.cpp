#include "lab/run_page.h"

#include <three.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "cx/base/byte_codec.h"
#include "cx/base/file.h"
#include "cx/journal/chunk.h"
#include "lab/base64.h"
#include "lab/page.h"
#include "scenarios/scene.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

// --- What the world declares

/// A whole number as one, so that it is shown without a fraction; a time to the millisecond.
Json short_number(double value) {
  value = std::round(value * 1000) / 1000;
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<std::int64_t>(value);
  return value;
}

Json short_number(const std::optional<double>& value) { return value ? short_number(*value) : Json(); }

std::string_view to_string(PageBar::Shape shape) {
  switch (shape) {
    case PageBar::Shape::kAlert: return "alert";
    case PageBar::Shape::kInset: return "inset";
    case PageBar::Shape::kStrip: return "strip";
    case PageBar::Shape::kBar: break;
  }
  return "bar";
}

/// Keys that have nothing to say are left out.
void put(Json& out, const char* key, const std::string& text) {
  if (!text.empty()) out[key] = text;
}

Json json_of(const PageTable& table) {
  Json rows = Json::array();
  for (const auto& row : table.rows) {
    Json cells = Json::array();
    for (const PageCell& cell : row) cells.push_back({{"text", cell.text}, {"bold", cell.bold}, {"kind", cell.kind}});
    rows.push_back(std::move(cells));
  }
  return {{"title", table.title}, {"columns", table.columns}, {"rows", std::move(rows)}, {"note", table.note}};
}

Json json_of(const PageChart& chart) {
  Json lines = Json::array();
  for (const PageLine& line : chart.lines) {
    Json steps = Json::array();
    for (const auto& [t, value] : line.steps) steps.push_back({short_number(t), short_number(value)});
    lines.push_back({{"kind", line.kind},
                     {"text", line.text.empty() ? line.kind : line.text},
                     {"part", line.is_part},
                     {"steps", std::move(steps)}});
  }
  return {{"type", "chart"}, {"title", chart.title}, {"lines", std::move(lines)}};
}

Json json_of(const PageLane& lane) {
  Json bars = Json::array(), marks = Json::array();
  for (const PageBar& bar : lane.bars) {
    Json& one = bars.emplace_back(Json{{"shape", to_string(bar.shape)},
                                       {"kind", bar.kind},
                                       {"begin", short_number(bar.begin)},
                                       {"end", short_number(bar.end)},
                                       {"text", bar.text}});
    put(one, "remark", bar.remark);
    put(one, "task", bar.task);
  }
  for (const PageMark& mark : lane.marks)
    marks.push_back({{"kind", mark.kind}, {"t", short_number(mark.t)}, {"text", mark.text}});
  return {{"name", lane.name}, {"bars", std::move(bars)}, {"marks", std::move(marks)}};
}

Json json_of(const PageLanes& lanes) {
  Json key = Json::array(), all = Json::array();
  for (const PageLanes::Key& one : lanes.key) key.push_back({{"kind", one.kind}, {"text", one.text}});
  for (const PageLane& lane : lanes.lanes) all.push_back(json_of(lane));
  return {{"type", "lanes"}, {"title", lanes.title}, {"key", std::move(key)}, {"lanes", std::move(all)}};
}

Json json_of(const PageTask& task) {
  Json out{{"id", task.id},
           {"name", task.name},
           {"text", task.text},
           {"known", short_number(task.known)},
           {"begin", short_number(task.begin)},
           {"end", short_number(task.end)},
           {"begun", short_number(task.begun)},
           {"done", short_number(task.done)},
           {"state", task.state},
           {"state_kind", task.state_kind},
           {"late_s", short_number(task.late_s)},
           {"waited_s", short_number(task.waited_s)},
           {"points", short_number(task.points)},
           {"reason", task.reason}};
  put(out, "kind", task.kind);
  put(out, "look", task.look);
  Json& steps = out["steps"] = Json::array();
  for (const PageStep& step : task.steps) {
    Json& one = steps.emplace_back(Json{{"text", step.text},
                                        {"begin", short_number(step.begin)},
                                        {"end", short_number(step.end)},
                                        {"waited_s", short_number(step.waited_s)}});
    put(one, "where", step.where);
    put(one, "reason", step.reason);
  }
  return out;
}

Json json_of(const PageTasks& tasks) {
  Json all = Json::array();
  for (const PageTask& task : tasks.tasks) all.push_back(json_of(task));
  return {{"type", "tasks"}, {"title", tasks.title}, {"word", tasks.word}, {"tasks", std::move(all)}};
}

Json json_of(const PageEvent& event) {
  // An event of the whole run has no time.
  Json out{{"t", event.t < 0 ? Json() : short_number(event.t)}, {"kind", event.kind}, {"text", event.text}};
  put(out, "who", event.who);
  put(out, "reason", event.reason);
  put(out, "task", event.task);
  return out;
}

// --- The file

/// The chunks of a scene that fit into so many bytes.
std::string_view whole_chunks(std::string_view scene, std::size_t most) {
  constexpr std::size_t kMagic = 8;
  if (scene.size() <= most || scene.size() < kMagic) return scene;
  ByteReader in(scene.substr(kMagic));
  std::size_t end = kMagic;
  while (read_chunk(in) && kMagic + in.position() <= most) end = kMagic + in.position();
  return scene.substr(0, end);
}

/// The scripts of pages, below lab/pages: each file is a module that says what it needs of the others. A page has them
/// as one, in this order.
using Scripts = std::span<const char* const>;
constexpr std::array kOfRun{"run/data.js",    "run/time.js", "run/scene.js", "run/draw.js",   "run/field.js",
                            "run/field3d.js", "run/axis.js", "run/lanes.js", "run/orders.js", "run/chart.js",
                            "run/table.js",   "run/now.js",  "run/theme.js", "run/main.js"};
constexpr std::array kServedRun{"run/time.js",   "run/draw.js",    "view/served.js", "run/data.js",  "run/scene.js",
                                "run/field.js",  "run/field3d.js", "run/axis.js",    "run/lanes.js", "run/orders.js",
                                "run/chart.js",  "run/table.js",   "run/now.js",     "run/theme.js", "view/graph.js",
                                "view/facts.js", "view/sorted.js", "view/rules.js",  "view/why.js",  "view/users.js",
                                "view/ask.js",   "view/live.js",   "run/main.js"};
constexpr std::array kServedRuns{"run/time.js",    "run/draw.js",    "run/theme.js",
                                 "view/served.js", "view/sorted.js", "view/runs.js"};
constexpr std::array kServedTwo{"run/time.js", "run/draw.js", "run/theme.js", "view/served.js", "view/two.js"};

Expected<std::string> one_script(Scripts names) {
  std::string out;
  for (const char* name : names) {
    const auto text = read_file(find_share().pages / name);
    if (!text) return text.error();
    for (std::size_t at = 0; at < text->size();) {
      const std::size_t end = std::min(text->find('\n', at), text->size() - 1) + 1;
      std::string_view line = std::string_view(*text).substr(at, end - at);
      at = end;
      if (line.starts_with("import ")) continue;
      if (line.starts_with("export ")) line.remove_prefix(7);
      out += line;
    }
  }
  return out;
}

void add_element(std::string& page, const char* opening, std::string_view content) {
  ((page += opening) += content) += "</script>\n";
}

}  // namespace

std::string packed(std::string_view bytes) {
  z_stream stream{};
  constexpr int kGzip = 16 + 15, kLevel = 6, kMemory = 9;
  // Fails only where it has no memory, or is called wrongly.
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK) return {};
  std::string out(deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return base64(out);
}

Json run_data(const RunPage& page, double end) {
  Json kinds = Json::array(), shades = Json::array(), parts = Json::array(), events = Json::array();
  for (const PageKind& kind : page.kinds)
    kinds.push_back({{"name", kind.name}, {"fill", kind.fill}, {"ink", kind.ink}, {"hatched", kind.hatched}});
  for (const PageShade& shade : page.shades)
    shades.push_back({{"kind", shade.kind},
                      {"begin", short_number(shade.begin)},
                      {"end", short_number(shade.end)},
                      {"text", shade.text}});
  for (const auto& part : page.parts)
    if (!std::holds_alternative<PageTable>(part))
      parts.push_back(std::visit([](const auto& one) { return json_of(one); }, part));
  for (const PageEvent& event : page.events) events.push_back(json_of(event));
  return {{"end", short_number(end)},
          {"kinds", std::move(kinds)},
          {"shades", std::move(shades)},
          {"parts", std::move(parts)},
          {"events", std::move(events)}};
}

Json tables_of(const RunPage& page) {
  Json out = Json::array();
  for (const auto& part : page.parts)
    if (const auto* table = std::get_if<PageTable>(&part)) out.push_back(json_of(*table));
  return out;
}

Expected<std::string> run_page(const Json& head, RunPageData data) {
  auto page = render_page("run.html", json_text(head));
  if (!page) return page.error();
  const auto script = one_script(kOfRun);
  if (!script) return script.error();
  const std::string run = packed(json_text(data.run));
  const std::string_view three = three_script();
  constexpr std::size_t kAroundThem = 1000;
  const std::size_t others = page->size() + script->size() + run.size() + three.size() + kAroundThem;
  std::string_view shown = data.scene;
  std::string scene = packed(shown);
  // A half of what is there, until it fits in.
  while (others + scene.size() > kLargestPage && shown.size() > 8) {
    shown = whole_chunks(shown, shown.size() / 2);
    scene = packed(shown);
  }
  add_element(*page, "<script type=\"text/plain\" id=\"run-data\">", run);
  if (shown.size() > 8) add_element(*page, "<script type=\"text/plain\" id=\"run-scene\">", scene);
  add_element(*page, "<script type=\"text/plain\" id=\"three-js\">", three);
  add_element(*page, "<script type=\"module\">\n", *script);
  *page += "</html>\n";
  return page;
}

Expected<std::string> served_run_page(Json head) {
  head["served"] = true;
  return render_page("run.html", json_text(head));
}

Expected<std::string> served_page(const std::string& name) { return render_page("view/" + name, "{}"); }

Expected<std::string> served_script(std::string_view name) {
  if (name == "run.js") return one_script(kServedRun);
  if (name == "runs.js") return one_script(kServedRuns);
  if (name == "two.js") return one_script(kServedTwo);
  return input_error("no page has a script '" + std::string(name) + "'");
}

}  // namespace cxlab::lab
