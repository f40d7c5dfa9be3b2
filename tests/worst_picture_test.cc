// The bounds of time and memory for the pictures that the search for the worst has found
// (tests/worst_picture.h, bench/worst_case.cc), with the options that they are worst for.

#include "tests/worst_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/place_grid.h"
#include "tests/live_bytes.h"
#include "tests/thread_time.h"
#include "topotag/detector.h"

namespace topotag {
namespace {

// Measured: 54, with all options.
constexpr double kMaxBytesPerPixel = 64;

TEST(WorstPictureTest, MemoryIsBoundedByThePixels) {
  for (const KnownWorst& known : KnownWorstPictures()) {
    constexpr int kWidth = 640, kHeight = 480;
    const PaddedImage image = WorstPicture::Parse(known.picture).Draw(kWidth, kHeight);
    std::vector<Detection> detections;
    const PeakBytes peak;
    Detector detector(WorstOptions(known.options, kWidth, kHeight));
    detector.detect(image.view(), &detections);
    const double bytes = static_cast<double>(peak.Get()) / (kWidth * kHeight);
    RecordProperty("bytes_per_pixel", std::to_string(bytes));
    EXPECT_LT(bytes, kMaxBytesPerPixel) << known.options << ": " << known.picture;
  }
}

// The thread's own time, which others on the machine do not count in, of the fastest frame; tries
// for long while it is above the limit.
double SecondsPerPixel(const char* picture, int width, int height, double limit) {
  const PaddedImage image = WorstPicture::Parse(picture).Draw(width, height);
  Detector detector(WorstOptions("default", width, height));
  std::vector<Detection> detections;
  double fastest = std::numeric_limits<double>::max();
  for (int i = 0; i < 3 || (fastest >= limit && i < 30); ++i) {
    const double begin = ThreadSeconds();
    detector.detect(image.view(), &detections);
    fastest = std::min(fastest, (ThreadSeconds() - begin) / (double{1} * width * height));
  }
  EXPECT_GT(detections.size(), static_cast<size_t>(width * height / 1000));
  return fastest;
}

// Ten thousand of them: whether a reading is a new one must not be asked of each. Measured: 1.1;
// 4 where it was.
TEST(WorstPictureTest, AMarkerAmongManyCostsNoMoreThanAmongFew) {
  const double few = SecondsPerPixel(kManyMarkers, 640, 480, 0);
  EXPECT_LT(SecondsPerPixel(kManyMarkers, 3264, 2448, 2 * few), 2 * few);
}

TEST(WorstPictureTest, PicturesAreReadBackFromTheirText) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const WorstPicture picture = WorstPicture::Made(&random);
    EXPECT_EQ(WorstPicture::Parse(picture.Text()).Text(), picture.Text());
  }
  EXPECT_THROW(WorstPicture::Parse("1 2 3"), Error);
  EXPECT_THROW(WorstPicture::Parse("99 6 1 6 1 0 16 3 5 6 1 6 1 0 16 3 0 8 30 220 0 0"), Error);
}

TEST(PlaceGridTest, FindsWhatIsNear) {
  Random random(7);
  for (const auto& [width, height] : {std::pair(640, 480), std::pair(1, 1), std::pair(65, 1000)}) {
    PlaceGrid grid;
    for (int round = 0; round < 2; ++round) {
      grid.Start(width, height);
      std::vector<Point2> places;
      const auto place = [&random, w = width, h = height] {
        return Point2{random.Between(-99, w + 99) / 3.0, random.Between(-99, h + 99) / 3.0};
      };
      for (int i = 0; i < 300; ++i) {
        const Point2 p = place();
        const double squared = random.Chance(10) ? INFINITY : random.Below(2000);
        const bool is_near = std::any_of(places.begin(), places.end(), [&](const Point2& other) {
          const double dx = other.x - p.x, dy = other.y - p.y;
          return dx * dx + dy * dy < squared;
        });
        EXPECT_EQ(grid.HasNear(p, squared), is_near) << p.x << " " << p.y << " " << squared;
        EXPECT_FALSE(grid.HasNear({NAN, p.y}, squared));
        EXPECT_FALSE(grid.HasNear(p, NAN));
        if (i % 5 != 0) continue;
        grid.Add(p);
        places.push_back(p);
      }
    }
  }
}

}  // namespace
}  // namespace topotag
