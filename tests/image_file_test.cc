// Image files: every format, and every kind of file that is not one.
#include "topotag/image_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "host/encoded_image.h"
#include "tests/temporary_folder.h"
#include "topotag/error.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<uint8_t>;

class ImageFileTest : public testing::Test {
 protected:
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  std::string Save(const std::string& name, const Bytes& bytes) const {
    std::ofstream file(Path(name), std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return Path(name);
  }
  std::string Save(const std::string& name, const std::string& text) const {
    return Save(name, Bytes(text.begin(), text.end()));
  }
  Bytes Load(const std::string& path) const {
    std::ifstream file(path, std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(file), {});
  }
  std::string SaveMat(const std::string& name, const cv::Mat& mat) const {
    Bytes bytes;
    EXPECT_TRUE(cv::imencode(fs::path(name).extension().string(), mat, bytes));
    return Save(name, bytes);
  }

  // Reading fails with one line that names the file and contains `reason`, and nothing is printed.
  void ExpectReadError(const std::string& path, const std::string& reason,
                       ErrorCode code = ErrorCode::kFile) const {
    testing::internal::CaptureStderr();
    std::string message = "no error";
    try {
      ReadImage(path);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code);
      message = error.what();
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_NE(message.find("'" + path + "'"), std::string::npos) << message;
    EXPECT_NE(message.find(reason), std::string::npos) << message << "\nlacks: " << reason;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
};

cv::Mat Gradient(int width, int height) {
  cv::Mat mat(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) mat.at<uint8_t>(y, x) = static_cast<uint8_t>(3 * x + 5 * y);
  }
  return mat;
}

Image ToImage(const cv::Mat& mat) {
  Image image(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) std::copy_n(mat.ptr(y), mat.cols, image.row(y));
  return image;
}

int LargestDifference(const Image& image, const cv::Mat& expected) {
  if (image.width() != expected.cols || image.height() != expected.rows) return 1000;
  int largest = 0;
  for (int y = 0; y < expected.rows; ++y) {
    for (int x = 0; x < expected.cols; ++x) {
      largest = std::max(largest, std::abs(image.row(y)[x] - expected.at<uint8_t>(y, x)));
    }
  }
  return largest;
}

TEST_F(ImageFileTest, EveryFormatComesBack) {
  const cv::Mat mat = Gradient(61, 43);
  for (const char* name : {"a.png", "a.BMP", "a.pgm", "a.ppm", "a.pnm", "a.tif", "a.TIFF", "a.jpg",
                           "a.JPEG", "a.webp"}) {
    // One byte of padding a row, which must not be written.
    Bytes padded(62 * 43, 255);
    for (int y = 0; y < 43; ++y) std::copy_n(mat.ptr(y), 61, padded.data() + 62 * y);
    WriteImage({padded.data(), 61, 43, 62}, Path(name));
    const bool lossy = std::string("jJw").find(name[2]) != std::string::npos;
    EXPECT_LE(LargestDifference(ReadImage(Path(name)), mat), lossy ? 12 : 0) << name;
  }
}

TEST_F(ImageFileTest, SmallestImages) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(200, 1), cv::Size(1, 200)}) {
    const cv::Mat mat = Gradient(size.width, size.height);
    for (const char* extension : {".png", ".bmp", ".pgm", ".tif"}) {
      const std::string path = Path(std::string("a") + extension);
      WriteImage(ToImage(mat).view(), path);
      EXPECT_EQ(LargestDifference(ReadImage(path), mat), 0) << extension << size;
    }
  }
}

TEST_F(ImageFileTest, ColourBecomesLuminance) {
  cv::Mat color(20, 30, CV_8UC3), alpha(20, 30, CV_8UC4), expected(20, 30, CV_8UC1);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 30; ++x) {
      const int b = 8 * x, g = 12 * y, r = (5 * x * y) % 256;
      color.at<cv::Vec3b>(y, x) = cv::Vec3b(b, g, r);
      alpha.at<cv::Vec4b>(y, x) = cv::Vec4b(b, g, r, 7 * x);
      expected.at<uint8_t>(y, x) =
          static_cast<uint8_t>(std::lround(0.299 * r + 0.587 * g + 0.114 * b));
    }
  }
  for (const char* name : {"c.png", "c.bmp", "c.ppm", "c.tif"}) {
    EXPECT_LE(LargestDifference(ReadImage(SaveMat(name, color)), expected), 0) << name;
  }
  for (const char* name : {"a.png", "a.tif"}) {
    EXPECT_LE(LargestDifference(ReadImage(SaveMat(name, alpha)), expected), 0) << name;
  }
  EXPECT_LE(LargestDifference(ReadImage(SaveMat("c.jpg", color)), expected), 40);
}

