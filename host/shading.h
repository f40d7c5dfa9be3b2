#ifndef TOPOTAG_HOST_SHADING_H_
#define TOPOTAG_HOST_SHADING_H_

#include "host/local_map.h"
#include "host/node_levels.h"
#include "host/support.h"

namespace topotag {

/// Change of the white across a marker, grey levels per unit: least-squares plane through the
/// levels of the gaps around `count` nodes.
/// @param tag  their centres, units
Point2 FitShading(const Point2* tag, const NodeLevels* levels, int count);

/// The same without what blur can explain: where perspective narrows the gaps on one side of a
/// marker, blur darkens them more, as the squares of their widths. The part of the slope that goes
/// with such darkening is left out.
/// @param maps  at the centres
Point2 FitShading(const Point2* tag, const LocalMaps& maps, const NodeLevels* levels, int count);

/// Sets the white of the supports, and how it changes around each: as over the whole marker, plus
/// what its own gaps show beyond doubt. Around a small node, what lies beyond the gaps (nodes on
/// one side, the frame on the other) blurs into them by more than the light changes.
void SetWhite(const NodeLevels* levels, int count, Point2 whole, Supports* supports);

}  // namespace topotag

#endif  // TOPOTAG_HOST_SHADING_H_
