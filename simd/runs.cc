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
constexpr hn::Repartition<uint8_t, decltype(kU64)> kU8;

// Words of the widest row and one behind it, padded to vectors.
constexpr size_t kMaxStride = (kMaxImageSide + 63) / 64 / 8 * 8 + 8;

// Some rows of a bit image.
struct Rows {
  const uint64_t* row(int y) const { return bits + static_cast<size_t>(y) * words; }

  const uint64_t* bits;  // readable for BitImage::kPadding words before and behind
  size_t words;
  int count;
};

// The bits of a band that differ from their left neighbour, and how many in each block. A row that
// is white up to the end of its last word has one more in the word behind it.
struct Changes {
  uint64_t* row(int y) const { return bits + static_cast<size_t>(y) * stride; }

  uint64_t* bits;
  size_t stride;
  HWY_ALIGN uint64_t count[kMaxStride];
};

void FindChanges(const Rows& rows, Changes* changes) {
  for (size_t w = 0; w < changes->stride; w += hn::Lanes(kU64)) {
    // Vectors reach into the rows before and behind.
    const auto word = hn::Iota(kU64, w);
    const auto is_own = hn::Lt(word, hn::Set(kU64, rows.words));
    const auto has_left =
        hn::And(hn::Lt(hn::Zero(kU64), word), hn::Lt(word, hn::Set(kU64, rows.words + 1)));
    auto count = hn::Zero(kU8);  // at most 8 * kBlockRows
    for (int y = 0; y < rows.count; ++y) {
      const uint64_t* row = rows.row(y) + w;
      const auto own = hn::IfThenElseZero(is_own, hn::LoadU(kU64, row));
      const auto left = hn::IfThenElseZero(has_left, hn::ShiftRight<63>(hn::LoadU(kU64, row - 1)));
      const auto change = hn::Xor(own, hn::Or(hn::Add(own, own), left));
      hn::Store(change, kU64, changes->row(y) + w);
      count = hn::Add(count, hn::PopulationCount(hn::BitCast(kU8, change)));
    }
    hn::Store(hn::SumsOf8(count), kU64, changes->count + w);
  }
}

// Takes the blocks above the noise limit as black.
void RemoveNoise(const Rows& rows, Changes* changes) {
  const auto is_noise = [](uint64_t count) { return count > kMaxBlockChanges; };
  if (std::none_of(changes->count, changes->count + rows.words, is_noise)) return;
  HWY_ALIGN uint64_t copy[kBlockRows * kMaxStride + 2 * BitImage::kPadding];
  uint64_t* bits = copy + BitImage::kPadding;
  std::copy_n(rows.bits, static_cast<size_t>(rows.count) * rows.words, bits);
  for (size_t w = 0; w < rows.words; ++w) {
    if (!is_noise(changes->count[w])) continue;
    for (int y = 0; y < rows.count; ++y) bits[static_cast<size_t>(y) * rows.words + w] = 0;
  }
  FindChanges({bits, rows.words, rows.count}, changes);
}

// Where the bounds of a row are written to.
struct Output {
  int16_t* bound;
  int16_t* rank;
  size_t count;       // of bounds
  size_t runs_above;  // that begin left of here in the row above, but for the first one
};

#if HWY_TARGET <= HWY_AVX3_DL

// Bounds and ranks of all pixels of a word, of which Compress, an instruction here, takes those
// that are bounds.

constexpr hn::CappedTag<uint8_t, 64> kPixels;
constexpr hn::CappedTag<uint16_t, 32> kBounds;
constexpr hn::Repartition<uint32_t, decltype(kBounds)> kPairs;
constexpr hn::RebindToSigned<decltype(kBounds)> kStored;

// Which pixel a lane holds, so that interleaving brings the pixels into order; its byte, the bits
// of that up to its own, and its own.
struct PixelOfLane {
  constexpr PixelOfLane() {
    for (size_t i = 0; i < 64; ++i) {
      pixel[i] = static_cast<uint8_t>(i / 16 * 8 + i % 8 + (i % 16 < 8 ? 0 : 32));
      byte[i] = static_cast<uint8_t>(pixel[i] / 8);
      up_to[i] = static_cast<uint8_t>((2 << pixel[i] % 8) - 1);
      own[i] = static_cast<uint8_t>(1 << pixel[i] % 8);
    }
  }
  alignas(64) uint8_t pixel[64]{}, byte[64]{}, up_to[64]{}, own[64]{};
};
constexpr PixelOfLane kLane;

// In each byte, how many bits are set in the bytes below it.
HWY_INLINE uint64_t BitsInLowerBytes(uint64_t word) {
  word -= word >> 1 & 0x5555555555555555;
  word = (word & 0x3333333333333333) + (word >> 2 & 0x3333333333333333);
  word = (word + (word >> 4)) & 0x0f0f0f0f0f0f0f0f;
  return word * 0x0101010101010100;
}

