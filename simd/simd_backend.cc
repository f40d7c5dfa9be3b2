#include "simd/simd_backend.h"

#include "host/stop_watch.h"
#include "simd/binarize.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/simd_backend.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace topotag::simd {
namespace HWY_NAMESPACE {

const char* Target() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace topotag::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag::simd {

HWY_EXPORT(Target);

std::string TargetName() { return HWY_DYNAMIC_DISPATCH(Target)(); }

void SimdBackend::Binarize(const ImageView& image, const ThresholdParams& params, BitImage* bits,
                           StageTimes* times) {
  StopWatch watch;
  simd::ThresholdMap(image, params, workers_, &threshold_, &grid_);
  times->threshold += watch.Lap();
  simd::Binarize(image, grid_, workers_, bits);
  times->binarize += watch.Lap();
}

void SimdBackend::Label(const BitImage& bits, Components* components) {
  simd::Label(bits, workers_, &label_, components);
}

void SimdBackend::Measure(const Components& components, const uint32_t* slot, size_t slots,
                          Feature* features) {
  simd::Measure(components, slot, slots, workers_, &measure_, features);
}

}  // namespace topotag::simd
#endif  // HWY_ONCE