TEST_F(ImageFileTest, SixteenBitsAreScaledWithRounding) {
  cv::Mat mat(256, 257, CV_16UC1), expected(256, 257, CV_8UC1);
  cv::Mat color(256, 257, CV_16UC3);
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 257; ++x) {
      const int value = std::min(65535, 257 * y + x - 128 + (y == 0 ? 128 : 0));
      mat.at<uint16_t>(y, x) = static_cast<uint16_t>(value);
      color.at<cv::Vec3w>(y, x) = cv::Vec3w::all(static_cast<uint16_t>(value));
      expected.at<uint8_t>(y, x) = static_cast<uint8_t>(std::lround(value / 257.0));
    }
  }
  for (const char* name : {"a.png", "a.pgm", "a.tif"}) {
    EXPECT_EQ(LargestDifference(ReadImage(SaveMat(name, mat)), expected), 0) << name;
  }
  EXPECT_EQ(LargestDifference(ReadImage(SaveMat("c.png", color)), expected), 0);
}

TEST_F(ImageFileTest, PnmOfEveryKind) {
  const auto pixels = [&](const std::string& text) {
    const Image image = ReadImage(Save("a.pnm", text));
    std::vector<int> values{image.width(), image.height()};
    for (int y = 0; y < image.height(); ++y) {
      values.insert(values.end(), image.row(y), image.row(y) + image.width());
    }
    return values;
  };
  using V = std::vector<int>;
  EXPECT_EQ(pixels("P1 # 1 is black\n3 2\n1 0 1\n001"), (V{3, 2, 0, 255, 0, 255, 255, 0}));
  EXPECT_EQ(pixels("P2\n# a comment\n2 2 # another\n100\n0 50 100 200\n"),
            (V{2, 2, 0, 128, 255, 255}));
  EXPECT_EQ(pixels("P3 1 2 255 255 0 0  0 0 255"), (V{1, 2, 76, 29}));
  EXPECT_EQ(pixels("P4 9 2\n\x80\x80\x01\x7F"),
            (V{9, 2,   0,   255, 255, 255, 255, 255, 255, 255,
               0, 255, 255, 255, 255, 255, 255, 255, 0,   255}));
  EXPECT_EQ(pixels("P5 2 1 15\n\x0F\x05"), (V{2, 1, 255, 85}));
  EXPECT_EQ(pixels(std::string("P5 2 1 1023\n\x03\xFF\x01\x00", 16)), (V{2, 1, 255, 64}));
  EXPECT_EQ(pixels(std::string("P6 1 1 255\n\x00\xFF\x00", 14)), (V{1, 1, 150}));
}

TEST_F(ImageFileTest, OrientationTagIsIgnored) {
  Bytes jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", Gradient(48, 16), jpeg));
  // An Exif segment whose only entry says "rotate by 90 degrees".
  const Bytes exif{0xFF, 0xE1, 0, 34,   'E', 'x', 'i', 'f', 0, 0, 'M', 'M', 0, 42, 0, 0, 0, 8,
                   0,    1,    1, 0x12, 0,   3,   0,   0,   0, 1, 0,   6,   0, 0,  0, 0, 0, 0};
  jpeg.insert(jpeg.begin() + 2, exif.begin(), exif.end());
  ASSERT_EQ(cv::imdecode(jpeg, cv::IMREAD_GRAYSCALE).cols, 16) << "the tag should be valid";
  EXPECT_EQ(ReadImage(Save("a.jpg", jpeg)).width(), 48);
}

