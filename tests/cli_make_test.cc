// The commands generate, render and info, run as a user runs them.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class CliMakeTest : public CliTest {};

TEST_F(CliMakeTest, GeneratedMarkersAreFound) {
  WriteFile(folder_ / "house.txt", "-10 -9\n0 -14\n10 -9\n10 10\n-10 10\n");
  const std::string outers[] = {"square", "circle", "butterfly", "house.txt"};
  const std::string inners[] = {"square", "circle", "hexagon", "square"};
  for (size_t i = 0; i < 4; ++i) {
    const Outcome made =
        Run("generate --family 4x4 --id " + std::to_string(8390 + i) + " --outer " + outers[i] +
            " --inner " + inners[i] + " --margin 2 --dpi 120 -o m.png");
    ASSERT_EQ(made.status, 0) << made.err;
    const Json line = Detect("m.png");
    ASSERT_EQ(line["detections"].size(), 1u) << outers[i];
    EXPECT_EQ(line["detections"][0]["family"], "4x4");
    EXPECT_EQ(line["detections"][0]["id"], 8390 + i);
  }
}

TEST_F(CliMakeTest, GenerateWritesFoldersAndSheets) {
  EXPECT_EQ(Run("generate --family 3x3 --ids 0,7-8,127 --dpi 60 -o made/").status, 0);
  EXPECT_EQ(Names(folder_ / "made"),
            (Strings{"3x3_000.png", "3x3_007.png", "3x3_008.png", "3x3_127.png"}));
  EXPECT_EQ(Run("generate --family 4x4 --id 5 --format svg -o in").status, 0);
  EXPECT_EQ(Names(folder_ / "in"), Strings{"4x4_00005.svg"});
  EXPECT_EQ(Run("generate --family 3x3 --ids 0-5 --page letter -o sheet.pdf").status, 0);
  EXPECT_EQ(ReadFile(folder_ / "sheet.pdf").compare(0, 5, "%PDF-"), 0);
  EXPECT_EQ(Run("generate --family 3x3 --ids 3-8 --dpi 150 -o sheet.png").status, 0);
  const Json sheet = Detect("sheet.png");
  ASSERT_EQ(sheet["detections"].size(), 6u);
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(sheet["detections"][i]["id"], 3 + i);
}

TEST_F(CliMakeTest, GenerateRejectsWrongUsage) {
  const std::string four = "generate --family 4x4 ";
  ExpectComplaint(four + "--id 16384 -o m.png", 2, {"--id", "16384", "16383"});
  ExpectComplaint(four + "--ids 16380-16390 -o m.pdf", 2, {"--ids", "16390", "16383"});
  ExpectComplaint(four + "--ids 9-3 -o m.pdf", 2, {"--ids", "9-3"});
  ExpectComplaint(four + "--ids 1,,2 -o m.pdf", 2, {"--ids"});
  ExpectComplaint(four + "--id -1 -o m.png", 2, {"--id", "-1"});
  ExpectComplaint("generate --family 8x8 --ids 0-4611686018427387903 -o m/", 2, {"--ids"});
  ExpectComplaint("generate --family 2x2 --id 1 -o m.png", 2, {"--family", "2x2"});
  ExpectComplaint("generate --id 1 -o m.png", 2, {"--family"});
  ExpectComplaint(four + "-o m.png", 2, {"--id"});
  ExpectComplaint(four + "--id 1 --ids 1-2 -o m.png", 2, {"--id"});
  ExpectComplaint(four + "--id 1", 2, {"--output"});
  ExpectComplaint(four + "--id 1 -o m.bmp", 2, {"m.bmp"});
  ExpectComplaint(four + "--id 1 --inner star -o m.png", 2, {"--inner", "star"});
  ExpectComplaint(four + "--id 1 --outer star -o m.png", 2, {"--outer", "star"});
  ExpectComplaint(four + "--id 1 --frame -1 -o m.png", 2, {"--frame"});
  ExpectComplaint(four + "--id 1 --margin nan -o m.png", 2, {"--margin"});
  ExpectComplaint(four + "--id 1 --size-mm 0 -o m.png", 2, {"--size-mm"});
  ExpectComplaint(four + "--id 1 --dpi x -o m.png", 2, {"--dpi"});
  ExpectComplaint(four + "--ids 1-2 --page a9 -o m.pdf", 2, {"--page", "a9"});
  ExpectComplaint(four + "--ids 1-2 --size-mm 500 -o m.pdf", 2, {"does not fit"});
  ExpectComplaint(four + "--id 1 --outer /dev/zero -o m.png", 2, {"--outer", "/dev/zero"});
  ExpectComplaint(four + "--id 1 -o missing/m.png", 1, {"missing/m.png"});
  ExpectComplaint(four + "--id 1 -o /proc/none.png", 1, {"/proc/none.png: "});
  ExpectComplaint(four + "--ids 1-2 -o /proc/none/", 1, {"/proc/none/: "});
  EXPECT_EQ(Names(folder_), Strings{"in"});
}

