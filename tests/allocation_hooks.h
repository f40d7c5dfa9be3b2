#ifndef TOPOTAG_TESTS_ALLOCATION_HOOKS_H_
#define TOPOTAG_TESTS_ALLOCATION_HOOKS_H_

// Replaces operator new and delete of the test that includes it, in one source file.

#include <stdlib.h>

#include <cstddef>
#include <new>

/// The test defines both: what follows an allocation, which has failed where this throws
/// std::bad_alloc, and what comes before one is freed, which is never null. On any thread.
void OnAllocate(void* memory);
void OnFree(void* memory);

namespace allocation_internal {

inline void* Allocate(size_t size, size_t alignment) {
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, size == 0 ? 1 : size) != 0) throw std::bad_alloc();
  try {
    OnAllocate(memory);
  } catch (...) {
    free(memory);
    throw;
  }
  return memory;
}

inline void* AllocateOrNull(size_t size) noexcept {
  try {
    return Allocate(size, alignof(std::max_align_t));
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

inline void Free(void* memory) {
  if (memory == nullptr) return;
  OnFree(memory);
  free(memory);
}

}  // namespace allocation_internal

void* operator new(size_t size) {
  return allocation_internal::Allocate(size, alignof(std::max_align_t));
}
void* operator new[](size_t size) {
  return allocation_internal::Allocate(size, alignof(std::max_align_t));
}
void* operator new(size_t size, std::align_val_t alignment) {
  return allocation_internal::Allocate(size, static_cast<size_t>(alignment));
}
void* operator new[](size_t size, std::align_val_t alignment) {
  return allocation_internal::Allocate(size, static_cast<size_t>(alignment));
}
void* operator new(size_t size, const std::nothrow_t&) noexcept {
  return allocation_internal::AllocateOrNull(size);
}
void* operator new[](size_t size, const std::nothrow_t&) noexcept {
  return allocation_internal::AllocateOrNull(size);
}
void operator delete(void* memory) noexcept { allocation_internal::Free(memory); }
void operator delete[](void* memory) noexcept { allocation_internal::Free(memory); }
void operator delete(void* memory, size_t) noexcept { allocation_internal::Free(memory); }
void operator delete[](void* memory, size_t) noexcept { allocation_internal::Free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { allocation_internal::Free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept {
  allocation_internal::Free(memory);
}
void operator delete(void* memory, size_t, std::align_val_t) noexcept {
  allocation_internal::Free(memory);
}
void operator delete[](void* memory, size_t, std::align_val_t) noexcept {
  allocation_internal::Free(memory);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
  allocation_internal::Free(memory);
}
void operator delete[](void* memory, const std::nothrow_t&) noexcept {
  allocation_internal::Free(memory);
}

#endif  // TOPOTAG_TESTS_ALLOCATION_HOOKS_H_
