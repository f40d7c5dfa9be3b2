#include "simd/label.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "host/workers.h"
#include "simd/labels.h"
#include "simd/runs.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/label.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace topotag::simd {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<int16_t, 16> kRanks;
constexpr hn::CappedTag<int32_t, 16> kIndices;
constexpr hn::RebindToUnsigned<decltype(kIndices)> kLabels;
constexpr hn::Rebind<int16_t, decltype(kIndices)> kRanksOfIndices;
constexpr size_t kMaxLanes = 16;

// Some neighbouring runs of a row, and the first and the last run above that each touches.
struct Contacts {
  HWY_ALIGN int16_t first[kMaxLanes];
  HWY_ALIGN int16_t last[kMaxLanes];
  uint32_t none;     // bit i: run i touches no run above
  uint32_t several;  // bit i: run i touches more than one
  uint32_t many;     // bit i: run i touches more than two
};

// Bytes are read as they were written: a wider load would wait for the store.
template <class M>
HWY_INLINE uint32_t Bits(M mask) {
  uint8_t bytes[8];
  hn::StoreMaskBits(kRanks, mask, bytes);
  return hn::Lanes(kRanks) <= 8 ? bytes[0] : bytes[0] | uint32_t{bytes[1]} << 8;
}

// Of the runs above between two ranks, those of the same colour count: they have the same parity.
// @param rank   of the first run, which is black
// @param count  of the runs that exist
HWY_INLINE void FindContacts(const int16_t* rank, int count, Contacts* contacts) {
  const auto exists = hn::Lt(hn::Iota(kRanks, 0), hn::Set(kRanks, static_cast<int16_t>(count)));
  const auto white = hn::And(hn::Iota(kRanks, 0), hn::Set(kRanks, 1));
  const auto black = hn::Sub(hn::Set(kRanks, 1), white);
  const auto even = hn::Set(kRanks, static_cast<int16_t>(~1));
  const auto begin = hn::LoadU(kRanks, rank);
  const auto end = hn::LoadU(kRanks, rank + 1);
  const auto first =
      hn::IfThenElseZero(exists, hn::Add(hn::And(hn::Add(begin, black), even), white));
  const auto last = hn::IfThenElseZero(exists, hn::Add(hn::And(hn::Sub(end, white), even), white));
  hn::Store(first, kRanks, contacts->first);
  hn::Store(last, kRanks, contacts->last);
  contacts->none = Bits(hn::Lt(last, first));
  contacts->several = Bits(hn::Lt(first, last));
  contacts->many = Bits(hn::Lt(hn::Add(first, hn::Set(kRanks, 2)), last));
}

#if HWY_TARGET <= HWY_AVX3

// Labels of neighbouring runs, in vectors and without a branch: Compress is an instruction here.

constexpr hn::Rebind<uint8_t, decltype(kLabels)> kBytes;
static_assert(hn::MaxLanes(kLabels) == hn::MaxLanes(kRanks), "one vector of labels");

HWY_ALIGN constexpr int32_t kLaneBefore[kMaxLanes] = {0, 0, 1, 2,  3,  4,  5,  6,
                                                      7, 8, 9, 10, 11, 12, 13, 14};

using LabelVector = hn::Vec<decltype(kLabels)>;
using LabelMask = hn::Mask<decltype(kLabels)>;

HWY_INLINE LabelMask MaskOf(uint32_t bits) {
  uint8_t bytes[8];
  std::memcpy(bytes, &bits, sizeof(bits));
  return hn::LoadMaskBits(kLabels, bytes);
}

HWY_INLINE LabelVector Gather(const uint32_t* from, const int16_t* run) {
  return hn::GatherIndex(kLabels, from, hn::PromoteTo(kIndices, hn::Load(kRanksOfIndices, run)));
}

