// The command detect, run as a user runs it.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

double Distance(const Json& a, const Json& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::pow(a[i].get<double>() - b[i].get<double>(), 2);
  return std::sqrt(sum);
}

TEST_F(CliTest, JsonHasTheKeysOfTheContractInOrder) {
  RenderScene();
  const Json line = Detect("--camera cam.yaml --tag-size 0.05 scene.png");
  EXPECT_EQ(Keys(line),
            (Strings{"image", "frame", "width", "height", "backend", "detections", "time_us"}));
  EXPECT_EQ(line["image"], "scene.png");
  EXPECT_EQ(line["frame"], 0);
  EXPECT_EQ(line["width"], 640);
  EXPECT_EQ(line["height"], 480);
  EXPECT_EQ(Keys(line["time_us"]), (Strings{"threshold", "binarize", "label", "tree", "decode",
                                            "vertices", "pose", "total"}));
  ASSERT_EQ(line["detections"].size(), 3u);
  for (const Json& marker : line["detections"]) {
    EXPECT_EQ(Keys(marker), (Strings{"family", "id", "center", "corners", "vertices", "pose"}));
    EXPECT_EQ(Keys(marker["pose"]), (Strings{"R", "t", "rms_px", "covariance", "alternative"}));
    EXPECT_EQ(marker["corners"].size(), 4u);
    ASSERT_EQ(marker["pose"]["covariance"].size(), 6u);
    for (const Json& row : marker["pose"]["covariance"]) EXPECT_EQ(row.size(), 6u);
    const Json& alternative = marker["pose"]["alternative"];
    if (!alternative.is_null()) {
      EXPECT_EQ(Keys(alternative), (Strings{"R", "t", "rms_px"}));
    }
  }
}

TEST_F(CliTest, JsonAgreesWithTheGroundTruth) {
  RenderScene();
  const Json line = Detect("--camera cam.yaml --tag-size 0.05 scene.png");
  const Json truth = Json::parse(ReadFile(folder_ / "truth.json"));
  EXPECT_EQ(Keys(truth), (Strings{"image", "frame", "width", "height", "detections"}));
  ASSERT_EQ(line["detections"].size(), truth["detections"].size());
  for (size_t i = 0; i < truth["detections"].size(); ++i) {
    const Json& is = line["detections"][i];
    const Json& must = truth["detections"][i];
    EXPECT_EQ(is["family"], must["family"]);
    EXPECT_EQ(is["id"], must["id"]);
    EXPECT_LT(Distance(is["center"], must["center"]), 0.1);
    for (size_t k = 0; k < 4; ++k) {
      EXPECT_LT(Distance(is["corners"][k], must["corners"][k]), 0.5) << is["id"] << " corner " << k;
    }
    ASSERT_EQ(is["vertices"].size(), must["vertices"].size());
    for (size_t k = 0; k < must["vertices"].size(); ++k) {
      EXPECT_LT(Distance(is["vertices"][k], must["vertices"][k]), 0.1)
          << is["id"] << " vertex " << k;
    }
    EXPECT_LT(Distance(is["pose"]["t"], must["pose"]["t"]), 0.002) << is["id"];
    for (size_t row = 0; row < 3; ++row) {
      EXPECT_LT(Distance(is["pose"]["R"][row], must["pose"]["R"][row]), 0.02) << is["id"];
    }
    EXPECT_LT(is["pose"]["rms_px"].get<double>(), 0.2);
  }
}

TEST_F(CliTest, PoseNeedsCameraAndTagSize) {
  RenderScene();
  for (const char* arguments :
       {"scene.png", "--tag-size 0.05 scene.png", "--camera cam.yaml scene.png"}) {
    const Json line = Detect(arguments);
    ASSERT_EQ(line["detections"].size(), 3u) << arguments;
    for (const Json& marker : line["detections"])
      EXPECT_TRUE(marker["pose"].is_null()) << arguments;
  }
}

