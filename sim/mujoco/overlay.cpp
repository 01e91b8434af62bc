#include "sim/mujoco/overlay.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <Eigen/Geometry>

namespace cxlab::sim {
namespace {

constexpr double kBlinkPeriod = 0.5;  ///< s; docs/reference/models.md: lights blink at 2 Hz
constexpr int kMargin = 3;            ///< px around a text
constexpr int kTied = 5;              ///< px between a label and its body from which a leader is drawn
constexpr double kMachineTop = 1.12;  ///< m, with its signal light
constexpr double kRobotTop = 0.9;     ///< m, with its gripper
constexpr Legend::Colour kLamps[3] = {{1.0f, 0.15f, 0.1f}, {1.0f, 0.85f, 0.0f}, {0.15f, 0.95f, 0.25f}};
constexpr int kNarrow = 700;  ///< px: in a picture that is less wide names are short
constexpr float kUnlit = 0.22f;

mjrRect rect(const Box& box) { return {box.left, box.bottom, box.width, box.height}; }

void fill(const Box& box, const Legend::Colour& colour, float alpha = 1) {
  mjr_rectangle(rect(box), colour[0], colour[1], colour[2], alpha);
}

int text_width(const mjrContext& gl, const std::string& text) {
  int width = 0;
  for (const char c : text) width += gl.charWidth[std::min<std::size_t>(static_cast<unsigned char>(c), 126)];
  return width;
}

int line_height(const mjrContext& gl) { return gl.charHeight; }

Legend::Colour colour_of(const float* rgba) { return {rgba[0], rgba[1], rgba[2]}; }

/// The colours of a piece, from below; none when it is parked.
std::vector<Legend::Colour> colours_of(const mjModel& model, const PieceIds& piece) {
  std::vector<Legend::Colour> colours;
  for (const int geom : piece.geoms)
    if (model.geom_rgba[4 * geom + 3] > 0) colours.push_back(colour_of(model.geom_rgba + 4 * geom));
  return colours;
}

std::vector<Legend::Colour> colours_of(const FactoryModel& factory, const Stack& stack) {
  std::vector<Legend::Colour> colours;
  const auto add = [&](const std::vector<int>& materials, std::uint8_t colour) {
    if (colour > 0 && colour < materials.size())
      colours.push_back(colour_of(factory.model->mat_rgba + 4 * materials[colour]));
  };
  add(factory.base_materials, stack.base);
  for (const std::uint8_t ring : stack.rings) add(factory.ring_materials, ring);
  add(factory.cap_materials, stack.cap);
  return colours;
}

/// A column of that many layers, whose lowest is a base, with its middle and its foot there.
Box column_at(int x, int bottom, std::size_t layers, int layer, int width) {
  return {x - width / 2, bottom, width, (static_cast<int>(layers) + 1) * layer + 2};
}

void paint_column(const Overlay::Column& column) {
  const int layer = (column.box.height - 2) / (static_cast<int>(column.colours.size()) + 1);
  fill(column.box, {1, 1, 1});
  int bottom = column.box.bottom + 1;
  for (std::size_t i = 0; i < column.colours.size(); ++i) {
    const int height = i == 0 ? 2 * layer : layer;
    fill({column.box.left + 1, bottom, column.box.width - 2, height}, column.colours[i]);
    bottom += height;
  }
}

/// A line as boxes of one pixel in width, as long as they can be.
template <class Visit>
void each_run(const Leader& line, Visit visit) {
  const int dx = line.x1 - line.x0, dy = line.y1 - line.y0, steps = std::max(std::abs(dx), std::abs(dy));
  if (steps == 0) return;
  const auto at = [&](int k, int from, int along) {
    return from + static_cast<int>(std::lround(static_cast<double>(along) * k / steps));
  };
  for (int k = 0; k <= steps;) {
    const int x = at(k, line.x0, dx), y = at(k, line.y0, dy);
    int last = k;
    while (last < steps &&
           (std::abs(dx) >= std::abs(dy) ? at(last + 1, line.y0, dy) == y : at(last + 1, line.x0, dx) == x))
      ++last;
    const int x_last = at(last, line.x0, dx), y_last = at(last, line.y0, dy);
    visit(Box{std::min(x, x_last), std::min(y, y_last), std::abs(x_last - x) + 1, std::abs(y_last - y) + 1});
    k = last + 1;
  }
}

void paint_leader(const Overlay::Label& label) {
  if (gap_between(label.box, label.body) < kTied) return;
  const Leader leader = label.leader();
  each_run(leader,
           [](const Box& run) { fill({run.left - 1, run.bottom - 1, run.width + 2, run.height + 2}, {0, 0, 0}); });
  each_run(leader, [](const Box& run) { fill(run, {1, 1, 1}); });
  fill({leader.x1 - 2, leader.y1 - 2, 5, 5}, {0, 0, 0});
  fill({leader.x1 - 1, leader.y1 - 1, 3, 3}, {1, 1, 1});
}

void paint_tick(const Box& box, const Legend::Colour& colour) {
  const int knee_x = box.left + box.width / 3;
  for (int thick = 0; thick < std::max(2, box.width / 5); ++thick)
    for (const Leader& stroke : {Leader{box.left, box.middle_y(), knee_x, box.bottom},
                                 Leader{knee_x, box.bottom, box.right() - 1, box.top() - 1}})
      each_run({stroke.x0, stroke.y0 + thick, stroke.x1, stroke.y1 + thick},
               [&](const Box& run) { fill(run, colour); });
}

/// The part of the box within the picture; width 0 if there is none.
Box clipped(const Box& box, const Box& picture) {
  const int left = std::max(box.left, picture.left), bottom = std::max(box.bottom, picture.bottom);
  const int width = std::min(box.right(), picture.right()) - left;
  const int height = std::min(box.top(), picture.top()) - bottom;
  return width > 0 && height > 0 ? Box{left, bottom, width, height} : Box{};
}

double area(const Box& box) { return static_cast<double>(box.width) * box.height; }

}  // namespace

// --- where things are ------------------------------------------------------------------------------------------

std::array<bool, 3> shining(const Lights& lights, double time) {
  const bool lit_phase = std::fmod(time + kBlinkPeriod / 4, kBlinkPeriod) < kBlinkPeriod / 2;
  const auto on = [&](Light light) { return light == Light::kOn || (light == Light::kBlink && lit_phase); };
  return {on(lights.red), on(lights.yellow), on(lights.green)};
}

Projection::Projection(const mjvGLCamera& camera, int width, int height) {
  const auto vector = [](const float* v) -> Vec3 { return Eigen::Map<const Eigen::Vector3f>(v).cast<double>(); };
  from_ = vector(camera.pos);
  forward_ = vector(camera.forward);
  upward_ = vector(camera.up);
  right_ = forward_.cross(upward_);
  const double near = static_cast<double>(camera.frustum_near), bottom = static_cast<double>(camera.frustum_bottom);
  pixels_ = near * height / (static_cast<double>(camera.frustum_top) - bottom);
  bottom_ = bottom / near;
  centre_ = static_cast<double>(camera.frustum_center) / near;
  half_width_ = width / 2.0;
}

std::optional<Projection::Pixel> Projection::pixel(const Vec3& point) const {
  const Vec3 offset = point - from_;
  const double along = offset.dot(forward_);
  if (along <= 0) return std::nullopt;
  return Pixel{half_width_ + (offset.dot(right_) / along - centre_) * pixels_,
               (offset.dot(upward_) / along - bottom_) * pixels_};
}

Box Projection::around(std::span<const Vec3> points) const {
  constexpr double kFarAway = 1e6;  // px; what is beyond is not in the picture
  double left = kFarAway, right = -kFarAway, bottom = kFarAway, top = -kFarAway;
  for (const Vec3& point : points) {
    const auto at = pixel(point);
    if (!at) continue;
    left = std::min(left, std::max(at->x, -kFarAway));
    right = std::max(right, std::min(at->x, kFarAway));
    bottom = std::min(bottom, std::max(at->y, -kFarAway));
    top = std::max(top, std::min(at->y, kFarAway));
  }
  if (left > right) return {};
  const int x = static_cast<int>(std::floor(left)), y = static_cast<int>(std::floor(bottom));
  return {x, y, static_cast<int>(std::ceil(right)) - x, static_cast<int>(std::ceil(top)) - y};
}

std::array<Vec3, 8> corners(const Pose2& pose, double half_depth, double half_width, double height) {
  std::array<Vec3, 8> out;
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  for (std::size_t i = 0; i < 8; ++i) {
    const double x = i & 1 ? half_depth : -half_depth, y = i & 2 ? half_width : -half_width;
    out[i] = {pose.x + c * x - s * y, pose.y + s * x + c * y, i & 4 ? height : 0};
  }
  return out;
}

// --- places ----------------------------------------------------------------------------------------------------

int place_legend(const Legend& legend, const FactoryModel& factory, const mjrContext& gl, const Box& picture,
                 Overlay& overlay) {
  const int line = line_height(gl), lowest = picture.top() - picture.height / 2;
  int bottom = picture.top();
  const auto add_text = [&](const Legend::Text& text, int left, int at) {
    overlay.lines.push_back({{left, at, text_width(gl, text.text), line}, text});
  };
  const int icon = line, height = 2 * line + 2 * kMargin, layer = (height - 2 * kMargin - 2) / 6;
  int left = picture.right();  // the first card begins a row
  for (const Legend::Card& card : legend.cards) {
    int text = 0;
    for (const Legend::Text& words : card.lines) text = std::max(text, text_width(gl, words.text));
    const int tick = line * 3 / 4, ticks = static_cast<int>(card.ticks.size()) * (tick + kMargin);
    text = std::max(text, text_width(gl, card.lines[0].text) + ticks);
    const int width = icon + text + 3 * kMargin;
    if (left + width > picture.right()) {
      if (bottom - height - kMargin < lowest) break;
      bottom -= height + kMargin;
      left = picture.left;
    }
    const Box box{left, bottom, width, height};
    overlay.cards.push_back(box);
    const auto colours = colours_of(factory, card.product);
    overlay.columns.push_back(
        {column_at(left + kMargin + icon / 2, bottom + kMargin, colours.size(), layer, icon), colours});
    int at = box.top() - kMargin;
    for (const Legend::Text& words : card.lines) add_text(words, left + icon + 2 * kMargin, at -= line);
    int right = box.right();
    for (const Legend::Colour& colour : card.ticks)
      overlay.ticks.push_back({{right -= tick + kMargin, box.top() - tick - kMargin, tick, tick}, colour});
    left = box.right() + kMargin;
  }
  return std::max(picture.top() - bottom, std::min(legend.rows * (height + kMargin), picture.height / 2));
}

void place_pieces(const OverlayInput& input, const Projection& projection, const mjrContext& gl, const Box& free,
                  Overlay& overlay) {
  const int layer = std::max(3, line_height(gl) / 4), width = std::max(7, line_height(gl) * 2 / 3);
  for (const PieceIds& piece : input.world.factory().pieces) {
    const auto colours = colours_of(input.world.model(), piece);
    if (colours.empty()) continue;
    const auto at = projection.pixel(Eigen::Map<const Vec3>(input.data.xpos + 3 * piece.body));
    if (!at) continue;
    const Box box = column_at(static_cast<int>(std::lround(at->x)), static_cast<int>(std::lround(at->y)),
                              colours.size(), layer, width);
    if (box.within(free)) overlay.columns.push_back({box, colours});
  }
}

void place_names(const OverlayInput& input, const Projection& projection, const mjrContext& gl, const Box& free,
                 Overlay& overlay) {
  std::vector<Box> taken;
  for (const Overlay::Column& column : overlay.columns) taken.push_back(column.box);
  const int line = line_height(gl), lamp = std::max(3, line / 3);
  std::vector<LabelWish> wishes;
  const mjModel& model = input.world.model();
  const bool narrow = free.width < kNarrow;
  const auto bright = [&](int material) {
    Legend::Colour colour{1, 1, 1};
    for (std::size_t i = 0; i < 3 && material >= 0; ++i)
      colour[i] = 0.4f + 0.6f * model.mat_rgba[4 * static_cast<std::size_t>(material) + i];
    return colour;
  };
  const auto add = [&](const std::string& name, const std::string& text, int material, std::span<const Vec3> outline,
                       std::optional<std::array<bool, 3>> lit) {
    const Box whole = projection.around(outline), body = clipped(whole, free);
    if (area(body) * 3 < area(whole) || body.width == 0) return;  // mostly out of sight
    overlay.labels.push_back({name, text, bright(material), body, {}, lit});
    wishes.push_back({body, text_width(gl, text) + 2 * kMargin + (lit ? lamp + kMargin : 0), 3 * lamp + 4});
  };
  const std::size_t first = overlay.labels.size();
  for (std::size_t i = 0; i < input.plan.stations.size(); ++i) {
    const Station& station = input.plan.stations[i];
    const std::size_t dash = station.name.find('-') + 1;
    add(station.name, narrow ? station.name.substr(dash) : station.name,
        mj_name2id(&model, mjOBJ_MATERIAL, ("team-" + station.name.substr(0, 1)).c_str()),
        corners(station.pose_in_world, kMachine.half_depth, kMachine.half_width, kMachineTop),
        shining(input.world.lights(static_cast<StationId>(i)), input.world.time()));
  }
  for (std::size_t i = 0; i < input.plan.robots.size(); ++i) {
    const double* at = input.data.geom_xpos + 3 * input.robot_geoms[i];
    const double radius = kRobot.hull_radius;
    const std::string& name = input.plan.robots[i].name;
    const std::size_t number = name.find_last_not_of("0123456789") + 1;
    add(name, narrow && number < name.size() ? name.substr(number) : name, model.geom_matid[input.robot_geoms[i]],
        corners({at[0], at[1], 0}, radius, radius, kRobotTop), std::nullopt);
  }

  const std::vector<Box> boxes = place_labels(wishes, std::move(taken), free);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    Overlay::Label& label = overlay.labels[first + i];
    label.box = boxes[i];
    for (int k = 0; k < 3; ++k)
      label.lamps[static_cast<std::size_t>(k)] = {label.box.right() - lamp - 2, label.box.top() - (k + 1) * (lamp + 1),
                                                  lamp, lamp};
  }
}

