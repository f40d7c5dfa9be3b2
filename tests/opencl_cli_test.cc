// The device of the opencl backend on the command line. Without a device these tests fail, as those
// of opencl_backend_test do.

#include <gtest/gtest.h>

#include <string>

#include "tests/cli_fixture.h"

namespace topotag {
namespace {

class OpenClCliTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    RenderScene();
  }
  // With TOPOTAG_BACKEND set to `variable`.
  Outcome Detect(const std::string& variable, const std::string& arguments) const {
    return Shell("TOPOTAG_BACKEND=" + variable + " '" + TOPOTAG_CLI + "' detect --format json " +
                 arguments + " scene.png");
  }
};

TEST_F(OpenClCliTest, DeviceGoesWithTheBackendHoweverItIsChosen) {
  for (const Outcome& outcome :
       {Detect("scalar", "--backend opencl --device 0"), Detect("opencl", "--device 0"),
        Detect("opencl", "--backend auto --device 0")}) {
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Json frame = Json::parse(outcome.out);
    EXPECT_EQ(frame["backend"].get<std::string>().compare(0, 7, "opencl/"), 0) << frame["backend"];
    EXPECT_EQ(frame["detections"].size(), 3u);
  }
}

TEST_F(OpenClCliTest, OtherBackendsHaveNoDevice) {
  for (const Outcome& outcome : {Detect("opencl", "--backend simd --device 0"),
                                 Detect("opencl", "--backend scalar --device 0"),
                                 Detect("simd", "--device 0"), Detect("''", "--device 0")}) {
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("--device: only with --backend opencl"), std::string::npos)
        << outcome.err;
  }
}

TEST_F(OpenClCliTest, WrongIndexIsRefused) {
  for (const char* index : {"1000", "2147483647"}) {
    for (const Outcome& outcome : {Detect("''", std::string("--backend opencl --device ") + index),
                                   Detect("opencl", std::string("--device ") + index)}) {
      EXPECT_EQ(outcome.status, 2);
      EXPECT_EQ(outcome.out, "");
      ASSERT_EQ(Lines(outcome.err).size(), 1u) << outcome.err;
      EXPECT_NE(outcome.err.find(std::string("device ") + index + " does not exist"),
                std::string::npos)
          << outcome.err;
    }
  }
  for (const char* index : {"-1", "x", "1.5", "2147483648", "99999999999999999999"}) {
    ExpectComplaint(std::string("detect --backend opencl --device ") + index + " scene.png", 2,
                    {"--device"});
  }
}

}  // namespace
}  // namespace topotag