TEST_F(CliTest, OutputIsDeterministicApartFromTheTime) {
  RenderScene();
  const std::string arguments = "--camera cam.yaml --tag-size 0.05 scene.png";
  Json first = Detect(arguments);
  Json second = Detect(arguments);
  first.erase("time_us");
  second.erase("time_us");
  EXPECT_EQ(first.dump(), second.dump());
  const std::string image = ReadFile(folder_ / "scene.png");
  RenderScene();
  EXPECT_EQ(ReadFile(folder_ / "scene.png"), image);
}

TEST_F(CliTest, RegionOfInterestKeepsFullFrameCoordinates) {
  RenderScene();
  const Json all = Detect("scene.png");
  const Json part = Detect("--roi 340,160,280,290 scene.png");
  ASSERT_EQ(part["detections"].size(), 1u);
  EXPECT_EQ(part["detections"][0]["id"], 278);
  EXPECT_LT(Distance(part["detections"][0]["center"], all["detections"][2]["center"]), 0.1);
  ExpectComplaint("detect --roi 600,400,100,100 scene.png", 1, {"scene.png"});
}

TEST_F(CliTest, CsvHasARowADetection) {
  RenderScene();
  fs::copy_file(folder_ / "scene.png", folder_ / "a,b.png");
  const Outcome outcome =
      Run("detect --format csv --camera cam.yaml --tag-size 0.05 scene.png 'a,b.png'");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Strings lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[0].compare(0, 38, "image,frame,family,id,center_x,center_"), 0);
  const auto commas = std::count(lines[0].begin(), lines[0].end(), ',');
  EXPECT_EQ(lines[1].compare(0, 18, "scene.png,0,3x3,1,"), 0) << lines[1];
  EXPECT_EQ(std::count(lines[1].begin(), lines[1].end(), ','), commas);
  EXPECT_EQ(lines[6].compare(0, 20, "\"a,b.png\",0,4x4,278,"), 0) << lines[6];
  EXPECT_EQ(std::count(lines[6].begin(), lines[6].end(), ','), commas + 1);
  const Strings without = Lines(Run("detect --format csv scene.png").out);
  ASSERT_EQ(without.size(), 4u);
  EXPECT_EQ(std::count(without[1].begin(), without[1].end(), ','), commas);
}

TEST_F(CliTest, TextNamesEachMarker) {
  RenderScene();
  const Outcome outcome = Run("detect --camera cam.yaml --tag-size 0.05 scene.png");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Strings lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 4u) << outcome.out;
  EXPECT_EQ(lines[0], "scene.png: 640x480, 3 markers");
  EXPECT_NE(lines[3].find("4x4 278"), std::string::npos) << lines[3];
  EXPECT_NE(lines[3].find(" m  tilt "), std::string::npos) << lines[3];
}

TEST_F(CliTest, FolderIsReadInOrder) {
  RenderScene();
  for (const char* name : {"b.png", "a.png", "c.png"}) {
    fs::copy_file(folder_ / "scene.png", folder_ / "in" / name);
  }
  WriteFile(folder_ / "in" / "readme.txt", "no image\n");
  const Outcome outcome = Run("detect --format json in");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Strings lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(Json::parse(lines[0])["image"], "in/a.png");
  EXPECT_EQ(Json::parse(lines[1])["image"], "in/b.png");
  EXPECT_EQ(Json::parse(lines[2])["image"], "in/c.png");
}

