// Variants of image files that OpenCV does not write, made here byte by byte.
#include "host/encoded_image.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

// Needs <cstdio> above it.
#include <jpeglib.h>

#include "topotag/error.h"
#include "topotag/image.h"

namespace topotag {
namespace {

using Bytes = std::vector<uint8_t>;
using Values = std::vector<int>;

Values Pixels(const Image& image) {
  Values values{image.width(), image.height()};
  for (int y = 0; y < image.height(); ++y) {
    values.insert(values.end(), image.row(y), image.row(y) + image.width());
  }
  return values;
}

std::string DecodeError(const Bytes& bytes) {
  try {
    DecodeImage(bytes);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFile);
    return error.what();
  }
  return "no error";
}

void Append(Bytes* bytes, uint32_t value, int size) {
  for (int i = 0; i < size; ++i) bytes->push_back(static_cast<uint8_t>(value >> 8 * i));
}

TEST(EncodedImageTest, BmpWithTheOldHeader) {
  Bytes bmp{'B', 'M'};
  for (const uint32_t value : {14 + 12 + 2 * 8, 0, 14 + 12}) Append(&bmp, value, 4);
  Append(&bmp, 12, 4);                                                // its header has 12 bytes
  for (const uint32_t value : {2, 2, 1, 24}) Append(&bmp, value, 2);  // width, height, planes, bits
  // From the last row on, blue first, rows of whole words.
  const Bytes pixels{10, 10, 10, 20, 20, 20, 0, 0, 0, 0, 255, 40, 40, 40, 0, 0};
  bmp.insert(bmp.end(), pixels.begin(), pixels.end());
  EXPECT_EQ(Pixels(DecodeImage(bmp)), (Values{2, 2, 76, 40, 10, 20}));
  bmp.pop_back();
  EXPECT_EQ(DecodeError(bmp), "truncated");
}

struct TiffTag {
  uint32_t tag, type, value;
};

// One tile of 16 x 16 grey pixels, of which 3 x 2 are the picture.
Bytes TiledTiff() {
  constexpr uint32_t kShort = 3, kLong = 4;
  const std::vector<TiffTag> tags{
      {256, kShort, 3}, {257, kShort, 2},  {258, kShort, 8},  {259, kShort, 1}, {262, kShort, 1},
      {277, kShort, 1}, {322, kShort, 16}, {323, kShort, 16}, {324, kLong, 0},  {325, kLong, 256}};
  const auto end = static_cast<uint32_t>(8 + 2 + 12 * tags.size() + 4);
  Bytes tiff{'I', 'I', 42, 0};
  Append(&tiff, 8, 4);
  Append(&tiff, static_cast<uint32_t>(tags.size()), 2);
  for (const TiffTag& tag : tags) {
    Append(&tiff, tag.tag, 2);
    Append(&tiff, tag.type, 2);
    Append(&tiff, 1, 4);
    Append(&tiff, tag.tag == 324 ? end : tag.value, 4);
  }
  Append(&tiff, 0, 4);
  for (uint32_t i = 0; i < 256; ++i) Append(&tiff, i, 1);
  return tiff;
}

// Not every version of OpenCV reads such files; the check must let them through to it.
TEST(EncodedImageTest, TiffInTiles) {
  Bytes tiff = TiledTiff();
  EXPECT_EQ(CheckEncodedImage(&tiff), ImageFormat::kTiff);
  tiff.pop_back();
  EXPECT_EQ(DecodeError(tiff), "truncated");
}

TEST(EncodedImageTest, TiffWithoutPlacesOfItsPixels) {
  Bytes tiff = TiledTiff();
  tiff[8 + 2 + 12 * 8] = 0;  // the tag of the tiles' places
  EXPECT_EQ(DecodeError(tiff), "corrupt: TIFF without pixel data");
}

TEST(EncodedImageTest, WebpWithoutAPicture) {
  Bytes webp{'R', 'I', 'F', 'F', 12, 0, 0, 0, 'W', 'E', 'B', 'P', 'J', 'U', 'N', 'K', 0, 0, 0, 0};
  EXPECT_EQ(DecodeError(webp), "corrupt: WebP without a picture");
}

// With a version in its header that WebP does not have, OpenCV takes this for a medical image,
// whose decoder ends the process.
TEST(EncodedImageTest, WebpIsNotHandedOnToOtherDecoders) {
  Bytes webp{'R', 'I', 'F', 'F', 156, 0, 0, 0,    'W',  'E',  'B',  'P', 'V',
             'P', '8', 'L', 144, 0,   0, 0, 0x2f, 0x02, 0x00, 0x36, 0x35};
  webp.resize(128);
  const uint8_t medical[] = {'D',  'I',  'C',  'M',  0x01, 0x01, 0xff, 0xd8, 'P',  'N',
                             0x00, 0x10, 'D',  'I',  'A',  'N',  'C',  'E',  0x08, 0x0b,
                             0x0a, 0x0c, 0x09, 0x0a, 0x0a, 0x0a, 0xff, 0xc0, 0xda, 0x00,
                             0x08, 0x01, 0x01, 0x09, 0x00, 0x00, 0x3f};
  webp.insert(webp.end(), std::begin(medical), std::end(medical));
  webp.resize(170);
  EXPECT_EQ(DecodeError(webp), "cannot be decoded: corrupt, or of an unsupported variant");
}

TEST(EncodedImageTest, JpegWithFillBytesBeforeAMarker) {
  const cv::Mat grey(8, 8, CV_8UC1, cv::Scalar(77));
  Bytes jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", grey, jpeg));
  const Values plain = Pixels(DecodeImage(jpeg));
  EXPECT_NEAR(plain[2], 77, 1);
  jpeg.insert(jpeg.begin() + 2, 3, 0xFF);
  EXPECT_EQ(Pixels(DecodeImage(jpeg)), plain);
}

// As Adobe's programs write them: 255 is no ink.
Bytes JpegOfFourInks(const Bytes& inks, int width) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* data = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &data, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = 1;
  jpeg.input_components = 4;
  jpeg.in_color_space = JCS_CMYK;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  JSAMPROW row = const_cast<JSAMPROW>(inks.data());
  jpeg_write_scanlines(&jpeg, &row, 1);
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  Bytes bytes(data, data + size);
  std::free(data);
  return bytes;
}

TEST(EncodedImageTest, JpegOfFourInks) {
  const std::vector<Bytes> colors{
      {255, 255, 255, 255}, {255, 255, 255, 0}, {255, 0, 0, 255}, {100, 150, 200, 128}};
  constexpr int kWide = 16;  // of one colour, so that nothing rings
  Bytes inks;
  for (const Bytes& color : colors) {
    for (int i = 0; i < kWide; ++i) inks.insert(inks.end(), color.begin(), color.end());
  }
  const int width = kWide * static_cast<int>(colors.size());
  const Image image = DecodeImage(JpegOfFourInks(inks, width));
  ASSERT_EQ(image.width(), width);
  for (size_t i = 0; i < colors.size(); ++i) {
    const Bytes& c = colors[i];
    const double light = (0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2]) * c[3] / 255;
    EXPECT_NEAR(image.row(0)[kWide * i + kWide / 2], light, 2) << i;
  }
}

}  // namespace
}  // namespace topotag
