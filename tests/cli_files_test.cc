// Files that are read and files that are written: none of the first is lost, none that the user did
// not name is opened, and what a file's name or a video's header says is not taken for more than it
// is.

#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class CliFilesTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    RenderScene();
  }

  void MakeVideo(const std::string& name, int frames) const {
    const cv::Mat scene = cv::imread((folder_ / "scene.png").string());
    cv::VideoWriter video((folder_ / name).string(), cv::CAP_FFMPEG,
                          cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 30, scene.size());
    ASSERT_TRUE(video.isOpened()) << name;
    for (int i = 0; i < frames; ++i) video.write(scene);
  }
};

TEST_F(CliFilesTest, InputsAreNotWrittenOver) {
  ASSERT_EQ(Run("object grid --rows 1 --columns 2 --tag-size 0.03 --pitch 0.04 -o b.txt").status,
            0);
  const auto all = [this] {
    std::string bytes;
    for (const char* name : {"scene.png", "scene.json", "cam.yaml", "b.txt"}) {
      bytes += ReadFile(folder_ / name);
    }
    return bytes;
  };
  const std::string before = all();
  const std::string calibrate = "object calibrate --camera cam.yaml --object b.txt -o ";
  for (const std::string file : {"scene.png", "cam.yaml", "b.txt", "in/../cam.yaml"}) {
    ExpectComplaint("detect --camera cam.yaml --object b.txt --output " + file + " scene.png", 2,
                    {"--output: " + file + " is an input"});
    ExpectComplaint(calibrate + file + " scene.png", 2, {"-o: " + file + " is an input"});
  }
  ExpectComplaint("render scene.json -o new.png --truth scene.json", 2, {"--truth: scene.json"});
  ExpectComplaint("render --camera cam.yaml --background scene.png -o scene.png", 2,
                  {"-o: scene.png"});
  ExpectComplaint("render --camera cam.yaml -o new.png --write-camera cam.yaml", 2,
                  {"--write-camera: cam.yaml"});
  WriteFile(folder_ / "named.json",
            R"({"camera": "cam.yaml", "background": "scene.png", "markers": []})");
  ExpectComplaint("render named.json -o scene.png", 2, {"-o: scene.png is an input"});
  ExpectComplaint("render named.json -o new.png --truth cam.yaml", 2, {"--truth: cam.yaml"});
  fs::copy_file(folder_ / "b.txt", folder_ / "polygon.svg");
  ExpectComplaint("generate --family 3x3 --id 1 --outer polygon.svg -o polygon.svg", 2, {});
  EXPECT_TRUE(ReadFile(folder_ / "polygon.svg") == ReadFile(folder_ / "b.txt"));
  EXPECT_TRUE(all() == before);
}

TEST_F(CliFilesTest, NorIsOneOutputByAnother) {
  ExpectComplaint("render scene.json -o new.png --truth in/../new.png", 2,
                  {"--truth: in/../new.png is that of -o, too"});
  ExpectComplaint("render scene.json -o new.png --truth t --write-camera t", 2,
                  {"--write-camera: t is that of --truth, too"});
  EXPECT_FALSE(fs::exists(folder_ / "new.png"));
  EXPECT_EQ(Run("render scene.json -o new.png --truth /dev/null --write-camera cam2.yaml").status,
            0);
  EXPECT_EQ(Run("detect --draw in --output in/scene.png scene.png").status, 0);
  EXPECT_EQ(Names(folder_ / "in"), (Strings{"scene.png", "scene_2.png"}));
  fs::copy_file(folder_ / "scene.png", folder_ / "scene_6_result.png");
  EXPECT_EQ(Run("detect --draw st --stages st scene.png scene_6_result.png").status, 0);
  EXPECT_EQ(Names(folder_ / "st").size(), 14u) << "two pictures and six stages of each";
}

TEST_F(CliFilesTest, AFileThatIsReplacedKeepsItsPermissions) {
  for (const bool exists : {true, false}) {
    const std::string name = exists ? "private" : "new";
    if (exists) {
      WriteFile(folder_ / name, "old");
      fs::permissions(folder_ / name, fs::perms(0600));
    }
    ASSERT_EQ(Shell("umask 022; '" + std::string(TOPOTAG_CLI) + "' detect --output " + name +
                    " scene.png")
                  .status,
              0);
    EXPECT_EQ(fs::status(folder_ / name).permissions(), fs::perms(exists ? 0600 : 0644));
    EXPECT_NE(ReadFile(folder_ / name), "old");
  }
}

