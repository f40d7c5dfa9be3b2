// The opencl backend equals the scalar one, on every device of this machine. Without a device these
// tests fail: install one (PoCL), or build with TOPOTAG_OPENCL=OFF.

#include "kernels/opencl_backend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "tests/frames.h"
#include "tests/guarded.h"
#include "tests/opencl_util.h"
#include "tests/random_image.h"
#include "topotag/detector.h"
#include "topotag/device.h"

namespace topotag {
namespace {

using opencl::AllDevices;
using opencl::Binarizer;
using opencl::ChooseDevice;
using opencl::Transfer;

ThresholdParams Params(Preset preset) {
  ThresholdParams params;
  params.preset = preset;
  return params;
}

template <typename Frame>
void ExpectParity(const ImageView& image, const Frame& frame, Binarizer* binarizer) {
  for (const Preset preset : {Preset::kDefault, Preset::kPaper}) {
    const Reference expected(image, Params(preset));
    binarizer->Submit(image, Params(preset));
    ASSERT_EQ(CollectDifference(expected, binarizer), "")
        << frame << ", preset " << static_cast<int>(preset);
  }
}

class OpenClParityTest : public ::testing::TestWithParam<Transfer> {
 protected:
  static std::vector<std::unique_ptr<Binarizer>> Binarizers() {
    std::vector<std::unique_ptr<Binarizer>> all;
    for (const opencl::Device& device : AllDevices()) {
      all.push_back(std::make_unique<Binarizer>(device, nullptr, GetParam()));
    }
    EXPECT_FALSE(all.empty()) << "no OpenCL device";
    return all;
  }
};

TEST_P(OpenClParityTest, AllSizes) {
  std::vector<ImageCase> cases = AllCases();
  for (const int width : {255, 256, 257, 1279, 1280, 1281}) {
    cases.push_back({width, 960, width % 5, Content::kBlobs, static_cast<uint64_t>(width)});
  }
  for (const auto& binarizer : Binarizers()) {
    for (const ImageCase& c : cases) {
      const PaddedImage image = MakeImage(c);
      ExpectParity(image.view(), c, binarizer.get());
      if (HasFatalFailure()) return;
    }
  }
}

// Nothing outside the rows is read: there is no memory, or garbage.
TEST_P(OpenClParityTest, GuardedFrames) {
  for (const auto& binarizer : Binarizers()) {
    for (uint64_t seed = 0; seed < 300; ++seed) {
      const FrameCase c = RandomFrameCase(seed);
      const GuardedImage image = MakeFrame(c, seed % 2 == 0 ? Guard::kEnd : Guard::kBegin);
      ExpectParity(image.view(), c, binarizer.get());
      if (HasFatalFailure()) return;
    }
  }
}

TEST_P(OpenClParityTest, OtherParameters) {
  const PaddedImage image = MakeImage({333, 222, 3, Content::kBlobs, 4});
  for (const auto& binarizer : Binarizers()) {
    for (const int sixteenths : {1, 6, 8, 15}) {
      for (const int contrast : {0, 1, 60, 256}) {
        ThresholdParams params;
        params.contrast_sixteenths = sixteenths;
        params.min_contrast = contrast;
        const Reference expected(image.view(), params);
        binarizer->Submit(image.view(), params);
        ASSERT_EQ(CollectDifference(expected, binarizer.get()), "") << sixteenths << contrast;
      }
    }
  }
}

// Blank words and tiles of both colours, with outliers that their bounds decide about.
TEST_P(OpenClParityTest, FlatTiles) {
  PaddedImage image = MakeImage({400, 160, 3, Content::kBlack, 4});
  Random random(5);
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 400; ++x) {
      int level = (y < 90 ? 200 : 20) + random.Below(12);
      if (x >= 150 && x < 270) level = x % 16 < 8 ? 0 : 255;
      image.row(y)[x] = static_cast<uint8_t>(level);
    }
  }
  // Half of each is hidden in the mean of its pair.
  image.row(40)[20] = 185;
  image.row(120)[20] = 45;
  const Reference expected(image.view(), {});
  const auto tiles = [](const std::vector<uint8_t>& bounds, uint8_t bound) {
    return std::count(bounds.begin(), bounds.end(), bound);
  };
  EXPECT_GT(tiles(expected.grid.floor, 255), 10);
  EXPECT_GT(tiles(expected.grid.ceiling, 0), 50);
  for (const auto& binarizer : Binarizers()) {
    ExpectParity(image.view(), "flat tiles", binarizer.get());
    if (HasFatalFailure()) return;
  }
}

