#include "fallback/scalar_backend.h"

#include "fallback/binarize.h"

namespace topotag::scalar {

void ScalarBackend::Threshold(const ImageView& image, const ThresholdParams& params,
                              ThresholdGrid* grid) {
  scalar::ThresholdMap(image, params, &threshold_, grid);
}

void ScalarBackend::Binarize(const ImageView& image, const ThresholdGrid& grid, BitImage* bits) {
  scalar::Binarize(image, grid, bits);
}

void ScalarBackend::Label(const BitImage& bits, Components* components) {
  scalar::Label(bits, &label_, components);
}

void ScalarBackend::Measure(const Components& components, const std::vector<uint32_t>& slot,
                            std::vector<Feature>* features) {
  scalar::Measure(components, slot, features);
}

}  // namespace topotag::scalar
