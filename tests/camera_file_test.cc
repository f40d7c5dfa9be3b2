#include "topotag/camera_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"
#include "topotag/error.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

class CameraFileTest : public testing::Test {
 protected:
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  std::string WriteText(const std::string& text, const std::string& name = "camera.yaml") const {
    std::ofstream(Path(name), std::ios::binary) << text;
    return Path(name);
  }

  Camera Read(const std::string& text) const { return ReadCamera(WriteText(text)); }

  // The text is refused with one line that names the file and every one of `parts`.
  void ExpectRefused(const std::string& text, const std::vector<std::string>& parts) const {
    const std::string path = WriteText(text, "refused.yaml");
    try {
      ReadCamera(path);
      FAIL() << "accepted:\n" << text.substr(0, 400);
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_EQ(error.code(), ErrorCode::kParse) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      EXPECT_NE(message.find(path), std::string::npos) << message;
      EXPECT_LT(message.size(), path.size() + 300);
      for (const std::string& part : parts) {
        EXPECT_NE(message.find(part), std::string::npos) << part << "\nnot in: " << message;
      }
    }
  }

  void ExpectFileError(const std::string& path, const std::string& part) const {
    try {
      ReadCamera(path);
      FAIL() << "accepted: " << path;
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_EQ(error.code(), ErrorCode::kFile) << message;
      EXPECT_NE(message.find(path), std::string::npos) << message;
      EXPECT_NE(message.find(part), std::string::npos) << message;
    }
  }

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

void ExpectEqual(const Camera& a, const Camera& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.distortion, b.distortion);
}

Camera Expected(int width = 1280, int height = 960) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = 921.315;
  camera.fy = 921.375;
  camera.cx = 649.204;
  camera.cy = 459.739;
  camera.model = DistortionModel::kBrown;
  camera.distortion = {0.978811, 3.71217, 1.5e-4, 2.8e-4, 0.638837};
  return camera;
}

const char kSize[] = "image_width: 1280\nimage_height: 960\n";
const char kMatrix[] = "camera_matrix: [921.315, 0, 649.204, 0, 921.375, 459.739, 0, 0, 1]\n";
const char kDistortion[] =
    "distortion_coefficients: [0.978811, 3.71217, 1.5e-4, 2.8e-4, 0.638837]\n";

std::string Flat() { return std::string(kSize) + kMatrix + kDistortion; }

std::string WithMatrix(const std::string& value) {
  return std::string(kSize) + "camera_matrix: " + value + "\n" + kDistortion;
}

std::string WithDistortion(const std::string& value) {
  return std::string(kSize) + kMatrix + "distortion_coefficients: " + value + "\n";
}

TEST_F(CameraFileTest, ReadsOpenCvYaml) {
  const std::string text =
      "%YAML:1.0\n---\ncalibration_time: \"Sat 01 Jan\"\nnframes: 20\nimage_width: 1280\n"
      "image_height: 960\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
      "   data: [ 9.21315e+02, 0., 649.204, 0.,\n       921.375, 459.739, 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
      "   data: [ 0.978811, 3.71217, 1.5e-04, 2.8e-04, 0.638837 ]\navg_reprojection_error: 0.2\n";
  ExpectEqual(Read(text), Expected());
  ExpectEqual(Read("\xEF\xBB\xBF" + text), Expected());
}

TEST_F(CameraFileTest, ReadsOpenCvJson) {
  ExpectEqual(Read("{\n\t\"image_width\": 1280,\n\t\"image_height\": 960,\n"
                   "\t\"camera_matrix\": {\n\t\t\"type_id\": \"opencv-matrix\",\n\t\t\"rows\": 3,\n"
                   "\t\t\"cols\": 3,\n\t\t\"dt\": \"d\",\n\t\t\"data\": [ 921.315, 0.0, 649.204, "
                   "0.0,\n\t\t\t921.375, 459.739, 0.0, 0.0, 1.0 ]\n\t},\n"
                   "\t\"distortion_coefficients\": {\n\t\t\"type_id\": \"opencv-matrix\",\n"
                   "\t\t\"rows\": 1,\n\t\t\"cols\": 5,\n\t\t\"dt\": \"d\",\n"
                   "\t\t\"data\": [ 0.978811, 3.71217, 1.5e-4, 2.8e-4, 0.638837 ]\n\t}\n}\n"),
              Expected());
}