TEST_F(CliTest, VideoHasALineAFrame) {
  RenderScene();
  const cv::Mat scene = cv::imread((folder_ / "scene.png").string());
  {
    cv::VideoWriter video((folder_ / "v.avi").string(), cv::CAP_OPENCV_MJPEG,
                          cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30, scene.size());
    ASSERT_TRUE(video.isOpened());
    for (int i = 0; i < 3; ++i)
      video.write(i == 1 ? cv::Mat::zeros(scene.size(), scene.type()) : scene);
  }
  const Outcome outcome = Run("detect --format json --draw drawn scene.png v.avi");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const Strings lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 4u) << outcome.out;
  for (int i = 0; i < 3; ++i) {
    const Json line = Json::parse(lines[1 + static_cast<size_t>(i)]);
    EXPECT_EQ(line["image"], "v.avi");
    EXPECT_EQ(line["frame"], i);
    EXPECT_EQ(line["detections"].size(), i == 1 ? 0u : 3u);
  }
  EXPECT_EQ(Names(folder_ / "drawn"),
            (Strings{"scene.png", "v_000000.png", "v_000001.png", "v_000002.png"}));
  const std::string whole = ReadFile(folder_ / "v.avi");
  WriteFile(folder_ / "cut.avi", whole.substr(0, whole.size() / 2));
  ExpectComplaint("detect cut.avi", 1, {"cut.avi", "of 3 frames"});
}

TEST_F(CliTest, BrokenInputsAreNamedAndTheOthersProcessed) {
  RenderScene();
  const std::string whole = ReadFile(folder_ / "scene.png");
  WriteFile(folder_ / "empty.png", "");
  WriteFile(folder_ / "truncated.png", whole.substr(0, whole.size() / 2));
  WriteFile(folder_ / "text.png", "this is no image\n");
  WriteFile(folder_ / "text.avi", "this is no video\n");
  const Outcome outcome =
      Run("detect --format json scene.png empty.png truncated.png text.png text.avi missing.png in "
          "scene.png");
  EXPECT_EQ(outcome.status, 1);
  const Strings lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 2u) << outcome.out;
  for (const std::string& line : lines) EXPECT_EQ(Json::parse(line)["detections"].size(), 3u);
  const Strings complaints = Lines(outcome.err);
  const Strings broken{"empty.png", "truncated.png", "text.png", "text.avi", "missing.png", "in"};
  ASSERT_EQ(complaints.size(), broken.size()) << outcome.err;
  for (size_t i = 0; i < broken.size(); ++i) {
    const std::string start = "topotag: " + broken[i] + ": ";
    EXPECT_EQ(complaints[i].compare(0, start.size(), start), 0) << complaints[i];
    EXPECT_GT(complaints[i].size(), start.size());
  }
}

TEST_F(CliTest, EveryPixelFormatAndSizeIsRead) {
  RenderScene();
  const cv::Mat gray = cv::imread((folder_ / "scene.png").string(), cv::IMREAD_GRAYSCALE);
  cv::Mat deep;
  gray.convertTo(deep, CV_16U, 257);
  cv::imwrite((folder_ / "deep.png").string(), deep);
  cv::Mat rgba;
  cv::merge(std::vector<cv::Mat>{gray, gray, gray, cv::Mat::zeros(gray.size(), CV_8U)}, rgba);
  cv::imwrite((folder_ / "rgba.png").string(), rgba);
  for (const char* name : {"deep.png", "rgba.png"}) {
    EXPECT_EQ(Detect(name)["detections"], Detect("scene.png")["detections"]) << name;
  }
  cv::imwrite((folder_ / "dot.png").string(), cv::Mat(1, 1, CV_8U, cv::Scalar(255)));
  cv::imwrite((folder_ / "row.png").string(), cv::Mat(1, 500, CV_8U, cv::Scalar(128)));
  cv::imwrite((folder_ / "column.png").string(), cv::Mat(500, 1, CV_8U, cv::Scalar(128)));
  for (const char* name : {"dot.png", "row.png", "column.png"}) {
    EXPECT_EQ(Detect(std::string("--draw drawn --stages stages ") + name)["detections"].size(), 0u);
  }
}

