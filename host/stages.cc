#include "host/stages.h"

#include "fallback/binarize.h"
#include "host/canonical.h"
#include "host/detector_impl.h"

namespace topotag {
namespace {

template <typename WhiteArea>
std::vector<Rect> Boxes(const std::vector<WhiteArea>& areas) {
  std::vector<Rect> boxes;
  for (const WhiteArea& area : areas) {
    const Feature& white = area.white;
    boxes.push_back(
        {white.min_x, white.min_y, white.max_x - white.min_x + 1, white.max_y - white.min_y + 1});
  }
  return boxes;
}

}  // namespace

DetectorStages::DetectorStages(const Detector& detector) : impl_(detector.impl()) {}

Image DetectorStages::ThresholdMap() const {
  Backend* const backend = impl_.source == nullptr ? impl_.backend.get() : impl_.source->backend();
  Image map(impl_.first.bits.width, impl_.first.bits.height);
  for (int y = 0; y < map.height(); ++y) {
    scalar::ThresholdRow(backend->Grid(), y, map.width(), map.row(y));
  }
  return map;
}

Image DetectorStages::Binary() const {
  Image binary(impl_.first.bits.width, impl_.first.bits.height);
  for (int y = 0; y < binary.height(); ++y) {
    const uint64_t* bits = impl_.first.bits.row(y);
    for (int x = 0; x < binary.width(); ++x) {
      binary.row(y)[x] = (bits[x / 64] >> (x % 64) & 1) != 0 ? 255 : 0;
    }
  }
  return binary;
}

std::vector<uint32_t> DetectorStages::Labels() const {
  return CanonicalLabels(impl_.first.components);
}

std::vector<Rect> DetectorStages::Candidates() const {
  return Boxes(impl_.first.tree.candidates());
}

std::vector<Rect> DetectorStages::Doubts() const { return Boxes(impl_.first.tree.doubts()); }

}  // namespace topotag
