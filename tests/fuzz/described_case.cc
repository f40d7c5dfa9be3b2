#include "tests/fuzz/described_case.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "tests/fuzz/input.h"
#include "tests/fuzz/painted_scene.h"
#include "tests/scene_util.h"

namespace topotag::fuzz {
namespace {

constexpr int kMaxPixels = 1 << 14;  // larger pictures take longer, nothing else

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

void DescribeTagSizes(Input* input, Options* options) {
  const int which = input->Byte();
  if ((which & 3) != 0) options->tag_size = input->Real(0.001, 1);
  const int n = options->families.back().n();
  if ((which & 12) == 4) options->family_tag_size[n] = input->Real(0, 1);
  if ((which & 12) == 8) options->id_tag_size[{n, input->Byte() & 127u}] = input->Real(0, 1);
}

/// @param width, height  of the frames
Options DescribedOptions(Input* input, int width, int height) {
  Options options;
  options.families = DescribedFamilies(input);
  const int search = input->Byte();
  if ((search & 7) == 0) options.preset = Preset::kPaper;
  options.far = (search & 0x18) == 0x18;
  options.pre_blur = (search & 0x60) == 0;
  options.inverted = (search & 0x81) == 0x81;
  constexpr std::array<int, 4> kHiddenNodes{0, 0, 3, kMaxVertices};
  options.hidden_nodes = kHiddenNodes[static_cast<size_t>(input->Between(0, 3))];
  const int extras = input->Byte();
  if ((extras & 3) != 0) options.camera = DescribedCamera(input, width, height);
  if ((extras & 3) != 0) DescribeTagSizes(input, &options);
  if ((extras & 0x0c) == 0) options.pose = PoseMode::kPhotometric;
  const int limit = extras >> 4;
  if (limit == 0 || limit == 1) options.roi = DescribedRoi(input, width, height);
  if (limit == 1 || limit == 2) options.min_size = input->Real(0, 1.2) * std::min(width, height);
  if (limit == 3) options.ids[options.families[0].n()] = {input->Byte() & 127u, 5, 100};
  return options;
}

PaddedImage DescribedPicture(Input* input, const Camera& camera, int padding) {
  PaddedImage image(camera.width, camera.height, padding);
  image.FillPadding(input->Byte());
  if (input->Byte() % 4 != 0) {
    PaintScene(input, camera, &image);
    return image;
  }
  // What is missing is repeated.
  const std::string pixels = input->Rest() + '\0';
  size_t next = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++next) {
      image.row(y)[x] = static_cast<uint8_t>(pixels[next % pixels.size()]);
    }
  }
  return image;
}

// The picture goes on as it began, more or less, until it meets the border.
std::vector<Shot> DescribedShots(Input* input, int free_x, int free_y) {
  const int step_x = input->Between(-32, 32), step_y = input->Between(-32, 32);
  int x = input->Between(0, 65535) % (free_x + 1), y = input->Between(0, 65535) % (free_y + 1);
  std::vector<Shot> shots(static_cast<size_t>(input->Between(2, 5)));
  for (Shot& shot : shots) {
    const int event = input->Byte();
    shot = {x, y, event < 32 ? Shot::Event(event % 4) : Shot::Event::kNone};
    const int turn = input->Byte();
    x = std::clamp(x + step_x + (turn & 15) - 8, 0, free_x);
    y = std::clamp(y + step_y + (turn >> 4) - 8, 0, free_y);
  }
  return shots;
}

}  // namespace

Case DescribedCase(const uint8_t* data, size_t size) {
  Input input(data, size);
  const int kind = input.Byte();
  const Check check = (kind & 3) == 0   ? Check::kStages
                      : (kind & 3) == 1 ? Check::kTracks
                                        : Check::kDetections;
  const bool pipelined = (kind & 0x10) != 0, refined = (kind & 0x60) == 0;
  const size_t subject = input.Byte();
  const int side = input.Byte();
  int width = 1 + (side >= 0x80 ? 60 + (side & 0x7f) : side) + input.Between(0, 15);
  int height = 1 + (side >= 0x80 ? 60 : 0) + input.Byte();
  height = std::min(height, kMaxPixels / width);
  const int padding = input.Flag() ? 0 : input.Byte();
  const Camera usual = test::PinholeCamera(width, height, std::max(width, height));
  std::vector<Shot> shots;
  uint8_t ground = 0;
  if (check == Check::kTracks) {
    const int free_x = input.Between(0, 511), free_y = input.Between(0, 255);
    ground = static_cast<uint8_t>(input.Byte());
    shots = DescribedShots(&input, free_x, free_y);
    width += free_x;
    height += free_y;
  }
  TrackerOptions options;
  options.detection = DescribedOptions(&input, width, height);
  if (check == Check::kTracks) {
    options.search_interval = input.Between(1, 4);
    options.lost_frames = input.Between(0, 2);
  }
  const bool fills_frame = check != Check::kTracks;
  PaddedImage picture = DescribedPicture(
      &input, fills_frame ? options.detection.camera.value_or(usual) : usual, padding);
  return {check, subject, pipelined, refined, std::move(options), std::move(picture),
          width, height,  padding,   ground,  std::move(shots)};
}

PaddedImage Frame(const Case& video, const Shot& shot) {
  const Options& options = video.options.detection;
  const bool is_lower =
      shot.event == Shot::Event::kLowerFrame && video.height > 1 && !options.camera && !options.roi;
  PaddedImage frame(video.width, video.height - (is_lower ? 1 : 0), video.padding);
  for (int y = 0; y < frame.view().height; ++y) {
    std::fill_n(frame.row(y), video.width, video.ground);
  }
  if (shot.event == Shot::Event::kNoPicture) return frame;
  const ImageView picture = video.picture.view();
  for (int y = 0; y < std::min(picture.height, frame.view().height - shot.y); ++y) {
    std::copy_n(picture.row(y), picture.width, frame.row(shot.y + y) + shot.x);
  }
  return frame;
}

}  // namespace topotag::fuzz
