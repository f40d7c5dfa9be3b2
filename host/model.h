#ifndef TOPOTAG_HOST_MODEL_H_
#define TOPOTAG_HOST_MODEL_H_

#include "topotag/family.h"
#include "topotag/geometry.h"

namespace topotag {

/// The vertex_count() model vertices of a family, then the centre of its baseline node, units;
/// lives as long as the program.
const Point2* ModelTable(Family family);

}  // namespace topotag

#endif  // TOPOTAG_HOST_MODEL_H_