TEST_F(CliMakeTest, NothingButAFileIsOverwritten) {
  RenderScene();
  Shell("mkfifo pipe pipe.png pipe.pdf");
  fs::create_directories(folder_ / "made" / "4x4_00001.png");
  const std::string marker = "generate --family 4x4 --id 1 -o ";
  ExpectComplaint(marker + "pipe.pdf", 1, {"pipe.pdf: ", "not a regular file"});
  ExpectComplaint(marker + "made", 1, {"made/4x4_00001.png: ", "Is a directory"});
  const std::string render = "render scene.json -o ";
  ExpectComplaint(render + "pipe.png", 1, {"pipe.png: ", "not a regular file"});
  ExpectComplaint(render + "made/x.png --write-camera pipe", 1, {"pipe: ", "not a regular file"});
  ExpectComplaint(render + "made/x.png --truth in", 1, {"in: ", "Is a directory"});
  for (const char* name : {"pipe", "pipe.png", "pipe.pdf"}) {
    EXPECT_TRUE(fs::is_fifo(folder_ / name)) << name;
  }
  EXPECT_EQ(Names(folder_ / "made"), (Strings{"4x4_00001.png", "x.png"}));
}

TEST_F(CliMakeTest, RenderWithoutASceneFile) {
  RenderScene();
  const Outcome made =
      Run("render --camera cam.yaml --tag-size 0.05 --marker 4x4:278 --pose -0.06,0,0.3,0.3,0,0 "
          "--marker 3x3:5 --pose 0.06,0,0.3,0,0.3,0 --noise 0 -o quick.png");
  ASSERT_EQ(made.status, 0) << made.err;
  const Json line = Detect("quick.png");
  ASSERT_EQ(line["detections"].size(), 2u);
  EXPECT_EQ(line["detections"][0]["id"], 5);
  EXPECT_EQ(line["detections"][1]["id"], 278);
  const std::string render = "render -o x.png --camera cam.yaml --tag-size 0.05 ";
  ExpectComplaint(render + "--marker 4x4:278", 2, {"--pose"});
  ExpectComplaint(render + "--marker 4x4 --pose 0,0,1,0,0,0", 2, {"--marker", "4x4"});
  ExpectComplaint(render + "--marker 4x4:99999 --pose 0,0,1,0,0,0", 2, {"--marker", "16383"});
  ExpectComplaint(render + "--marker 4x4:1 --pose 0,0,1", 2, {"--pose"});
  ExpectComplaint(render + "--marker 4x4:1 --pose 0,0,-1,0,0,0", 2, {"camera"});
  ExpectComplaint(render + "scene.json", 2, {"--camera"});
  ExpectComplaint("render -o x.png", 2, {"--camera"});
  ExpectComplaint("render scene.json --blur -1 -o x.png", 2, {"--blur"});
  ExpectComplaint("render scene.json --background none.png -o x.png", 1, {"none.png"});
  ExpectComplaint("render scene.json -o missing/x.png", 1, {"missing/x.png"});
  EXPECT_FALSE(fs::exists(folder_ / "x.png"));
}

