// Full disks, folders that cannot be written, inputs that end too early, signals: a clear line on
// stderr, and whatever is there under its name is complete.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <thread>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

// A process of the command line, for signals.
class Process {
 public:
  Process(const fs::path& folder, const Strings& arguments) {
    pid_ = fork();
    if (pid_ != 0) return;
    std::vector<char*> line{const_cast<char*>(TOPOTAG_CLI)};
    for (const std::string& argument : arguments) {
      line.push_back(const_cast<char*>(argument.c_str()));
    }
    line.push_back(nullptr);
    const bool ready = chdir(folder.c_str()) == 0 && freopen("out", "w", stdout) != nullptr &&
                       freopen("err", "w", stderr) != nullptr;
    if (ready) execv(TOPOTAG_CLI, line.data());
    _exit(99);
  }
  ~Process() {
    if (pid_ > 0) Wait(SIGKILL);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// @return the exit status, or 128 + the number of the signal that ended it.
  int Wait(int signal) {
    kill(pid_, signal);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }

 private:
  pid_t pid_ = 0;
};

template <typename Condition>
bool WaitUntil(const Condition& condition) {
  for (int i = 0; i < 3000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

class CliFaultTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    RenderScene();
  }

  // Files may grow to this many blocks of 512 bytes only, as on a disk that is nearly full.
  Outcome RunLimited(int blocks, const std::string& arguments) const {
    return Shell("ulimit -f " + std::to_string(blocks) + "; '" + TOPOTAG_CLI + "' " + arguments);
  }
  void ExpectComplaintOf(const Outcome& outcome, const Strings& parts) const {
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    ASSERT_EQ(Lines(outcome.err).size(), 1u) << outcome.err;
    for (const std::string& part : parts) {
      EXPECT_NE(outcome.err.find(part), std::string::npos) << part << " in " << outcome.err;
    }
  }
  // Every line is a whole frame.
  size_t ExpectWholeLines(const std::string& text) const {
    EXPECT_TRUE(text.empty() || text.back() == '\n');
    for (const std::string& line : Lines(text)) {
      Json json;
      EXPECT_NO_THROW(json = Json::parse(line)) << line;
      EXPECT_EQ(json["detections"].size(), 3u);
    }
    return Lines(text).size();
  }
  void MakeVideo(const std::string& name, int api, const char* code, int frames) const {
    const cv::Mat scene = cv::imread((folder_ / "scene.png").string());
    cv::VideoWriter video((folder_ / name).string(), api,
                          cv::VideoWriter::fourcc(code[0], code[1], code[2], code[3]), 30,
                          scene.size());
    ASSERT_TRUE(video.isOpened()) << name;
    for (int i = 0; i < frames; ++i) video.write(scene);
  }
};

// A user's own limit, of which OpenCV tells by an exception.
TEST_F(CliFaultTest, AnImageThatOpenCvRefuses) {
  const Outcome outcome =
      Shell("OPENCV_IO_MAX_IMAGE_WIDTH=100 '" + std::string(TOPOTAG_CLI) + "' detect scene.png");
  ExpectComplaintOf(outcome, {"scene.png: cannot read image: cannot be decoded: ", "WIDTH"});
  EXPECT_EQ(outcome.out, "");
}

TEST_F(CliFaultTest, AFullDisk) {
  const Strings before = Names(folder_);
  const std::string what = "File too large";
  ExpectComplaintOf(RunLimited(1, "detect --draw in scene.png"), {"in/scene.png", what});
  ExpectComplaintOf(RunLimited(1, "detect --stages in scene.png"), {"in/scene_1_input.png", what});
  ExpectComplaintOf(RunLimited(1, "detect --format json --output o.json scene.png"),
                    {"o.json", what});
  ExpectComplaintOf(RunLimited(1, "render scene.json -o new.png"), {"new.png", what});
  for (const std::string format : {"png", "svg", "pdf"}) {
    const std::string arguments = "generate --family 5x5 --id 99 --inner circle --size-mm 400 -o ";
    ExpectComplaintOf(RunLimited(1, arguments + "new." + format), {"new." + format, what});
    ExpectComplaintOf(RunLimited(1, arguments + "in/ --format " + format), {"in/", what});
  }
  ExpectComplaintOf(RunLimited(1,
                               "object grid --rows 9 --columns 9 --tag-size 0.03 --pitch 0.04 "
                               "-o board.txt"),
                    {"board.txt", what});
  EXPECT_EQ(Names(folder_), before);
  EXPECT_EQ(Names(folder_ / "in"), Strings());
}

TEST_F(CliFaultTest, AFullDiskKeepsWhatWasThere) {
  const std::string old = ReadFile(folder_ / "scene.png");
  WriteFile(folder_ / "b.txt", "old");
  ExpectComplaintOf(RunLimited(1, "render scene.json -o scene.png"), {"scene.png"});
  EXPECT_TRUE(ReadFile(folder_ / "scene.png") == old);
  ExpectComplaintOf(RunLimited(1,
                               "object grid --rows 9 --columns 9 --tag-size 0.03 --pitch 0.04 "
                               "-o b.txt"),
                    {"b.txt"});
  EXPECT_EQ(ReadFile(folder_ / "b.txt"), "old");
}

// The pictures that were written before are whole.
TEST_F(CliFaultTest, ADiskThatFillsUp) {
  const auto blocks = static_cast<int>(fs::file_size(folder_ / "scene.png") / 512);
  const Outcome outcome =
      RunLimited(blocks / 2, "generate --family 3x3 --ids 0-3 --size-mm 20 -o in/");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(Names(folder_ / "in").size(), 4u);
  ExpectComplaintOf(RunLimited(blocks / 2, "detect --draw in scene.png"), {"in/scene.png"});
  for (const std::string& name : Names(folder_ / "in")) {
    EXPECT_FALSE(cv::imread((folder_ / "in" / name).string()).empty()) << name;
  }
}

TEST_F(CliFaultTest, DevicesThatAreFull) {
  const std::string cli = std::string("'") + TOPOTAG_CLI + "'";
  ExpectComplaintOf(Shell(cli + " detect --format json scene.png >/dev/full"),
                    {"standard output", "No space left"});
  ExpectComplaint("detect --output /dev/full scene.png", 1, {"/dev/full: ", "No space left"});
  ExpectComplaint("render scene.json -o new.png --truth /dev/full", 1, {"/dev/full: "});
}

// As root, permission bits are no obstacle: paths below a file are.
TEST_F(CliFaultTest, FoldersThatCannotBeWritten) {
  for (const std::string folder : {"cam.yaml", "none/deeper"}) {
    const bool is_file = folder == "cam.yaml";
    if (is_file) {
      ExpectComplaint("detect --draw " + folder + " scene.png", 1, {folder});
      ExpectComplaint("detect --stages " + folder + "/x scene.png", 1, {folder});
      ExpectComplaint("generate --family 3x3 --ids 0-3 -o " + folder + "/x/", 1, {folder});
    }
    ExpectComplaint("detect --output " + folder + "/o.json scene.png", 1, {folder + "/o.json"});
    ExpectComplaint("render scene.json -o " + folder + "/o.png", 1, {folder + "/o.png"});
    ExpectComplaint("render scene.json -o o.png --write-camera " + folder + "/c.yaml", 1,
                    {folder + "/c.yaml"});
    ExpectComplaint("generate --family 3x3 --id 1 -o " + folder + "/o.pdf", 1, {folder + "/o.pdf"});
    ExpectComplaint(
        "object rhombicuboctahedron --tag-size 0.03 --edge 0.04 -o " + folder + "/b.txt", 1,
        {folder + "/b.txt"});
    ExpectComplaint("object calibrate --ids 0-1 --tag-size 0.05 --camera cam.yaml -o " + folder +
                        "/b.txt scene.png",
                    1, {});
  }
}

TEST_F(CliFaultTest, TruncatedImages) {
  const cv::Mat scene = cv::imread((folder_ / "scene.png").string());
  for (const std::string extension : {".png", ".jpg", ".bmp", ".tif", ".webp", ".ppm"}) {
    const std::string whole = "whole" + extension, part = "part" + extension;
    cv::imwrite((folder_ / whole).string(), scene);
    const std::string bytes = ReadFile(folder_ / whole);
    WriteFile(folder_ / part, bytes.substr(0, bytes.size() * 3 / 4));
    const Outcome outcome = Run("detect --format json " + part + " scene.png");
    ExpectComplaintOf(outcome, {part, "truncated"});
    EXPECT_EQ(ExpectWholeLines(outcome.out), 1u) << "the other one is processed";
  }
}

TEST_F(CliFaultTest, VideosThatEndInTheMiddleOfAFrame) {
  struct Kind {
    std::string name;
    int api;
    const char* code;
  };
  for (const Kind& kind :
       {Kind{"v.avi", cv::CAP_OPENCV_MJPEG, "MJPG"}, Kind{"w.avi", cv::CAP_FFMPEG, "MJPG"},
        Kind{"v.mkv", cv::CAP_FFMPEG, "MJPG"}, Kind{"v.mp4", cv::CAP_FFMPEG, "mp4v"}}) {
    MakeVideo(kind.name, kind.api, kind.code, 20);
    const Outcome all = Run("detect --format json " + kind.name);
    EXPECT_EQ(all.status, 0) << all.err;
    EXPECT_EQ(Lines(all.out).size(), 20u);
    const std::string bytes = ReadFile(folder_ / kind.name);
    for (const double part : {0.97, 0.5}) {
      WriteFile(folder_ / ("cut-" + kind.name),
                bytes.substr(0, static_cast<size_t>(part * static_cast<double>(bytes.size()))));
      const Outcome outcome = Run("detect --format json cut-" + kind.name + " scene.png");
      const bool is_readable = kind.name != "v.mp4";  // its index is at its end
      ExpectComplaintOf(outcome,
                        {"cut-" + kind.name, is_readable ? "is cut off" : "not a readable"});
      const size_t lines = ExpectWholeLines(outcome.out);
      if (!is_readable) {
        EXPECT_EQ(lines, 1u);
        continue;
      }
      EXPECT_GE(lines, part > 0.9 ? 19u : 8u) << kind.name;
      EXPECT_LE(lines, part > 0.9 ? 20u : 12u) << kind.name;
    }
  }
}

TEST_F(CliFaultTest, SignalsEndABatch) {
  Strings arguments{"detect", "--format", "json", "--draw", "drawn"};
  for (int i = 0; i < 3000; ++i) arguments.push_back("scene.png");
  for (const int signal : {SIGINT, SIGTERM}) {
    for (const char* left : {"drawn", "out", "err"}) fs::remove_all(folder_ / left);
    Process process(folder_, arguments);
    ASSERT_TRUE(WaitUntil([&] { return Lines(ReadFile(folder_ / "out")).size() > 3; }));
    EXPECT_EQ(process.Wait(signal), 128 + signal);
    const std::string err = ReadFile(folder_ / "err");
    EXPECT_EQ(err, "topotag: interrupted after scene.png\n");
    const size_t frames = ExpectWholeLines(ReadFile(folder_ / "out"));
    EXPECT_GT(frames, 3u);
    EXPECT_LT(frames, 3000u);
    const Strings pictures = Names(folder_ / "drawn");
    EXPECT_EQ(pictures.size(), frames) << "one for each, and nothing else";
    for (const std::string& name : pictures) {
      EXPECT_FALSE(cv::imread((folder_ / "drawn" / name).string()).empty()) << name;
    }
  }
}

// Even one that cannot be caught leaves nothing under the name, nor a temporary file.
TEST_F(CliFaultTest, SignalsLeaveNoHalfOfAFile) {
  Strings detect{"detect", "--output", "o.json", "--draw", "drawn"};
  for (int i = 0; i < 3000; ++i) detect.push_back("scene.png");
  const Strings generate{"generate", "--family", "4x4", "--ids", "0-9999",
                         "--format", "pdf",      "-o",  "drawn/"};
  WriteFile(folder_ / "o.json", "old");
  for (const Strings& arguments : {detect, generate}) {
    for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
      fs::remove_all(folder_ / "drawn");
      Process process(folder_, arguments);
      ASSERT_TRUE(WaitUntil(
          [&] { return fs::exists(folder_ / "drawn") && Names(folder_ / "drawn").size() > 3; }));
      EXPECT_EQ(process.Wait(signal), 128 + signal);
      EXPECT_EQ(ReadFile(folder_ / "o.json"), "old");
      for (const fs::path& folder : {folder_, folder_ / "drawn"}) {
        for (const std::string& name : Names(folder)) {
          EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
        }
      }
      for (const auto& file : fs::directory_iterator(folder_ / "drawn")) {
        const std::string bytes = ReadFile(file.path());
        const std::string end =
            file.path().extension() == ".pdf" ? "%%EOF\n" : "IEND\xAE\x42\x60\x82";
        EXPECT_EQ(bytes.substr(std::max(bytes.size(), end.size()) - end.size()), end)
            << file.path();
      }
    }
  }
}

}  // namespace
}  // namespace topotag
