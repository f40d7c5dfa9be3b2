// The command bench, run as a user runs it.
#include <gtest/gtest.h>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class CliBenchTest : public CliTest {};

const Strings kStages{"threshold", "binarize", "label", "tree",
                      "decode",    "vertices", "pose",  "total"};

TEST_F(CliBenchTest, JsonHasTheKeysOfTheContractInOrder) {
  RenderScene();
  const Outcome outcome =
      Run("bench --format json --frames 5 --camera cam.yaml --tag-size 0.05 scene.png");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  ASSERT_EQ(Lines(outcome.out).size(), 1u);
  const Json line = Json::parse(outcome.out);
  EXPECT_EQ(Keys(line), (Strings{"image", "width", "height", "results"}));
  EXPECT_EQ(line["image"], "scene.png");
  EXPECT_EQ(line["width"], 640);
  EXPECT_EQ(line["height"], 480);
  ASSERT_FALSE(line["results"].empty());
  EXPECT_EQ(line["results"][0]["backend"], "scalar");
  int scalars = 0;
  for (const Json& result : line["results"]) {
    EXPECT_EQ(Keys(result), (Strings{"backend", "threads", "frames", "stage_us"}));
    EXPECT_EQ(result["frames"], 5);
    EXPECT_EQ(Keys(result["stage_us"]), kStages);
    for (const Json& spread : result["stage_us"]) {
      EXPECT_EQ(Keys(spread), (Strings{"min", "median", "p99"}));
      EXPECT_LE(spread["min"], spread["median"]);
      EXPECT_LE(spread["median"], spread["p99"]);
    }
    EXPECT_GT(result["stage_us"]["total"]["min"], 0);
    EXPECT_GT(result["stage_us"]["pose"]["median"], 0);
    scalars += result["backend"] == "scalar";
  }
  EXPECT_EQ(scalars, 1);
}

TEST_F(CliBenchTest, EachImageIsALine) {
  RenderScene();
  fs::copy_file(folder_ / "scene.png", folder_ / "in" / "a.png");
  fs::copy_file(folder_ / "scene.png", folder_ / "in" / "b.png");
  const Outcome outcome = Run("bench --format json --frames 2 scene.png in");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const Strings lines = Lines(outcome.out);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(Json::parse(lines[0])["image"], "scene.png");
  EXPECT_EQ(Json::parse(lines[1])["image"], "in/a.png");
  EXPECT_EQ(Json::parse(lines[2])["image"], "in/b.png");
}

TEST_F(CliBenchTest, TextNamesTheBackendsThatAreLeftOut) {
  RenderScene();
  const Outcome outcome = Run("bench --frames 3 scene.png");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("scene.png: 640x480"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("scalar, 1 thread, 3 frames, 3 markers"), std::string::npos)
      << outcome.out;
  for (const std::string& stage : kStages) {
    EXPECT_NE(outcome.out.find("    " + stage + " "), std::string::npos) << stage;
  }
  const std::string info = Run("info").out;
  for (const std::string backend : {"simd", "opencl"}) {
    const bool used = outcome.out.find("\n  " + backend) != std::string::npos;
    const bool left_out = outcome.out.find("left out: " + backend) != std::string::npos;
    EXPECT_NE(used, left_out) << backend << "\n" << outcome.out << info;
  }
}

TEST_F(CliBenchTest, OtherImagesAreStillTimedAfterAFailure) {
  RenderScene();
  WriteFile(folder_ / "in" / "bad.png", "no image");
  const Outcome outcome = Run("bench --format json --frames 1 none.png in scene.png");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(Lines(outcome.out).size(), 1u);
  const Strings complaints = Lines(outcome.err);
  ASSERT_EQ(complaints.size(), 2u) << outcome.err;
  EXPECT_EQ(complaints[0].compare(0, 18, "topotag: none.png:"), 0) << outcome.err;
  EXPECT_EQ(complaints[1].compare(0, 20, "topotag: in/bad.png:"), 0) << outcome.err;
}

TEST_F(CliBenchTest, HelpFitsATerminal) {
  const Outcome help = Run("bench --help");
  EXPECT_EQ(help.status, 0);
  EXPECT_GT(Lines(help.out).size(), 8u) << help.out;
  for (const std::string& line : Lines(help.out)) EXPECT_LE(line.size(), 80u) << line;
  EXPECT_EQ(help.err, "");
}

TEST_F(CliBenchTest, RejectsWrongUsage) {
  RenderScene();
  ExpectComplaint("bench", 2, {"IMAGE"});
  ExpectComplaint("bench ''", 2, {"IMAGE"});
  ExpectComplaint("bench --format csv scene.png", 2, {"--format", "csv", "text, json"});
  ExpectComplaint("bench --frames 0 scene.png", 2, {"--frames", "0"});
  ExpectComplaint("bench --frames many scene.png", 2, {"--frames", "many"});
  ExpectComplaint("bench --family 9x9 scene.png", 2, {"--family", "9x9"});
  ExpectComplaint("bench --camera none.yaml scene.png", 2, {"--camera", "none.yaml"});
  ExpectComplaint("bench --tag-size -1 scene.png", 2, {"--tag-size", "-1"});
  ExpectComplaint("bench --tag-size 1e9 scene.png", 2, {"tag size"});
  fs::create_directory(folder_ / "empty");
  ExpectComplaint("bench empty", 1, {"empty"});
}

}  // namespace
}  // namespace topotag
