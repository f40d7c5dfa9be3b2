#include <gtest/gtest.h>

#include <cmath>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class CliObjectTest : public CliTest {
 protected:
  // board.txt, a board of 2 x 3 markers, and views of it: in/NUMBER.png, with cam.yaml.
  void RenderBoard(int views) const {
    const Outcome made =
        Run("object grid --rows 2 --columns 3 --tag-size 0.03 --pitch 0.045 -o board.txt");
    ASSERT_EQ(made.status, 0) << made.err;
    ASSERT_EQ(made.out + made.err, "");
    for (int i = 0; i < views; ++i) {
      // Tilted about an axis in the plane, a different one in each view.
      const double angle = 2 * M_PI * i / views, x = 0.5 * std::cos(angle),
                   y = 0.5 * std::sin(angle);
      const Json rotation{x, y, 0};
      Json scene;
      scene["camera"] = {{"width", 640}, {"height", 480}, {"fx", 900},
                         {"fy", 900},    {"cx", 319.5},   {"cy", 239.5}};
      scene["noise"] = 1;
      for (int id = 0; id < 6; ++id) {
        const double px = (id % 3 - 1) * 0.045, py = (id / 3 - 0.5) * 0.045;
        // R (px, py, 0), by Rodrigues.
        const double s = std::sin(0.5), c = std::cos(0.5);
        const double kx = x / 0.5, ky = y / 0.5, along = (kx * px + ky * py) * (1 - c);
        scene["markers"].push_back(
            {{"family", "4x4"},
             {"id", id},
             {"size", 0.03},
             {"rvec", rotation},
             {"t", {px * c + kx * along, py * c + ky * along, (kx * py - ky * px) * s + 0.4}}});
      }
      WriteFile(folder_ / "scene.json", scene.dump());
      const Outcome outcome =
          Run("render scene.json --write-camera cam.yaml -o in/" + std::to_string(i) + ".png");
      ASSERT_EQ(outcome.status, 0) << outcome.err;
    }
  }
};

TEST_F(CliObjectTest, DetectGivesTheObjectsPose) {
  RenderBoard(1);
  const Json line = Detect("--camera cam.yaml --object board.txt in/0.png");
  EXPECT_EQ(Keys(line), (Strings{"image", "frame", "width", "height", "backend", "detections",
                                 "objects", "time_us"}));
  // Markers have the object's sizes.
  ASSERT_EQ(line["detections"].size(), 6u);
  EXPECT_NEAR(line["detections"][0]["pose"]["t"][2].get<double>(), 0.4, 0.03);
  ASSERT_EQ(line["objects"].size(), 1u);
  const Json& object = line["objects"][0];
  EXPECT_EQ(Keys(object), (Strings{"name", "R", "t", "rms_px", "covariance", "alternative",
                                   "markers", "rejected"}));
  EXPECT_EQ(object["name"], "board");
  EXPECT_NEAR(object["t"][0].get<double>(), 0, 1e-4);
  EXPECT_NEAR(object["t"][2].get<double>(), 0.4, 4e-4);
  EXPECT_EQ(object["markers"].size(), 6u);
  EXPECT_EQ(object["markers"][3], (Json{{"family", "4x4"}, {"id", 3}}));
  EXPECT_TRUE(object["rejected"].empty());
}

TEST_F(CliObjectTest, TextCsvAndPictures) {
  RenderBoard(1);
  const Outcome text = Run("detect --camera cam.yaml --object board.txt --draw out in/0.png");
  EXPECT_EQ(text.status, 0) << text.err;
  ASSERT_EQ(Lines(text.out).size(), 8u);
  EXPECT_EQ(Lines(text.out)[7].find("  object board  t ("), 0u) << text.out;
  EXPECT_NE(text.out.find("from 6 of its markers"), std::string::npos);
  EXPECT_EQ(Names(folder_ / "out"), (Strings{"0.png"}));
  const Outcome csv = Run("detect --format csv --camera cam.yaml --object board.txt in/0.png");
  const Strings rows = Lines(csv.out);
  ASSERT_EQ(rows.size(), 8u);
  EXPECT_EQ(rows[7].find("in/0.png,0,object,board,,"), 0u) << rows[7];
  for (const std::string& row : rows) {
    EXPECT_EQ(std::count(row.begin(), row.end(), ','), 26) << row;
  }
}

TEST_F(CliObjectTest, AFrameWithoutTheObjectHasAnEmptyList) {
  RenderScene();
  WriteFile(folder_ / "other.txt", "6x6 5 0.03 0 0 0 0 0 0\n");
  const Json line = Detect("--camera cam.yaml --object other.txt scene.png");
  EXPECT_TRUE(line["objects"].is_array());
  EXPECT_TRUE(line["objects"].empty());
  EXPECT_EQ(line["detections"].size(), 3u);
}

