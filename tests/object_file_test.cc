#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "tests/decimal_comma.h"
#include "tests/object_util.h"
#include "tests/temporary_folder.h"
#include "topotag/error.h"
#include "topotag/object.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;
using test::operator*;

class ObjectFileTest : public testing::Test {
 protected:
  Object Read(const std::string& text) const {
    std::ofstream(path_, std::ios::binary) << text;
    return ReadObject(path_);
  }
  // What stands after the file's name.
  std::string Complaint(const std::string& text) const {
    try {
      Read(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kParse);
      const std::string message = error.what();
      EXPECT_EQ(message.find('\n'), std::string::npos);
      EXPECT_EQ(message.compare(0, path_.size(), path_), 0) << message;
      return message.substr(path_.size());
    }
    return "nothing";
  }

  const test::TemporaryFolder folder_;
  const std::string path_ = (folder_.path() / "topotag_board.txt").string();
};

void ExpectSame(const Object& a, const Object& b) {
  ASSERT_EQ(a.markers.size(), b.markers.size());
  for (size_t i = 0; i < a.markers.size(); ++i) {
    EXPECT_EQ(a.markers[i].family, b.markers[i].family);
    EXPECT_EQ(a.markers[i].id, b.markers[i].id);
    EXPECT_NEAR(a.markers[i].tag_size, b.markers[i].tag_size, 1e-12);
    for (size_t r = 0; r < 3; ++r) {
      EXPECT_NEAR(a.markers[i].t[r], b.markers[i].t[r], 1e-12);
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(a.markers[i].R[r][c], b.markers[i].R[r][c], 1e-12) << i;
      }
    }
  }
}

TEST_F(ObjectFileTest, WhatIsWrittenIsRead) {
  Object object = MakeRhombicuboctahedron(Family(4), 7, 0.03, 0.04);
  test::Random random(1);
  for (int i = 0; i < 200; ++i) {
    ObjectMarker marker;
    marker.family = Family(8);
    marker.id = (uint64_t{1} << 62) - 1 - static_cast<uint64_t>(i);
    marker.tag_size = random.Uniform(1e-3, 1);
    marker.R = random.Tilted(random.Uniform(0, M_PI));
    marker.t = {random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1)};
    object.markers.push_back(marker);
  }
  WriteObject(object, path_);
  const Object read = ReadObject(path_);
  ExpectSame(read, object);
  EXPECT_EQ(read.name, "topotag_board");
}

TEST_F(ObjectFileTest, HalfTurnsAboutAnyAxis) {
  Object object;
  for (const double roll : {0.0, 0.3, 1.2, 2.5}) {
    for (const double tilt : {0.0, 0.7, 1.5, 3.0}) {
      const Matrix3 to_axis = test::RotationZ(roll) * test::RotationX(tilt);
      const Matrix3 back = test::RotationX(-tilt) * test::RotationZ(-roll);
      for (const double angle : {M_PI, M_PI - 1e-9, 1e-9}) {
        ObjectMarker marker;
        marker.id = object.markers.size();
        marker.R = to_axis * (test::RotationZ(angle) * back);
        object.markers.push_back(marker);
      }
    }
  }
  WriteObject(object, path_);
  ExpectSame(ReadObject(path_), object);
}

TEST_F(ObjectFileTest, CommentsBlanksAndLineEnds) {
  const Object object = Read(
      "# a board\r\n\r\n"
      "  4x4\t12 0.03 +0.1 0 -1e-2 0 0 1.5  # the first\r\n"
      "3x3 127 5e-2 0 0 0 0 0 -6.28");
  ASSERT_EQ(object.markers.size(), 2u);
  EXPECT_EQ(object.markers[0].id, 12u);
  EXPECT_EQ(object.markers[0].t, (Vector3{0.1, 0, -0.01}));
  EXPECT_LT(test::AngleBetween(object.markers[0].R, test::RotationZ(1.5)), 1e-9);
  EXPECT_EQ(object.markers[1].family, Family(3));
  EXPECT_LT(test::AngleBetween(object.markers[1].R, test::RotationZ(-6.28)), 1e-9);
}

