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
using Vector = hn::Vec<decltype(kI32)>;
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
HWY_INLINE void MeasureRuns(Vector slot, Vector begin, Vector end, Vector y, Runs* runs) {
  const auto last = hn::Sub(end, hn::Set(kI32, 1));
  const auto y16 = hn::DemoteTo(kI16, y);
  hn::StoreInterleaved4(hn::Not(hn::DemoteTo(kI16, begin)), hn::Not(y16), hn::DemoteTo(kI16, last),
                        y16, kI16, runs->limits);
  const auto length = hn::Sub(end, begin);
  const auto sum_x = hn::ShiftRight<1>(hn::Mul(hn::Add(begin, last), length));
  const auto sum_y = hn::Mul(y, length);
  hn::Store(hn::BitCast(kU32, slot), kU32, runs->slot);
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

HWY_INLINE void AddRuns(Vector slot, Vector begin, Vector end, Vector y, PartialFeature* partial) {
  Runs runs;
  MeasureRuns(slot, begin, end, y, &runs);
  for (uint32_t k = 0; k < hn::Lanes(kI32); ++k) AddRun(runs, k, partial);
}

#if HWY_TARGET <= HWY_AVX3

// Collects the runs that count from all rows, with Compress, an instruction here, before it adds
// them: so no vector has others in it, and no loop's end depends on the image.
class Adder {
 public:
  static constexpr hn::CappedTag<uint32_t, 16> kRuns{};

  explicit Adder(PartialFeature* partial) : partial_(partial) {}

  template <class V>
  HWY_INLINE void Add(V slot, const int16_t* bound, int y) {
    const auto begin = hn::PromoteTo(kRuns, hn::LoadU(kBounds, Unsigned(bound)));
    const auto end = hn::PromoteTo(kRuns, hn::LoadU(kBounds, Unsigned(bound + 1)));
    const auto counts = hn::Ne(slot, hn::Zero(kRuns));
    hn::StoreU(hn::Compress(slot, counts), kRuns, slot_ + count_);
    hn::StoreU(hn::Compress(hn::Or(begin, hn::ShiftLeft<16>(end)), counts), kRuns, range_ + count_);
    hn::StoreU(hn::Set(kRuns, static_cast<uint32_t>(y)), kRuns, y_ + count_);
    count_ += hn::CountTrue(kRuns, counts);
    if (count_ >= kCapacity) Flush();
  }
  HWY_INLINE void Finish() {
    for (uint32_t* values : {slot_, range_, y_}) std::fill_n(values + count_, kMaxLanes, 0);
    count_ += kMaxLanes - 1;
    Flush();
  }

 private:
  static constexpr hn::Rebind<uint16_t, decltype(kRuns)> kBounds{};
  static constexpr size_t kCapacity = 256;

  // Bounds of runs that count are not negative.
  static const uint16_t* Unsigned(const int16_t* bound) {
    return reinterpret_cast<const uint16_t*>(bound);
  }

  // Adds whole vectors; the rest stays.
  HWY_NOINLINE void Flush() {
    size_t i = 0;
    for (; i + hn::Lanes(kI32) <= count_; i += hn::Lanes(kI32)) {
      const auto load = [i](const uint32_t* values)
                            HWY_ATTR { return hn::BitCast(kI32, hn::Load(kU32, values + i)); };
      const auto range = load(range_);
      AddRuns(load(slot_), hn::And(range, hn::Set(kI32, 0xffff)), hn::ShiftRight<16>(range),
              load(y_), partial_);
    }
    for (uint32_t* values : {slot_, range_, y_}) std::copy(values + i, values + count_, values);
    count_ -= i;
  }

  PartialFeature* partial_;
  size_t count_ = 0;
  HWY_ALIGN uint32_t slot_[kCapacity + 2 * 16];
  HWY_ALIGN uint32_t range_[kCapacity + 2 * 16];  // begin and, in the upper half, end
  HWY_ALIGN uint32_t y_[kCapacity + 2 * 16];
};

#else

class Adder {
 public:
  static constexpr decltype(kU32) kRuns{};

  explicit Adder(PartialFeature* partial) : partial_(partial) {}

  template <class V>
  HWY_INLINE void Add(V slot, const int16_t* bound, int y) {
    if (hn::AllTrue(kRuns, hn::Eq(slot, hn::Zero(kRuns)))) return;
    AddRuns(hn::BitCast(kI32, slot), hn::PromoteTo(kI32, hn::LoadU(kI16, bound)),
            hn::PromoteTo(kI32, hn::LoadU(kI16, bound + 1)), hn::Set(kI32, y), partial_);
  }
  void Finish() {}

 private:
  PartialFeature* partial_;
};

#endif

}  // namespace

// Adds the runs of some rows. Slot 0 takes in what belongs to no other one: cheaper than a branch
// for each run. What lies behind a row's end is added to it as well.
void MeasureRows(const Components& components, const uint32_t* slot, int row_begin, int row_end,
                 PartialFeature* partial) {
  constexpr auto kRuns = Adder::kRuns;
  constexpr hn::RebindToSigned<decltype(Adder::kRuns)> kIndices;
  const auto lanes = static_cast<uint32_t>(hn::Lanes(kRuns));
  Adder adder(partial);
  for (int y = row_begin; y < row_end; ++y) {
    const auto row = static_cast<size_t>(y);
    const uint32_t* label = components.label.data() + components.row_begin[row];
    const int16_t* bound = components.bound.data() + components.row_begin[row];
    // The first and the last run belong to the outside, which is not measured.
    const uint32_t end = components.row_runs[row] - 1;
    if (end == 2 && slot[label[1]] == 0) continue;
    for (uint32_t run = 1; run < end; run += lanes) {
      const auto valid = hn::FirstN(kRuns, end - run);
      const auto own = hn::IfThenElseZero(valid, hn::LoadU(kRuns, label + run));
      adder.Add(hn::GatherIndex(kRuns, slot, hn::BitCast(kIndices, own)), bound + run, y);
    }
  }
  adder.Finish();
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
