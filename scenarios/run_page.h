#pragma once
// What the page of a run shows of its world beside its scene: tables, figures over time, lanes that say who did what
// when, tasks with their windows, events. A world declares how it is made (WorldKind::page); the page knows no world.
//
// All of it shares one time axis. A lane whose name is that of an entity of the scene belongs to that entity.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "scenarios/result.h"

namespace cxlab {

/// How things of a kind look. Colours are those of a page on white: "#0072b2", or "#88888838" where what lies below
/// shows through. On a dark page inks become lighter.
struct PageKind {
  std::string name;
  std::string fill;      ///< of bars; empty: it is the colour of lines and words only
  std::string ink;       ///< of lines and words
  bool hatched = false;  ///< its bars have stripes, for those who cannot tell colours apart
};

struct PageCell {
  std::string text;
  bool bold = false;
  std::string kind = {};  ///< bold, in its ink

  PageCell(std::string shown, bool is_bold = false, std::string of = {})
      : text(std::move(shown)), bold(is_bold), kind(std::move(of)) {}
  PageCell(const char* shown) : text(shown) {}
};

struct PageTable {
  std::string title;  ///< may be empty
  std::vector<std::string> columns;
  std::vector<std::vector<PageCell>> rows;
  std::string note = {};  ///< a sentence below it
};

/// A figure that begins with 0 and changes in steps.
struct PageLine {
  std::string kind;                              ///< whose ink it has
  std::vector<std::pair<double, double>> steps;  ///< from that time (s) on it has that value
  std::string text = {};                         ///< in the legend; empty: the kind
  bool is_part = false;                          ///< drawn thinner: what another line is the sum of
};

struct PageChart {
  std::string title;
  std::vector<PageLine> lines;
};

/// From when to when (s) something was so.
struct PageBar {
  enum class Shape : std::uint8_t {
    kBar,    ///< as high as the lane
    kAlert,  ///< the same, and seen however short it is
    kInset,  ///< less high, over the others
    kStrip,  ///< a strip below
  };
  Shape shape{};
  std::string kind;
  double begin = 0, end = 0;
  std::string text;         ///< who points at it reads this, the time, and the remark
  std::string remark = {};  ///< ", failed"
  std::string task = {};    ///< the id of the task that it is about
};

/// Something that happened at a time (s).
struct PageMark {
  std::string kind;
  double t = 0;
  std::string text;
};

/// A mark on the time axis, a row of the table of events, and a text in the caption of a film. The page adds decisions,
/// errors and warnings of the agents, of kinds "decision", "error" and "warning".
struct PageEvent {
  double t = 0;             ///< s
  std::string kind;         ///< by which people choose what they see: "fault", "points"
  std::string who;          ///< a lane or an entity; may be empty
  std::string text;         ///< what happened
  std::string reason = {};  ///< a code, a cause
  std::string task = {};    ///< the id of the task that it is about
  bool minor = false;       ///< captions of films leave it out
};

struct PageLane {
  std::string name;
  std::vector<PageBar> bars;  ///< later ones lie on earlier ones
  std::vector<PageMark> marks;
};

struct PageLanes {
  struct Key {
    std::string kind;  ///< empty: the text explains the marks
    std::string text;
  };
  std::string title;
  std::vector<Key> key;
  std::vector<PageLane> lanes;
};

/// A step on the way to a task's end; steps are in order of time, and may be of several tries.
struct PageStep {
  std::string text;                            ///< "RING_BLUE"
  std::string where = {};                      ///< a lane or an entity
  std::optional<double> begin = {}, end = {};  ///< s
  double waited_s = 0;
  std::string reason = {};  ///< what it waited for
};

/// Something that is to be done in a stretch of time: an order, a visit, an errand.
struct PageTask {
  std::string id;             ///< unique in the run: "5"; with the word of its part it is a link, `#order=5`
  std::string name;           ///< of its row: "order 5"
  std::string kind;           ///< whose ink the name has: a team; may be empty
  std::string text;           ///< what is wanted
  std::string look = {};      ///< what it looks like when it is done: solids, see `solids_of` of scenarios/scene.h
  double known = 0;           ///< s, when it became known
  double begin = 0, end = 0;  ///< s, the window
  std::optional<double> begun = {}, done = {};  ///< s
  std::string state;                            ///< "late"
  std::string state_kind;                       ///< the kind that the bar of its work has
  double late_s = 0;                            ///< how much it was late
  double waited_s = 0;                          ///< by waits of its steps
  std::optional<double> points = {};            ///< what it brought
  std::string reason = {};                      ///< how it ended, and why it is late or missing
  std::vector<PageStep> steps = {};
};

struct PageTasks {
  std::string title;
  std::string word;  ///< what a task is called in links: "order"
  std::vector<PageTask> tasks;
};

/// A stretch of time (s) behind each chart and all lanes.
struct PageShade {
  std::string kind;
  double begin = 0, end = 0;
  std::string text;
};

struct RunPage {
  std::vector<PageKind> kinds;
  std::vector<PageShade> shades;
  std::vector<std::variant<PageTable, PageChart, PageLanes, PageTasks>> parts;  ///< in their order on the page
  std::vector<PageEvent> events;  ///< in any order; beside those that `WorldKind::happened` tells
  /// Keys that report.json has of it, for pages of a user's own.
  std::vector<Result::Section> data;
};

}  // namespace cxlab
