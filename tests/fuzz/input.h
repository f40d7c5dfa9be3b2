#ifndef TOPOTAG_TESTS_FUZZ_INPUT_H_
#define TOPOTAG_TESTS_FUZZ_INPUT_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace topotag::fuzz {

/// The bytes of an input as values, one after the other. Behind the end all bytes are 0, so that
/// every input is complete.
class Input {
 public:
  Input(const uint8_t* data, size_t size) : data_(data), size_(size) {}

  size_t left() const { return size_; }

  uint8_t Byte() {
    if (size_ == 0) return 0;
    --size_;
    return *data_++;
  }
  bool Flag() { return (Byte() & 1) != 0; }
  /// One byte where that is enough for the range, else two; at most 65,536 values.
  int Between(int low, int high) {
    const int count = high - low + 1;
    const int value = count > 256 ? Byte() << 8 | Byte() : Byte();
    return low + value % count;
  }
  /// In 65,536 steps.
  double Real(double low, double high) {
    const int value = Byte() << 8 | Byte();
    return low + (high - low) * value / 65535;
  }
  uint64_t Word() {
    uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value = value << 8 | Byte();
    return value;
  }
  /// The bytes up to the first `end`, which is dropped, or up to the end.
  std::string Until(char end) {
    const uint8_t* found = std::find(data_, data_ + size_, static_cast<uint8_t>(end));
    const std::string text(data_, found);
    const size_t used = std::min(text.size() + 1, size_);
    data_ += used;
    size_ -= used;
    return text;
  }
  std::string Rest() {
    const std::string text(data_, data_ + size_);
    data_ += size_;
    size_ = 0;
    return text;
  }

 private:
  const uint8_t* data_;
  size_t size_;
};

}  // namespace topotag::fuzz

#endif  // TOPOTAG_TESTS_FUZZ_INPUT_H_
