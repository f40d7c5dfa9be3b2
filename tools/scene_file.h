#ifndef TOPOTAG_TOOLS_SCENE_FILE_H_
#define TOPOTAG_TOOLS_SCENE_FILE_H_

#include <string>
#include <vector>

#include "topotag/image.h"
#include "topotag/image_file.h"
#include "topotag/renderer.h"

namespace topotag::tools {

/// A scene and the background picture that it points to.
struct SceneFile {
  Scene scene;
  Image background;
  std::vector<std::string> files;  ///< that the scene names

  /// Reads the background picture and makes the scene point to it.
  /// @throws Error as ReadInput.
  void SetBackground(const std::string& path, uint64_t max_pixels);
};

/// Reads a scene of at most 16 MB; the files that it names are in its folder or below.
///
/// {"camera": FILE or {"width","height","fx","fy","cx","cy"(,"distortion_model","distortion")},
///  "background": LEVEL or FILE, "blur": S, "noise": S, "seed": N,
///  "markers": [{"family","id","size","t","rvec" or "R","inner","outer","frame","margin",
///               "inverted","black","white","growth","velocity","angular_velocity"}],
///  and what ReadConditions reads}
/// Needed are camera, and family, id, size and t of each marker; the rest is Scene's default.
/// @throws Error (kFile, kParse) that names the file, the marker's index and the key.
SceneFile ReadScene(const std::string& path, uint64_t max_pixels = kDefaultMaxPixels);

/// Rotation of a rotation vector (axis times angle, radians).
Matrix3 RotationMatrix(const Vector3& rvec);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_SCENE_FILE_H_
