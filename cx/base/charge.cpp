#include "cx/base/charge.h"

namespace cxlab {

constinit thread_local bool Charge::on_ = false;
constinit std::atomic<std::int64_t> Charge::memory_ = 0, Charge::disk_ = 0;

}  // namespace cxlab
