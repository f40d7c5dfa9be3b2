#ifndef TOPOTAG_FALLBACK_SCALAR_BACKEND_H_
#define TOPOTAG_FALLBACK_SCALAR_BACKEND_H_

#include <string>
#include <vector>

#include "fallback/label.h"
#include "fallback/threshold.h"
#include "host/backend.h"

namespace topotag::scalar {

/// The specification of every stage, in plain C++.
class ScalarBackend : public Backend {
 public:
  std::string name() const override { return "scalar"; }
  void Threshold(const ImageView& image, const ThresholdParams& params,
                 ThresholdGrid* grid) override;
  void Binarize(const ImageView& image, const ThresholdGrid& grid, BitImage* bits) override;
  void Label(const BitImage& bits, Components* components) override;
  void Measure(const Components& components, const std::vector<uint32_t>& slot,
               std::vector<Feature>* features) override;

 private:
  ThresholdWorkspace threshold_;
  LabelWorkspace label_;
};

}  // namespace topotag::scalar

#endif  // TOPOTAG_FALLBACK_SCALAR_BACKEND_H_
