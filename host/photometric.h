#ifndef TOPOTAG_HOST_PHOTOMETRIC_H_
#define TOPOTAG_HOST_PHOTOMETRIC_H_

#include "host/photometric_fit.h"
#include "topotag/camera.h"
#include "topotag/detection.h"
#include "topotag/image.h"

namespace topotag {

/// Replaces a marker's pose by the photometric one: the model of the whole marker, in grey levels,
/// is aligned with the image. Beyond the paper; docs/design.md.
///
/// From both planar solutions where their errors are close; then the fit decides between them.
/// @param tag_size   side of the white area, metres
/// @param detection  of this image, with its pose; pose->photometric is set, and where the fit is
///                   accepted the rest of the pose
/// @return whether it is accepted
bool RefinePhotometric(const ImageView& image, const Camera& camera, double tag_size,
                       PhotometricWorkspace* workspace, Detection* detection);

}  // namespace topotag

#endif  // TOPOTAG_HOST_PHOTOMETRIC_H_
