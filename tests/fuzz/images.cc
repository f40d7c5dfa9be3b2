// Images of any size, stride and content through every backend that runs on the processor, with any
// options. Grid, bits, components and features are the same, bit for bit, on every Highway target;
// detections on two of them, which the input chooses, one with two threads: all take too long.

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/detection_text.h"
#include "tests/fuzz/input.h"
#include "tests/fuzz/painted_scene.h"
#include "tests/fuzz/target.h"
#include "tests/random_image.h"
#include "tests/scene_util.h"
#include "tests/segmentation_parity.h"
#include "tests/simd_targets.h"
#include "topotag/detector.h"

#if defined(__SANITIZE_ADDRESS__)
#define TOPOTAG_POISON 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define TOPOTAG_POISON 1
#endif
#endif
#ifdef TOPOTAG_POISON
#include <sanitizer/asan_interface.h>
#endif

namespace topotag::fuzz {
namespace {

constexpr int kMaxPixels = 1 << 14;  // larger pictures take longer, nothing else

/// While it lives, what lies between the rows of an image must not be read.
class PoisonedPadding {
 public:
  explicit PoisonedPadding(const ImageView& image) : image_(image) { Poison(true); }
  PoisonedPadding(const PoisonedPadding&) = delete;
  PoisonedPadding& operator=(const PoisonedPadding&) = delete;
  ~PoisonedPadding() { Poison(false); }

 private:
  void Poison([[maybe_unused]] bool poisoned) {
#ifdef TOPOTAG_POISON
    const size_t padding = static_cast<size_t>(image_.stride - image_.width);
    for (int y = 0; y + 1 < image_.height; ++y) {
      const uint8_t* end = image_.row(y) + image_.width;
      if (poisoned) {
        __asan_poison_memory_region(end, padding);
      } else {
        __asan_unpoison_memory_region(end, padding);
      }
    }
#endif
  }

  ImageView image_;
};

struct Described {
  Options options;
  ThresholdParams threshold;
  bool warm;      ///< the detectors have seen another frame before
  size_t target;  ///< the first of the two
};

std::vector<Family> DescribedFamilies(Input* input) {
  const int mask = input->Between(1, 127);
  if (mask >= 64) return Options().families;
  std::vector<Family> families;
  for (int i = 0; i < 6; ++i) {
    if ((mask >> i & 1) != 0) families.emplace_back(Family::kMinN + i);
  }
  return families;
}

Camera DescribedCamera(Input* input, int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = input->Real(0.3, 3) * std::max(width, height);
  camera.fy = camera.fx * input->Real(0.8, 1.2);
  camera.cx = input->Real(0.2, 0.8) * width;
  camera.cy = input->Real(0.2, 0.8) * height;
  const int lens = input->Between(0, 6);
  if (lens == 0 || lens > 3) return camera;
  camera.model = lens == 1 ? DistortionModel::kFisheye : DistortionModel::kBrown;
  const size_t count = lens == 1 ? 4 : lens == 2 ? 5 : 14;
  for (size_t i = 0; i < count; ++i) camera.distortion[i] = input->Real(-0.3, 0.3);
  return camera;
}

Rect DescribedRoi(Input* input, int width, int height) {
  Rect roi;
  roi.x = input->Between(0, 65535) % width;
  roi.y = input->Between(0, 65535) % height;
  roi.width = 1 + input->Between(0, 65535) % (width - roi.x);
  roi.height = 1 + input->Between(0, 65535) % (height - roi.y);
  return roi;
}

Described DescribedRun(Input* input, int width, int height) {
  Described run;
  Options& options = run.options;
  options.families = DescribedFamilies(input);
  const int flags = input->Byte();
  if ((flags & 7) == 0) options.preset = Preset::kPaper;
  options.far = (flags & 0x18) == 0x18;
  options.pre_blur = (flags & 0x60) == 0;
  run.warm = (flags & 0x80) != 0;
  constexpr std::array<int, 4> kHiddenNodes{0, 0, 3, kMaxVertices};
  options.hidden_nodes = kHiddenNodes[static_cast<size_t>(input->Between(0, 3))];
  const int geometry = input->Byte();
  if ((geometry & 3) != 0) options.camera = DescribedCamera(input, width, height);
  if ((geometry & 12) != 0) options.tag_size = input->Real(0.001, 1);
  if ((geometry & 16) != 0) options.pose = PoseMode::kPhotometric;
  if ((geometry & 0xe0) == 0) options.roi = DescribedRoi(input, width, height);
  if ((geometry & 0xe0) == 0x20)
    options.ids[options.families[0].n()] = {input->Byte() & 127u, 5, 100};
  run.threshold.preset = options.preset;
  run.target = input->Byte();
  return run;
}

std::string Detections(Detector* detector, const ImageView& image, bool warm) {
  if (warm && !detector->options().camera && !detector->options().roi) {
    detector->detect({image.data, (image.width + 1) / 2, (image.height + 1) / 2, image.stride});
  }
  return DetectionText(detector->detect(image)).str();
}

void CompareDetections(const ImageView& image, const Described& run) {
  Options options = run.options;
  options.threads = 1;
  options.backend = BackendKind::kScalar;
  Detector scalar(options);
  const std::string expected = Detections(&scalar, image, false);
  options.backend = BackendKind::kSimd;
  const std::vector<int64_t> targets = SimdTargets();
  for (options.threads = 1; options.threads <= 2; ++options.threads) {
    const size_t target = run.target + static_cast<size_t>(options.threads);
    const ForcedTarget forced(targets[target % targets.size()]);
    Detector detector(options);
    const std::string actual = Detections(&detector, image, run.warm);
    if (actual == expected) continue;
    Abort(detector.backend() + ", " + std::to_string(options.threads) + " threads:\n" + actual +
          "instead of\n" + expected);
  }
}

void CompareStages(const ImageView& image, const Described& run, uint64_t seed) {
  // Their workspaces stay from input to input, of any size.
  static SegmentationParity parity({1, 2});
  Random random(seed);
  const std::string difference = parity.Difference(image, run.threshold, &random);
  if (!difference.empty()) Abort(difference);
}

PaddedImage DescribedImage(Input* input, const Options& options, int width, int height,
                           int padding) {
  PaddedImage image(width, height, padding);
  image.FillPadding(input->Byte());
  if (input->Byte() % 4 != 0) {
    const Camera usual = test::PinholeCamera(width, height, std::max(width, height));
    PaintScene(input, options.camera.value_or(usual), &image);
    return image;
  }
  // What is missing is repeated.
  const std::string pixels = input->Rest() + '\0';
  size_t next = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x, ++next) {
      image.row(y)[x] = static_cast<uint8_t>(pixels[next % pixels.size()]);
    }
  }
  return image;
}

