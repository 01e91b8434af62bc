#include "sim/mujoco/overlay.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

namespace cxlab::sim {
namespace {

constexpr double kBlinkPeriod = 0.5;  ///< s; docs/models.md: lights blink at 2 Hz
constexpr int kMargin = 3;            ///< px around a text
constexpr double kBody = 0.9;         ///< m, of a machine or robot that its tag leaves free
constexpr int kSearchStep = 4;        ///< px between two places that are tried
constexpr float kLamps[3][3] = {{1.0f, 0.15f, 0.1f}, {1.0f, 0.85f, 0.0f}, {0.15f, 0.95f, 0.25f}};

mjrRect rect(const Box& box) { return {box.left, box.bottom, box.width, box.height}; }

struct Pixel {
  int x = 0, y = 0;
  double scale = 0;  ///< px per metre, there
};

/// Where a point of the world is in the picture; nothing behind the camera.
std::optional<Pixel> project(const mjvScene& scene, const Box& picture, const double* point) {
  const mjvGLCamera& camera = scene.camera[0];
  const auto vector = [](const float* v) -> Vec3 { return Eigen::Map<const Eigen::Vector3f>(v).cast<double>(); };
  const Vec3 forward = vector(camera.forward), upward = vector(camera.up);
  const Vec3 offset = Eigen::Map<const Vec3>(point) - vector(camera.pos);
  const double along = offset.dot(forward), up = offset.dot(upward), right = offset.dot(forward.cross(upward));
  if (along <= 0) return std::nullopt;
  const double near = static_cast<double>(camera.frustum_near), bottom = static_cast<double>(camera.frustum_bottom);
  const double pixels = picture.height / (static_cast<double>(camera.frustum_top) - bottom);  // per m at `near`
  const double scale = pixels * near / along;
  return Pixel{picture.left + picture.width / 2 + static_cast<int>(std::lround(right * scale)),
               picture.bottom + static_cast<int>(std::lround(up * scale - bottom * pixels)), scale};
}

int text_width(const mjrContext& gl, const std::string& text) {
  int width = 0;
  for (const char c : text) width += gl.charWidth[static_cast<unsigned char>(c) % 128];
  return width;
}

/// The colours of a piece, from below; none when it is parked.
std::vector<const float*> colours_of(const mjModel& model, const PieceIds& piece) {
  std::vector<const float*> colours;
  for (const int geom : piece.geoms)
    if (model.geom_rgba[4 * geom + 3] > 0) colours.push_back(model.geom_rgba + 4 * geom);
  return colours;
}

void draw_piece(const std::vector<const float*>& colours, const Box& column) {
  mjr_rectangle(rect(column), 1, 1, 1, 1);
  const int layer = (column.height - 2) / static_cast<int>(colours.size());
  for (std::size_t i = 0; i < colours.size(); ++i)
    mjr_rectangle({column.left + 1, column.bottom + 1 + static_cast<int>(i) * layer, column.width - 2, layer},
                  colours[i][0], colours[i][1], colours[i][2], 1);
}

}  // namespace

std::array<bool, 3> shining(const Lights& lights, double time) {
  const bool lit_phase = std::fmod(time, kBlinkPeriod) < kBlinkPeriod / 2;
  const auto on = [&](Light light) { return light == Light::kOn || (light == Light::kBlink && lit_phase); };
  return {on(lights.red), on(lights.yellow), on(lights.green)};
}

std::vector<Box> place_boxes(std::span<const BoxWish> wishes, std::vector<Box> taken, const Box& picture) {
  std::vector<Box> placed;
  const int farthest = std::max(picture.width, picture.height);
  for (const BoxWish& wish : wishes) {
    Box found;
    double nearest = 0;
    for (int reach = 0; reach <= farthest && found.width == 0; reach += kSearchStep)
      for (int dy = -reach; dy <= reach; dy += kSearchStep)
        for (int dx = -reach; dx <= reach; dx += std::abs(dy) == reach || reach == 0 ? kSearchStep : 2 * reach) {
          const Box box{wish.x - wish.width / 2 + dx, wish.y - wish.height / 2 + dy, wish.width, wish.height};
          if (box.left < picture.left || box.bottom < picture.bottom ||
              box.left + box.width > picture.left + picture.width ||
              box.bottom + box.height > picture.bottom + picture.height)
            continue;
          if (std::ranges::any_of(taken, [&](const Box& other) { return box.overlaps(other); })) continue;
          const double distance = std::hypot(dx, dy);
          if (found.width > 0 && distance >= nearest) continue;
          found = box;
          nearest = distance;
        }
    if (found.width > 0) taken.push_back(found);
    placed.push_back(found);
  }
  return placed;
}

void draw_overlay(const OverlayInput& input, const Box& picture) {
  const mjModel& model = input.world.model();
  const int line = input.gl.charHeight;
  std::vector<Box> taken;

  const int side = std::max(5, line / 2), layer = std::max(3, line / 4);
  for (const PieceIds& piece : input.world.factory().pieces) {
    const auto colours = colours_of(model, piece);
    if (colours.empty()) continue;
    const auto at = project(input.scene, picture, input.data.xpos + 3 * piece.body);
    if (!at) continue;
    const Box column{at->x - side / 2, at->y, side + 2, layer * static_cast<int>(colours.size()) + 2};
    draw_piece(colours, column);
    taken.push_back(column);
  }

  struct Tag {
    const std::string* text;
    std::optional<std::array<bool, 3>> lamps;
  };
  std::vector<Tag> tags;
  std::vector<BoxWish> wishes;
  const auto add = [&](const std::string& text, int geom, std::optional<std::array<bool, 3>> lamps) {
    const auto at = project(input.scene, picture, input.data.geom_xpos + 3 * geom);
    if (!at) return;
    const int size = static_cast<int>(kBody * at->scale);  // what is tagged stays visible
    taken.push_back({at->x - size / 2, at->y - size / 2, size, size});
    tags.push_back({&text, lamps});
    wishes.push_back(
        {at->x, at->y + line, text_width(input.gl, text) + (lamps ? 3 * side + 5 : 0) + 2 * kMargin, line + kMargin});
  };
  for (std::size_t i = 0; i < input.stations.size(); ++i)
    add(input.stations[i], input.station_geoms[i], shining(input.world.lights(static_cast<StationId>(i)), input.time));
  for (std::size_t i = 0; i < input.robots.size(); ++i) add(input.robots[i], input.robot_geoms[i], std::nullopt);

  const std::vector<Box> boxes = place_boxes(wishes, std::move(taken), picture);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Box& box = boxes[i];
    if (box.width == 0) continue;
    mjr_rectangle(rect(box), 0, 0, 0, 0.75f);
    Box text = box;
    if (const auto& lamps = tags[i].lamps) {
      text.width -= 3 * side + 5;
      for (std::size_t lamp = 0; lamp < 3; ++lamp) {
        const float glow = (*lamps)[lamp] ? 1.0f : 0.22f;
        const Box square{text.left + text.width + static_cast<int>(lamp) * (side + 1),
                         box.bottom + (box.height - side) / 2, side, side};
        mjr_rectangle(rect(square), glow * kLamps[lamp][0], glow * kLamps[lamp][1], glow * kLamps[lamp][2], 1);
      }
    }
    mjr_label(rect(text), mjFONT_NORMAL, tags[i].text->c_str(), 0, 0, 0, 0, 1, 1, 1, &input.gl);
  }
}

}  // namespace cxlab::sim