TEST_F(ImageFileTest, PngWarningsAndExtrasAreNotPrinted) {
  Bytes png;
  ASSERT_TRUE(cv::imencode(".png", Gradient(20, 20), png));
  // A colour profile chunk that libpng would warn about, with its checksum.
  const Bytes profile{0,    0,    0,    24,   'i',  'C',  'C',  'P',  'x',  0,    0,    0x78,
                      0x9C, 0xCB, 0xCB, 0x2F, 0x51, 0x48, 0x54, 0x28, 0x28, 0xCA, 0x4F, 0xCB,
                      0xCC, 0x49, 0x05, 0x00, 0x21, 0x73, 0x04, 0xE4, 0xD2, 0x62, 0xBB, 0x82};
  png.insert(png.begin() + 33, profile.begin(), profile.end());
  png.insert(png.end(), {'t', 'r', 'a', 's', 'h'});
  testing::internal::CaptureStderr();
  ASSERT_FALSE(cv::imdecode(png, cv::IMREAD_GRAYSCALE).empty());
  ASSERT_NE(testing::internal::GetCapturedStderr(), "") << "the chunk should cause a warning";
  testing::internal::CaptureStderr();
  EXPECT_EQ(LargestDifference(ReadImage(Save("a.png", png)), Gradient(20, 20)), 0);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(ImageFileTest, FilesThatAreNoImages) {
  ExpectReadError(Path("missing.png"), "No such file or directory");
  ExpectReadError(folder_.string(), "Is a directory");
  ExpectReadError(Save("empty.png", ""), "empty");
  ExpectReadError(Save("text.png", "this is not an image"), "not a PNG");
  ExpectReadError(Save("one.png", "P"), "not a PNG");
  ExpectReadError(Save("gif.gif", "GIF89a........"), "not a PNG");
  ASSERT_EQ(mkfifo(Path("fifo.png").c_str(), 0600), 0);
  ExpectReadError(Path("fifo.png"), "not a regular file");
  ExpectReadError(Save("file", "x") + "/a.png", "Not a directory");
}

TEST_F(ImageFileTest, EveryTruncationIsAnError) {
  cv::Mat mat(40, 50, CV_8UC3);
  cv::randu(mat, 0, 256);
  const std::vector<int> progressive{cv::IMWRITE_JPEG_PROGRESSIVE, 1};
  for (const std::string extension :
       {".png", ".jpg", ".bmp", ".ppm", ".tif", ".webp", "progressive"}) {
    Bytes bytes;
    if (extension == "progressive") {
      ASSERT_TRUE(cv::imencode(".jpg", mat, bytes, progressive));
    } else {
      ASSERT_TRUE(cv::imencode(extension, mat, bytes));
    }
    ASSERT_NO_THROW(ReadImage(Save("whole", bytes))) << extension;
    for (const double part : {0.02, 0.1, 0.3, 0.5, 0.9, 0.99}) {
      SCOPED_TRACE(extension + " cut at " + std::to_string(part));
      const Bytes start(bytes.begin(), bytes.begin() + static_cast<int>(part * bytes.size()));
      ExpectReadError(Save("part", start), part < 0.03 ? "" : "truncated");
    }
    bytes.pop_back();
    ExpectReadError(Save("part", bytes), "truncated");
  }
  ExpectReadError(Save("part", "P2 3 3 255 1 2 3 4"), "truncated");
  ExpectReadError(Save("part", "P5 3"), "truncated");
}

// Before memory is asked for: what a header claims is no size until the bytes are there.
TEST_F(ImageFileTest, EveryFormatKeepsToALimitOfPixels) {
  cv::Mat mat(40, 50, CV_8UC3), transparent(40, 50, CV_8UC4);
  cv::randu(mat, 0, 256);
  cv::randu(transparent, 0, 256);
  const auto check = [&](const std::string& extension, const cv::Mat& picture, int webp_quality) {
    SCOPED_TRACE(extension + " " + std::to_string(webp_quality));
    Bytes bytes;
    ASSERT_TRUE(cv::imencode(extension, picture, bytes, {cv::IMWRITE_WEBP_QUALITY, webp_quality}));
    const std::string path = Save("a", bytes);
    EXPECT_EQ(ReadImage(path, 2000).width(), 50);
    try {
      ReadImage(path, 1999);
      ADD_FAILURE() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kTooLarge);
      EXPECT_NE(std::string(error.what())
                    .find("a': too large: 50x40 pixels, more than the limit of 1999"),
                std::string::npos)
          << error.what();
    }
  };
  for (const char* extension : {".png", ".jpg", ".bmp", ".ppm", ".tif"}) check(extension, mat, 80);
  check(".webp", mat, 80);          // VP8
  check(".webp", mat, 101);         // VP8L
  check(".webp", transparent, 80);  // VP8X
  ExpectReadError(Save("a.pgm", "P2 30000 8000 255 1 2 3"), "truncated");
  ExpectReadError(Save("a.pbm", "P1 30000 8000 1 0 1"), "truncated");
}

