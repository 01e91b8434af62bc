#pragma once
// Counts what the process takes from the machine on behalf of rules, which may not take everything.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace cxlab {

/// While one lives and is on, what its thread allocates with `new` and writes to files is charged.
class Charge {
 public:
  explicit Charge(bool on = true) : outer_(std::exchange(on_, on)) {}
  ~Charge() { on_ = outer_; }
  Charge(const Charge&) = delete;
  Charge& operator=(const Charge&) = delete;
  static bool is_on() { return on_; }

  /// Bytes that were allocated while it was on and are not freed yet; always 0 in a program without
  /// cx/base/charged_new.cpp.
  static std::int64_t memory() { return memory_.load(std::memory_order_relaxed); }
  static void allocated(std::int64_t bytes) { memory_.fetch_add(bytes, std::memory_order_relaxed); }
  /// Bytes that were written to files, in all.
  static std::int64_t disk() { return disk_.load(std::memory_order_relaxed); }
  static void written(std::size_t bytes) {
    disk_.fetch_add(static_cast<std::int64_t>(bytes), std::memory_order_relaxed);
  }

 private:
  static thread_local constinit bool on_;
  static std::atomic<std::int64_t> memory_, disk_;
  bool outer_;
};

}  // namespace cxlab
