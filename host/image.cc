#include "topotag/image.h"

#include <cstdint>
#include <cstring>
#include <new>
#include <string>

#include "host/check.h"

namespace topotag {
namespace {

constexpr size_t kRowAlignment = 64;

void ValidateSize(int width, int height) {
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide) {
    FailArgument("image size " + Text(width, height) + " is not within 1x1 .. " +
                 Text(kMaxImageSide, kMaxImageSide));
  }
}

}  // namespace

void ValidateImage(const ImageView& image) {
  if (image.data == nullptr) FailArgument("image data is null");
  ValidateSize(image.width, image.height);
  if (image.stride < image.width) {
    FailArgument("image stride " + std::to_string(image.stride) + " is less than its width " +
                 std::to_string(image.width));
  }
  if (image.stride > (PTRDIFF_MAX - image.width) / image.height) {
    FailArgument("image stride " + std::to_string(image.stride) + " is too large for " +
                 std::to_string(image.height) + " rows");
  }
}

Image::Image(int width, int height) : width_(width), height_(height) {
  ValidateSize(width, height);
  stride_ = static_cast<ptrdiff_t>((static_cast<size_t>(width) + kRowAlignment - 1) /
                                   kRowAlignment * kRowAlignment);
  const size_t bytes = static_cast<size_t>(stride_) * static_cast<size_t>(height);
  data_.reset(static_cast<uint8_t*>(::operator new[](bytes, std::align_val_t(kRowAlignment))));
  std::memset(data_.get(), 0, bytes);
}

void Image::AlignedDelete::operator()(uint8_t* p) const {
  ::operator delete[](p, std::align_val_t(kRowAlignment));
}

}  // namespace topotag
