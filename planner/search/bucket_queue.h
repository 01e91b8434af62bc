#pragma once
// A queue by estimate.

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "cx/base/random.h"

namespace cxlab::planner {

/// The entries with the smallest estimate come first, first in first out among equals. Estimates above 65,536 count as
/// that.
template <class Entry>
class BucketQueue {
 public:
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  void push(int estimate, Entry entry) {
    const std::size_t bucket = static_cast<std::size_t>(std::min(estimate, 1 << 16));
    if (bucket >= buckets_.size()) buckets_.resize(bucket + 1);
    buckets_[bucket].entries.push_back(entry);
    least_ = std::min(least_, bucket);
    ++size_;
  }
  Entry pop() {
    while (buckets_[least_].entries.size() == buckets_[least_].head) ++least_;
    return take(buckets_[least_]);
  }
  /// Any entry, each with the same probability.
  Entry pop_any(RandomStream& random) {
    std::size_t skip = random.below(size_);
    for (Bucket& bucket : buckets_) {
      const std::size_t here = bucket.entries.size() - bucket.head;
      if (skip < here) {
        std::swap(bucket.entries[bucket.head], bucket.entries[bucket.head + skip]);
        return take(bucket);
      }
      skip -= here;
    }
    return pop();
  }

 private:
  struct Bucket {
    std::vector<Entry> entries;
    std::size_t head = 0;
  };
  Entry take(Bucket& bucket) {
    const Entry entry = bucket.entries[bucket.head++];
    if (bucket.head == bucket.entries.size()) {
      bucket.entries.clear();
      bucket.head = 0;
    }
    --size_;
    return entry;
  }

  std::vector<Bucket> buckets_;
  std::size_t least_ = std::numeric_limits<std::size_t>::max(), size_ = 0;
};

}  // namespace cxlab::planner