TEST_F(ImageFileTest, CorruptFilesAreErrors) {
  Bytes png;
  ASSERT_TRUE(cv::imencode(".png", Gradient(64, 64), png));
  for (size_t at = 8; at < png.size(); at += 7) {
    Bytes changed = png;
    changed[at] ^= 0x10;
    ExpectReadError(Save("a.png", changed), "");
  }
  ExpectReadError(Save("a.pgm", "P5 x 3 255\n123456789"), "a number is missing");
  ExpectReadError(Save("a.pgm", "P5 0 3 255\n"), "0x3");
  ExpectReadError(Save("a.pgm", "P5 1 1 70000\n12"), "70000");
  ExpectReadError(Save("a.jpg", "\xFF\xD8\x12\x34\x56\x78\x9A"), "corrupt");
}

TEST_F(ImageFileTest, JpegGivesTheLuminanceOfEveryVariant) {
  cv::Mat color(37, 50, CV_8UC3);
  for (int y = 0; y < color.rows; ++y) {
    for (int x = 0; x < color.cols; ++x) {
      color.at<cv::Vec3b>(y, x) = cv::Vec3b(5 * x, 255 - 6 * y, 128 + (x - y));
    }
  }
  const std::vector<std::vector<int>> variants{{},
                                               {cv::IMWRITE_JPEG_PROGRESSIVE, 1},
                                               {cv::IMWRITE_JPEG_RST_INTERVAL, 2},
                                               {cv::IMWRITE_JPEG_QUALITY, 20}};
  for (const auto& variant : variants) {
    for (const cv::Mat& mat : {color, Gradient(37, 50)}) {
      Bytes bytes;
      ASSERT_TRUE(cv::imencode(".jpg", mat, bytes, variant));
      const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
      EXPECT_EQ(LargestDifference(ReadImage(Save("a.jpg", bytes)), expected), 0);
    }
  }
}

TEST_F(ImageFileTest, DamagedJpegPixelsAreAnErrorAndHarmlessBytesAreNot) {
  cv::Mat mat(64, 64, CV_8UC1);
  cv::randu(mat, 0, 256);
  Bytes jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", mat, jpeg));
  // The scan ends in the middle, with the end of the image right behind it.
  Bytes part(jpeg.begin(), jpeg.begin() + static_cast<int>(jpeg.size() / 2));
  part.insert(part.end(), {0xFF, 0xD9});
  ExpectReadError(Save("part.jpg", part), "corrupt: ");
  Bytes padded = jpeg;
  padded.insert(padded.end() - 2, {0x12, 0x34, 0x56});
  testing::internal::CaptureStderr();
  const Image image = ReadImage(Save("padded.jpg", padded));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(LargestDifference(image, cv::imdecode(jpeg, cv::IMREAD_GRAYSCALE)), 0);
}

TEST_F(ImageFileTest, FloatingPointPixelsAreRejected) {
  ExpectReadError(SaveMat("float.tif", cv::Mat(8, 8, CV_32FC1, cv::Scalar(0.5))),
                  "8-bit and 16-bit");
}