TEST_F(ObjectFileTest, EveryErrorNamesTheLineAndTheReason) {
  const std::string good = "4x4 12 0.03 0 0 0 0 0 0\n";
  const std::pair<const char*, const char*> cases[] = {
      {"9x9 1 0.03 0 0 0 0 0 0", "9x9"},
      {"3x3 128 0.03 0 0 0 0 0 0", "marker 3x3 128: the ID is outside the range 0 .. 127 of 3x3"},
      {"4x4 -1 0.03 0 0 0 0 0 0", "ID '-1' is not a whole number of 0 or more"},
      {"4x4 99999999999999999999 0.03 0 0 0 0 0 0", "ID '99999999999999999999' is not"},
      {"4x4 12 0.04 0 0 0 0 0 0", "marker 4x4 12 stands in line 1 already"},
      {"4x4 13 0.03", "the pose is missing: expected 9 values 'FAMILY ID SIZE TX TY TZ RX RY RZ'"},
      {"4x4 13 0.03 0 0 0", "expected 9 values 'FAMILY ID SIZE TX TY TZ RX RY RZ', got 6"},
      {"4x4 13 0.03 0 0 0 0 0 0 0", "got 10"},
      {"4x4 13 0.03 0 abc 0 0 0 0", "TY 'abc' is not a finite number"},
      {"4x4 13 0.03 0 0 0 0 nan 0", "RY 'nan' is not a finite number"},
      {"4x4 13 0.03 0 0 0 0 0 1,5", "RZ '1,5' is not a finite number"},
      {"4x4 13 0.03m 0 0 0 0 0 0", "SIZE '0.03m' is not a finite number"},
      {"4x4 13 -0.03 0 0 0 0 0 0", "marker 4x4 13: the size -0.03 m is not within 1e-09 .. 1e+06"},
      {"4x4 13 0.03 0 0 9e9 0 0 0", "marker 4x4 13: the position 9e+09 m is not within"},
      {"4x4 13 0.03 0 0 0 0 0 90", "RX RY RZ is more than a full turn"},
  };
  for (const auto& [line, reason] : cases) {
    const std::string complaint = Complaint(good + "# next\n" + line + "\n");
    EXPECT_EQ(complaint.compare(0, 4, ":3: "), 0) << complaint;
    EXPECT_NE(complaint.find(reason), std::string::npos) << complaint;
  }
  EXPECT_EQ(Complaint("# nothing\n\n"), ": the file holds no marker");
}

TEST_F(ObjectFileTest, TheSmallestMarkersAreWritten) {
  Object object;
  object.markers.emplace_back();
  object.markers[0].tag_size = 1e-9;
  object.markers[0].t = {5e-16, -5e-16, 1e-9};
  WriteObject(object, path_);
  const ObjectMarker read = ReadObject(path_).markers[0];
  EXPECT_EQ(read.tag_size, 1e-9);
  EXPECT_EQ(read.t, (Vector3{0, 0, 1e-9}));
  // Smaller ones are refused before they are written, not when they are read.
  object.markers[0].tag_size = 5e-16;
  EXPECT_THROW(WriteObject(object, path_), Error);
}

// A program may have set its user's locale.
TEST_F(ObjectFileTest, NumbersHaveAPointInEveryLocale) {
  const Object object = MakeRhombicuboctahedron(Family(4), 7, 0.03, 0.04);
  WriteObject(object, path_);
  const auto text = [&] {
    std::ifstream file(path_);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string expected = text();
  const test::DecimalComma locale;
  if (!locale.Works()) GTEST_SKIP() << "no locale with a decimal comma";
  WriteObject(object, path_);
  EXPECT_EQ(text(), expected);
  ExpectSame(ReadObject(path_), object);
  EXPECT_EQ(Complaint("4x4 13 -0.03 0 0 0 0 0 0"),
            ":1: marker 4x4 13: the size -0.03 m is not within 1e-09 .. 1e+06");
}

TEST_F(ObjectFileTest, FilesThatCannotBeReadOrWrittenAreNamed) {
  const auto complaint = [](const auto& act) -> std::string {
    try {
      act();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFile);
      return error.what();
    }
    return "nothing";
  };
  EXPECT_EQ(complaint([] { ReadObject("/nowhere/board.txt"); }),
            "cannot read object file '/nowhere/board.txt': No such file or directory");
  const Object board = MakeGrid(Family(4), 0, 2, 2, 0.03, 0.05);
  EXPECT_EQ(complaint([&] { WriteObject(board, "/nowhere/board.txt"); }),
            "cannot write '/nowhere/board.txt': No such file or directory");
  EXPECT_THROW(WriteObject({}, path_), Error);
  EXPECT_FALSE(fs::exists(path_));
}

}  // namespace
}  // namespace topotag