// For each pixel, how many bits of `above` are set up to it, times two, plus its own.
HWY_INLINE hn::Vec<decltype(kPixels)> RankPixels(uint64_t above) {
  const auto byte = hn::Load(kPixels, kLane.byte);
  const auto bits = hn::TableLookupBytes(hn::BitCast(kPixels, hn::Set(kU64, above)), byte);
  const auto lower =
      hn::TableLookupBytes(hn::BitCast(kPixels, hn::Set(kU64, BitsInLowerBytes(above))), byte);
  const auto up_to = hn::And(bits, hn::Load(kPixels, kLane.up_to));
  const auto rank = hn::Add(lower, hn::PopulationCount(up_to));
  const auto own = hn::IfThenElseZero(hn::TestBit(bits, hn::Load(kPixels, kLane.own)),
                                      hn::Set(kPixels, uint8_t{1}));
  return hn::Add(hn::Add(rank, rank), own);
}

// Appends the bounds among 32 pixels.
// @param pixels  high byte: the pixel in its word; low byte: what RankPixels says of it
HWY_INLINE void EmitHalf(hn::Vec<decltype(kBounds)> pixels, uint32_t change, size_t word,
                         Output* out) {
  uint8_t bytes[8];
  std::memcpy(bytes, &change, sizeof(change));
  const auto found = hn::Compress(pixels, hn::LoadMaskBits(kBounds, bytes));
  const auto x =
      hn::Add(hn::Set(kBounds, static_cast<uint16_t>(word * 64)), hn::ShiftRight<8>(found));
  // The rank of an even bound, where a black run begins, leaves out the bound's own pixel.
  const auto leave_out =
      hn::BitCast(kBounds, hn::Set(kPairs, out->count % 2 == 0 ? 1u : uint32_t{1} << 16));
  const auto rank = hn::Sub(hn::ShiftRight<1>(hn::And(found, hn::Set(kBounds, uint16_t{0xff}))),
                            hn::And(found, leave_out));
  const auto runs_above = hn::Set(kBounds, static_cast<uint16_t>(out->runs_above));
  hn::StoreU(hn::BitCast(kStored, x), kStored, out->bound + out->count);
  hn::StoreU(hn::BitCast(kStored, hn::Add(runs_above, rank)), kStored, out->rank + out->count);
  out->count += hwy::PopCount(uint64_t{change});
}

// Appends the bounds in one word and their ranks.
HWY_INLINE void EmitWord(uint64_t change, uint64_t above, size_t word, Output* out) {
  const auto rank = RankPixels(above);
  const auto pixel = hn::Load(kPixels, kLane.pixel);
  EmitHalf(hn::BitCast(kBounds, hn::InterleaveLower(kPixels, rank, pixel)),
           static_cast<uint32_t>(change), word, out);
  if (change >> 32 != 0) {
    EmitHalf(hn::BitCast(kBounds, hn::InterleaveUpper(kPixels, rank, pixel)),
             static_cast<uint32_t>(change >> 32), word, out);
  }
  out->runs_above += hwy::PopCount(above);
}

#else

// Appends the bounds in one word and their ranks. Four at a time, the last ones in vain: fewer
// branches to mispredict.
HWY_INLINE void EmitWord(uint64_t change, uint64_t above, size_t word, Output* out) {
  const auto before = static_cast<int>(word * 64) - 1;
  const size_t end = out->count + hwy::PopCount(change);
  // The rank of an even bound, where a black run begins, leaves out the bound's own pixel.
  const size_t leave_out[2] = {~out->count & 1, out->count & 1};
  for (size_t begin = out->count; begin < end; begin += 4) {
    for (size_t i = 0; i < 4; ++i) {
      const uint64_t up_to_bit = change ^ (change - 1);
      const uint64_t bounds_above = above & (up_to_bit >> leave_out[i % 2]);
      out->bound[begin + i] =
          static_cast<int16_t>(before + static_cast<int>(hwy::PopCount(up_to_bit)));
      out->rank[begin + i] = static_cast<int16_t>(out->runs_above + hwy::PopCount(bounds_above));
      change &= change - 1;
    }
  }
  out->count = end;
  out->runs_above += hwy::PopCount(above);
}

#endif

// Writes the bounds of one row and their ranks among those of the row above; returns how many runs
// it has. Rows are padded to vectors.
uint32_t EmitBounds(const uint64_t* change, const uint64_t* above, size_t words, int16_t* bound,
                    int16_t* rank) {
  bound[0] = -1;
  rank[0] = 0;
  Output out{bound, rank, 1, 0};
  for (size_t begin = 0; begin < words; begin += hn::Lanes(kU64)) {
    const auto any = hn::Or(hn::Load(kU64, change + begin), hn::Load(kU64, above + begin));
    if (hn::AllTrue(kU64, hn::Eq(any, hn::Zero(kU64)))) continue;
    const size_t end = std::min(begin + hn::Lanes(kU64), words);
    for (size_t w = begin; w < end; ++w) {
      if ((change[w] | above[w]) != 0) EmitWord(change[w], above[w], w, &out);
    }
  }
  rank[out.count] = static_cast<int16_t>(out.runs_above);
  bound[out.count] = Components::kOutsideBound;
  return static_cast<uint32_t>(out.count);
}

