// The option --track of the command detect.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class CliTrackTest : public CliTest {
 protected:
  // The folder "in" and the video v.avi: the same four frames, of which the third is without
  // markers.
  void MakeSequences() const {
    RenderScene();
    const cv::Mat scene = cv::imread((folder_ / "scene.png").string());
    cv::VideoWriter video((folder_ / "v.avi").string(), cv::CAP_OPENCV_MJPEG,
                          cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30, scene.size());
    ASSERT_TRUE(video.isOpened());
    for (int i = 0; i < 4; ++i) {
      const cv::Mat frame = i == 2 ? cv::Mat::zeros(scene.size(), scene.type()) : scene;
      video.write(frame);
      cv::imwrite((folder_ / "in" / (std::to_string(i) + ".png")).string(), frame);
    }
  }

  std::vector<Json> Frames(const std::string& arguments) const {
    const Outcome outcome =
        Run("detect --format json --camera cam.yaml --tag-size 0.05 " + arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    std::vector<Json> frames;
    for (const std::string& line : Lines(outcome.out)) frames.push_back(Json::parse(line));
    return frames;
  }
};

TEST_F(CliTrackTest, TellsWhichMarkerIsWhich) {
  MakeSequences();
  for (const char* input : {"in", "v.avi"}) {
    SCOPED_TRACE(input);
    std::vector<Json> frames = Frames(std::string("--track on ") + input);
    const std::vector<Json> plain = Frames(std::string("--track off ") + input);
    ASSERT_EQ(frames.size(), 4u);
    ASSERT_EQ(plain.size(), 4u);
    for (size_t i = 0; i < frames.size(); ++i) {
      Json& detections = frames[i]["detections"];
      ASSERT_EQ(detections.size(), i == 2 ? 0u : 3u);
      for (size_t k = 0; k < detections.size(); ++k) {
        const Json track = detections[k]["track"];
        EXPECT_EQ(Keys(track), (Strings{"number", "age", "missed", "in_region"}));
        EXPECT_EQ(track["number"], k + 1);
        EXPECT_EQ(track["age"], i == 3 ? 3 : i + 1);
        EXPECT_EQ(track["missed"], i == 3 ? 1 : 0);
        if (i != 1) {
          EXPECT_EQ(track["in_region"], false);
        }
        detections[k].erase("track");
      }
      // The rest is as without.
      EXPECT_EQ(detections, plain[i]["detections"]);
    }
  }
}

TEST_F(CliTrackTest, EachInputBeginsAnew) {
  MakeSequences();
  const std::vector<Json> frames = Frames("--track on in v.avi scene.png scene.png");
  ASSERT_EQ(frames.size(), 10u);
  for (const size_t first : {0u, 4u, 8u, 9u}) {
    for (const Json& marker : frames[first]["detections"]) EXPECT_EQ(marker["track"]["age"], 1);
    EXPECT_EQ(frames[first]["detections"][0]["track"]["number"], 1);
  }
}

TEST_F(CliTrackTest, OtherFormatsHaveTheNumber) {
  MakeSequences();
  const Strings text = Lines(Run("detect --track on scene.png").out);
  ASSERT_EQ(text.size(), 4u);
  for (size_t i = 1; i < 4; ++i) {
    EXPECT_NE(text[i].find("  track " + std::to_string(i)), std::string::npos) << text[i];
  }
  const Strings rows = Lines(Run("detect --track on --format csv scene.png").out);
  ASSERT_EQ(rows.size(), 4u);
  const auto last = [](const std::string& row) { return row.substr(row.rfind(',') + 1); };
  EXPECT_EQ(last(rows[0]), "track");
  for (size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(last(rows[i]), std::to_string(i));
    EXPECT_EQ(std::count(rows[i].begin(), rows[i].end(), ','),
              std::count(rows[0].begin(), rows[0].end(), ','));
  }
}

TEST_F(CliTrackTest, WrongUsage) {
  RenderScene();
  ExpectComplaint("detect --track maybe scene.png", 2, {"--track", "maybe"});
  ExpectComplaint("detect --track on --stages out scene.png", 2, {"--stages", "--track on"});
}

}  // namespace
}  // namespace topotag