// --- paint -----------------------------------------------------------------------------------------------------

void paint(const Overlay& overlay, const mjrContext& gl) {
  const auto write = [&](const Box& box, const std::string& text, const Legend::Colour& colour) {
    mjr_label(rect(box), mjFONT_NORMAL, text.c_str(), 0, 0, 0, 0, colour[0], colour[1], colour[2], &gl);
  };
  for (const Box& card : overlay.cards) fill(card, {0, 0, 0}, 0.75f);
  for (const Overlay::Column& column : overlay.columns) paint_column(column);
  for (const Overlay::Line& line : overlay.lines) write(line.box, line.text.text, line.text.colour);
  for (const Overlay::Tick& tick : overlay.ticks) paint_tick(tick.box, tick.colour);

  for (const Overlay::Label& label : overlay.labels)
    if (label.box.width > 0) paint_leader(label);
  for (const Overlay::Label& label : overlay.labels) {
    if (label.box.width == 0) continue;
    fill(label.box, {0, 0, 0}, 0.8f);
    Box text = label.box;
    if (label.lit) {
      text.width = label.lamps[0].left - text.left;
      for (std::size_t k = 0; k < 3; ++k) {
        const float glow = (*label.lit)[k] ? 1.0f : kUnlit;
        fill(label.lamps[k], {glow * kLamps[k][0], glow * kLamps[k][1], glow * kLamps[k][2]});
      }
    }
    write(text, label.text, label.colour);
  }
}

}  // namespace cxlab::sim
