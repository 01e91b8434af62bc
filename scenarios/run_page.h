#pragma once
// What the page of a run shows of its world: tables, figures over time, lanes that say who did what when. A world
// declares how it is made (WorldKind::page); who draws it knows no world.

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "scenarios/result.h"

namespace cxlab {

/// How things of a kind look: the name is a class of the style sheet.
struct PageKind {
  std::string name;
  std::string fill;  ///< of bars; empty: it is the colour of lines and words only
  std::string ink;   ///< of lines and words
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
};

/// Something that happened at a time (s).
struct PageMark {
  std::string kind;
  double t = 0;
  std::string text;
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

/// A stretch of time (s) behind each chart and all lanes.
struct PageShade {
  std::string kind;
  double begin = 0, end = 0;
  std::string text;
};

struct RunPage {
  std::vector<PageKind> kinds;
  std::vector<PageShade> shades;
  std::vector<std::variant<PageTable, PageChart, PageLanes>> parts;  ///< in their order on the page
  /// Keys that report.json has of it, for pages of a user's own.
  std::vector<Result::Section> data;
};

}  // namespace cxlab