TEST_F(CameraFileTest, ReadsPlainJsonWithNestedLists) {
  ExpectEqual(Read("{\"image_width\":1280,\"image_height\":960,\"camera_matrix\":[[921.315,0,"
                   "649.204],[0,921.375,459.739],[0,0,1]],\"distortion_coefficients\":"
                   "[[0.978811,3.71217,0.00015,0.00028,0.638837]]}"),
              Expected());
}

TEST_F(CameraFileTest, ReadsFlatListsAndColumns) {
  ExpectEqual(Read(Flat()), Expected());
  ExpectEqual(Read(WithDistortion("[[0.978811], [3.71217], [1.5e-4], [+2.8e-4], [0.638837]]")),
              Expected());
}

std::string Ros(const std::string& model, const std::vector<std::string>& coefficients) {
  std::string data;
  for (const std::string& c : coefficients) data += (data.empty() ? "" : ", ") + c;
  return std::string(kSize) +
         "camera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
         "  data: [921.315, 0.0, 649.204, 0.0, 921.375, 459.739, 0.0, 0.0, 1.0]\n"
         "distortion_model: " +
         model +
         "\ndistortion_coefficients:\n  rows: 1\n  cols: " + std::to_string(coefficients.size()) +
         "\n  data: [" + data +
         "]\nrectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
         "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [9, 0, 6, 0, 0, 9, 4, 0, 0, 0, 1, 0]\n";
}

TEST_F(CameraFileTest, ReadsRosCameraInfo) {
  ExpectEqual(Read(Ros("plumb_bob", {"0.978811", "3.71217", "1.5e-4", "2.8e-4", "0.638837"})),
              Expected());
  Camera camera = Expected();
  camera.distortion = {1, 2, 3, 4, 5, 6, 7, 8};
  ExpectEqual(Read(Ros("rational_polynomial", {"1", "2", "3", "4", "5", "6", "7", "8"})), camera);
  camera.model = DistortionModel::kFisheye;
  camera.distortion = {0.1, -0.2, 0.3, -0.4};
  ExpectEqual(Read(Ros("equidistant", {"0.1", "-0.2", "0.3", "-0.4"})), camera);
  ExpectEqual(Read(Ros("fisheye", {"0.1", "-0.2", "0.3", "-0.4"})), camera);
}

TEST_F(CameraFileTest, ReadsAuthorsKeysWithoutSize) {
  const Camera expected = Expected(0, 0);
  ExpectEqual(Read("{\"cameraMatrix\": [921.315,0,649.204,0,921.375,459.739,0,0,1],\n"
                   " \"distortionCoefficients\": [0.978811,3.71217,1.5e-4,2.8e-4,0.638837]}"),
              expected);
}

TEST_F(CameraFileTest, ReadsEveryNumberOfCoefficients) {
  for (int count : {0, 4, 5, 8, 12, 14}) {
    Camera camera = Expected();
    camera.model = count == 0 ? DistortionModel::kNone : DistortionModel::kBrown;
    camera.distortion = {};
    std::string list;
    for (int i = 0; i < count; ++i) {
      camera.distortion[i] = 0.25 * (i + 1);
      list += (i > 0 ? ", " : "") + std::to_string(camera.distortion[i]);
    }
    SCOPED_TRACE(count);
    ExpectEqual(Read(WithDistortion("[" + list + "]")), camera);
  }
  for (int count : {1, 2, 3, 6, 7, 9, 10, 11, 13, 15, 64, 65, 1000}) {
    std::string list = "1";
    for (int i = 1; i < count; ++i) list += ", 1";
    ExpectRefused(WithDistortion("[" + list + "]"), {"distortion_coefficients", "elements"});
  }
  ExpectRefused(Ros("plumb_bob", {"1", "2", "3", "4", "5", "6", "7", "8"}),
                {"distortion_coefficients has 8 elements", "plumb_bob"});
  ExpectRefused(Ros("equidistant", {"1", "2", "3", "4", "5"}), {"has 5 elements", "equidistant"});
  ExpectRefused(Ros("rational_polynomial", {"1", "2", "3", "4", "5"}), {"rational_polynomial"});
}

TEST_F(CameraFileTest, RefusesMissingKeys) {
  ExpectRefused(std::string(kSize) + kDistortion, {"no key camera_matrix"});
  ExpectRefused(std::string(kSize) + kMatrix, {"no key distortion_coefficients"});
  ExpectRefused(std::string("image_width: 1280\n") + kMatrix + kDistortion,
                {"image_width without image_height"});
  ExpectRefused(std::string("image_height: 960\n") + kMatrix + kDistortion,
                {"image_height without image_width"});
}

