#ifndef TOPOTAG_HOST_SEARCH_PLAN_H_
#define TOPOTAG_HOST_SEARCH_PLAN_H_

#include <vector>

#include "host/track_list.h"
#include "topotag/detection.h"

namespace topotag {

/// The regions in which markers are expected, apart from each other. Seen from the first pixel of
/// the area, each begins with a word of bits and a row of tiles: so it has the tiles, and the
/// blocks of the noise limit, that the whole area has there.
/// @param area  all that may be searched
/// @return false, and no regions, where searching all of the area at once is needed, because some
///         marker is expected outside, or is no slower
bool PlanRegions(const std::vector<Track>& tracks, const Rect& area, std::vector<Rect>* regions);

/// Whether nothing that a region leaves out had a part in a detection: where it is at least a tile
/// away from the region's border, unless that is the area's border too.
bool IsInside(const Detection& detection, const Rect& region, const Rect& area);

}  // namespace topotag

#endif  // TOPOTAG_HOST_SEARCH_PLAN_H_
