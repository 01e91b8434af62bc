#include "sim/mujoco/label_places.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <optional>

namespace cxlab::sim {
namespace {

constexpr int kNearest = 2;   ///< px between a label and its body where nothing is in the way
constexpr int kStep = 4;      ///< px between two places that are tried
constexpr int kAttached = 8;  ///< px: a label that near needs no leader, and no better place
constexpr int kRounds = 3;    ///< of moving labels for others

class Placer {
 public:
  Placer(std::span<const LabelWish> wishes, std::vector<Box> taken, const Box& picture)
      : wishes_(wishes), taken_(std::move(taken)), picture_(picture), places_(wishes.size()) {
    for (const LabelWish& wish : wishes_) taken_.push_back(wish.body);
  }

  std::vector<Box> place() {
    for (std::size_t i = 0; i < wishes_.size(); ++i) places_[i] = nearest(i);
    for (int round = 0; round < kRounds; ++round)
      for (std::size_t i = 0; i < wishes_.size(); ++i)
        if (distance(i) > kAttached) make_room(i);
    return std::move(places_);
  }

 private:
  static constexpr int kFar = std::numeric_limits<int>::max() / 4;

  int distance(std::size_t i) const { return places_[i].width == 0 ? kFar : gap_between(places_[i], wishes_[i].body); }

  /// Calls with each place whose distance from the body is `gap`, until that returns true.
  template <class Visit>
  void each_place(std::size_t i, int gap, Visit visit) const {
    const auto& [body, width, height] = wishes_[i];
    const auto at = [&](int left, int bottom) {
      const Box box{left, bottom, width, height};
      if (box.within(picture_)) visit(box);
    };
    const int half_x = (body.width + width) / 2 + gap, half_y = (body.height + height) / 2 + gap;
    const int left = body.middle_x() - width / 2, bottom = body.middle_y() - height / 2;
    for (int along = 0; along <= half_x; along += kStep)
      for (const int dx : {along, -along}) {
        at(left + dx, body.top() + gap);
        at(left + dx, body.bottom - gap - height);
      }
    for (int along = 0; along <= half_y; along += kStep)
      for (const int dy : {along, -along}) {
        at(body.right() + gap, bottom + dy);
        at(body.left - gap - width, bottom + dy);
      }
  }

  bool covers_something(const Box& box) const {
    return std::ranges::any_of(taken_, [&](const Box& other) { return box.overlaps(other); });
  }
  /// The labels that the box overlaps, but for `self`.
  std::vector<std::size_t> covered_labels(std::size_t self, const Box& box) const {
    std::vector<std::size_t> found;
    for (std::size_t k = 0; k < places_.size(); ++k)
      if (k != self && places_[k].width > 0 && box.overlaps(places_[k])) found.push_back(k);
    return found;
  }
  bool crosses_something(std::size_t self, const Box& box) const {
    const Leader own = leader_of(box, wishes_[self].body);
    for (std::size_t k = 0; k < places_.size(); ++k) {
      if (k == self || places_[k].width == 0) continue;
      if (own.crosses(places_[k]) || leader_of(places_[k], wishes_[k].body).crosses(box)) return true;
    }
    return false;
  }
  /// Among places at the same distance, the best is the one whose middle is nearest to that of the body.
  long badness(std::size_t i, const Box& box) const {
    const long dx = box.middle_x() - wishes_[i].body.middle_x(), dy = box.middle_y() - wishes_[i].body.middle_y();
    return dx * dx + dy * dy;
  }

  Box nearest(std::size_t i) const {
    Box any;  // that crosses a leader
    const int farthest = std::max(picture_.width, picture_.height);
    for (int gap = kNearest; gap <= farthest; gap += kStep) {
      Box best;
      each_place(i, gap, [&](const Box& box) {
        if (best.width > 0 && badness(i, box) >= badness(i, best)) return;
        if (covers_something(box) || !covered_labels(i, box).empty()) return;
        if (!crosses_something(i, box))
          best = box;
        else if (any.width == 0)
          any = box;
      });
      if (best.width > 0) return best;
    }
    return any;
  }

  /// Tries the places nearer than the present one that only one other label holds, which then looks for another.
  void make_room(std::size_t i) {
    const int now = distance(i);
    for (int gap = kNearest; gap < now && gap < std::max(picture_.width, picture_.height); gap += kStep) {
      std::optional<std::pair<Box, std::size_t>> wanted;
      std::vector<std::size_t> tried;
      each_place(i, gap, [&](const Box& box) {
        if (wanted || covers_something(box)) return;
        const auto others = covered_labels(i, box);
        if (others.size() != 1 || std::ranges::find(tried, others[0]) != tried.end()) return;
        tried.push_back(others[0]);
        if (gap + distance_without(others[0], i, box) < now + distance(others[0])) wanted = {box, others[0]};
      });
      if (!wanted) continue;
      places_[i] = wanted->first;
      places_[wanted->second] = nearest(wanted->second);
      return;
    }
  }
  /// How far label `other` would be from its body if label `i` took that box.
  int distance_without(std::size_t other, std::size_t i, const Box& box) {
    const Box own = places_[i];
    places_[i] = box;
    const Box moved = nearest(other);
    places_[i] = own;
    return moved.width == 0 ? kFar : gap_between(moved, wishes_[other].body);
  }

  std::span<const LabelWish> wishes_;
  std::vector<Box> taken_;
  Box picture_;
  std::vector<Box> places_;
};

}  // namespace

int gap_between(const Box& a, const Box& b) {
  const int across = std::max(a.left - b.right(), b.left - a.right());
  const int upright = std::max(a.bottom - b.top(), b.bottom - a.top());
  return std::max({across, upright, 0});
}

Leader leader_of(const Box& label, const Box& body) {
  const int x = body.middle_x(), y = body.middle_y();
  return {std::clamp(x, label.left, label.right() - 1), std::clamp(y, label.bottom, label.top() - 1), x, y};
}

// Liang and Barsky: the part of the line that lies within all four sides.
bool Leader::crosses(const Box& box) const {
  double from = 0, to = 1;
  const auto cut = [&](double along, double room) {
    if (along == 0) return room > 0;
    const double t = room / along;
    (along < 0 ? from : to) = along < 0 ? std::max(from, t) : std::min(to, t);
    return from < to;
  };
  const double dx = x1 - x0, dy = y1 - y0;
  return cut(-dx, x0 - box.left) && cut(dx, box.right() - x0) && cut(-dy, y0 - box.bottom) && cut(dy, box.top() - y0);
}

std::vector<Box> place_labels(std::span<const LabelWish> wishes, std::vector<Box> taken, const Box& picture) {
  return Placer(wishes, std::move(taken), picture).place();
}

}  // namespace cxlab::sim
