// Whole files: what may be read, and that an output is replaced as a whole or not at all.
#include "host/file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "topotag/error.h"

namespace topotag {
namespace {

namespace fs = std::filesystem;

class FileTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "file_test.XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  std::string Save(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name), std::ios::binary) << text;
    return Path(name);
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  fs::path folder_;
};

template <typename Action>
std::string ErrorOf(Action action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kFile);
    return error.what();
  }
  return "no error";
}

using Strings = std::vector<std::string>;

TEST_F(FileTest, ReadsBytesAsTheyAre) {
  const std::string text("a\0\r\n\xFF", 5);
  const std::string path = Save("file", text);
  EXPECT_EQ(ReadText(path, 5), text);
  EXPECT_EQ(ReadBytes(path, 5), std::vector<uint8_t>(text.begin(), text.end()));
  EXPECT_EQ(ReadText(Save("empty", ""), 0), "");
}

TEST_F(FileTest, ReadsRegularFilesUpToASizeOnly) {
  const auto error = [](const std::string& path) { return ErrorOf([&] { ReadText(path, 4); }); };
  EXPECT_EQ(error(Save("file", "12345")), "the file is larger than 4 bytes");
  EXPECT_EQ(error(Path("none")), "No such file or directory");
  EXPECT_EQ(error(Path("file/inside")), "Not a directory");
  EXPECT_EQ(error(folder_.string()), "Is a directory");
  EXPECT_EQ(error("/dev/zero"), "not a regular file");
  ASSERT_EQ(mkfifo(Path("fifo").c_str(), 0600), 0);
  EXPECT_EQ(error(Path("fifo")), "not a regular file");
}

TEST_F(FileTest, ExtensionIsLowerCase) {
  EXPECT_EQ(LowerExtension("a.b/C.PnG"), ".png");
  EXPECT_EQ(LowerExtension("a.b/c"), "");
  EXPECT_EQ(LowerExtension(".png"), "");
}

TEST_F(FileTest, AnOutputThatIsNotCommittedLeavesNothing) {
  Save("old", "old");
  {
    OutputFile old_file(Path("old")), new_file(Path("new"));
    old_file.Write("12", 2);
    new_file.Write("12", 2);
    EXPECT_EQ(Names().size(), 3u) << "two temporary files beside the old one";
  }
  EXPECT_EQ(Names(), Strings{"old"});
  EXPECT_EQ(ReadText(Path("old"), 10), "old");
}

TEST_F(FileTest, ACommittedOutputReplacesTheOldFile) {
  Save("old", "old");
  OutputFile file(Path("old"));
  file.Write("12", 2);
  file.Write("3", 1);
  EXPECT_EQ(ReadText(Path("old"), 10), "old");
  file.Commit();
  EXPECT_EQ(ReadText(Path("old"), 10), "123");
  EXPECT_EQ(Names(), Strings{"old"});
}

TEST_F(FileTest, ASymbolicLinkStaysOne) {
  fs::create_directory(Path("there"));
  Save("there/target", "old");
  fs::create_symlink("there/target", Path("link"));
  WriteWholeFile(Path("link"), "new");
  EXPECT_TRUE(fs::is_symlink(Path("link")));
  EXPECT_EQ(ReadText(Path("there/target"), 10), "new");
  EXPECT_EQ(Names(), (Strings{"link", "there"}));
}

TEST_F(FileTest, NothingButAFileIsReplaced) {
  const auto error = [&](const std::string& name) {
    const std::string path = Path(name);
    const std::string message = ErrorOf([&] { WriteWholeFile(path, "1"); });
    const std::string start = "cannot write '" + path + "': ";
    EXPECT_EQ(message.compare(0, start.size(), start), 0) << message;
    return message.substr(std::min(start.size(), message.size()));
  };
  fs::create_directory(Path("folder"));
  Save("file", "old");
  ASSERT_EQ(mkfifo(Path("fifo").c_str(), 0600), 0);
  fs::create_symlink("fifo", Path("link"));
  EXPECT_EQ(error("folder"), "Is a directory");
  EXPECT_EQ(error("fifo"), "not a regular file");
  EXPECT_EQ(error("link"), "not a regular file");
  EXPECT_EQ(error("file/inside"), "Not a directory");
  EXPECT_EQ(error("none/file"), "No such file or directory");
  EXPECT_TRUE(fs::is_fifo(Path("fifo")));
  if (geteuid() != 0) {  // root may write every file
    fs::permissions(Path("file"), fs::perms::owner_read);
    EXPECT_EQ(error("file"), "Permission denied");
  }
  EXPECT_EQ(ReadText(Path("file"), 10), "old");
  EXPECT_EQ(Names(), (Strings{"fifo", "file", "folder", "link"}));
}

}  // namespace
}  // namespace topotag
