#ifndef TOPOTAG_TESTS_SEGMENTATION_PARITY_H_
#define TOPOTAG_TESTS_SEGMENTATION_PARITY_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fallback/scalar_backend.h"
#include "host/backend.h"
#include "host/workers.h"
#include "simd/simd_backend.h"
#include "tests/guarded.h"
#include "tests/parity.h"
#include "tests/simd_targets.h"
#include "topotag/error.h"

namespace topotag {

/// So many of SegmentationParity's subjects, a backend with its target and threads each, from one
/// on, in a circle.
struct SubjectRange {
  size_t first = 0;
  size_t count = SIZE_MAX;  ///< all, where it is larger
};

/// Runs frames through the stages of all backends: simd on every target, opencl where this build
/// and machine have it, each with every number of threads. Their workspaces stay from frame to
/// frame.
class SegmentationParity {
 public:
  explicit SegmentationParity(const std::vector<int>& thread_counts) {
    for (const int threads : thread_counts) {
      workers_.push_back(std::make_unique<Workers>(threads));
      for (const int64_t target : SimdTargets()) {
        subjects_.push_back(
            {std::make_unique<simd::SimdBackend>(workers_.back().get()), target, threads, {}, {}});
      }
      try {
        subjects_.push_back({MakeBackend(BackendKind::kOpenCl, workers_.back().get()),
                             std::nullopt,
                             threads,
                             {},
                             {}});
        has_opencl_ = true;
      } catch (const Error& error) {
        if (error.code() != ErrorCode::kUnavailable) throw;
      }
    }
  }

  bool has_opencl() const { return has_opencl_; }

  /// The first difference from the scalar backend, with the backend and its threads.
  std::string Difference(const ImageView& image, const ThresholdParams& params, Random* random,
                         const SubjectRange& which = {}) {
    StageTimes times;
    scalar_.Binarize(image, params, &bits_, &times);
    scalar_.Label(bits_, &components_);
    const CanonicalComponents canonical(components_);
    size_t slots;
    const std::vector<uint32_t> slot =
        RandomSlots(canonical.parent.size(), random->Chance(50) ? 5 : 100, random, &slots);
    std::vector<uint32_t> label_slot(components_.label_end());
    SlotsOfLabels(components_, slot, &label_slot);
    features_.resize(slots);
    scalar_.Measure(components_, label_slot.data(), slots, features_.data());
    for (size_t i = 0; i < std::min(which.count, subjects_.size()); ++i) {
      Subject& subject = subjects_[(which.first + i) % subjects_.size()];
      const std::string difference = DifferenceOf(image, params, slot, &subject);
      if (!difference.empty()) {
        return subject.name + ", " + std::to_string(subject.threads) + " threads: " + difference;
      }
    }
    return "";
  }

 private:
  struct Subject {
    std::unique_ptr<Backend> backend;
    std::optional<int64_t> target;  ///< of simd
    int threads;
    std::string name;
    Components components;
  };

  std::string DifferenceOf(const ImageView& image, const ThresholdParams& params,
                           const std::vector<uint32_t>& slot, Subject* subject) {
    std::optional<ForcedTarget> forced;
    if (subject->target) forced.emplace(*subject->target);
    Backend& backend = *subject->backend;
    subject->name = backend.name();
    const std::string expected_name =
        subject->target ? std::string("simd/") + hwy::TargetName(*subject->target) : "opencl/";
    if (subject->name.compare(0, expected_name.size(), expected_name) != 0) {
      return "runs instead of " + expected_name;
    }
    StageTimes times;
    const VectorGuard<uint64_t> guard(&other_bits_.bits, bits_.bits.size());
    backend.Binarize(image, params, &other_bits_, &times);
    std::string difference = topotag::Difference(scalar_.Grid(), backend.Grid());
    if (difference.empty()) difference = topotag::Difference(bits_, other_bits_);
    if (difference.empty() && !guard.IsIntact()) difference = "bits are written behind their end";
    if (!difference.empty()) return difference;
    backend.Label(other_bits_, &subject->components);
    difference = topotag::Difference(components_, subject->components);
    if (!difference.empty()) return difference;
    label_slot_.resize(subject->components.label_end());
    SlotsOfLabels(subject->components, slot, &label_slot_);
    other_features_.assign(features_.size(), Feature());
    backend.Measure(subject->components, label_slot_.data(), features_.size(),
                    other_features_.data());
    return topotag::Difference(features_.data(), other_features_.data(), features_.size());
  }

  std::vector<std::unique_ptr<Workers>> workers_;
  std::vector<Subject> subjects_;
  bool has_opencl_ = false;
  scalar::ScalarBackend scalar_;
  BitImage bits_, other_bits_;
  Components components_;
  std::vector<Feature> features_, other_features_;
  std::vector<uint32_t> label_slot_;
};

}  // namespace topotag

#endif  // TOPOTAG_TESTS_SEGMENTATION_PARITY_H_
