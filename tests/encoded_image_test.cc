// Variants of image files that OpenCV does not write, made here byte by byte.
#include "host/encoded_image.h"

#include <gtest/gtest.h>

#include <algorithm>
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

std::string DecodeError(const Bytes& bytes, uint64_t max_pixels = kDefaultMaxPixels,
                        ErrorCode code = ErrorCode::kFile) {
  try {
    DecodeImage(bytes, max_pixels);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
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

constexpr uint32_t kShort = 3, kLong = 4;

// The tags end in places and sizes of the pixels: those whose value is 0 get the end of the file,
// where 256 bytes follow.
Bytes TiffOf(const std::vector<TiffTag>& tags) {
  const auto end = static_cast<uint32_t>(8 + 2 + 12 * tags.size() + 4);
  Bytes tiff{'I', 'I', 42, 0};
  Append(&tiff, 8, 4);
  Append(&tiff, static_cast<uint32_t>(tags.size()), 2);
  for (const TiffTag& tag : tags) {
    Append(&tiff, tag.tag, 2);
    Append(&tiff, tag.type, 2);
    Append(&tiff, 1, 4);
    Append(&tiff, tag.value == 0 ? end : tag.value, 4);
  }
  Append(&tiff, 0, 4);
  for (uint32_t i = 0; i < 256; ++i) Append(&tiff, i, 1);
  return tiff;
}

// One tile of grey pixels, of which 3 x 2 are the picture.
Bytes TiledTiff(uint32_t tile_width = 16, uint32_t tile_height = 16, uint32_t type = kLong) {
  return TiffOf({{256, kShort, 3},
                 {257, kShort, 2},
                 {258, kShort, 8},
                 {259, kShort, 1},
                 {262, kShort, 1},
                 {277, kShort, 1},
                 {322, type, tile_width},
                 {323, type, tile_height},
                 {324, kLong, 0},
                 {325, kLong, 256}});
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

// A decoder asks for the memory of a whole tile before it knows how much of it is there.
TEST(EncodedImageTest, TiffTilesAreNoReasonToAskForMemory) {
  for (const uint32_t side : {256, 512, 4096}) {  // as writers make them for any picture
    Bytes tiff = TiledTiff(side, side);
    EXPECT_EQ(CheckEncodedImage(&tiff), ImageFormat::kTiff) << side;
  }
  EXPECT_EQ(DecodeError(TiledTiff(32768, 16384)), "corrupt: TIFF tiles of 32768x16384 pixels");
  EXPECT_EQ(DecodeError(TiledTiff(65536, 65536)), "corrupt: TIFF tiles of 65536x65536 pixels");
  // libtiff takes numbers of other types, too.
  constexpr uint32_t kSigned = 9;
  EXPECT_EQ(DecodeError(TiledTiff(32768, 16384, kSigned)), "corrupt: TIFF tiles without a size");
  std::vector<TiffTag> both{
      {256, kShort, 16}, {257, kShort, 16}, {258, kShort, 8},  {259, kShort, 1},  {262, kShort, 1},
      {273, kLong, 0},   {277, kShort, 1},  {278, kShort, 16}, {279, kLong, 256}, {322, kLong, 16},
      {323, kLong, 16},  {324, kLong, 0},   {325, kLong, 256}};
  Bytes strips_and_tiles = TiffOf(both);
  EXPECT_EQ(CheckEncodedImage(&strips_and_tiles), ImageFormat::kTiff);
  both.back().value = 257;
  EXPECT_EQ(DecodeError(TiffOf(both)), "truncated");
  both[9].value = 32768;
  both[10].value = 16384;
  EXPECT_EQ(DecodeError(TiffOf(both)), "corrupt: TIFF tiles of 32768x16384 pixels");
  both[11].tag = both[12].tag = 40000;  // the strips alone are tiles then
  EXPECT_EQ(DecodeError(TiffOf(both)), "corrupt: TIFF tiles of 32768x16384 pixels");
  both.erase(both.begin() + 9);  // and the height alone makes them tiles
  EXPECT_EQ(DecodeError(TiffOf(both)), "corrupt: TIFF tiles without a size");
}

TEST(EncodedImageTest, AnimatedWebp) {
  Bytes still;
  ASSERT_TRUE(cv::imencode(".webp", cv::Mat(8, 9, CV_8UC1, cv::Scalar(77)), still,
                           {cv::IMWRITE_WEBP_QUALITY, 101}));
  const Bytes picture(still.begin() + 12, still.end());
  Bytes webp{'W', 'E', 'B', 'P'};
  const auto chunk = [&webp](const std::string& name, size_t size) {
    webp.insert(webp.end(), name.begin(), name.end());
    Append(&webp, static_cast<uint32_t>(size), 4);
  };
  chunk("VP8X", 10);
  Append(&webp, 2, 4);  // animated
  for (const uint32_t value : {8, 7}) Append(&webp, value, 3);
  chunk("ANIM", 6);
  webp.insert(webp.end(), 6, 0);
  chunk("ANMF", 16 + picture.size());
  for (const uint32_t value : {0, 0, 8, 7, 100}) Append(&webp, value, 3);
  webp.push_back(0);
  webp.insert(webp.end(), picture.begin(), picture.end());
  Bytes file{'R', 'I', 'F', 'F'};
  Append(&file, static_cast<uint32_t>(webp.size()), 4);
  file.insert(file.end(), webp.begin(), webp.end());
  EXPECT_EQ(DecodeError(file), "animated WebP is not supported");
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

// TEM has no length. Who reads one takes a comment for the frame, and the limit of pixels is none.
TEST(EncodedImageTest, JpegWithAMarkerAlone) {
  Bytes jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", cv::Mat(8, 8, CV_8UC1, cv::Scalar(77)), jpeg));
  const Values plain = Pixels(DecodeImage(jpeg));
  constexpr size_t kSegments = 2;
  ASSERT_EQ(jpeg[kSegments + 1], 0xE0);
  jpeg.insert(jpeg.begin() + kSegments, {0xFF, 0x01});
  EXPECT_EQ(Pixels(DecodeImage(jpeg)), plain);
  // 0xFFE0 would be the length; a frame of 1 x 1 stands there.
  constexpr size_t kTem = kSegments, kFrame = kTem + 2 + 0xFFE0;
  const size_t comment = kTem + 4 + (jpeg[kTem + 4] * 256u + jpeg[kTem + 5]);
  Bytes text(4 + 65533, ' ');
  const Bytes head{0xFF, 0xFE, 0xFF, 0xFF};
  const Bytes frame{0xFF, 0xC0, 0, 11, 8, 0, 1, 0, 1, 1, 1, 0x11, 0, 0xFF, 0xD9};
  std::copy(head.begin(), head.end(), text.begin());
  std::copy(frame.begin(), frame.end(), text.begin() + (kFrame - comment));
  jpeg.insert(jpeg.begin() + comment, text.begin(), text.end());
  ASSERT_EQ(jpeg[kFrame + 1], 0xC0);
  EXPECT_EQ(Pixels(DecodeImage(jpeg, 64)), plain);
  EXPECT_EQ(DecodeError(jpeg, 63, ErrorCode::kTooLarge),
            "too large: 8x8 pixels, more than the limit of 63");
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