TEST_P(OpenClParityTest, FramesWithoutContrastAreWhite) {
  for (const auto& binarizer : Binarizers()) {
    for (const auto& [width, height] : {std::pair(1, 1), std::pair(64, 16), std::pair(201, 99)}) {
      for (const Content content : {Content::kBlack, Content::kWhite}) {
        const PaddedImage image = MakeImage({width, height, 1, content, 1});
        binarizer->Submit(image.view(), {});
        BitImage bits;
        ThresholdGrid grid;
        binarizer->Collect(&bits);
        binarizer->ReadGrid(&grid);
        EXPECT_EQ(grid.value, std::vector<uint16_t>(grid.value.size(), 0));
        EXPECT_EQ(grid.ceiling, std::vector<uint8_t>(grid.ceiling.size(), 0));
        EXPECT_EQ(Difference(Reference(image.view(), {}).bits, bits), "");
        EXPECT_EQ(bits.row(height - 1)[0] & 1, 1U);
      }
    }
  }
}

// Frames come back in their order, whatever their sizes, and each with its own grid.
TEST_P(OpenClParityTest, TwoInFlight) {
  for (const auto& binarizer : Binarizers()) {
    std::vector<PaddedImage> images;
    std::vector<Reference> expected;
    for (uint64_t seed = 0; seed < 24; ++seed) {
      const int width = static_cast<int>(seed * 37 % 211 + 1);
      const int height = static_cast<int>(seed * 53 % 157 + 1);
      const Preset preset = seed % 3 == 0 ? Preset::kPaper : Preset::kDefault;
      images.push_back(MakeImage({width, height, 2, Content::kBlobs, seed}));
      expected.emplace_back(images.back().view(), Params(preset));
      binarizer->Submit(images.back().view(), Params(preset));
      if (seed == 0) continue;
      ASSERT_EQ(binarizer->submitted(), 2);
      ASSERT_EQ(CollectDifference(expected[seed - 1], binarizer.get()), "") << seed;
    }
    ASSERT_EQ(CollectDifference(expected.back(), binarizer.get()), "");
    EXPECT_EQ(binarizer->submitted(), 0);
  }
}

// The grid of the frame collected last is there while two others are under way.
TEST_P(OpenClParityTest, GridStaysWhileOthersAreSubmitted) {
  const PaddedImage first = MakeImage({200, 100, 0, Content::kBlobs, 1});
  const PaddedImage other = MakeImage({120, 300, 0, Content::kNoise, 2});
  for (const auto& binarizer : Binarizers()) {
    BitImage bits;
    ThresholdGrid grid;
    binarizer->Submit(first.view(), {});
    binarizer->Collect(&bits);
    binarizer->Submit(other.view(), {});
    binarizer->Submit(other.view(), {});
    binarizer->ReadGrid(&grid);
    EXPECT_EQ(Difference(Reference(first.view(), {}).grid, grid), "");
  }
}

TEST_P(OpenClParityTest, TooManyOrNoFrames) {
  const PaddedImage image = MakeImage({20, 10, 0, Content::kNoise, 2});
  for (const auto& binarizer : Binarizers()) {
    BitImage bits;
    ExpectError(ErrorCode::kInvalidArgument, {"no frame"}, [&] { binarizer->Collect(&bits); });
    binarizer->Submit(image.view(), {});
    binarizer->Submit(image.view(), {});
    ExpectError(ErrorCode::kInvalidArgument, {"2 frames"},
                [&] { binarizer->Submit(image.view(), {}); });
    EXPECT_EQ(CollectDifference(Reference(image.view(), {}), binarizer.get()), "");
  }
}

