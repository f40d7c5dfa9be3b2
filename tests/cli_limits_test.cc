// Inputs that are larger than the limit of pixels, too little memory, files that go away during a
// batch: a clear line on stderr, and what can be done is done.

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class CliLimitsTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    RenderScene();
  }
};

constexpr char kTooLarge[] =
    "too large: 640x480 pixels, more than the limit of 307199; --max-pixels raises it";

TEST_F(CliLimitsTest, EveryCommandKeepsToTheLimitOfPixels) {
  const std::string more = " --max-pixels 307200", less = " --max-pixels 307199";
  WriteFile(folder_ / "wall.json", R"({
    "camera": {"width": 64, "height": 48, "fx": 60, "fy": 60, "cx": 32, "cy": 24},
    "background": "scene.png"})");
  const std::pair<const char*, const char*> commands[] = {
      {"detect scene.png", "scene.png: "},
      {"bench --frames 1 scene.png", "scene.png: "},
      {"render wall.json -o new.png", "wall.json: background: scene.png: "},
      {"render scene.json --background scene.png -o new.png", "scene.png: "},
      {"object calibrate --ids 1,46 --family 3x3 --tag-size 0.05 --camera cam.yaml -o b.txt "
       "scene.png scene.png",
       "scene.png: "}};
  for (const auto& [command, subject] : commands) {
    const Outcome outcome = Run(command + more);
    EXPECT_EQ(outcome.status, 0) << command << "\n" << outcome.err;
    const Outcome refused = Run(command + less);
    EXPECT_EQ(refused.status, 1) << command;
    EXPECT_NE(refused.err.find(std::string("topotag: ") + subject), std::string::npos)
        << refused.err;
    EXPECT_NE(refused.err.find(kTooLarge), std::string::npos) << refused.err;
  }
}

TEST_F(CliLimitsTest, SoDoVideos) {
  const cv::Mat scene = cv::imread((folder_ / "scene.png").string());
  cv::VideoWriter video((folder_ / "v.avi").string(), cv::CAP_OPENCV_MJPEG,
                        cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30, scene.size());
  ASSERT_TRUE(video.isOpened());
  video.write(scene);
  video.release();
  EXPECT_EQ(Lines(Run("detect --format json --max-pixels 307200 v.avi").out).size(), 1u);
  ExpectComplaint("detect --max-pixels 307199 v.avi", 1, {"v.avi: ", kTooLarge});
}

// Before a pixel is decoded, or memory asked for: the file is only its header.
TEST_F(CliLimitsTest, TheLimitCanBeRaisedAboveTheUsual) {
  const auto write_header = [&](int side) {
    const std::string size = std::to_string(side);
    WriteFile(folder_ / "large.pgm", "P5 " + size + " " + size + " 255\n");
  };
  write_header(16385);
  ExpectComplaint("detect large.pgm", 1, {"16385x16385", "268435456; --max-pixels raises it"});
  ExpectComplaint("detect --max-pixels 268468225 large.pgm", 1, {"truncated"});
  write_header(32767);
  ExpectComplaint("detect --max-pixels 1073610756 large.pgm", 1, {"at most 32766 on a side"});
}

TEST_F(CliLimitsTest, WrongLimitsOfPixels) {
  for (const std::string value : {"0", "1073610757", "-1", "1e6", "x", "''"}) {
    for (const std::string command :
         {"detect scene.png", "bench scene.png", "render scene.json -o new.png"}) {
      ExpectComplaint(command + " --max-pixels=" + value, 2, {"--max-pixels"});
    }
  }
}

// From too little for a large picture up to enough: a line that says so, never a crash, and a
// picture is written wholly or not at all.
TEST_F(CliLimitsTest, TooLittleMemory) {
  constexpr int kStep = 32768;  // KiB
  const auto limited = [&](int kib, const std::string& arguments) {
    return Shell("ulimit -v " + std::to_string(kib) + "; '" + TOPOTAG_CLI + "' " + arguments);
  };
  const std::string small = "detect --threads 1 scene.png";
  int kib = kStep;
  while (kib < 64 * kStep && limited(kib, small).status != 0) kib += kStep;
  if (kib >= 64 * kStep) GTEST_SKIP() << "2 GiB of addresses do not do, as with a sanitizer";
  WriteFile(folder_ / "large.pgm", "P5 6000 6000 255\n" + std::string(36000000, 'Z'));
  int failed = 0;
  for (Outcome outcome{1, "", ""}; outcome.status != 0; kib += kStep) {
    ASSERT_LT(kib, 128 * kStep);
    outcome = limited(kib, "detect --threads 1 --far on --draw in large.pgm");
    const bool is_written = !Names(folder_ / "in").empty();
    EXPECT_EQ(is_written, outcome.status == 0) << kib;
    if (outcome.status == 0) break;
    ++failed;
    EXPECT_EQ(outcome.status, 1) << kib << "\n" << outcome.err;
    ASSERT_EQ(Lines(outcome.err).size(), 1u) << outcome.err;
    EXPECT_EQ(outcome.err.compare(0, 20, "topotag: large.pgm: "), 0) << outcome.err;
    EXPECT_NE(outcome.err.find("not enough memory"), std::string::npos) << outcome.err;
  }
  EXPECT_GT(failed, 0);
  EXPECT_FALSE(cv::imread((folder_ / "in" / "large.png").string()).empty());
}

