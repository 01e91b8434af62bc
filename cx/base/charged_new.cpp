// `new` and `delete` of a program that charges memory: a mark before each block says what was charged.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "cx/base/charge.h"

namespace {

/// What lies before each block: the bytes that were charged for it, or 0.
struct alignas(__STDCPP_DEFAULT_NEW_ALIGNMENT__) Mark {
  std::size_t charged;
};

/// From a block of malloc to what `new` returns.
std::size_t offset(std::align_val_t alignment) { return std::max(sizeof(Mark), static_cast<std::size_t>(alignment)); }

/// A block of that many bytes, or null.
void* block_of(std::size_t bytes, std::align_val_t alignment) {
  const auto align = static_cast<std::size_t>(alignment);
  if (align <= alignof(Mark)) return std::malloc(bytes);
  return bytes > SIZE_MAX - align ? nullptr : std::aligned_alloc(align, (bytes + align - 1) / align * align);
}

void* allocated(std::size_t size, std::align_val_t alignment = {}) {
  const std::size_t before = offset(alignment);
  for (;;) {
    void* const block = size > SIZE_MAX - before ? nullptr : block_of(before + size, alignment);
    if (block != nullptr) {
      void* const given = static_cast<char*>(block) + before;
      const std::size_t charged = cxlab::Charge::is_on() ? before + size : 0;
      new (static_cast<Mark*>(given) - 1) Mark{charged};
      if (charged > 0) cxlab::Charge::allocated(static_cast<std::int64_t>(charged));
      return given;
    }
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void freed(void* given, std::align_val_t alignment = {}) {
  if (given == nullptr) return;
  const std::size_t charged = (static_cast<const Mark*>(given) - 1)->charged;
  if (charged > 0) cxlab::Charge::allocated(-static_cast<std::int64_t>(charged));
  std::free(static_cast<char*>(given) - offset(alignment));
}

template <class... Alignment>
void* allocated_or_null(std::size_t size, Alignment... alignment) noexcept {
  try {
    return operator new(size, alignment...);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

}  // namespace

// All forms: those of a sanitizer's library do not call the first two.
void* operator new(std::size_t size) { return allocated(size); }
void* operator new(std::size_t size, std::align_val_t alignment) { return allocated(size, alignment); }
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new[](std::size_t size, std::align_val_t alignment) { return operator new(size, alignment); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return allocated_or_null(size); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return allocated_or_null(size); }
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocated_or_null(size, alignment);
}
void* operator new[](std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocated_or_null(size, alignment);
}
void operator delete(void* block) noexcept { freed(block); }
void operator delete[](void* block) noexcept { freed(block); }
void operator delete(void* block, std::size_t) noexcept { freed(block); }
void operator delete[](void* block, std::size_t) noexcept { freed(block); }
void operator delete(void* block, std::align_val_t alignment) noexcept { freed(block, alignment); }
void operator delete[](void* block, std::align_val_t alignment) noexcept { freed(block, alignment); }
void operator delete(void* block, std::size_t, std::align_val_t alignment) noexcept { freed(block, alignment); }
void operator delete[](void* block, std::size_t, std::align_val_t alignment) noexcept { freed(block, alignment); }
void operator delete(void* block, const std::nothrow_t&) noexcept { freed(block); }
void operator delete[](void* block, const std::nothrow_t&) noexcept { freed(block); }
void operator delete(void* block, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  freed(block, alignment);
}
void operator delete[](void* block, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  freed(block, alignment);
}
