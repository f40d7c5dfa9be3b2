#include "fallback/scalar_backend.h"

#include "fallback/binarize.h"
#include "host/stop_watch.h"

namespace topotag::scalar {

void ScalarBackend::Binarize(const ImageView& image, const ThresholdParams& params, BitImage* bits,
                             StageTimes* times) {
  StopWatch watch;
  scalar::ThresholdMap(image, params, &threshold_, &grid_);
  times->threshold += watch.Lap();
  scalar::Binarize(image, grid_, bits);
  times->binarize += watch.Lap();
}

void ScalarBackend::Label(const BitImage& bits, Components* components) {
  scalar::Label(bits, &label_, components);
}

void ScalarBackend::Measure(const Components& components, const uint32_t* slot, size_t slots,
                            Feature* features) {
  scalar::Measure(components, slot, slots, features);
}

}  // namespace topotag::scalar