// Somebody else's scene must not have any file of this machine read, nor its lines shown.
TEST_F(CliFilesTest, ScenesNameFilesOfTheirOwnFolderOnly) {
  const std::string scene = ReadFile(folder_ / "scene.json");
  WriteFile(folder_ / "secret", "a secret\n");
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = scene;
    text.replace(text.find(from), from.size(), to);
    WriteFile(folder_ / "in" / "s.json", text);
  };
  fs::create_symlink("../secret", folder_ / "in" / "link");
  fs::create_symlink("..", folder_ / "in" / "up");
  fs::create_symlink("loop", folder_ / "in" / "loop");
  for (const std::string& path :
       {(folder_ / "secret").string(), std::string("../secret"), std::string("link"),
        std::string("up/secret"), std::string(300, 'x'), std::string("loop")}) {
    for (const std::string key : {"background", "camera", "outer"}) {
      if (key == "background") with("\"background\": 90", "\"background\": \"" + path + "\"");
      if (key == "camera") {
        WriteFile(folder_ / "in" / "s.json", R"({"markers": [], "camera": ")" + path + "\"}");
      }
      if (key == "outer") with("\"outer\": \"circle\"", "\"outer\": \"" + path + "\"");
      const std::string command = "render in/s.json -o new.png";
      ExpectComplaint(command, 1, {key + ": '" + path + "' is not a file of the scene's folder"});
      EXPECT_EQ(Run(command).err.find("a secret"), std::string::npos);
    }
  }
  // A name is not looked up where the command runs.
  with("\"outer\": \"circle\"", "\"outer\": \"secret\"");
  ExpectComplaint("render in/s.json -o new.png", 1, {"outer: 'in/secret' is not one of"});
  fs::create_directory(folder_ / "in" / "walls");
  fs::copy_file(folder_ / "scene.png", folder_ / "in" / "walls" / "wall.png");
  with("\"background\": 90", "\"background\": \"walls/wall.png\"");
  EXPECT_EQ(Run("render in/s.json -o new.png").status, 0);
}

TEST_F(CliFilesTest, ScenesAreNotNestedWithoutEnd) {
  WriteFile(folder_ / "deep.json", std::string(1000000, '['));
  ExpectComplaint("render deep.json -o new.png", 1, {"deep.json: is nested too deeply"});
}

// Players know the length of such a file, and frames as if they came evenly.
TEST_F(CliFilesTest, AVideoWhoseRateVariesIsWhole) {
  MakeVideo("v.mkv", 5);
  std::string bytes = ReadFile(folder_ / "v.mkv");
  const size_t at = bytes.find("\x44\x89\x88") + 3;  // Duration, of eight bytes
  ASSERT_LT(at, bytes.size());
  char duration[8];
  for (size_t i = 0; i < 8; ++i) duration[7 - i] = bytes[at + i];
  double value = 0;
  std::memcpy(&value, duration, 8);
  value *= 100;
  std::memcpy(duration, &value, 8);
  for (size_t i = 0; i < 8; ++i) bytes[at + i] = duration[7 - i];
  WriteFile(folder_ / "v.mkv", bytes);
  EXPECT_GT(cv::VideoCapture((folder_ / "v.mkv").string()).get(cv::CAP_PROP_FRAME_COUNT), 400);
  const Outcome outcome = Run("detect --format json v.mkv");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(Lines(outcome.out).size(), 5u);
}

TEST_F(CliFilesTest, AVideoOfAnotherSizeThanTheCamerasIsNamedOnce) {
  MakeVideo("v.avi", 5);
  WriteFile(folder_ / "small.json", R"({"camera": {"width": 320, "height": 240, "fx": 300,
    "fy": 300, "cx": 160, "cy": 120}, "markers": []})");
  ASSERT_EQ(Run("render small.json -o small.png --write-camera small.yaml").status, 0);
  const Outcome outcome = Run("detect --format json --camera small.yaml v.avi small.png");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.err,
            "topotag: v.avi: the image is 640x480, the camera file small.yaml is for 320x240\n");
  EXPECT_EQ(Lines(outcome.out).size(), 1u);
  const Outcome calibrate =
      Run("object calibrate --camera small.yaml --ids 1,46 --family 3x3 --tag-size 0.05 -o b.txt "
          "v.avi");
  EXPECT_EQ(calibrate.status, 1);
  EXPECT_EQ(calibrate.err, outcome.err + "topotag: object calibrate: no picture could be used\n");
}

TEST_F(CliFilesTest, APipeIsNoVideo) {
  ASSERT_EQ(Shell("mkfifo v.avi").status, 0);
  ExpectComplaint("detect v.avi", 1, {"v.avi: not a regular file"});
}

TEST_F(CliFilesTest, NamesGiveNoOrdersToATerminal) {
  const std::string name = "a\n\x1b[31m\xc2\x9b.png";
  fs::copy_file(folder_ / "scene.png", folder_ / name);
  const Outcome outcome = Run("detect in/../a*.png missing\x1b.png");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.err, "topotag: missing .png: No such file or directory\n");
  EXPECT_EQ(Lines(outcome.out).size(), 4u) << outcome.out;
  EXPECT_EQ((outcome.out + outcome.err).find('\x1b'), std::string::npos);
  EXPECT_EQ(outcome.out.find('\x9b'), std::string::npos);
}

TEST_F(CliFilesTest, VersionAndHelpToAFullDisk) {
  for (const char* option : {"--version", "--help", "detect --help"}) {
    const Outcome outcome = Shell("'" + std::string(TOPOTAG_CLI) + "' " + option + " >/dev/full");
    EXPECT_EQ(outcome.status, 1) << option;
    EXPECT_NE(outcome.err.find("No space left"), std::string::npos) << option << outcome.err;
  }
}

// As for what a script starts in the background.
TEST_F(CliFilesTest, ASignalThatIsIgnoredStaysIgnored) {
  const Outcome outcome = Shell("trap '' INT; '" + std::string(TOPOTAG_CLI) +
                                "' detect --output out --draw in scene.png scene.png & child=$!; "
                                "for i in 1 2 3 4 5; do kill -INT $child; sleep 0.02; done; "
                                "wait $child");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(folder_ / "out"));
}

}  // namespace
}  // namespace topotag
