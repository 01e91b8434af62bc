// `new` and `delete` of a program that charges memory: the last byte of each block says whether it was charged.

#include <malloc.h>

#include <cstdlib>
#include <new>

#include "cx/base/charge.h"

namespace {

/// The block with its mark, or null.
void* marked(void* block) {
  if (block == nullptr) return nullptr;
  const std::size_t size = malloc_usable_size(block);
  const bool charged = cxlab::Charge::is_on();
  static_cast<bool*>(block)[size - 1] = charged;
  if (charged) cxlab::Charge::allocated(static_cast<std::int64_t>(size));
  return block;
}

template <class Allocate>
void* allocated(std::size_t size, Allocate allocate) {
  for (;;) {
    if (void* block = size == SIZE_MAX ? nullptr : marked(allocate(size + 1))) return block;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void freed(void* block) {
  if (block == nullptr) return;
  const std::size_t size = malloc_usable_size(block);
  if (static_cast<const bool*>(block)[size - 1]) cxlab::Charge::allocated(-static_cast<std::int64_t>(size));
  std::free(block);
}

void* allocated(std::size_t size, std::align_val_t alignment) {
  const auto align = static_cast<std::size_t>(alignment);
  return allocated(size, [align](std::size_t bytes) {
    return bytes > SIZE_MAX - align ? nullptr : std::aligned_alloc(align, (bytes + align - 1) / align * align);
  });
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
void* operator new(std::size_t size) { return allocated(size, std::malloc); }
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
void operator delete(void* block, std::align_val_t) noexcept { freed(block); }
void operator delete[](void* block, std::align_val_t) noexcept { freed(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { freed(block); }
void operator delete[](void* block, std::size_t, std::align_val_t) noexcept { freed(block); }
void operator delete(void* block, const std::nothrow_t&) noexcept { freed(block); }
void operator delete[](void* block, const std::nothrow_t&) noexcept { freed(block); }
void operator delete(void* block, std::align_val_t, const std::nothrow_t&) noexcept { freed(block); }
void operator delete[](void* block, std::align_val_t, const std::nothrow_t&) noexcept { freed(block); }
