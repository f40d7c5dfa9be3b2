// Writes a marker with the installed component io and reads it back.

#include <topotag/camera_file.h>
#include <topotag/generator.h>
#include <topotag/image_file.h>

#include <cstdio>
#include <string>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: consumer_io FOLDER\n");
    return 2;
  }
  const std::string folder = argv[1];
  topotag::MarkerDesign design;
  design.id = 278;
  topotag::WriteMarker(design, {50, 254}, folder + "/marker.png");
  const topotag::Image image = topotag::ReadImage(folder + "/marker.png");
  // 4x4: 17 units of white and a frame of 1 unit on each side, at 10 pixels a millimetre.
  const int side = static_cast<int>(50.0 * 19 / 17 * 10 + 0.5);

  topotag::Camera camera;
  camera.fx = camera.fy = 500;
  topotag::WriteCamera(camera, folder + "/camera.yaml");
  const double fx = topotag::ReadCamera(folder + "/camera.yaml").fx;

  std::printf("marker.png: %d x %d pixels, camera.yaml: fx %g\n", image.width(), image.height(),
              fx);
  return image.width() == side && image.height() == side && fx == 500 ? 0 : 1;
}
