#include "topotag/image_file.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <system_error>

#include "host/encoded_image.h"
#include "topotag/error.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtensions[] = {".png", ".jpg", ".jpeg", ".bmp",  ".pgm",
                                       ".ppm", ".pnm", ".tif",  ".tiff", ".webp"};

[[noreturn]] void Fail(const std::string& reason) { throw Error(ErrorCode::kFile, reason); }

std::string Reason(int error) { return std::generic_category().message(error); }

std::string LowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

bool IsImageExtension(const std::string& extension) {
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) !=
         std::end(kExtensions);
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::vector<uint8_t> ReadBytes(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) Fail(error ? error.message() : Reason(ENOENT));
  if (fs::is_directory(status)) Fail(Reason(EISDIR));
  if (!fs::is_regular_file(status)) Fail("not a regular file");
  const uintmax_t size = fs::file_size(path, error);
  if (error) Fail(error.message());
  if (size == 0) Fail("the file is empty");
  if (size > INT_MAX) Fail("the file is larger than 2 GiB");
  errno = 0;
  const File file(std::fopen(path.c_str(), "rb"));
  if (file == nullptr) Fail(Reason(errno));
  std::vector<uint8_t> bytes(size);
  const size_t read = std::fread(bytes.data(), 1, bytes.size(), file.get());
  if (std::ferror(file.get()) != 0) Fail(Reason(errno));
  bytes.resize(read);
  return bytes;
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

Image Decode(std::vector<uint8_t> bytes) {
  const ImageFormat format = CheckEncodedImage(&bytes);
  if (format == ImageFormat::kPnm) return DecodePnm(bytes);
  // A JPEG file holds the luminance itself. Unchanged too means that no orientation tag is applied.
  const int flags = format == ImageFormat::kJpeg
                        ? cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION
                        : cv::IMREAD_UNCHANGED;
  cv::Mat mat;
  try {
    mat = cv::imdecode(bytes, flags);
  } catch (const cv::Exception& error) {
    Fail("cannot be decoded: " + error.err.substr(0, error.err.find('\n')));
  }
  if (mat.empty()) Fail("cannot be decoded: corrupt, or of an unsupported variant");
  if (mat.channels() > 4) Fail(std::to_string(mat.channels()) + " channels are not supported");
  if (mat.depth() == CV_8U) return ToLuminance<uint8_t>(mat, 255);
  if (mat.depth() == CV_16U) return ToLuminance<uint16_t>(mat, 65535);
  Fail("only 8-bit and 16-bit unsigned integer pixels are supported");
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
    Fail("cannot be encoded: " + error.err.substr(0, error.err.find('\n')));
  }
  Fail("an image of " + std::to_string(image.width) + "x" + std::to_string(image.height) +
       " pixels cannot be encoded in this format");
}

// Writes next to the target and renames, so that the target is whole at any time.
void ReplaceFile(const fs::path& path, const std::vector<uint8_t>& bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) Fail(Reason(EISDIR));
  // Renaming would replace a device or a pipe by a file.
  if (fs::exists(status) && !fs::is_regular_file(status)) Fail("not a regular file");
  static std::atomic<unsigned> counter{0};
  fs::path temporary;
  File file;
  for (int attempt = 0; file == nullptr; ++attempt) {
    temporary = path.parent_path() / (".topotag-" + std::to_string(counter++) + ".tmp");
    errno = 0;
    file.reset(std::fopen(temporary.c_str(), "wbx"));
    if (file == nullptr && (errno != EEXIST || attempt == 1000)) Fail(Reason(errno));
  }
  errno = 0;
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  const bool closed = std::fclose(file.release()) == 0;
  std::string reason = written && closed ? "" : Reason(errno);
  if (reason.empty()) {
    fs::rename(temporary, path, error);
    if (!error) return;
    reason = error.message();
  }
  fs::remove(temporary, error);
  Fail(reason);
}

}  // namespace

Image ReadImage(const std::string& path) {
  std::string reason;
  try {
    return Decode(ReadBytes(path));
  } catch (const Error& error) {
    reason = error.what();
  } catch (const std::bad_alloc&) {
    reason = "not enough memory";
  }
  Fail("cannot read image '" + path + "': " + reason);
}

void WriteImage(const ImageView& image, const std::string& path) {
  ValidateImage(image);
  std::string reason;
  try {
    const std::string extension = LowerExtension(path);
    if (!IsImageExtension(extension)) {
      std::string known;
      for (const char* name : kExtensions) known += (known.empty() ? "" : ", ") + std::string(name);
      Fail("unknown image extension '" + extension + "': expected one of " + known);
    }
    return ReplaceFile(path, Encode(image, extension));
  } catch (const Error& error) {
    reason = error.what();
  } catch (const std::bad_alloc&) {
    reason = "not enough memory";
  }
  Fail("cannot write image '" + path + "': " + reason);
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
