#pragma once
// Where the labels of a picture go: clear of each other and of everything that they name, each as near to its own thing
// as that allows.

#include <span>
#include <vector>

namespace cxlab::sim {

/// In pixels, from the lower left corner of the picture.
struct Box {
  int left = 0, bottom = 0, width = 0, height = 0;
  int right() const { return left + width; }
  int top() const { return bottom + height; }
  int middle_x() const { return left + width / 2; }
  int middle_y() const { return bottom + height / 2; }
  bool overlaps(const Box& other) const {
    return left < other.right() && other.left < right() && bottom < other.top() && other.bottom < top();
  }
  bool within(const Box& other) const {
    return left >= other.left && bottom >= other.bottom && right() <= other.right() && top() <= other.top();
  }
  friend bool operator==(const Box&, const Box&) = default;
};

/// Pixels between two boxes in the direction in which they are farther apart; 0 where they touch or overlap.
int gap_between(const Box& a, const Box& b);

/// A line from a label to what it names.
struct Leader {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool crosses(const Box& box) const;
};
/// From the label's nearest point to the middle of the body.
Leader leader_of(const Box& label, const Box& body);

/// A label of that size for what fills `body`.
struct LabelWish {
  Box body;
  int width = 0, height = 0;
};

/// A place for each label within `picture`, clear of `taken`, of all bodies and of the other labels; leaders run clear
/// of other labels where that is possible. A label moves away for one that would be much farther from its body
/// otherwise. A label that finds no place is left out (width 0). The same wishes get the same places.
std::vector<Box> place_labels(std::span<const LabelWish> wishes, std::vector<Box> taken, const Box& picture);

}  // namespace cxlab::sim
