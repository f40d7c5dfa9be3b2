// Whole files: what may be read, and that an output is replaced as a whole or not at all.
#include "host/file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"
#include "topotag/error.h"

namespace {

bool has_unnamed_files = true;

}  // namespace

// Takes the place of the C library's open: a file system may know no files without a name.
extern "C" int OpenOfTest(const char* path, int flags, ...) __asm__("open");
int OpenOfTest(const char* path, int flags, ...) {
  const bool is_unnamed = (flags & O_TMPFILE) == O_TMPFILE;
  if (is_unnamed && !has_unnamed_files) {
    errno = EOPNOTSUPP;
    return -1;
  }
  mode_t mode = 0;
  if (is_unnamed || (flags & O_CREAT) != 0) {
    va_list arguments;
    va_start(arguments, flags);
    mode = va_arg(arguments, mode_t);
    va_end(arguments);
  }
  return static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

namespace topotag {
namespace {

namespace fs = std::filesystem;

class FileTest : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override { has_unnamed_files = GetParam(); }
  void TearDown() override { has_unnamed_files = true; }

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

  const test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
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

INSTANTIATE_TEST_SUITE_P(Temporary, FileTest, testing::Bool(),
                         [](const auto& info) { return info.param ? "Unnamed" : "Named"; });

TEST_P(FileTest, ReadsBytesAsTheyAre) {
  const std::string text("a\0\r\n\xFF", 5);
  const std::string path = Save("file", text);
  EXPECT_EQ(ReadText(path, 5), text);
  EXPECT_EQ(ReadBytes(path, 5), std::vector<uint8_t>(text.begin(), text.end()));
  EXPECT_EQ(ReadText(Save("empty", ""), 0), "");
}

TEST_P(FileTest, ReadsRegularFilesUpToASizeOnly) {
  const auto error = [](const std::string& path) { return ErrorOf([&] { ReadText(path, 4); }); };
  EXPECT_EQ(error(Save("file", "12345")), "the file is larger than 4 bytes");
  EXPECT_EQ(error(Path("none")), "No such file or directory");
  EXPECT_EQ(error(Path("file/inside")), "Not a directory");
  EXPECT_EQ(error(folder_.string()), "Is a directory");
  EXPECT_EQ(error("/dev/zero"), "not a regular file");
  ASSERT_EQ(mkfifo(Path("fifo").c_str(), 0600), 0);
  EXPECT_EQ(error(Path("fifo")), "not a regular file");
}

TEST_P(FileTest, ExtensionIsLowerCase) {
  EXPECT_EQ(LowerExtension("a.b/C.PnG"), ".png");
  EXPECT_EQ(LowerExtension("a.b/c"), "");
  EXPECT_EQ(LowerExtension(".png"), "");
}

TEST_P(FileTest, AnOutputThatIsNotCommittedLeavesNothing) {
  Save("old", "old");
  {
    OutputFile old_file(Path("old")), new_file(Path("new"));
    old_file.Write("12", 2);
    new_file.Write("12", 2);
    // A temporary folder's file system knows them on every usual system.
    EXPECT_EQ(Names().size(), GetParam() ? 1u : 3u);
  }
  EXPECT_EQ(Names(), Strings{"old"});
  EXPECT_EQ(ReadText(Path("old"), 10), "old");
}

TEST_P(FileTest, ACommittedOutputReplacesTheOldFile) {
  Save("old", "old");
  OutputFile file(Path("old"));
  file.Write("12", 2);
  file.Write("3", 1);
  EXPECT_EQ(ReadText(Path("old"), 10), "old");
  file.Commit();
  EXPECT_EQ(ReadText(Path("old"), 10), "123");
  EXPECT_EQ(Names(), Strings{"old"});
}

// Names that are in use, by whoever else writes there, are left alone.
TEST_P(FileTest, TemporaryNamesOfOthersStay) {
  Save("old", "old");
  Save(".topotag-0.tmp", "other");
  WriteWholeFile(Path("old"), "new");
  WriteWholeFile(Path("new"), "new");
  EXPECT_EQ(ReadText(Path(".topotag-0.tmp"), 10), "other");
  EXPECT_EQ(ReadText(Path("old"), 10), "new");
  EXPECT_EQ(ReadText(Path("new"), 10), "new");
  EXPECT_EQ(Names(), (Strings{".topotag-0.tmp", "new", "old"}));
}

TEST_P(FileTest, ASymbolicLinkStaysOne) {
  fs::create_directory(Path("there"));
  Save("there/target", "old");
  fs::create_symlink("there/target", Path("link"));
  WriteWholeFile(Path("link"), "new");
  EXPECT_TRUE(fs::is_symlink(Path("link")));
  EXPECT_EQ(ReadText(Path("there/target"), 10), "new");
  EXPECT_EQ(Names(), (Strings{"link", "there"}));
}

TEST_P(FileTest, NothingButAFileIsReplaced) {
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