TEST_F(CameraFileTest, RefusesMalformedSizes) {
  const std::string rest = std::string("image_height: 960\n") + kMatrix + kDistortion;
  for (const char* value : {"abc", "1280.5", "", "[1280]", "99999999999", "nan", "1e3"}) {
    ExpectRefused(std::string("image_width: ") + value + "\n" + rest,
                  {"image_width", "not an integer"});
  }
  ExpectRefused("image_width: -1280\n" + rest, {"width", "-1280", "negative"});
  ExpectRefused("image_width: 0\n" + rest, {"0x960"});
}

TEST_F(CameraFileTest, RefusesMalformedMatrices) {
  const std::string key = "camera_matrix";
  ExpectRefused(WithMatrix("[1, 0, 2, 0, 1, 2, 0, 0]"), {key, "8 elements, expected 9"});
  ExpectRefused(WithMatrix("[1, 0, 2, 0, 1, 2, 0, 0, 1, 0]"), {key, "10 elements"});
  ExpectRefused(WithMatrix("[]"), {key, "0 elements"});
  ExpectRefused(WithMatrix(""), {key, "neither a list nor a map"});
  ExpectRefused(WithMatrix("5"), {key, "neither a list nor a map"});
  ExpectRefused(WithMatrix("[[1, 0, 2], [0, 1, 2, 0], [0, 1]]"), {key, "row"});
  ExpectRefused(WithMatrix("[[1, 0, 2], 0, 1, 2, [0, 0, 1]]"), {key, "row"});
  ExpectRefused(WithMatrix("[[[1, 0, 2]], [[0, 1, 2]], [[0, 0, 1]]]"), {key});
  ExpectRefused(WithMatrix("[1, 0, x1, 0, 1, 2, 0, 0, 1]"),
                {key, "element 2 'x1' is not a number"});
  ExpectRefused(WithMatrix("[1, 0, '', 0, 1, 2, 0, 0, 1]"), {key, "element 2"});
  ExpectRefused(WithMatrix("[1, 0, +-2, 0, 1, 2, 0, 0, 1]"), {key, "element 2"});
  ExpectRefused(WithMatrix("[1, 0, 1.5px, 0, 1, 2, 0, 0, 1]"), {key, "'1.5px'"});
  ExpectRefused(WithMatrix("[1, 0, {a: 1}, 0, 1, 2, 0, 0, 1]"), {key, "element 2"});
  ExpectRefused(WithMatrix("[1, 0, \"a\\nb\", 0, 1, 2, 0, 0, 1]"), {key, "'a b'"});
  ExpectRefused(WithMatrix("[nan, 0, 2, 0, 1, 2, 0, 0, 1]"), {key, "'nan' is not finite"});
  ExpectRefused(WithMatrix("[1, 0, inf, 0, 1, 2, 0, 0, 1]"), {key, "'inf' is not finite"});
  ExpectRefused(WithMatrix("[1, 0, .Nan, 0, 1, 2, 0, 0, 1]"), {key, "'.Nan'"});
  ExpectRefused(WithMatrix("[1, 0, 1e999, 0, 1, 2, 0, 0, 1]"), {key, "'1e999'"});
  ExpectRefused(WithMatrix("{cols: 3, data: [1, 0, 2, 0, 1, 2, 0, 0, 1]}"), {key, "rows"});
  ExpectRefused(WithMatrix("{rows: 3, data: [1, 0, 2, 0, 1, 2, 0, 0, 1]}"), {key, "cols"});
  ExpectRefused(WithMatrix("{rows: 3, cols: 3}"), {key, "data is missing"});
  ExpectRefused(WithMatrix("{rows: 3, cols: 3, data: 7}"), {key, "data"});
  ExpectRefused(WithMatrix("{rows: 1, cols: 9, data: [1, 0, 2, 0, 1, 2, 0, 0, 1]}"),
                {key, "1x9, expected 3x3"});
  ExpectRefused(WithMatrix("{rows: 3, cols: 3, data: [1, 0, 2, 0, 1, 2, 0, 0]}"),
                {key, "stated as 3x3", "8 numbers"});
  ExpectRefused(WithDistortion("{rows: 1, cols: 8, data: [1, 2, 3, 4, 5]}"),
                {"distortion_coefficients", "1x8", "5 numbers"});
  ExpectRefused(WithDistortion("{rows: -1, cols: -4, data: [1, 2, 3, 4]}"), {"rows"});
  ExpectRefused(WithDistortion("none"), {"distortion_coefficients", "neither a list nor a map"});
  ExpectRefused(WithDistortion("[0.1, 0.2, 0, inf, 0]"), {"distortion_coefficients element 3"});
}