// Gives new labels to the runs that touch none above. What is written in vain lies behind the
// labels in use: a strip has a label for every run, and the two of the outside in each row need
// none.
// @param label       of what each run touches; any where it touches none
// @param left_label  of the run before the first one
HWY_INLINE LabelVector AddNew(uint32_t none, LabelVector label, uint32_t left_label, uint32_t* next,
                              Labels* labels) {
  const auto lane = hn::Iota(kLabels, 0);
  const auto one = hn::Set(kLabels, 1);
  const auto first = hn::Set(kLabels, *next);
  const auto before = hn::Sub(hn::Shl(one, lane), one);
  const auto rank = hn::PopulationCount(hn::And(hn::Set(kLabels, none), before));
  const LabelMask is_new = MaskOf(none);
  const auto own = hn::IfThenElse(is_new, hn::Add(first, rank), label);
  const auto left =
      hn::IfThenElse(hn::FirstN(kLabels, 1), hn::Set(kLabels, left_label),
                     hn::TableLookupLanes(own, hn::SetTableIndices(kLabels, kLaneBefore)));
  const auto white = hn::Compress(hn::And(lane, one), is_new);
  hn::StoreU(hn::Add(first, lane), kLabels, labels->root(*next));
  hn::StoreU(hn::Compress(left, is_new), kLabels, labels->parent(*next));
  hn::StoreU(hn::DemoteTo(kBytes, hn::BitCast(kIndices, white)), kBytes, labels->white(*next));
  *next += static_cast<uint32_t>(hwy::PopCount(none));
  return own;
}

HWY_INLINE void LabelRuns(const Row& above, const Contacts& contacts, uint32_t* label,
                          uint32_t* next, Labels* labels, Equivalences* equivalences) {
  const LabelVector touched = Gather(above.label, contacts.first);
  const LabelVector own = AddNew(contacts.none, touched, label[-1], next, labels);
  hn::StoreU(own, kLabels, label);
  // Around a hole the first and the last label are the same.
  const LabelVector last = Gather(above.label, contacts.last);
  const LabelMask differs = hn::And(MaskOf(contacts.several), hn::Ne(own, last));
  hn::StoreU(hn::Compress(own, differs), kLabels, equivalences->a + equivalences->count);
  hn::StoreU(hn::Compress(last, differs), kLabels, equivalences->b + equivalences->count);
  equivalences->count += hn::CountTrue(kLabels, differs);
}

#else

HWY_INLINE void Gather(const uint32_t* from, const int16_t* run, uint32_t* to) {
  for (size_t k = 0; k < hn::Lanes(kRanks); k += hn::Lanes(kIndices)) {
    const auto index = hn::PromoteTo(kIndices, hn::Load(kRanksOfIndices, run + k));
    hn::StoreU(hn::GatherIndex(kLabels, from, index), kLabels, to + k);
  }
}

// Gives new labels to the runs that touch none above. Four at a time, the last ones in vain: fewer
// branches to mispredict. What is written in vain lies behind the vector, where the next one comes,
// and behind the labels in use: a strip has a label for every run, and the outside's need none.
HWY_INLINE uint32_t AddNew(uint32_t none, uint32_t* label, uint32_t next, Labels* labels) {
  const auto count = static_cast<uint32_t>(hwy::PopCount(none));
  for (uint32_t i = 0; i < count; i += 4) {
    for (uint32_t added = next + i; added < next + i + 4; ++added) {
      const size_t k = hwy::Num0BitsBelowLS1Bit_Nonzero32(none | 1u << kMaxLanes);
      label[k] = added;
      labels->Add(added, label[static_cast<ptrdiff_t>(k) - 1], (k & 1) != 0);
      none &= none - 1;
    }
  }
  return next + count;
}

HWY_INLINE void LabelRuns(const Row& above, const Contacts& contacts, uint32_t* label,
                          uint32_t* next, Labels* labels, Equivalences* equivalences) {
  Gather(above.label, contacts.first, label);
  *next = AddNew(contacts.none, label, *next, labels);
  if (contacts.several == 0) return;
  // Around a hole the first and the last label are the same.
  HWY_ALIGN uint32_t last_label[kMaxLanes];
  Gather(above.label, contacts.last, last_label);
  for (uint32_t rest = contacts.several; rest != 0; rest &= rest - 1) {
    const size_t k = hwy::Num0BitsBelowLS1Bit_Nonzero32(rest);
    if (label[k] == last_label[k]) continue;
    equivalences->a[equivalences->count] = label[k];
    equivalences->b[equivalences->count++] = last_label[k];
  }
}

