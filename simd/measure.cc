#include "simd/measure.h"

#include <algorithm>
#include <limits>

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
constexpr hn::Rebind<int16_t, decltype(kU32)> kI16;
constexpr hn::CappedTag<int64_t, 2> kSums;
constexpr hn::CappedTag<int32_t, 2> kSumsOfRun;
constexpr hn::CappedTag<int16_t, 4> kLimits;

constexpr size_t kMaxLanes = 8;

// What some neighbouring runs of one row add to their components.
struct Runs {
  HWY_ALIGN uint32_t slot[kMaxLanes];
  HWY_ALIGN int32_t length[kMaxLanes];
  HWY_ALIGN int32_t sums[2 * kMaxLanes];    // as PartialFeature::sums
  HWY_ALIGN int16_t limits[4 * kMaxLanes];  // as PartialFeature::limits
};

// A row of the widest image that is one run sums up to less than 2^31 in x and in y.
HWY_INLINE void MeasureRuns(int y, const int16_t* bound, Runs* runs) {
  const auto begin16 = hn::LoadU(kI16, bound);
  const auto last16 = hn::Sub(hn::LoadU(kI16, bound + 1), hn::Set(kI16, 1));
  const auto y16 = hn::Set(kI16, static_cast<int16_t>(y));
  hn::StoreInterleaved4(hn::Not(begin16), hn::Not(y16), last16, y16, kI16, runs->limits);
  const auto begin = hn::PromoteTo(kI32, begin16);
  const auto last = hn::PromoteTo(kI32, last16);
  const auto length = hn::Add(hn::Sub(last, begin), hn::Set(kI32, 1));
  const auto sum_x = hn::ShiftRight<1>(hn::Mul(hn::Add(begin, last), length));
  const auto sum_y = hn::Mul(hn::Set(kI32, y), length);
  hn::Store(length, kI32, runs->length);
  hn::StoreInterleaved2(sum_x, sum_y, kI32, runs->sums);
}

HWY_INLINE void AddRun(const Runs& runs, uint32_t k, PartialFeature* partial) {
  PartialFeature& feature = partial[runs.slot[k]];
  const auto sums = hn::PromoteTo(kSums, hn::LoadU(kSumsOfRun, runs.sums + 2 * k));
  const auto limits = hn::LoadU(kLimits, runs.limits + 4 * k);
  hn::Store(hn::Add(hn::Load(kSums, feature.sums), sums), kSums, feature.sums);
  hn::StoreU(hn::Max(hn::LoadU(kLimits, feature.limits), limits), kLimits, feature.limits);
  feature.area += static_cast<uint32_t>(runs.length[k]);
}

}  // namespace

// Adds the runs of some rows. Slot 0 takes in what belongs to no other one: cheaper than a branch
// for each run. What lies behind a row's end is added to it as well.
void MeasureRows(const Components& components, const uint32_t* slot, int row_begin, int row_end,
                 PartialFeature* partial) {
  const auto lanes = static_cast<uint32_t>(hn::Lanes(kU32));
  const auto first_lanes = hn::Iota(kU32, 0);
  Runs runs;
  for (int y = row_begin; y < row_end; ++y) {
    const auto row = static_cast<size_t>(y);
    const uint32_t* label = components.label.data() + components.row_begin[row];
    const int16_t* bound = components.bound.data() + components.row_begin[row];
    // The first and the last run belong to the outside, which is not measured.
    const uint32_t end = components.row_runs[row] - 1;
    if (end == 2 && slot[label[1]] == 0) continue;
    for (uint32_t run = 1; run < end; run += lanes) {
      const auto valid = hn::Lt(first_lanes, hn::Set(kU32, end - run));
      const auto own = hn::IfThenElseZero(valid, hn::LoadU(kU32, label + run));
      const auto slots = hn::GatherIndex(kU32, slot, hn::BitCast(kI32, own));
      if (hn::AllTrue(kU32, hn::Eq(slots, hn::Zero(kU32)))) continue;
      hn::Store(slots, kU32, runs.slot);
      MeasureRuns(y, bound + run, &runs);
      for (uint32_t k = 0; k < lanes; ++k) AddRun(runs, k, partial);
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

void Add(const PartialFeature& part, Feature* feature) {
  feature->sum_x += part.sums[0];
  feature->sum_y += part.sums[1];
  feature->area += part.area;
  if (part.area == 0) return;
  feature->min_x = std::min(feature->min_x, static_cast<uint16_t>(-1 - part.limits[0]));
  feature->min_y = std::min(feature->min_y, static_cast<uint16_t>(-1 - part.limits[1]));
  feature->max_x = std::max(feature->max_x, static_cast<uint16_t>(part.limits[2]));
  feature->max_y = std::max(feature->max_y, static_cast<uint16_t>(part.limits[3]));
}

}  // namespace

void Measure(const Components& components, const uint32_t* slot, size_t slots, Workers* workers,
             MeasureWorkspace* workspace, Feature* features) {
  const int tasks = std::min(workers->threads(), components.height);
  workspace->partial.Reserve(static_cast<size_t>(tasks) * slots);
  workers->For(tasks, [&](int task) {
    PartialFeature* part = workspace->partial.data() + static_cast<size_t>(task) * slots;
    constexpr int16_t kNone = std::numeric_limits<int16_t>::min();
    std::fill_n(part, slots, PartialFeature{{0, 0}, {kNone, kNone, kNone, kNone}, 0});
    HWY_DYNAMIC_DISPATCH(MeasureRows)
    (components, slot, components.height * task / tasks, components.height * (task + 1) / tasks,
     part);
  });
  std::fill_n(features, slots, Feature());
  for (size_t task = 0; task < static_cast<size_t>(tasks); ++task) {
    for (size_t s = 1; s < slots; ++s) Add(workspace->partial[task * slots + s], &features[s]);
  }
}

}  // namespace topotag::simd
#endif  // HWY_ONCE