/// What the bytes of an input describe.
struct Case {
  Described run;
  PaddedImage image;
};

Case DescribedCase(const uint8_t* data, size_t size) {
  Input input(data, size);
  const int side = input.Byte();
  const int width = 1 + (side >= 0x80 ? 60 + (side & 0x7f) : side) + input.Between(0, 15);
  const int height = 1 + (side >= 0x80 ? 60 : 0) + input.Byte();
  const int padding = input.Flag() ? 0 : input.Byte();
  const int whole_height = std::min(height, kMaxPixels / width);
  const Described run = DescribedRun(&input, width, whole_height);
  return {run, DescribedImage(&input, run.options, width, whole_height, padding)};
}

bool HasMarkers(const std::string& bytes) {
  const Case scene = DescribedCase(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  Options options = scene.run.options;
  options.backend = BackendKind::kScalar;
  return !Detector(options).detect(scene.image.view()).empty();
}

}  // namespace

// Random bytes describe random scenes. In most of those that are kept markers are found: this also
// proves that the painted ones are.
std::vector<std::string> Seeds() {
  constexpr size_t kLength = 120, kWithMarkers = 40, kWithout = 10;
  std::mt19937_64 random(1);
  std::vector<std::string> with, without;
  for (int tries = 0; tries < 500 && with.size() < kWithMarkers; ++tries) {
    std::string bytes(kLength, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    if (HasMarkers(bytes)) {
      with.push_back(bytes);
    } else if (without.size() < kWithout) {
      without.push_back(bytes);
    }
  }
  Require(with.size() == kWithMarkers, "painted markers are not found");
  with.insert(with.end(), without.begin(), without.end());
  return with;
}

}  // namespace topotag::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace topotag;
  fuzz::HideDevices();
  const fuzz::Case scene = fuzz::DescribedCase(data, size);
  const ImageView image = scene.image.view();
  const fuzz::PoisonedPadding poisoned(image);
  fuzz::CompareStages(image, scene.run, size);
  fuzz::CompareDetections(image, scene.run);
  return 0;
}
