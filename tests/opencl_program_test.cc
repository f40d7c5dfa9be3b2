// How the kernels are built and where the result is kept.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "kernels/embedded.h"
#include "kernels/program.h"
#include "tests/opencl_util.h"
#include "tests/random_image.h"
#include "tests/temporary_folder.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

std::string ReadAll(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void WriteAll(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// Builds the kernels and runs one frame.
void ExpectWorks() {
  const PaddedImage image = MakeImage({150, 70, 0, Content::kBlobs, 3});
  opencl::Binarizer binarizer(opencl::ChooseDevice({}), nullptr, opencl::Transfer::kMapped);
  binarizer.Submit(image.view(), {});
  EXPECT_EQ(CollectDifference(Reference(image.view(), {}), &binarizer), "");
}

class OpenClProgramTest : public ::testing::Test {
 protected:
  static std::string File() { return opencl::CacheFile(opencl::ChooseDevice({})); }

  test::TemporaryFolder folder_;
  ScopedVariable cache_{"TOPOTAG_CACHE_DIR", (folder_.path() / "cache").string()};
};

TEST_F(OpenClProgramTest, IsKept) {
  EXPECT_FALSE(fs::exists(File()));
  ExpectWorks();
  ASSERT_TRUE(fs::exists(File()));
  EXPECT_EQ(fs::path(File()).parent_path(), folder_.path() / "cache");
  const auto written = fs::last_write_time(File());
  ExpectWorks();
  EXPECT_EQ(fs::last_write_time(File()), written);
}

TEST_F(OpenClProgramTest, DamagedFilesAreIgnored) {
  ExpectWorks();
  const std::string whole = ReadAll(File());
  std::vector<std::string> damaged = {"", "x", whole.substr(0, whole.size() / 2),
                                      whole.substr(0, whole.size() - 1), whole + "x"};
  for (const size_t place : {size_t{0}, whole.size() / 2, whole.size() - 1}) {
    damaged.push_back(whole);
    damaged.back()[place] = static_cast<char>(damaged.back()[place] ^ 1);
  }
  for (const std::string& bytes : damaged) {
    WriteAll(File(), bytes);
    ExpectWorks();
    // Built again, and kept as it should be.
    EXPECT_NE(ReadAll(File()), bytes);
  }
}

TEST_F(OpenClProgramTest, ManyAtATime) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back(ExpectWorks);
  for (std::thread& thread : threads) thread.join();
  size_t files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_.path() / "cache")) {
    EXPECT_EQ(entry.path(), File());
    ++files;
  }
  EXPECT_EQ(files, 1U);
  ExpectWorks();
}

TEST_F(OpenClProgramTest, AnUnusableFolderIsAsNone) {
  WriteAll(folder_.path() / "file", "");
  for (const std::string& folder :
       {(folder_.path() / "file").string(), (folder_.path() / "file" / "below").string(),
        std::string("/proc/none")}) {
    const ScopedVariable cache("TOPOTAG_CACHE_DIR", folder);
    ExpectWorks();
  }
}

TEST_F(OpenClProgramTest, OtherSourcesHaveAnotherFile) {
  const std::string embedded = File();
  for (size_t i = 0; i < opencl::kKernelFileCount; ++i) {
    const opencl::KernelFile& file = opencl::kKernelFiles[i];
    WriteAll(folder_.path() / file.name, std::string(file.text, file.size));
  }
  const ScopedVariable sources("TOPOTAG_KERNEL_DIR", folder_.path().string());
  EXPECT_EQ(File(), embedded);
  std::ofstream(folder_.path() / "binarize.cl", std::ios::app) << "// another\n";
  EXPECT_NE(File(), embedded);
  ExpectWorks();
}

TEST_F(OpenClProgramTest, TheBuildLogIsInTheError) {
  for (size_t i = 0; i < opencl::kKernelFileCount; ++i) {
    const opencl::KernelFile& file = opencl::kKernelFiles[i];
    WriteAll(folder_.path() / file.name, std::string(file.text, file.size));
  }
  std::ofstream(folder_.path() / "threshold.cl", std::ios::app) << "\nint broken = no_such_name;\n";
  const ScopedVariable sources("TOPOTAG_KERNEL_DIR", folder_.path().string());
  ExpectError(ErrorCode::kDevice, {"do not build", "no_such_name", "threshold.cl"}, ExpectWorks);
}

TEST_F(OpenClProgramTest, AMissingSourceIsNamed) {
  const ScopedVariable sources("TOPOTAG_KERNEL_DIR", folder_.path().string());
  ExpectError(ErrorCode::kFile, {"TOPOTAG_KERNEL_DIR", "pixels.cl"}, ExpectWorks);
}

}  // namespace
}  // namespace topotag