// A real one, of 64 KiB: what is complete stays, nothing else is left of what did not fit.
TEST_F(CliLimitsTest, AFileSystemThatFillsUp) {
  const auto on_small_disk = [&](const std::string& line) {
    return Shell("unshare --map-root-user --mount sh -c 'mount -t tmpfs -o size=64k none in && { " +
                 line + "\n}; status=$?; cp -a in/. kept; exit $status'");
  };
  if (on_small_disk("true").status != 0) GTEST_SKIP() << "no file system can be mounted here";
  const std::string cli = TOPOTAG_CLI;
  fs::create_directory(folder_ / "kept");
  const std::pair<const char*, const char*> commands[] = {
      {"render scene.json -o in/new.png", "in/new.png"},
      {"detect --draw in scene.png", "in/scene.png"},
      {"detect --stages in scene.png", "in/scene_1_input.png"},
      {"object grid --rows 50 --columns 50 --tag-size 0.03 --pitch 0.04 --family 5x5 -o in/b.txt",
       "in/b.txt"}};
  for (const auto& [command, file] : commands) {
    const Outcome outcome = on_small_disk(cli + " " + command);
    EXPECT_EQ(outcome.status, 1) << command;
    EXPECT_EQ(outcome.err,
              std::string("topotag: ") + file + ": cannot write: No space left on device\n");
    EXPECT_EQ(Names(folder_ / "kept"), Strings()) << command;
  }
  const Outcome sheet =
      on_small_disk(cli + " generate --family 5x5 --ids 0-99 --format svg -o in/");
  EXPECT_EQ(sheet.status, 1);
  EXPECT_NE(sheet.err.find("No space left on device"), std::string::npos) << sheet.err;
  const Strings kept = Names(folder_ / "kept");
  EXPECT_GT(kept.size(), 3u);
  for (const std::string& name : kept) {
    const std::string text = ReadFile(folder_ / "kept" / name);
    EXPECT_NE(text.find("</svg>"), std::string::npos) << name;
  }
}

// A pipe that nobody reads from holds the command up until its inputs have gone.
TEST_F(CliLimitsTest, InputsThatGoAwayDuringABatch) {
  constexpr int kFiles = 400;
  for (const std::string gone : {"in/399.png", "in"}) {
    for (int i = 0; i < kFiles; ++i) {
      fs::create_directory(folder_ / "in");
      fs::copy_file(folder_ / "scene.png",
                    folder_ / "in" / (std::to_string(1000 + i).substr(1) + ".png"),
                    fs::copy_options::overwrite_existing);
    }
    const Outcome outcome = Shell("{ '" + std::string(TOPOTAG_CLI) +
                                  "' detect --format json in; echo $? >status; } | "
                                  "{ read -r first; rm -r " +
                                  gone + "; wc -l; }");
    EXPECT_EQ(ReadFile(folder_ / "status"), "1\n");
    const Strings complaints = Lines(outcome.err);
    const size_t done = 1 + std::stoul(outcome.out);
    EXPECT_EQ(done + complaints.size(), size_t{kFiles});
    EXPECT_EQ(gone == "in", complaints.size() > 1);
    ASSERT_FALSE(complaints.empty());
    EXPECT_EQ(complaints.back(),
              "topotag: in/399.png: cannot read image: No such file or directory");
  }
}

TEST_F(CliLimitsTest, AFolderOfPicturesThatGoesAway) {
  Strings inputs(300, "scene.png");
  std::string list;
  for (const std::string& input : inputs) list += " " + input;
  const Outcome outcome = Shell("{ '" + std::string(TOPOTAG_CLI) +
                                "' detect --format json --draw "
                                "drawn" +
                                list +
                                "; echo $? >status; } | "
                                "{ read -r first; rm -r drawn; wc -l; }");
  EXPECT_EQ(ReadFile(folder_ / "status"), "1\n");
  ASSERT_EQ(Lines(outcome.err).size(), 1u) << outcome.err;
  EXPECT_EQ(outcome.err.compare(0, 20, "topotag: drawn/scene"), 0) << outcome.err;
  EXPECT_NE(outcome.err.find("No such file or directory"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(folder_ / "drawn"));
}

}  // namespace
}  // namespace topotag