TEST_F(CliMakeTest, SceneErrorsNameFileMarkerAndKey) {
  const std::string camera =
      R"("camera": {"width": 320, "height": 240, "fx": 300, "fy": 300, "cx": 160, "cy": 120})";
  const std::string marker = R"("family": "4x4", "id": 278, "size": 0.05, "t": [0, 0, 0.3])";
  const auto expect = [&](const std::string& text, const Strings& parts) {
    WriteFile(folder_ / "s.json", text);
    Strings all = parts;
    all.push_back("s.json");
    ExpectComplaint("render s.json -o x.png", 1, all);
  };
  const auto with = [&](const std::string& second) {
    return "{" + camera + R"(, "markers": [{)" + marker + "}, {" + second + "}]}";
  };
  ExpectComplaint("render missing.json -o x.png", 1, {"missing.json", "No such file"});
  ExpectComplaint("render /dev/zero -o x.png", 1, {"/dev/zero", "not a regular file"});
  expect("", {"line 1"});
  expect("{ nonsense", {"line 1"});
  expect("[]", {"object"});
  expect("{}", {"camera"});
  expect(R"({"camera": "none.yaml"})", {"camera", "none.yaml"});
  expect(R"({"camera": {"width": 320}})", {"camera", "height"});
  expect(R"({"camera": 5})", {"camera"});
  expect("{" + camera + R"(, "fog": 1})", {"fog"});
  expect("{" + camera + R"(, "blur": "soft"})", {"blur"});
  expect("{" + camera + R"(, "seed": -1})", {"seed"});
  expect("{" + camera + R"(, "background": "none.png"})", {"background", "none.png"});
  expect("{" + camera + R"(, "markers": {}})", {"markers"});
  expect(with(""), {"marker 1", "family"});
  expect(with(marker + R"(, "colour": 1)"), {"marker 1", "colour"});
  expect(with(R"("family": "9x9")"), {"marker 1", "family", "9x9"});
  expect(with(R"("family": "3x3", "id": 128)"), {"marker 1", "id", "127"});
  expect(with(R"("family": "3x3", "id": 1.5)"), {"marker 1", "id"});
  expect(with(R"("family": "3x3", "id": 1, "size": -1)"), {"marker 1", "size"});
  expect(with(R"("family": "3x3", "id": 1, "size": 1, "t": [0, 0])"), {"marker 1", "t"});
  expect(with(marker + R"(, "inner": "star")"), {"marker 1", "inner", "star"});
  expect(with(marker + R"(, "outer": "star")"), {"marker 1", "outer", "star"});
  expect(with(marker + R"(, "rvec": [0, 0, "a"])"), {"marker 1", "rvec"});
  expect(with(marker + R"(, "R": [[1, 0, 0], [0, 1, 0], [0, 0, 2]])"), {"marker 1", "R"});
  EXPECT_FALSE(fs::exists(folder_ / "x.png"));
}

