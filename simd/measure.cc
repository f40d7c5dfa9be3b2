#include "simd/measure.h"

#include <algorithm>

#include "host/workers.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/measure.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace topotag::simd {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<uint32_t, 8> kU32;
constexpr hn::RebindToSigned<decltype(kU32)> kI32;

HWY_INLINE void AddRun(int y, int begin, int end, Feature* feature) {
  const int length = end - begin;
  feature->area += static_cast<uint32_t>(length);
  feature->sum_x += (static_cast<int64_t>(begin + end - 1) * length) >> 1;
  feature->sum_y += static_cast<int64_t>(y) * length;
  feature->min_x = std::min(feature->min_x, static_cast<uint16_t>(begin));
  feature->max_x = std::max(feature->max_x, static_cast<uint16_t>(end - 1));
  feature->min_y = std::min(feature->min_y, static_cast<uint16_t>(y));
  feature->max_y = static_cast<uint16_t>(y);
}

}  // namespace

// Adds the runs of some rows. Feature 0 takes in what belongs to no slot beside others that do:
// cheaper than a branch for each run.
void MeasureRows(const Components& components, const uint32_t* slot, int row_begin, int row_end,
                 Feature* features) {
  const auto lanes = static_cast<uint32_t>(hn::Lanes(kU32));
  HWY_ALIGN uint32_t run_slot[HWY_MAX_BYTES / sizeof(uint32_t)];
  for (int y = row_begin; y < row_end; ++y) {
    const auto row = static_cast<size_t>(y);
    const uint32_t* label = components.label.data() + components.row_begin[row];
    const int16_t* bound = components.bound.data() + components.row_begin[row];
    // The first and the last run belong to the outside, which is not measured.
    const uint32_t end = components.row_runs[row] - 1;
    uint32_t run = 1;
    for (; run + lanes <= end; run += lanes) {
      const auto index = hn::BitCast(kI32, hn::LoadU(kU32, label + run));
      const auto slots = hn::GatherIndex(kU32, slot, index);
      if (hn::AllTrue(kU32, hn::Eq(slots, hn::Zero(kU32)))) continue;
      hn::Store(slots, kU32, run_slot);
      for (uint32_t k = 0; k < lanes; ++k) {
        AddRun(y, bound[run + k], bound[run + k + 1], features + run_slot[k]);
      }
    }
    for (; run < end; ++run) {
      if (const uint32_t s = slot[label[run]]; s != 0) {
        AddRun(y, bound[run], bound[run + 1], features + s);
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag::simd {
namespace {

HWY_EXPORT(MeasureRows);

void Add(const Feature& part, Feature* feature) {
  feature->area += part.area;
  feature->sum_x += part.sum_x;
  feature->sum_y += part.sum_y;
  feature->min_x = std::min(feature->min_x, part.min_x);
  feature->max_x = std::max(feature->max_x, part.max_x);
  feature->min_y = std::min(feature->min_y, part.min_y);
  feature->max_y = std::max(feature->max_y, part.max_y);
}

}  // namespace

void Measure(const Components& components, const uint32_t* slot, size_t slots, Workers* workers,
             MeasureWorkspace* workspace, Feature* features) {
  const int tasks = std::min(2 * workers->threads() - 1, components.height);
  workspace->partial.Reserve(static_cast<size_t>(tasks) * slots);
  workers->For(tasks, [&](int task) {
    Feature* part = workspace->partial.data() + static_cast<size_t>(task) * slots;
    std::fill_n(part, slots, Feature());
    HWY_DYNAMIC_DISPATCH(MeasureRows)
    (components, slot, components.height * task / tasks, components.height * (task + 1) / tasks,
     part);
  });
  std::copy_n(workspace->partial.data(), slots, features);
  for (size_t task = 1; task < static_cast<size_t>(tasks); ++task) {
    for (size_t s = 1; s < slots; ++s) Add(workspace->partial[task * slots + s], &features[s]);
  }
  features[0] = Feature();
}

}  // namespace topotag::simd
#endif  // HWY_ONCE
