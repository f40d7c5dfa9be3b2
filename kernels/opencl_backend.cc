#include "kernels/opencl_backend.h"

#include <algorithm>
#include <utility>

#include "fallback/binarize.h"
#include "fallback/threshold.h"
#include "host/stop_watch.h"
#include "topotag/error.h"

namespace topotag::opencl {
namespace {

// A frame with steep and with flat parts, dark tiles and bright words, whose right and lower
// borders cut words, tiles and blocks.
Image TestFrame() {
  Image image(149, 83);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const int texture = (x * 29 + y * 53 + x * y) % 97;
      const int flat = (x < 60 ? 40 : 160) + x / 2 + (x + y) % 3;
      const bool is_flat = x / 40 % 2 == 0 || y / 32 == 1;
      image.row(y)[x] = static_cast<uint8_t>(is_flat ? flat : 3 * texture % 256);
    }
  }
  return image;
}

// Drivers have compiled the kernels wrongly before: better no device than other detections.
void RequireSameResult(Binarizer* binarizer, Preset preset) {
  const Image image = TestFrame();
  ThresholdParams params;
  params.preset = preset;
  scalar::ThresholdWorkspace workspace;
  ThresholdGrid expected_grid, grid;
  BitImage expected_bits, bits;
  scalar::ThresholdMap(image.view(), params, &workspace, &expected_grid);
  scalar::Binarize(image.view(), expected_grid, &expected_bits);
  binarizer->Submit(image.view(), params);
  binarizer->Collect(&bits);
  binarizer->ReadGrid(&grid);
  const char* stage = nullptr;
  if (grid.value != expected_grid.value || grid.floor != expected_grid.floor ||
      grid.ceiling != expected_grid.ceiling) {
    stage = "threshold map";
  } else if (bits.bits != expected_bits.bits) {
    stage = "bit image";
  }
  if (stage == nullptr) return;
  const DeviceInfo& info = binarizer->device().info;
  throw Error(ErrorCode::kDevice,
              "OpenCL: " + info.name + " (" + info.platform + ", driver " + info.driver +
                  ") computes another " + stage + " than the scalar backend, preset " +
                  (preset == Preset::kPaper ? "paper" : "default") + "; it cannot be used");
}

}  // namespace

OpenClBackend::OpenClBackend(const Device& device, cl_context context,
                             std::unique_ptr<Backend> others)
    : binarizer_(device, context, Binarizer::DefaultTransfer(device)), others_(std::move(others)) {
  RequireSameResult(&binarizer_, Preset::kDefault);
  RequireSameResult(&binarizer_, Preset::kPaper);
}

void OpenClBackend::Submit(const ImageView& image, const ThresholdParams& params) {
  binarizer_.Submit(image, params);
}

void OpenClBackend::KeepSubmitted(size_t count) {
  while (static_cast<size_t>(binarizer_.submitted()) > count) binarizer_.Drop();
}

void OpenClBackend::Binarize(const ImageView& image, const ThresholdParams& params, BitImage* bits,
                             StageTimes* times) {
  StopWatch watch;
  grid_is_read_ = false;
  if (binarizer_.submitted() == 0) binarizer_.Submit(image, params);
  binarizer_.Collect(bits);
  const double device_time = binarizer_.ThresholdTime();
  const double total = watch.Lap();
  times->threshold += std::min(device_time, total);
  times->binarize += total - std::min(device_time, total);
}

const ThresholdGrid& OpenClBackend::Grid() {
  if (!grid_is_read_) binarizer_.ReadGrid(&grid_);
  grid_is_read_ = true;
  return grid_;
}

void OpenClBackend::Label(const BitImage& bits, Components* components) {
  others_->Label(bits, components);
}

void OpenClBackend::Measure(const Components& components, const uint32_t* slot, size_t slots,
                            Feature* features) {
  others_->Measure(components, slot, slots, features);
}

}  // namespace topotag::opencl
