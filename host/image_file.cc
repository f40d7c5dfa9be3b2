#include "topotag/image_file.h"

#include <algorithm>
#include <climits>
#include <filesystem>
#include <iterator>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <system_error>

#include "host/check.h"
#include "host/encoded_image.h"
#include "host/file.h"
#include "host/jpeg.h"
#include "host/webp.h"
#include "topotag/error.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtensions[] = {".png", ".jpg", ".jpeg", ".bmp",  ".pgm",
                                       ".ppm", ".pnm", ".tif",  ".tiff", ".webp"};

[[noreturn]] void Fail(const std::string& reason) { throw Error(ErrorCode::kFile, reason); }

bool IsImageExtension(const std::string& extension) {
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) !=
         std::end(kExtensions);
}

template <typename Sample>
Image ToLuminance(const cv::Mat& mat, uint64_t max) {
  Image image(mat.cols, mat.rows);
  const int channels = mat.channels();
  for (int y = 0; y < mat.rows; ++y) {
    const Sample* in = mat.ptr<Sample>(y);
    uint8_t* out = image.row(y);
    for (int x = 0; x < mat.cols; ++x, in += channels) {
      // One or two channels are grey and alpha, three or four are B, G, R and alpha.
      out[x] =
          channels < 3 ? Luminance(in[0], in[0], in[0], max) : Luminance(in[2], in[1], in[0], max);
    }
  }
  return image;
}

std::vector<uint8_t> Encode(const ImageView& image, const std::string& extension) {
  // OpenCV's headers take no const data; the encoders only read it.
  const cv::Mat mat(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                    static_cast<size_t>(image.stride));
  std::vector<uint8_t> bytes;
  try {
    // Every PNM extension gets the one PNM format for grey levels.
    const bool pnm = extension == ".ppm" || extension == ".pnm";
    if (cv::imencode(pnm ? ".pgm" : extension, mat, bytes)) return bytes;
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw std::bad_alloc();
    Fail("cannot be encoded: " + error.err.substr(0, error.err.find('\n')));
  }
  Fail("an image of " + Text(image.width, image.height) +
       " pixels cannot be encoded in this format");
}

}  // namespace

Image DecodeImage(std::vector<uint8_t> bytes, uint64_t max_pixels) {
  if (bytes.empty()) Fail("the file is empty");
  const ImageFormat format = CheckEncodedImage(&bytes, max_pixels);
  if (format == ImageFormat::kPnm) return DecodePnm(bytes);
  if (format == ImageFormat::kJpeg) return DecodeJpeg(bytes, max_pixels);
  if (format == ImageFormat::kWebp) return DecodeWebp(bytes, max_pixels);
  cv::Mat mat;
  try {
    // Unchanged also means that no orientation tag is applied.
    mat = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw std::bad_alloc();
    Fail("cannot be decoded: " + error.err.substr(0, error.err.find('\n')));
  }
  if (mat.empty()) Fail("cannot be decoded: corrupt, or of an unsupported variant");
  if (mat.channels() > 4) Fail(std::to_string(mat.channels()) + " channels are not supported");
  if (mat.depth() == CV_8U) return ToLuminance<uint8_t>(mat, 255);
  if (mat.depth() == CV_16U) return ToLuminance<uint16_t>(mat, 65535);
  Fail("only 8-bit and 16-bit unsigned integer pixels are supported");
}

Image ReadImage(const std::string& path, uint64_t max_pixels) {
  const std::string prefix = "cannot read image '" + path + "': ";
  try {
    return DecodeImage(ReadBytes(path, INT_MAX), max_pixels);
  } catch (const Error& error) {
    throw Error(error.code(), prefix + error.what());
  } catch (const std::bad_alloc&) {
    Fail(prefix + "not enough memory");
  }
}

void WriteImage(const ImageView& image, const std::string& path) {
  ValidateImage(image);
  std::vector<uint8_t> bytes;
  std::string reason;
  try {
    const std::string extension = LowerExtension(path);
    if (!IsImageExtension(extension)) {
      std::string known;
      for (const char* name : kExtensions) known += (known.empty() ? "" : ", ") + std::string(name);
      Fail("unknown image extension '" + extension + "': expected one of " + known);
    }
    bytes = Encode(image, extension);
  } catch (const Error& error) {
    reason = error.what();
  } catch (const std::bad_alloc&) {
    reason = "not enough memory";
  }
  if (!reason.empty()) Fail("cannot write '" + path + "': " + reason);
  WriteWholeFile(path, bytes.data(), bytes.size());
}

std::vector<std::string> ListImages(const std::string& folder) {
  const std::string prefix = "cannot list folder '" + folder + "': ";
  std::vector<std::string> paths;
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    std::error_code unreadable;
    const bool hidden = entry->path().filename().string()[0] == '.';
    if (!hidden && IsImageExtension(LowerExtension(entry->path())) &&
        entry->is_regular_file(unreadable)) {
      paths.push_back(entry->path().string());
    }
  }
  if (error) Fail(prefix + error.message());
  if (paths.empty()) Fail(prefix + "it holds no image file");
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace topotag