TEST_F(CliObjectTest, WrongUsageIsNamed) {
  RenderScene();
  WriteFile(folder_ / "a.txt", "4x4 278 0.05 0 0 0 0 0 0\n");
  WriteFile(folder_ / "b.txt", "3x3 1 0.05 0 0 0 0 0 0\n4x4 278 0.05 0 0 1 0 0 0\n");
  WriteFile(folder_ / "bad.txt", "4x4 278 0.05\n");
  fs::create_directory(folder_ / "sub");
  WriteFile(folder_ / "sub" / "a.txt", "4x4 1 0.05 0 0 0 0 0 0\n");
  ExpectComplaint("detect --object a.txt scene.png", 2, {"--object", "--camera"});
  ExpectComplaint("detect --camera cam.yaml --object no.txt scene.png", 2,
                  {"--object", "'no.txt'", "No such file"});
  ExpectComplaint("detect --camera cam.yaml --object bad.txt scene.png", 2,
                  {"--object: bad.txt:1: the pose is missing"});
  ExpectComplaint("detect --camera cam.yaml --object a.txt --object b.txt scene.png", 2,
                  {"marker 4x4 278 is in a.txt and in b.txt"});
  ExpectComplaint("detect --camera cam.yaml --object a.txt --object sub/a.txt scene.png", 2,
                  {"sub/a.txt and a.txt have the same name"});
  ExpectComplaint("detect --camera cam.yaml --family 3x3 --object a.txt scene.png", 2,
                  {"--family: 4x4 is missing"});
  ExpectComplaint("object", 2, {"grid, rhombicuboctahedron or calibrate"});
  ExpectComplaint("object grid --rows 2 --columns 2 --tag-size 0.03 --pitch 0.01 -o b.txt", 2,
                  {"pitch 0.01 m"});
  ExpectComplaint("object grid --rows x --columns 2 --tag-size 0.03 --pitch 0.1 -o b.txt", 2,
                  {"--rows: 'x'"});
  ExpectComplaint(
      "object rhombicuboctahedron --family 3x3 --first-id 120 --tag-size 0.03 --edge 0.04 -o b.txt",
      2, {"18 IDs from 120"});
  ExpectComplaint("object rhombicuboctahedron --tag-size 0.03 --edge 0.04 -o no/b.txt", 1,
                  {"no/b.txt"});
  ExpectComplaint("object calibrate --camera cam.yaml -o c.txt scene.png", 2, {"--ids"});
  ExpectComplaint("object calibrate --camera cam.yaml --ids 1,1 --tag-size 0.05 -o c.txt scene.png",
                  2, {"--ids: marker 4x4 1 occurs twice"});
  ExpectComplaint(
      "object calibrate --camera cam.yaml --ids 278-279 --tag-size 0.05 -o c.txt scene.png", 1,
      {"marker 4x4 279 is in no view"});
}

TEST_F(CliObjectTest, RhombicuboctahedronIsWritten) {
  const Outcome made =
      Run("object rhombicuboctahedron --first-id 5 --tag-size 0.03 --edge 0.04 -o body.txt");
  EXPECT_EQ(made.status, 0) << made.err;
  const Strings lines = Lines(ReadFile(folder_ / "body.txt"));
  ASSERT_EQ(lines.size(), 20u);
  EXPECT_EQ(lines[2].find("4x4 5 0.03 0 0 -0.0482"), 0u) << lines[2];
}

TEST_F(CliObjectTest, CalibrateMeasuresTheBoard) {
  RenderBoard(8);
  const Outcome outcome = Run(
      "object calibrate --camera cam.yaml --ids 0-5 --tag-size 0.03 -o measured.txt in in/no.png");
  // A picture that cannot be read is named, and the others are used.
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("in/no.png"), std::string::npos) << outcome.err;
  ASSERT_EQ(Lines(outcome.out).size(), 7u) << outcome.out;
  EXPECT_EQ(outcome.out.find("6 markers, 8 of 8 views"), 0u) << outcome.out;
  const Strings lines = Lines(ReadFile(folder_ / "measured.txt"));
  ASSERT_EQ(lines.size(), 8u);
  double size, tx, ty, tz;
  ASSERT_EQ(std::sscanf(lines[7].c_str(), "4x4 5 %lf %lf %lf %lf", &size, &tx, &ty, &tz), 4);
  EXPECT_NEAR(tx, 0.09, 5e-5);
  EXPECT_NEAR(ty, 0.045, 5e-5);
  EXPECT_NEAR(tz, 0, 1e-4);

  const Outcome again =
      Run("object calibrate --camera cam.yaml --object board.txt -o measured.txt in");
  EXPECT_EQ(again.status, 0) << again.err;
  const Strings moved = Lines(ReadFile(folder_ / "measured.txt"));
  ASSERT_EQ(moved.size(), 8u);
  ASSERT_EQ(std::sscanf(moved[7].c_str(), "4x4 5 %lf %lf %lf %lf", &size, &tx, &ty, &tz), 4);
  EXPECT_NEAR(tx, 0.045, 5e-5);
  EXPECT_NEAR(ty, 0.0225, 5e-5);
}

}  // namespace
}  // namespace topotag
