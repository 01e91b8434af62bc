#include "scenarios/rcll/rules/orders.h"

#include <algorithm>
#include <utility>

namespace cxlab::rcll {
namespace {

// Seconds of production; the referee box's figures.
constexpr int kProductionEnd = 1200;
constexpr int kFirstActivation = 180;
constexpr int kLastActivation = 960;
constexpr int kSpacing = 120;
constexpr int kJitter = 90;

struct Range {
  int low, high;
};
constexpr std::array<Range, 4> kLead{{{60, 120}, {120, 300}, {300, 400}, {400, 500}}};
constexpr std::array<Range, 4> kWindow{{{90, 180}, {90, 180}, {150, 210}, {150, 210}}};

int draw(RandomStream& random, Range range) { return static_cast<int>(random.between(range.low, range.high)); }

RingPrices draw_prices(RandomStream& random) {
  auto colors = kRingColors;
  random.shuffle(colors);
  const bool first_costs_two = random.chance(0.5);
  RingPrices prices{};
  prices[static_cast<std::size_t>(colors[0]) - 1] = first_costs_two ? 2 : 1;
  prices[static_cast<std::size_t>(colors[2]) - 1] = first_costs_two ? 1 : 2;
  return prices;
}

/// Ten complexities: orders 1 and 2 get the first pair, the others are shuffled.
std::vector<Complexity> draw_complexities(RandomStream& random, const std::vector<Complexity>& allowed) {
  std::vector<Complexity> simple, complex;
  for (const Complexity c : {Complexity::kC0, Complexity::kC1, Complexity::kC2, Complexity::kC3}) {
    if (!allowed.empty() && std::ranges::find(allowed, c) == allowed.end()) continue;
    (c < Complexity::kC2 ? simple : complex).push_back(c);
  }
  if (simple.empty()) simple = complex;
  if (complex.empty()) complex = simple;

  std::vector<Complexity> drawn;
  for (int pair = 0; pair < 5; ++pair) {
    drawn.push_back(simple[random.below(simple.size())]);
    drawn.push_back(complex[random.below(complex.size())]);
  }
  std::vector<Complexity> later(drawn.begin() + 2, drawn.end());
  random.shuffle(later);
  std::ranges::copy(later, drawn.begin() + 2);
  return drawn;
}

BaseColor draw_base(RandomStream& random) { return static_cast<BaseColor>(random.between(1, 3)); }

/// No two rings of the same colour on each other.
std::vector<RingColor> draw_rings(RandomStream& random, std::size_t count) {
  std::vector<RingColor> rings;
  while (rings.size() < count) {
    const RingColor next = kRingColors[random.below(4)];
    if (rings.empty() || rings.back() != next) rings.push_back(next);
  }
  return rings;
}

void draw_times(RandomStream& random, Order& order) {
  const auto kind = static_cast<std::size_t>(order.complexity);
  const int centre = kFirstActivation + kSpacing * (order.id - 3);
  int begin = draw(random, {centre - kJitter, centre + kJitter});
  int end = begin + draw(random, kWindow[kind]);
  int activate = std::max(0, begin - draw(random, kLead[kind]));
  const int shift = std::clamp(activate, kFirstActivation, kLastActivation) - activate;
  activate += shift;
  begin += shift;
  end += shift;
  const int over = std::max(0, end - kProductionEnd);
  order.activate_at = activate;
  order.delivery_begin = begin - over;
  order.delivery_end = end - over;
}

void redraw_rings_and_base(RandomStream& random, Order& order) {
  order.product.rings = draw_rings(random, order.product.rings.size());
  order.product.base = draw_base(random);
}

/// Standing orders must begin with a ring that is free; no two orders with rings may share base and first ring.
void repair(RandomStream& random, Schedule& schedule) {
  const auto conflict = [&]() -> Order* {
    for (std::size_t i = 0; i < schedule.orders.size(); ++i) {
      Order& order = schedule.orders[i];
      if (order.product.rings.empty()) continue;
      if (i < 2 && schedule.price(order.product.rings.front()) > 0) return &order;
      for (std::size_t j = 0; j < i; ++j) {
        const Product& earlier = schedule.orders[j].product;
        if (!earlier.rings.empty() && earlier.base == order.product.base &&
            earlier.rings.front() == order.product.rings.front())
          return &order;
      }
    }
    return nullptr;
  };
  while (Order* order = conflict()) redraw_rings_and_base(random, *order);
}

}  // namespace

Schedule draw_schedule(RandomStream& random, const std::vector<Complexity>& allowed) {
  Schedule schedule;
  schedule.ring_prices = draw_prices(random);
  const std::vector<Complexity> complexities = draw_complexities(random, allowed);
  for (int id = 1; id <= 10; ++id) {
    Order order;
    order.id = id;
    order.complexity = complexities[static_cast<std::size_t>(id) - 1];
    order.delivery_end = kProductionEnd;
    if (id > 2) draw_times(random, order);
    order.delivery_gate = static_cast<int>(random.between(1, 3));
    order.product.base = draw_base(random);
    order.product.cap = static_cast<CapColor>(random.between(1, 2));
    order.product.rings = draw_rings(random, static_cast<std::size_t>(order.complexity));
    schedule.orders.push_back(std::move(order));
  }
  schedule.orders[static_cast<std::size_t>(random.between(3, 10)) - 1].competitive = true;
  repair(random, schedule);
  return schedule;
}

Order draw_overtime_order(RandomStream& random, double begin, double end) {
  Order order;
  order.complexity = Complexity::kC0;
  order.activate_at = order.delivery_begin = begin;
  order.delivery_end = end;
  order.delivery_gate = static_cast<int>(random.between(1, 3));
  order.product.base = draw_base(random);
  order.product.cap = static_cast<CapColor>(random.between(1, 2));
  order.competitive = true;
  return order;
}

Order read_order(const OrderConfig& config, int id) {
  Order order;
  order.id = id;
  order.complexity = *named<Complexity>(config.complexity);
  order.product.base = *named<BaseColor>(config.base_color);
  for (const std::string& ring : config.ring_colors) order.product.rings.push_back(*named<RingColor>(ring));
  order.product.cap = *named<CapColor>(config.cap_color);
  order.activate_at = config.activate_at;
  order.delivery_begin = config.delivery_begin;
  order.delivery_end = config.delivery_end;
  order.delivery_gate = config.delivery_gate;
  order.quantity = config.quantity;
  order.competitive = config.competitive;
  return order;
}

OrderConfig listed(const Order& order) {
  OrderConfig out;
  out.complexity = to_string(order.complexity);
  out.base_color = to_string(order.product.base);
  for (const RingColor ring : order.product.rings) out.ring_colors.emplace_back(to_string(ring));
  out.cap_color = to_string(order.product.cap);
  out.activate_at = order.activate_at;
  out.delivery_begin = order.delivery_begin;
  out.delivery_end = order.delivery_end;
  out.delivery_gate = order.delivery_gate;
  out.quantity = order.quantity;
  out.competitive = order.competitive;
  return out;
}

}  // namespace cxlab::rcll
