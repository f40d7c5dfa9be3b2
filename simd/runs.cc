#include "simd/runs.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "host/workers.h"
#include "topotag/image.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/runs.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace topotag::simd {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<uint64_t, 8> kU64;

// Words of the widest row, padded to vectors and one more in front.
constexpr size_t kMaxStride = (kMaxImageSide + 511) / 512 * 8 + 8;

// One band of rows, `stride` words apart, each behind a word that is zero.
struct Band {
  uint64_t* row(int y) { return bits + 8 + static_cast<size_t>(y) * stride; }
  uint64_t* change_row(int y) { return change + static_cast<size_t>(y) * stride; }

  int rows;
  size_t words;
  size_t stride;
  HWY_ALIGN uint64_t bits[kBlockRows * kMaxStride + 8];
  HWY_ALIGN uint64_t change[kBlockRows * kMaxStride];  // bits that differ from their left neighbour
  HWY_ALIGN uint64_t count[kMaxStride];                // of them in each block
};

void Copy(const BitImage& image, int first_row, Band* band) {
  band->rows = std::min(kBlockRows, image.height - first_row);
  band->words = static_cast<size_t>(image.words);
  band->stride = (band->words + 7) / 8 * 8 + 8;
  for (int y = 0; y < band->rows; ++y) {
    band->row(y)[-1] = 0;
    std::memcpy(band->row(y), image.row(first_row + y), band->words * sizeof(uint64_t));
  }
}

void FindChanges(Band* band) {
  for (size_t w = 0; w < band->words; w += hn::Lanes(kU64)) {
    auto count = hn::Zero(kU64);
    for (int y = 0; y < band->rows; ++y) {
      const uint64_t* row = band->row(y) + w;
      const auto own = hn::LoadU(kU64, row);
      const auto left = hn::ShiftRight<63>(hn::LoadU(kU64, row - 1));
      const auto change = hn::Xor(own, hn::Or(hn::Add(own, own), left));
      hn::Store(change, kU64, band->change_row(y) + w);
      count = hn::Add(count, hn::PopulationCount(change));
    }
    hn::Store(count, kU64, band->count + w);
  }
}

// Takes the blocks above the noise limit as black.
void RemoveNoise(Band* band) {
  bool found = false;
  for (size_t w = 0; w < band->words; ++w) {
    if (band->count[w] <= kMaxBlockChanges) continue;
    found = true;
    for (int y = 0; y < band->rows; ++y) band->row(y)[w] = 0;
  }
  if (found) FindChanges(band);
}

// Writes the bounds of one row; returns how many runs it has.
uint32_t EmitBounds(const uint64_t* change, size_t words, bool ends_white, int16_t* bound) {
  int16_t* out = bound;
  *out++ = -1;
  for (size_t w = 0; w < words; ++w) {
    uint64_t rest = change[w];
    if (rest == 0) continue;
    const auto base = static_cast<int16_t>(w * 64);
    const size_t count = hwy::PopCount(rest);
    // Four at a time, the last ones in vain: fewer branches to mispredict.
    for (size_t i = 0; i < count; i += 4) {
      for (size_t k = 0; k < 4; ++k) {
        const uint64_t stop = rest | uint64_t{1} << 63;
        out[i + k] =
            static_cast<int16_t>(base + static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero64(stop)));
        rest &= rest - 1;
      }
    }
    out += count;
  }
  if (ends_white) *out++ = static_cast<int16_t>(words * 64);
  for (int i = 0; i < kBoundsBehind; ++i) out[i] = Components::kOutsideBound;
  return static_cast<uint32_t>(out - bound);
}

}  // namespace

// Runs of one band, from index `begin` on.
void FindBandRuns(const BitImage& bits, int first_row, uint32_t begin, Components* components) {
  Band band;
  Copy(bits, first_row, &band);
  FindChanges(&band);
  RemoveNoise(&band);
  for (int y = 0; y < band.rows; ++y) {
    begin += kBoundsBefore;
    int16_t* bound = components->bound.data() + begin;
    std::fill_n(bound - kBoundsBefore, kBoundsBefore, int16_t{-2});
    const bool ends_white = band.row(y)[band.words - 1] >> 63 != 0;
    const uint32_t runs = EmitBounds(band.change_row(y), band.words, ends_white, bound);
    components->row_begin[static_cast<size_t>(first_row + y)] = begin;
    components->row_runs[static_cast<size_t>(first_row + y)] = runs;
    begin += runs + kBoundsBehind;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag::simd {
namespace {

HWY_EXPORT(FindBandRuns);

constexpr int kBandsPerTask = 4;
// What vectors may read or write behind a row's end.
constexpr size_t kSlack = 64;

}  // namespace

void FindRuns(const BitImage& bits, Workers* workers, Components* components) {
  components->width = bits.width;
  components->height = bits.height;
  const auto height = static_cast<size_t>(bits.height);
  const int bands = (bits.height + kBlockRows - 1) / kBlockRows;
  // The changes, one more in a row where the block to the left became black or the row ends in
  // white, and the bounds of the outside.
  const size_t region = static_cast<size_t>(bits.words) * (kMaxBlockChanges + kBlockRows) +
                        kBlockRows * (2 + kBoundsBefore + kBoundsBehind) + kSlack;
  components->row_begin.Reserve(height);
  components->row_runs.Reserve(height);
  components->bound.Reserve(static_cast<size_t>(bands) * region);
  components->label.Reserve(static_cast<size_t>(bands) * region);
  workers->For((bands + kBandsPerTask - 1) / kBandsPerTask, [&](int task) {
    const int begin = task * kBandsPerTask;
    for (int band = begin; band < std::min(begin + kBandsPerTask, bands); ++band) {
      HWY_DYNAMIC_DISPATCH(FindBandRuns)
      (bits, band * kBlockRows, static_cast<uint32_t>(static_cast<size_t>(band) * region),
       components);
    }
  });
}

}  // namespace topotag::simd
#endif  // HWY_ONCE
