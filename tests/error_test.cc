#include "topotag/error.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "topotag/image_file.h"
#include "topotag/marker.h"
#include "topotag/object.h"

namespace topotag {
namespace {

TEST(ErrorTest, IsOneLineWithoutControlCharacters) {
  const Error error(ErrorCode::kFile,
                    "a\nb\r\tc\x1b[1m\x7f \xc2\x9b\xc2\x85 \xc3\x89 \xc2\xa0 \xc2");
  EXPECT_STREQ(error.what(), "a b  c [1m       \xc3\x89 \xc2\xa0 \xc2");
  EXPECT_EQ(error.code(), ErrorCode::kFile);
}

TEST(ErrorTest, NamesOfFilesAreQuotedInOneLine) {
  const std::string name =
      (std::filesystem::temp_directory_path() / "no\nfolder" / "a\x1b.").string();
  const Image image(1, 1);
  const std::function<void()> calls[] = {[&] { ReadImage(name + "png"); },
                                         [&] { ListImages(name); },
                                         [&] { WriteImage(image.view(), name + "png"); },
                                         [&] { WriteImage(image.view(), name + "\n"); },
                                         [&] { ReadObject(name); },
                                         [&] { ReadPolygon(name); }};
  for (const auto& call : calls) {
    try {
      call();
      ADD_FAILURE() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find_first_of("\n\x1b"), std::string::npos)
          << error.what();
    }
  }
}

}  // namespace
}  // namespace topotag
