#include "kernels/program.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <vector>

#include "host/file.h"
#include "kernels/cache_file.h"
#include "kernels/embedded.h"
#include "topotag/error.h"

namespace topotag::opencl {
namespace {

constexpr char kSourceVariable[] = "TOPOTAG_KERNEL_DIR";
constexpr char kOptions[] = "-cl-std=CL1.2";
constexpr size_t kMaxSource = size_t{1} << 20;

std::string Variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

// All files as one text, with lines numbered as in the files.
std::string Source() {
  const std::string folder = Variable(kSourceVariable);
  std::string source;
  for (size_t i = 0; i < kKernelFileCount; ++i) {
    const KernelFile& file = kKernelFiles[i];
    source += std::string("#line 1 \"") + file.name + "\"\n";
    if (folder.empty()) {
      source.append(file.text, file.size);
      continue;
    }
    const std::string path = folder + "/" + file.name;
    try {
      source += ReadText(path, kMaxSource);
    } catch (const Error& error) {
      throw Error(ErrorCode::kFile,
                  std::string(kSourceVariable) + ": cannot read '" + path + "': " + error.what());
    }
  }
  return source;
}

// Everything that the binary depends on.
std::string CacheKey(const Device& device, const std::string& source) {
  const DeviceInfo& info = device.info;
  std::string key = "topotag kernels\n";
  for (const std::string& part :
       {info.platform, info.name, info.version, info.driver, std::string(kOptions), source}) {
    key += part + "\n";
  }
  return key;
}

std::string CacheFolder() {
  const std::string folder = Variable("TOPOTAG_CACHE_DIR");
  if (!folder.empty()) return folder;
  const std::string cache = Variable("XDG_CACHE_HOME");
  if (!cache.empty()) return cache + "/topotag";
  const std::string home = Variable("HOME");
  return home.empty() ? home : home + "/.cache/topotag";
}

std::string CachePath(const std::string& key) {
  const std::string folder = CacheFolder();
  if (folder.empty()) return folder;
  return folder + "/" + CacheFileName(key);
}

std::string BuildLog(cl_program program, cl_device_id device) {
  size_t size = 0;
  TOPOTAG_CL(clGetProgramBuildInfo, program, device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
  std::string log(size, '\0');
  TOPOTAG_CL(clGetProgramBuildInfo, program, device, CL_PROGRAM_BUILD_LOG, size, log.data(),
             nullptr);
  log.resize(std::min(log.find('\0'), log.size()));
  return log;
}

Program BuildSource(cl_context context, const Device& device, const std::string& source) {
  const char* text = source.data();
  const size_t size = source.size();
  cl_int code = CL_SUCCESS;
  Program program(clCreateProgramWithSource(context, 1, &text, &size, &code));
  TOPOTAG_CL_CODE(clCreateProgramWithSource, code);
  code = clBuildProgram(program.get(), 1, &device.id, kOptions, nullptr, nullptr);
  if (code == CL_BUILD_PROGRAM_FAILURE) {
    throw Error(ErrorCode::kDevice, "OpenCL: the kernels do not build on " + device.info.name +
                                        ":\n" + BuildLog(program.get(), device.id));
  }
  TOPOTAG_CL_CODE(clBuildProgram, code);
  return program;
}

// A program without kernels where the binary is of no use to the driver.
Program BuildBinary(cl_context context, const Device& device, const std::string& binary) {
  const size_t size = binary.size();
  const unsigned char* bytes = reinterpret_cast<const unsigned char*>(binary.data());
  cl_int status = CL_SUCCESS;
  cl_int code = CL_SUCCESS;
  Program program(clCreateProgramWithBinary(context, 1, &device.id, &size, &bytes, &status, &code));
  if (code != CL_SUCCESS || status != CL_SUCCESS ||
      clBuildProgram(program.get(), 1, &device.id, kOptions, nullptr, nullptr) != CL_SUCCESS) {
    program.Reset();
  }
  return program;
}

// A program has a binary for each device of its context; only one of them was built.
std::string BinaryOf(cl_program program, cl_device_id device) {
  cl_uint count = 0;
  TOPOTAG_CL(clGetProgramInfo, program, CL_PROGRAM_NUM_DEVICES, sizeof(count), &count, nullptr);
  std::vector<cl_device_id> devices(count);
  std::vector<size_t> sizes(count);
  TOPOTAG_CL(clGetProgramInfo, program, CL_PROGRAM_DEVICES, count * sizeof(cl_device_id),
             devices.data(), nullptr);
  TOPOTAG_CL(clGetProgramInfo, program, CL_PROGRAM_BINARY_SIZES, count * sizeof(size_t),
             sizes.data(), nullptr);
  std::string binary;
  std::vector<unsigned char*> places(count);
  for (size_t i = 0; i < count; ++i) {
    if (devices[i] != device || sizes[i] == 0) continue;
    binary.resize(sizes[i]);
    places[i] = reinterpret_cast<unsigned char*>(binary.data());
  }
  if (binary.empty()) return binary;
  TOPOTAG_CL(clGetProgramInfo, program, CL_PROGRAM_BINARIES, count * sizeof(unsigned char*),
             places.data(), nullptr);
  return binary;
}

void WriteCache(const std::string& path, const std::string& key, cl_program program,
                cl_device_id device) {
  if (path.empty()) return;
  try {
    const std::string binary = BinaryOf(program, device);
    if (!binary.empty()) WriteCacheFile(path, key, binary);
  } catch (const std::exception&) {
    // Without a cache the next start takes longer, that is all.
  }
}

}  // namespace

std::string CacheFile(const Device& device) { return CachePath(CacheKey(device, Source())); }

Program BuildProgram(cl_context context, const Device& device) {
  const std::string source = Source();
  const std::string key = CacheKey(device, source);
  const std::string path = CachePath(key);
  const std::string binary = ReadCacheFile(path, key);
  if (!binary.empty()) {
    Program program = BuildBinary(context, device, binary);
    if (program.get() != nullptr) return program;
  }
  Program program = BuildSource(context, device, source);
  WriteCache(path, key, program.get(), device.id);
  return program;
}

}  // namespace topotag::opencl
