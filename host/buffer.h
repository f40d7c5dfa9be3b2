#ifndef TOPOTAG_HOST_BUFFER_H_
#define TOPOTAG_HOST_BUFFER_H_

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>

namespace topotag {

/// Workspace of a trivial type that is kept between frames: it grows and never shrinks, and what is
/// in it is unspecified until written. Memory that is reserved but never written costs no pages.
template <typename T>
class Buffer {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  /// Room for n elements; what was in the buffer is lost where it grows.
  /// @throws std::bad_alloc, then the buffer is as before
  void Reserve(size_t n) {
    if (n <= capacity_) return;
    data_.reset(static_cast<T*>(::operator new(n * sizeof(T), kAlignment)));
    capacity_ = n;
  }
  size_t capacity() const { return capacity_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](size_t i) { return data_.get()[i]; }
  const T& operator[](size_t i) const { return data_.get()[i]; }

 private:
  static constexpr std::align_val_t kAlignment{64};
  struct Free {
    void operator()(T* p) const { ::operator delete(p, kAlignment); }
  };
  std::unique_ptr<T, Free> data_;
  size_t capacity_ = 0;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_BUFFER_H_