TEST_F(CameraFileTest, RefusesImpossibleCameras) {
  ExpectRefused(WithMatrix("[0, 0, 2, 0, 1, 2, 0, 0, 1]"), {"camera_matrix", "fx", "0"});
  ExpectRefused(WithMatrix("[1, 0, 2, 0, -900.5, 2, 0, 0, 1]"), {"fy", "-900.5", "not positive"});
  ExpectRefused(WithMatrix("[900, 0.5, 2, 0, 900, 2, 0, 0, 1]"), {"skew 0.5 is not supported"});
  ExpectRefused(WithMatrix("[900, 0, 2, 0.1, 900, 2, 0, 0, 1]"), {"element 3"});
  ExpectRefused(WithMatrix("[900, 0, 2, 0, 900, 2, 0, 0, 2]"), {"last row", "0 0 2"});
  ExpectRefused(WithMatrix("[900, 0, 0, 0, 900, 0, 640, 480, 1]"), {"last row"});
  EXPECT_EQ(Read(WithMatrix("[900, 1e-5, 640, 0, 901, 480, 0, 0, 1]")).fy, 901);
  ExpectRefused(Ros("kannala", {"1", "2", "3", "4"}), {"distortion_model 'kannala'", "plumb_bob"});
  ExpectRefused(Ros("[equidistant]", {"1", "2", "3", "4"}), {"distortion_model"});
  ExpectRefused(Ros("", {"1", "2", "3", "4"}), {"distortion_model"});
}

TEST_F(CameraFileTest, RefusesWhatIsNoCalibration) {
  ExpectRefused("", {"is empty"});
  ExpectRefused("\n\n", {"map"});
  ExpectRefused("hello", {"map"});
  ExpectRefused("[1, 2, 3]", {"map"});
  ExpectRefused("%YAML:1.0\n---\n", {"map"});
  ExpectRefused("%YAML:1.0", {"map"});
  ExpectRefused(std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16), {"not a text file"});
  ExpectRefused("\xff\xfe\xd8\x01\x02{]\x80\x81: &a *b", {});
  ExpectRefused(std::string(kMatrix) + "  broken: [1, 2\n: }\n", {"neither YAML nor JSON", "line"});
  ExpectRefused("camera_matrix: [1, 2", {"neither YAML nor JSON"});
  ExpectRefused("camera_matrix: *nowhere\n", {"neither YAML nor JSON"});
}

TEST_F(CameraFileTest, SurvivesHostileYaml) {
  for (const char* unit : {"[", "{", "- ", "[{", "{a: ", "? "}) {
    std::string text = "camera_matrix: ";
    while (text.size() < 1000000) text += unit;
    ExpectRefused(text, {});
  }
  // Every level names the one before it ten times: 10^30 elements if it were expanded.
  std::string laughs = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string alias = "*a" + std::to_string(i - 1);
    laughs += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + alias;
    for (int k = 1; k < 10; ++k) laughs += ", " + alias;
    laughs += "]\n";
  }
  ExpectRefused(laughs + kSize + kDistortion + "camera_matrix: *a29\n", {"camera_matrix"});
  ExpectRefused(laughs + kSize + kMatrix + "distortion_coefficients: *a29\n",
                {"distortion_coefficients"});
  ExpectRefused("camera_matrix: &m [*m, *m]\n" + std::string(kDistortion), {"camera_matrix"});
}

