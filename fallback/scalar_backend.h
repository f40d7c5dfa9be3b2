#ifndef TOPOTAG_FALLBACK_SCALAR_BACKEND_H_
#define TOPOTAG_FALLBACK_SCALAR_BACKEND_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "fallback/label.h"
#include "fallback/threshold.h"
#include "host/backend.h"

namespace topotag::scalar {

/// The specification of every stage, in plain C++.
class ScalarBackend : public Backend {
 public:
  std::string name() const override { return "scalar"; }
  void Binarize(const ImageView& image, const ThresholdParams& params, BitImage* bits,
                StageTimes* times) override;
  const ThresholdGrid& Grid() override { return grid_; }
  void Label(const BitImage& bits, Components* components) override;
  void Measure(const Components& components, const uint32_t* slot, size_t slots,
               Feature* features) override;

 private:
  ThresholdWorkspace threshold_;
  ThresholdGrid grid_;
  LabelWorkspace label_;
};

}  // namespace topotag::scalar

#endif  // TOPOTAG_FALLBACK_SCALAR_BACKEND_H_