#endif

// Most rows of a plain background: at most one white run, below the one of the row above.
HWY_INLINE bool IsPlain(const Row& above, const Row& row, const int16_t* rank) {
  return row.runs == above.runs &&
         (row.runs == 1 || (row.runs == 3 && rank[1] == 1 && rank[2] == 1));
}

// Labels a row below another one; returns the next free label.
uint32_t LabelRow(const Row& above, const Row& row, const int16_t* rank, uint32_t next,
                  Labels* labels, Equivalences* equivalences) {
  if (IsPlain(above, row, rank)) {
    std::copy_n(above.label, row.runs, row.label);
    return next;
  }
  const int lanes = static_cast<int>(hn::Lanes(kRanks));
  for (int begin = 0; begin < row.runs; begin += lanes) {
    Contacts contacts;
    FindContacts(rank + begin, row.runs - begin, &contacts);
    uint32_t* label = row.label + begin;
    LabelRuns(above, contacts, label, &next, labels, equivalences);
    for (uint32_t rest = contacts.many; rest != 0; rest &= rest - 1) {
      const size_t k = hwy::Num0BitsBelowLS1Bit_Nonzero32(rest);
      for (int run = contacts.first[k] + 2; run < contacts.last[k]; run += 2) {
        if (above.label[run] != label[k]) equivalences->Add(label[k], above.label[run], labels);
      }
    }
    equivalences->Unite(Equivalences::kCapacity, labels);
  }
  return next;
}

}  // namespace

// Labels the rows of a strip on their own, with labels from strip->labels.begin on.
void LabelStrip(const int16_t* rank, Components* components, Strip* strip) {
  Labels labels(components);
  Equivalences equivalences;
  uint32_t next = std::max(strip->labels.begin, 1u);
  for (int y = strip->row_begin; y < strip->row_end; ++y) {
    const Row row(components, y);
    if (y == strip->row_begin) {
      next = LabelFirstRow(row, next, &labels);
    } else {
      next = LabelRow(Row(components, y - 1), row,
                      rank + components->row_begin[static_cast<size_t>(y)], next, &labels,
                      &equivalences);
    }
  }
  equivalences.Unite(1, &labels);
  strip->labels.end = next;
}