TEST_F(CliTest, WrongUsageIsOneLineAndStatus2) {
  RenderScene();
  WriteFile(folder_ / "bad.yaml", "image_width: 640\nimage_height: 480\n");
  ExpectComplaint("", 2, {"command"});
  ExpectComplaint("frobnicate", 2, {"frobnicate"});
  ExpectComplaint("detect", 2, {"INPUT"});
  ExpectComplaint("detect --frobnicate scene.png", 2, {"--frobnicate"});
  ExpectComplaint("detect --family 9x9 scene.png", 2, {"--family", "9x9"});
  ExpectComplaint("detect --family 3x3,3x3 scene.png", 2, {"--family", "3x3"});
  ExpectComplaint("detect --family '' scene.png", 2, {"--family"});
  ExpectComplaint("detect --backend fpga scene.png", 2, {"--backend", "fpga"});
  ExpectComplaint("detect --preset best scene.png", 2, {"--preset", "best"});
  ExpectComplaint("detect --format xml scene.png", 2, {"--format", "xml", "json"});
  for (const char* size : {"-0.05", "nan", "0", "inf", "5cm", "''"}) {
    ExpectComplaint(std::string("detect --tag-size ") + size + " scene.png", 2, {"--tag-size"});
  }
  for (const char* threads : {"0", "-1", "two", "1.5", "99999999999999999999"}) {
    ExpectComplaint(std::string("detect --threads ") + threads + " scene.png", 2, {"--threads"});
  }
  ExpectComplaint("detect --camera missing.yaml scene.png", 2, {"--camera", "missing.yaml"});
  ExpectComplaint("detect --camera bad.yaml scene.png", 2, {"--camera", "bad.yaml"});
  ExpectComplaint("detect --camera scene.png scene.png", 2, {"--camera", "scene.png"});
  ExpectComplaint("detect --pose exact scene.png", 2, {"--pose", "vertices, photometric"});
  ExpectComplaint("detect --pose guess scene.png", 2, {"--pose", "guess"});
  ExpectComplaint("detect --device 0 scene.png", 2, {"--device", "--backend opencl"});
  ExpectComplaint("detect --device 0 --backend scalar scene.png", 2, {"--device", "opencl"});
  ExpectComplaint("detect --device x --backend opencl scene.png", 2, {"--device", "'x'"});
  ExpectComplaint("detect '' scene.png", 2, {"INPUT"});
  ExpectComplaint("detect --roi 0,0,10 scene.png", 2, {"--roi"});
  ExpectComplaint("detect --roi 0,0,0,10 scene.png", 2, {"--roi"});
  ExpectComplaint("detect --output scene.png scene.png", 2, {"--output", "scene.png"});
  ExpectComplaint("detect camera:first", 2, {"camera:first"});
}

TEST_F(CliTest, BackendThatIsNotThereIsWrongUsage) {
  RenderScene();
  for (const char* backend : {"simd", "opencl"}) {
    const Outcome info = Run("info");
    const bool available =
        info.out.find(std::string(backend) + " ") != std::string::npos &&
        Run(std::string("detect --backend ") + backend + " scene.png").status == 0;
    if (available) continue;
    ExpectComplaint(std::string("detect --backend ") + backend + " scene.png", 2,
                    {"--backend", backend});
  }
  const Outcome unknown =
      Shell(std::string("TOPOTAG_BACKEND=fpga '") + TOPOTAG_CLI + "' detect scene.png");
  EXPECT_EQ(unknown.status, 2);
  EXPECT_NE(unknown.err.find("fpga"), std::string::npos) << unknown.err;
  EXPECT_EQ(unknown.out, "");
}

TEST_F(CliTest, CameraOfAnotherResolutionNamesBothSizes) {
  RenderScene();
  cv::imwrite((folder_ / "small.png").string(), cv::Mat(240, 320, CV_8U, cv::Scalar(90)));
  const Outcome outcome = Run("detect --format json --camera cam.yaml small.png scene.png");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(Lines(outcome.out).size(), 1u);
  ASSERT_EQ(Lines(outcome.err).size(), 1u) << outcome.err;
  for (const char* part : {"small.png", "320x240", "640x480", "cam.yaml"}) {
    EXPECT_NE(outcome.err.find(part), std::string::npos) << part << " in " << outcome.err;
  }
}

