#ifndef TOPOTAG_IMAGE_H_
#define TOPOTAG_IMAGE_H_

#include <cstddef>
#include <cstdint>
#include <memory>

namespace topotag {

/// Largest width and height that the library accepts, in pixels.
inline constexpr int kMaxImageSide = 32766;

/// A grayscale image that somebody else owns: height rows of width bytes, `stride` bytes apart.
/// Nothing outside the `width` bytes of each row is ever read.
struct ImageView {
  const uint8_t* data = nullptr;
  int width = 0;         ///< pixels, 1 .. kMaxImageSide
  int height = 0;        ///< pixels, 1 .. kMaxImageSide
  ptrdiff_t stride = 0;  ///< bytes from one row to the next, >= width

  const uint8_t* row(int y) const { return data + y * stride; }
};

/// Checks null data, sizes and stride, and that rows so far apart can lie in memory.
/// @throws Error (kInvalidArgument) that names the value.
void ValidateImage(const ImageView& image);

/// A grayscale image that owns its pixels. Move-only; rows start on 64-byte boundaries.
/// The pixels of a new image are zero.
class Image {
 public:
  Image() = default;
  /// @throws Error (kInvalidArgument) unless 1 <= width, height <= kMaxImageSide.
  Image(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  ptrdiff_t stride() const { return stride_; }
  bool empty() const { return data_ == nullptr; }
  uint8_t* row(int y) { return data_.get() + y * stride_; }
  const uint8_t* row(int y) const { return data_.get() + y * stride_; }
  ImageView view() const { return {data_.get(), width_, height_, stride_}; }

 private:
  struct AlignedDelete {
    void operator()(uint8_t* p) const;
  };
  std::unique_ptr<uint8_t[], AlignedDelete> data_;
  int width_ = 0;
  int height_ = 0;
  ptrdiff_t stride_ = 0;
};

}  // namespace topotag

#endif  // TOPOTAG_IMAGE_H_