// Lets every label of a strip, and every root's parent, point to its root. A label of another strip
// may be read here while that strip is flattened: what is final already is not written again.
void Flatten(const Strip& strip, Components* components) {
  uint32_t* root = components->root.data();
  uint32_t* parent = components->parent.data();
#if HWY_TARGET <= HWY_AVX3
  for (uint32_t begin = strip.labels.begin; begin < strip.labels.end; begin += kMaxLanes) {
    const LabelMask valid = hn::FirstN(kLabels, strip.labels.end - begin);
    auto own = hn::IfThenElseZero(valid, hn::LoadU(kLabels, root + begin));
    // Labels of vectors before are final: again only where one of this vector stands for another.
    for (;;) {
      const auto last = hn::GatherIndex(kLabels, root, hn::BitCast(kIndices, own));
      const LabelMask moves = hn::Ne(last, own);
      if (hn::AllFalse(kLabels, moves)) break;
      hn::BlendedStore(last, moves, kLabels, root + begin);
      own = last;
    }
    const auto around = hn::IfThenElseZero(valid, hn::LoadU(kLabels, parent + begin));
    hn::BlendedStore(hn::GatherIndex(kLabels, root, hn::BitCast(kIndices, around)), valid, kLabels,
                     parent + begin);
  }
#else
  for (uint32_t label = strip.labels.begin; label < strip.labels.end; ++label) {
    const uint32_t own = root[label];
    if (own == label) {
      parent[label] = root[parent[label]];
    } else if (const uint32_t last = root[own]; last != own) {
      root[label] = last;
    }
  }
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace topotag::simd
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace topotag::simd {
namespace {

HWY_EXPORT(Flatten);
HWY_EXPORT(LabelStrip);

// Below so many runs a second strip costs more than it saves.
constexpr size_t kMinRunsPerStrip = 1000;
// What vectors may write behind the last label.
constexpr size_t kLabelSlack = 16;

// One strip a thread, with about as many runs each, of whole bands: vectors of labels reach beyond
// the end of a row, but not out of its band's region. Returns a bound of all labels.
uint32_t CutStrips(const Components& components, int threads, std::vector<Strip>* strips) {
  strips->clear();
  size_t total = 0;
  for (size_t y = 0; y < static_cast<size_t>(components.height); ++y) {
    total += components.row_runs[y];
  }
  const size_t count =
      std::clamp<size_t>(total / kMinRunsPerStrip, 1, static_cast<size_t>(threads));
  Strip strip{0, 0, {0, 0}};
  size_t runs = 0;
  uint32_t labels = 1;  // 0 is the outside
  for (int y = 0; y < components.height; ++y) {
    runs += components.row_runs[static_cast<size_t>(y)];
    labels += components.row_runs[static_cast<size_t>(y)];
    const bool is_end = y + 1 == components.height ||
                        ((y + 1) % kBlockRows == 0 && runs * count >= total * (strips->size() + 1));
    if (!is_end) continue;
    strip.row_end = y + 1;
    strips->push_back(strip);
    strip = {y + 1, y + 1, {labels, labels}};
  }
  return labels;
}

// Joins the runs of the first row of a strip with those of the last row before it.
void MergeRows(const Row& above, const Row& row, Labels* labels, std::vector<uint32_t>* merged) {
  ForContacts(above, row, [&](int i, int k) {
    const uint32_t a = labels->FindRoot(row.label[i]);
    const uint32_t b = labels->FindRoot(above.label[k]);
    if (a == b) return;
    labels->Unite(a, b);
    merged->push_back(std::max(a, b));
  });
}

// Black runs of the first and the last row touch the outside.
void MergeOutside(const Row& row, Labels* labels) {
  for (int i = 0; i < row.runs; i += 2) labels->Unite(0, row.label[i]);
}

}  // namespace

void Label(const BitImage& bits, Workers* workers, LabelWorkspace* workspace,
           Components* components) {
  FindRuns(bits, workers, &workspace->runs, components);
  std::vector<Strip>& strips = workspace->strips;
  const uint32_t max_labels = CutStrips(*components, workers->threads(), &strips);
  components->root.Reserve(max_labels + kLabelSlack);
  components->parent.Reserve(max_labels + kLabelSlack);
  components->white.Reserve(max_labels + kLabelSlack);
  Labels labels(components);
  labels.Add(0, 0, false);
  const int count = static_cast<int>(strips.size());
  workers->For(count, [&](int i) {
    HWY_DYNAMIC_DISPATCH(LabelStrip)
    (workspace->runs.rank.data(), components, &strips[static_cast<size_t>(i)]);
  });

  workspace->merged.clear();
  for (const Strip& strip : strips) {
    if (strip.row_begin == 0) continue;
    MergeRows(Row(components, strip.row_begin - 1), Row(components, strip.row_begin), &labels,
              &workspace->merged);
  }
  MergeOutside(Row(components, 0), &labels);
  MergeOutside(Row(components, bits.height - 1), &labels);
  for (const uint32_t label : workspace->merged) {
    components->root[label] = labels.FindRoot(label);
  }
  workers->For(count, [&](int i) {
    HWY_DYNAMIC_DISPATCH(Flatten)(strips[static_cast<size_t>(i)], components);
  });
  components->ranges.clear();
  for (const Strip& strip : strips) components->ranges.push_back(strip.labels);
}

}  // namespace topotag::simd
#endif  // HWY_ONCE