INSTANTIATE_TEST_SUITE_P(Transfers, OpenClParityTest,
                         ::testing::Values(Transfer::kMapped, Transfer::kStaged),
                         [](const auto& info) {
                           return info.param == Transfer::kMapped ? "Mapped" : "Staged";
                         });

TEST(OpenClDeviceTest, AreListedInOrder) {
  const std::vector<DeviceInfo> devices = ListDevices();
  ASSERT_FALSE(devices.empty());
  for (size_t i = 0; i < devices.size(); ++i) {
    EXPECT_EQ(devices[i].index, static_cast<int>(i));
    EXPECT_FALSE(devices[i].name.empty());
    EXPECT_FALSE(devices[i].platform.empty());
    EXPECT_GT(devices[i].compute_units, 0);
    EXPECT_EQ(ChooseDevice(static_cast<int>(i)).info.name, devices[i].name);
  }
}

TEST(OpenClDeviceTest, WrongIndexIsRefused) {
  for (const int index : {-1, 1000}) {
    const std::string number = std::to_string(index);
    Options options;
    options.backend = BackendKind::kOpenCl;
    options.device = index;
    ExpectError(ErrorCode::kInvalidArgument, {"device", number.c_str(), "does not exist"},
                [&] { Detector detector(options); });
  }
}

TEST(OpenClDetectorTest, NamesItsDevice) {
  Options options;
  options.backend = BackendKind::kOpenCl;
  EXPECT_EQ(Detector(options).backend(), "opencl/" + ChooseDevice({}).info.name);
}

// Frames that are submitted ahead give what frames one by one give.
TEST(OpenClDetectorTest, SubmittedFrames) {
  for (const BackendKind kind : {BackendKind::kOpenCl, BackendKind::kSimd}) {
    Options options;
    Detector expected(options);
    options.backend = kind;
    Detector detector(options);
    std::vector<Detection> detections;
    EXPECT_FALSE(detector.collect(&detections));
    size_t found = 0;
    std::vector<GuardedImage> images;
    for (uint64_t seed = 0; seed < 12; ++seed) {
      images.push_back(MakeFrame({320, 240, 1, FrameKind::kMarkers, seed}));
    }
    for (size_t i = 0; i <= images.size(); ++i) {
      if (i < images.size()) detector.submit(images[i].view());
      if (i == 0) continue;
      ASSERT_TRUE(detector.collect(&detections));
      const std::vector<Detection> other = expected.detect(images[i - 1].view());
      ASSERT_EQ(detections.size(), other.size()) << i;
      for (size_t k = 0; k < other.size(); ++k) {
        EXPECT_EQ(detections[k].id, other[k].id);
        EXPECT_EQ(detections[k].center.x, other[k].center.x);
        EXPECT_EQ(detections[k].center.y, other[k].center.y);
      }
      found += other.size();
    }
    EXPECT_GT(found, 0U);
  }
}

TEST(OpenClDetectorTest, SubmittedFramesMustBeCollected) {
  Options options;
  options.backend = BackendKind::kOpenCl;
  Detector detector(options);
  const PaddedImage image = MakeImage({64, 64, 0, Content::kNoise, 2});
  detector.submit(image.view());
  ExpectError(ErrorCode::kInvalidArgument, {"not been collected"},
              [&] { detector.detect(image.view()); });
  detector.submit(image.view());
  ExpectError(ErrorCode::kInvalidArgument, {"not been collected"},
              [&] { detector.submit(image.view()); });
  std::vector<Detection> detections;
  EXPECT_TRUE(detector.collect(&detections));
  EXPECT_TRUE(detector.collect(&detections));
  EXPECT_FALSE(detector.collect(&detections));
  detector.detect(image.view());
}

}  // namespace
}  // namespace topotag