// Headers that claim more than is allowed, before anything is decoded.
TEST_F(ImageFileTest, HugeSizesAreRejected) {
  const auto big = [](uint32_t v) {
    return Bytes{uint8_t(v >> 24), uint8_t(v >> 16), uint8_t(v >> 8), uint8_t(v)};
  };
  cv::Mat row(1, 32767, CV_8UC1, cv::Scalar(7));
  ExpectReadError(SaveMat("a.png", row), "32767x1");
  ExpectReadError(SaveMat("a.jpg", row), "32767x1");
  ExpectReadError(SaveMat("a.bmp", row), "32767x1");
  ExpectReadError(SaveMat("a.pgm", row), "32767x1");
  ExpectReadError(SaveMat("a.tif", row), "32767x1");
  EXPECT_EQ(ReadImage(SaveMat("b.png", row.colRange(1, 32767))).width(), kMaxImageSide);
  // 20,000 x 20,000 in a few bytes: the sides pass, the number of pixels does not.
  ExpectReadError(Save("a.pbm", "P1 20000 20000 1"), "20000x20000", ErrorCode::kTooLarge);
  Bytes jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", Gradient(16, 16), jpeg));
  const Bytes frame{0xFF, 0xC0};
  const auto at = std::search(jpeg.begin(), jpeg.end(), frame.begin(), frame.end());
  ASSERT_NE(at, jpeg.end());
  for (int i : {5, 7}) std::copy_n(big(20000 << 16).begin(), 2, at + i);
  ExpectReadError(Save("bomb.jpg", jpeg), "20000x20000", ErrorCode::kTooLarge);
}

TEST_F(ImageFileTest, WriteErrors) {
  const Image image = ToImage(Gradient(8, 8));
  const auto message = [&](const std::string& path) -> std::string {
    try {
      WriteImage(image.view(), path);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFile);
      EXPECT_NE(std::string(error.what()).find("'" + path + "'"), std::string::npos);
      return error.what();
    }
    return "no error";
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_PRED2(has, message(Path("a.xyz")), "'.xyz'");
  EXPECT_PRED2(has, message(Path("a")), "extension");
  EXPECT_PRED2(has, message(Path("none/a.png")), "No such file or directory");
  fs::create_directory(Path("folder.png"));
  EXPECT_PRED2(has, message(Path("folder.png")), "Is a directory");
  ASSERT_EQ(mkfifo(Path("fifo.png").c_str(), 0600), 0);
  EXPECT_PRED2(has, message(Path("fifo.png")), "not a regular file");
  const Image wide = ToImage(Gradient(20000, 1));  // WebP ends at 16,383
  EXPECT_THROW(WriteImage(wide.view(), Path("wide.webp")), Error);
  EXPECT_THROW(WriteImage({nullptr, 8, 8, 8}, Path("null.png")), Error);
  // Nothing half-written is left behind.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
}

TEST_F(ImageFileTest, WritingReplacesTheOldFileOnly) {
  const std::string path = Save("a.png", "old");
  WriteImage(ToImage(Gradient(8, 8)).view(), path);
  EXPECT_EQ(LargestDifference(ReadImage(path), Gradient(8, 8)), 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
  const mode_t mask = umask(0);
  umask(mask);
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0666 & ~mask) << "as any other new file";
  fs::current_path(folder_);
  WriteImage(ToImage(Gradient(8, 8)).view(), "relative.png");
  EXPECT_TRUE(fs::exists(Path("relative.png")));
  fs::current_path("/");
}

TEST_F(ImageFileTest, ListsImagesSortedByName) {
  for (const char* name : {"b.png", "a.JPG", "c.jpeg", "e.bmp", "d.pgm", "f.ppm", "g.pnm", "h.tif",
                           "i.TIFF", "j.webp", "k.txt", "l", ".hidden.png", "png"}) {
    Save(name, "x");
  }
  fs::create_directory(Path("m.png"));
  fs::create_directory(Path("sub"));
  Save("sub/n.png", "x");
  std::vector<std::string> expected;
  for (const char* name : {"a.JPG", "b.png", "c.jpeg", "d.pgm", "e.bmp", "f.ppm", "g.pnm", "h.tif",
                           "i.TIFF", "j.webp"}) {
    expected.push_back(Path(name));
  }
  EXPECT_EQ(ListImages(folder_.string()), expected);
}

TEST_F(ImageFileTest, ListErrors) {
  const auto message = [](const std::string& folder) -> std::string {
    try {
      ListImages(folder);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFile);
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message(folder_.string()),
            "cannot list folder '" + folder_.string() + "': it holds no image file");
  EXPECT_EQ(message(Path("none")),
            "cannot list folder '" + Path("none") + "': No such file or directory");
  EXPECT_EQ(message(Save("file", "x")),
            "cannot list folder '" + Path("file") + "': Not a directory");
}

}  // namespace
}  // namespace topotag
