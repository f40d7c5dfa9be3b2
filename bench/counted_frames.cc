// Detects one scene a few times, for instruction counts: bench/instructions.sh runs it.
//   counted_frames BACKEND SCENE WIDTH HEIGHT FRAMES
// Frames are counted within CountedFrames, after one that sizes the workspace.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "bench/scenes.h"
#include "topotag/detector.h"

namespace topotag::bench {
namespace {

SceneKind ParseScene(const std::string& name) {
  for (const SceneKind kind : kSceneKinds) {
    if (name == Name(kind)) return kind;
  }
  throw Error(ErrorCode::kInvalidArgument, "no scene is called '" + name + "'");
}

}  // namespace

/// A symbol of its own: counting begins and ends with it.
__attribute__((noinline)) void CountedFrames(Detector* detector, const ImageView& frame, int count,
                                             std::vector<Detection>* found) {
  for (int i = 0; i < count; ++i) detector->detect(frame, found);
}

int Main(char** arguments) {
  const FrameSize size{std::atoi(arguments[3]), std::atoi(arguments[4])};
  const BenchScene scene = MakeScene(ParseScene(arguments[2]), size, LoadPhotos(""));
  const Image frame = RenderTopoTags(scene);
  Options options = SceneOptions(scene);
  options.backend = ParseBackend(arguments[1]);
  Detector detector(options);
  std::vector<Detection> found;
  detector.detect(frame.view(), &found);
  CountedFrames(&detector, frame.view(), std::atoi(arguments[5]), &found);
  std::printf("%s\n", detector.backend().c_str());
  return found.size() == scene.scene.markers.size() ? 0 : 1;
}

}  // namespace topotag::bench

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "usage: counted_frames BACKEND SCENE WIDTH HEIGHT FRAMES\n");
    return 2;
  }
  try {
    return topotag::bench::Main(argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "counted_frames: %s\n", error.what());
  }
  return 1;
}