bool AreEqual(const uint64_t* a, const uint64_t* b, size_t words) {
  for (size_t w = 0; w < words; w += hn::Lanes(kU64)) {
    if (!hn::AllTrue(kU64, hn::Eq(hn::Load(kU64, a + w), hn::Load(kU64, b + w)))) return false;
  }
  return true;
}

// The same for a row that equals the one above, which has `runs` runs.
uint32_t CopyBounds(const int16_t* above, uint32_t runs, int16_t* bound, int16_t* rank) {
  std::copy_n(above, runs + 1, bound);
  rank[0] = 0;
  for (uint32_t k = 1; k < runs; ++k) rank[k] = static_cast<int16_t>(k - (~k & 1));
  rank[runs] = static_cast<int16_t>(runs - 1);
  return runs;
}

}  // namespace

void FindBandChanges(const BitImage& bits, int first_row, uint64_t* first_change, size_t stride) {
  const Rows rows{bits.row(first_row), static_cast<size_t>(bits.words),
                  std::min(kBlockRows, bits.height - first_row)};
  Changes changes;
  changes.bits = first_change;
  changes.stride = stride;
  FindChanges(rows, &changes);
  RemoveNoise(rows, &changes);
}

// Runs of one band, from index `begin` on.
void FindBandRuns(const uint64_t* changes, size_t stride, int first_row, uint32_t begin,
                  Components* components, int16_t* rank) {
  const auto words = static_cast<size_t>((components->width + 63) / 64) + 1;
  const int16_t* bound_above = nullptr;
  uint32_t runs = 0;
  for (int y = first_row; y < std::min(first_row + kBlockRows, components->height); ++y) {
    int16_t* bound = components->bound.data() + begin;
    const uint64_t* row = changes + static_cast<size_t>(y) * stride;
    const uint64_t* above = y == 0 ? row : row - stride;
    runs = bound_above != nullptr && AreEqual(row, above, words)
               ? CopyBounds(bound_above, runs, bound, rank + begin)
               : EmitBounds(row, above, words, bound, rank + begin);
    components->row_begin[static_cast<size_t>(y)] = begin;
    components->row_runs[static_cast<size_t>(y)] = runs;
    begin += runs + 1;
    bound_above = bound;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag::simd {
namespace {

HWY_EXPORT(FindBandChanges);
HWY_EXPORT(FindBandRuns);

constexpr int kBandsPerTask = 2;
// What vectors may read before a row's first label, where a run touches none above.
constexpr size_t kBefore = 1;
// What vectors may read or write behind a row's end.
constexpr size_t kSlack = 64;

template <typename Task>
void ForBands(int bands, Workers* workers, const Task& task) {
  workers->For((bands + kBandsPerTask - 1) / kBandsPerTask, [&](int part) {
    const int begin = part * kBandsPerTask;
    for (int band = begin; band < std::min(begin + kBandsPerTask, bands); ++band) task(band);
  });
}

}  // namespace

void FindRuns(const BitImage& bits, Workers* workers, RunsWorkspace* workspace,
              Components* components) {
  components->width = bits.width;
  components->height = bits.height;
  const auto height = static_cast<size_t>(bits.height);
  const int bands = (bits.height + kBlockRows - 1) / kBlockRows;
  // The changes, one more in a row where the block to the left became black or the row ends in
  // white, and the bounds of the outside.
  const size_t region =
      static_cast<size_t>(bits.words) * (kMaxBlockChanges + kBlockRows) + 3 * kBlockRows + kSlack;
  const size_t stride = static_cast<size_t>(bits.words) / 8 * 8 + 8;
  components->row_begin.Reserve(height);
  components->row_runs.Reserve(height);
  components->bound.Reserve(static_cast<size_t>(bands) * region);
  components->label.Reserve(static_cast<size_t>(bands) * region);
  workspace->rank.Reserve(static_cast<size_t>(bands) * region);
  workspace->changes.Reserve(height * stride);
  uint64_t* changes = workspace->changes.data();
  ForBands(bands, workers, [&](int band) {
    HWY_DYNAMIC_DISPATCH(FindBandChanges)
    (bits, band * kBlockRows, changes + static_cast<size_t>(band * kBlockRows) * stride, stride);
  });
  ForBands(bands, workers, [&](int band) {
    HWY_DYNAMIC_DISPATCH(FindBandRuns)
    (changes, stride, band * kBlockRows,
     static_cast<uint32_t>(static_cast<size_t>(band) * region + kBefore), components,
     workspace->rank.data());
  });
}

}  // namespace topotag::simd
#endif  // HWY_ONCE
