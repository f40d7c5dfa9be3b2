#ifndef TOPOTAG_SIMD_SIMD_BACKEND_H_
#define TOPOTAG_SIMD_SIMD_BACKEND_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "host/backend.h"
#include "simd/label.h"
#include "simd/measure.h"
#include "simd/threshold.h"

namespace topotag::simd {

/// The Highway target that runs: "AVX2", "NEON", ...
std::string TargetName();

/// All stages in Highway, dispatched at run time, on the threads of the workers.
class SimdBackend : public Backend {
 public:
  explicit SimdBackend(Workers* workers) : workers_(workers) {}

  std::string name() const override { return "simd/" + TargetName(); }
  void Binarize(const ImageView& image, const ThresholdParams& params, BitImage* bits,
                StageTimes* times) override;
  const ThresholdGrid& Grid() override { return grid_; }
  void Label(const BitImage& bits, Components* components) override;
  void Measure(const Components& components, const uint32_t* slot, size_t slots,
               Feature* features) override;

 private:
  Workers* workers_;
  ThresholdGrid grid_;
  ThresholdWorkspace threshold_;
  LabelWorkspace label_;
  MeasureWorkspace measure_;
};

}  // namespace topotag::simd

#endif  // TOPOTAG_SIMD_SIMD_BACKEND_H_
