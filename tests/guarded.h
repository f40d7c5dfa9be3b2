#ifndef TOPOTAG_TESTS_GUARDED_H_
#define TOPOTAG_TESTS_GUARDED_H_

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

#include "tests/random_image.h"
#include "topotag/image.h"

namespace topotag {

/// Which end of a guarded memory lies at an inaccessible page: one byte further is a fault.
enum class Guard { kBegin, kEnd };

/// `bytes` of memory between two inaccessible pages.
class GuardedMemory {
 public:
  GuardedMemory(size_t bytes, Guard guard) {
    const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
    const size_t used = (bytes + page - 1) / page * page;
    mapped_ = used + 2 * page;
    void* mapping =
        mmap(nullptr, mapped_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (mapping == MAP_FAILED) throw std::bad_alloc();
    mapping_ = static_cast<uint8_t*>(mapping);
    if (mprotect(mapping_ + page, used, PROT_READ | PROT_WRITE) != 0) throw std::bad_alloc();
    data_ = mapping_ + page + (guard == Guard::kBegin ? 0 : used - bytes);
  }
  GuardedMemory(GuardedMemory&& other) noexcept
      : mapped_(other.mapped_),
        mapping_(std::exchange(other.mapping_, nullptr)),
        data_(other.data_) {}
  GuardedMemory& operator=(GuardedMemory&&) = delete;
  ~GuardedMemory() {
    if (mapping_ != nullptr) munmap(mapping_, mapped_);
  }

  uint8_t* data() const { return data_; }

 private:
  size_t mapped_;
  uint8_t* mapping_;
  uint8_t* data_;
};

/// An image whose first or last pixel lies at an inaccessible page. What lies between the rows is
/// filled with garbage.
class GuardedImage {
 public:
  GuardedImage(int width, int height, int padding, Guard guard = Guard::kEnd)
      : width_(width),
        height_(height),
        stride_(width + padding),
        memory_(static_cast<size_t>(stride_) * static_cast<size_t>(height - 1) +
                    static_cast<size_t>(width),
                guard) {}

  int width() const { return width_; }
  int height() const { return height_; }
  uint8_t* row(int y) { return memory_.data() + y * stride_; }
  ImageView view() const { return {memory_.data(), width_, height_, stride_}; }

  void FillPadding(uint64_t seed) { FillBetweenRows(view(), memory_.data(), seed); }

 private:
  int width_;
  int height_;
  ptrdiff_t stride_;
  GuardedMemory memory_;
};

/// An array that ends at an inaccessible page, as its alignment allows.
template <typename T>
class GuardedArray {
 public:
  explicit GuardedArray(size_t size) : size_(size), memory_(size * sizeof(T), Guard::kEnd) {}
  size_t size() const { return size_; }
  T* data() { return reinterpret_cast<T*>(memory_.data()); }
  T& operator[](size_t i) { return data()[i]; }

 private:
  size_t size_;
  GuardedMemory memory_;
};

/// Canaries in the capacity of a vector, behind the `size` elements that a stage will write.
template <typename T>
class VectorGuard {
 public:
  VectorGuard(std::vector<T>* vector, size_t size) : vector_(vector), size_(size) {
    vector->assign(size + kCount, kCanary);
    vector->resize(size);
  }
  /// Whether the vector has kept its memory, and what lies behind its elements.
  bool IsIntact() const {
    const T* end = vector_->data() + size_;
    return vector_->size() == size_ && vector_->capacity() >= size_ + kCount &&
           std::all_of(end, end + kCount, [](T value) { return value == kCanary; });
  }

 private:
  static constexpr size_t kCount = 64;
  static constexpr T kCanary = static_cast<T>(0xa5c3a5c3a5c3a5c3);
  std::vector<T>* vector_;
  size_t size_;
};

}  // namespace topotag

#endif  // TOPOTAG_TESTS_GUARDED_H_