TEST_F(CliMakeTest, SceneConditionsAreRendered) {
  const std::string scene = R"({"camera": {"width": 320, "height": 240, "fx": 300, "fy": 300,
      "cx": 160, "cy": 120}, "noise": 0, "markers": [{"family": "4x4", "id": 278, "size": 0.05,
      "t": [0, 0, 0.2], "velocity": [0.1, 0, 0], "angular_velocity": [0, 0, 1], "growth": 0.1}])";
  WriteFile(folder_ / "plain.json", scene + "}");
  const std::string conditions[] = {
      R"("exposure": 0.01)",
      R"("row_time": 1e-4)",
      R"("lighting": {"gain": 0.8})",
      R"("lighting": {"gradient": [0.001, 0]})",
      R"("lighting": {"vignetting": 0.5})",
      R"("lighting": {"shadow": {"point": [160, 100], "angle": 1, "penumbra": 3}})",
      R"("lighting": {"highlights": [{"center": [150, 100]}]})",
      R"("occluders": [{"outline": [[0, 0], [50, 0], [0, 50]]}])",
      R"("occluders": [{"outline": [[0, 0], [2, 0], [0, 2]], "level": 200, "marker": 0}])"};
  ASSERT_EQ(Run("render plain.json -o plain.pgm").status, 0);
  Strings pictures{ReadFile(folder_ / "plain.pgm")};
  for (const std::string& condition : conditions) {
    WriteFile(folder_ / "s.json", scene + ", " + condition + "}");
    const Outcome made = Run("render s.json -o s.pgm");
    ASSERT_EQ(made.status, 0) << made.err;
    pictures.push_back(ReadFile(folder_ / "s.pgm"));
  }
  std::sort(pictures.begin(), pictures.end());
  EXPECT_EQ(std::unique(pictures.begin(), pictures.end()), pictures.end());
}

TEST_F(CliMakeTest, ErrorsOfSceneConditionsNameTheKey) {
  const auto expect = [&](const std::string& condition, const Strings& parts) {
    WriteFile(folder_ / "s.json", R"({"camera": {"width": 320, "height": 240, "fx": 300, "fy": 300,
        "cx": 160, "cy": 120}, )" + condition +
                                      "}");
    Strings all = parts;
    all.push_back("s.json");
    ExpectComplaint("render s.json -o x.png", 1, all);
  };
  expect(R"("exposure": "long")", {"exposure"});
  expect(R"("exposure": -1)", {"exposure -1"});
  expect(R"("lighting": 5)", {"lighting"});
  expect(R"("lighting": {"sun": 1})", {"lighting", "sun"});
  expect(R"("lighting": {"gradient": [1]})", {"lighting", "gradient", "2 numbers"});
  expect(R"("lighting": {"shadow": {}})", {"lighting", "shadow", "point"});
  expect(R"("lighting": {"highlights": {}})", {"lighting", "highlights"});
  expect(R"("lighting": {"highlights": [{"center": [1, 2], "size": 1}]})",
         {"lighting", "highlight 0", "size"});
  expect(R"("occluders": [{"outline": [[0, 0], [1, 1]]}])", {"occluder 0"});
  expect(R"("occluders": [{}])", {"occluder 0", "outline"});
  expect(R"("occluders": [{"outline": [], "marker": 0}])", {"occluder 0", "marker"});
  expect(R"("markers": [{"family": "4x4", "id": 1, "size": 1, "t": [0, 0, 9], "growth": 1}])",
         {"marker 0", "growth"});
  expect(R"("markers": [{"family": "4x4", "id": 1, "size": 1, "t": [0, 0, 9], "velocity": 1}])",
         {"marker 0", "velocity"});
}

TEST_F(CliMakeTest, VersionHelpAndInfo) {
  const Outcome version = Run("--version");
  EXPECT_EQ(version.status, 0);
  EXPECT_EQ(version.out.compare(0, 8, "topotag "), 0) << version.out;
  for (const char* arguments : {"--help", "detect --help", "generate --help", "render --help"}) {
    const Outcome help = Run(arguments);
    EXPECT_EQ(help.status, 0);
    EXPECT_GT(Lines(help.out).size(), 8u) << help.out;
    EXPECT_LT(Lines(help.out).size(), 50u) << help.out;
    for (const std::string& line : Lines(help.out)) EXPECT_LE(line.size(), 80u) << line;
    EXPECT_EQ(help.err, "");
  }
  const Outcome info = Run("info");
  EXPECT_EQ(info.status, 0);
  EXPECT_NE(info.out.find("available: scalar"), std::string::npos) << info.out;
}

}  // namespace
}  // namespace topotag