TEST_F(CameraFileTest, EveryTruncationAndChangedByteIsReadOrRefused) {
  const std::string text = Ros("plumb_bob", {"0.1", "0.2", "0.3", "0.4", "0.5"});
  int refused = 0;
  const auto attempt = [&](const std::string& changed) {
    const std::string path = WriteText(changed);
    try {
      ReadCamera(path);
    } catch (const Error& error) {
      ++refused;
      EXPECT_EQ(error.code(), ErrorCode::kParse) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  };
  for (size_t i = 0; i < text.size(); ++i) {
    attempt(text.substr(0, i));
    for (char c : {'\0', '[', '}', ':', '&', '\t', '-', '\xff'}) {
      std::string changed = text;
      changed[i] = c;
      attempt(changed);
    }
  }
  EXPECT_GT(refused, 500);
}

TEST_F(CameraFileTest, ReportsUnreadableFiles) {
  ExpectFileError(Path("absent.yaml"), "No such file");
  ExpectFileError(folder_.string(), "directory");
  ExpectFileError(WriteText(Flat()) + "/inside.yaml", "Not a directory");
  ExpectFileError("/dev/null", "not a regular file");
  ExpectFileError(WriteText(Flat() + std::string(size_t{1} << 20, '#')), "larger than 1048576");
}

Camera Precise(DistortionModel model, int coefficients) {
  Camera camera;
  camera.width = 1279;
  camera.height = 961;
  camera.fx = 1000.0 / 3;
  camera.fy = 1e3 / 7;
  camera.cx = 0.1 + 0.2;
  camera.cy = -1.0 / 9;
  camera.model = model;
  for (int i = 0; i < coefficients; ++i) camera.distortion[i] = (i % 2 ? -1e-7 : 1.0) / (i + 3);
  return camera;
}

std::vector<Camera> PreciseCameras() {
  std::vector<Camera> cameras = {Precise(DistortionModel::kNone, 0),
                                 Precise(DistortionModel::kFisheye, 4)};
  for (int count : {0, 4, 5, 8, 12, 14}) {
    cameras.push_back(Precise(DistortionModel::kBrown, count));
  }
  cameras.push_back(Precise(DistortionModel::kBrown, 5));
  cameras.back().width = cameras.back().height = 0;
  return cameras;
}

TEST_F(CameraFileTest, RoundTripIsExact) {
  for (const Camera& camera : PreciseCameras()) {
    WriteCamera(camera, Path("out.yaml"));
    ExpectEqual(ReadCamera(Path("out.yaml")), camera);
  }
}

TEST_F(CameraFileTest, OpenCvReadsWhatIsWritten) {
  for (const Camera& camera : PreciseCameras()) {
    WriteCamera(camera, Path("out.yaml"));
    cv::FileStorage file(Path("out.yaml"), cv::FileStorage::READ);
    ASSERT_TRUE(file.isOpened());
    cv::Mat matrix, distortion;
    file["camera_matrix"] >> matrix;
    file["distortion_coefficients"] >> distortion;
    ASSERT_EQ(matrix.size(), cv::Size(3, 3));
    ASSERT_EQ(matrix.type(), CV_64F);
    EXPECT_EQ(matrix.at<double>(0, 0), camera.fx);
    EXPECT_EQ(matrix.at<double>(0, 2), camera.cx);
    EXPECT_EQ(matrix.at<double>(1, 1), camera.fy);
    EXPECT_EQ(matrix.at<double>(1, 2), camera.cy);
    EXPECT_EQ(distortion.empty(), camera.model == DistortionModel::kNone);
    for (int i = 0; i < static_cast<int>(distortion.total()); ++i) {
      EXPECT_EQ(distortion.at<double>(i), camera.distortion[i]);
    }
    EXPECT_EQ(file["image_width"].empty(), camera.width == 0);
    if (camera.width > 0) {
      EXPECT_EQ(static_cast<int>(file["image_width"]), camera.width);
      EXPECT_EQ(static_cast<int>(file["image_height"]), camera.height);
    }
  }
}

TEST_F(CameraFileTest, ReadsWhatOpenCvWrites) {
  for (const char* name : {"cv.yaml", "cv.json"}) {
    for (int count : {0, 5, 14}) {
      const Camera camera =
          Precise(count == 0 ? DistortionModel::kNone : DistortionModel::kBrown, count);
      cv::Mat matrix =
          (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
      cv::Mat distortion(count, count == 0 ? 0 : 1, CV_64F);
      for (int i = 0; i < count; ++i) distortion.at<double>(i) = camera.distortion[i];
      {
        cv::FileStorage file(Path(name), cv::FileStorage::WRITE);
        file << "image_width" << camera.width << "image_height" << camera.height;
        file << "camera_matrix" << matrix << "distortion_coefficients" << distortion;
      }
      SCOPED_TRACE(name);
      ExpectEqual(ReadCamera(Path(name)), camera);
    }
  }
}

TEST_F(CameraFileTest, FailedWriteLeavesNothing) {
  const Camera good = Precise(DistortionModel::kBrown, 5);
  Camera bad = good;
  bad.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(WriteCamera(bad, Path("bad.yaml")), Error);
  fs::create_directory(Path("taken.yaml"));
  for (const std::string& path : {Path("absent/out.yaml"), Path("taken.yaml")}) {
    try {
      WriteCamera(good, path);
      FAIL() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFile);
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
    }
  }
  int entries = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) {
    EXPECT_EQ(entry.path().filename(), "taken.yaml");
    ++entries;
  }
  EXPECT_EQ(entries, 1);
}

}  // namespace
}  // namespace topotag