TEST_F(CliTest, OutputFileAppearsWhole) {
  RenderScene();
  WriteFile(folder_ / "out", "old");
  const Outcome outcome = Run("detect --format json --output out scene.png");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(Json::parse(ReadFile(folder_ / "out"))["detections"].size(), 3u);
  EXPECT_EQ(Run("detect --output missing/out scene.png").out, "");
  ExpectComplaint("detect --output missing/out scene.png", 1, {"missing/out"});
  ExpectComplaint("detect --output in scene.png", 1, {"in: "});
  ExpectComplaint("detect --output scene.png/out scene.png", 1, {"scene.png/out"});
  ExpectComplaint("detect --draw scene.json scene.png", 1, {"scene.json"});
  ExpectComplaint("detect --stages scene.json/stages scene.png", 1, {"scene.json/stages"});
  ExpectComplaint("detect --output /proc/none/out scene.png", 1, {"/proc/none/out: "});
  ExpectComplaint("detect --draw /proc/none scene.png", 1, {"/proc/none: "});
  ExpectComplaint("detect --output /dev/full scene.png", 1, {"/dev/full: "});
  EXPECT_EQ(Names(folder_),
            (Strings{"cam.yaml", "in", "out", "scene.json", "scene.png", "truth.json"}));
  EXPECT_TRUE(Names(folder_ / "in").empty());
}

TEST_F(CliTest, OutputGoesThroughAPipe) {
  RenderScene();
  const Outcome piped = Shell("mkfifo pipe; cat pipe >copy & '" + std::string(TOPOTAG_CLI) +
                              "' detect --format json --output pipe scene.png; wait");
  EXPECT_EQ(piped.err, "");
  EXPECT_TRUE(fs::is_fifo(folder_ / "pipe"));
  EXPECT_EQ(Json::parse(ReadFile(folder_ / "copy"))["detections"].size(), 3u);
}

TEST_F(CliTest, FullDiskIsAnErrorAndABrokenPipeIsNot) {
  RenderScene();
  const std::string cli = std::string("'") + TOPOTAG_CLI + "'";
  const Outcome full = Shell(cli + " detect scene.png >/dev/full");
  EXPECT_EQ(full.status, 1);
  EXPECT_EQ(Lines(full.err).size(), 1u) << full.err;
  const Outcome broken =
      Shell("{ sleep 0.3; " + cli + " detect scene.png scene.png; echo $? >status; } | true");
  EXPECT_EQ(broken.err, "");
  EXPECT_EQ(ReadFile(folder_ / "status"), "0\n");
}

TEST_F(CliTest, PicturesNeverOverwriteInputsOrEachOther) {
  RenderScene();
  fs::copy_file(folder_ / "scene.png", folder_ / "in" / "scene.png");
  const std::string before = ReadFile(folder_ / "scene.png");
  EXPECT_EQ(Run("detect --draw . --stages stages scene.png in/scene.png").status, 0);
  EXPECT_EQ(ReadFile(folder_ / "scene.png"), before);
  for (const char* name : {"scene_2.png", "scene_3.png"}) {
    const cv::Mat drawn = cv::imread((folder_ / name).string());
    ASSERT_EQ(drawn.size(), cv::Size(640, 480)) << name;
    const cv::Mat plain = cv::imread((folder_ / "scene.png").string());
    EXPECT_GT(cv::norm(drawn, plain, cv::NORM_L1), 1e5) << name;
  }
  Strings expected;
  for (const char* stem : {"scene", "scene_2"}) {
    for (const char* stage :
         {"_1_input", "_2_threshold", "_3_binary", "_4_components", "_5_candidates", "_6_result"}) {
      expected.push_back(stem + std::string(stage) + ".png");
      EXPECT_EQ(cv::imread((folder_ / "stages" / expected.back()).string()).size(),
                cv::Size(640, 480));
    }
  }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(Names(folder_ / "stages"), expected);
}

}  // namespace
}  // namespace topotag
