#ifndef TOPOTAG_HOST_REPORT_ORDER_H_
#define TOPOTAG_HOST_REPORT_ORDER_H_

#include <cstdint>
#include <tuple>

#include "topotag/family.h"
#include "topotag/geometry.h"

namespace topotag {

/// What detections are sorted by, as Detector::detect states.
inline auto ReportKey(Family family, uint64_t id, const Point2& center, bool inverted) {
  return std::make_tuple(family.n(), id, center.y, center.x, inverted);
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_REPORT_ORDER_H_
