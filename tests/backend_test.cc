#include "host/backend.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "fallback/binarize.h"
#include "fallback/label.h"
#include "fallback/threshold.h"
#include "host/stages.h"
#include "host/workers.h"
#include "tests/random_image.h"
#include "topotag/detector.h"
#include "topotag/error.h"

namespace topotag {
namespace {

constexpr char kVariable[] = "TOPOTAG_BACKEND";

// Leaves the environment as it was.
class BackendTest : public ::testing::Test {
 protected:
  BackendTest() {
    const char* value = std::getenv(kVariable);
    was_set_ = value != nullptr;
    if (was_set_) value_ = value;
    unsetenv(kVariable);
  }
  ~BackendTest() override {
    if (was_set_) {
      setenv(kVariable, value_.c_str(), 1);
    } else {
      unsetenv(kVariable);
    }
  }

  static void Force(const char* name) { ASSERT_EQ(setenv(kVariable, name, 1), 0); }

 private:
  bool was_set_;
  std::string value_;
};

Options With(BackendKind kind) {
  Options options;
  options.backend = kind;
  return options;
}

// What both ways to a backend call it.
std::string NameOf(BackendKind kind) {
  Workers workers(1);
  const std::string name = MakeBackend(kind, &workers)->name();
  EXPECT_EQ(Detector(With(kind)).backend(), name);
  return name;
}

bool IsSimd(const std::string& name) { return name.rfind("simd/", 0) == 0 && name.size() > 5; }

// Both ways to a backend fail alike.
void ExpectRefused(BackendKind kind, ErrorCode code, const std::string& message) {
  const auto expect = [&](auto make) {
    try {
      make();
      ADD_FAILURE() << Name(kind) << ": no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code);
      EXPECT_EQ(std::string(error.what()).substr(0, message.size()), message);
    }
  };
  expect([&] {
    Workers workers(1);
    MakeBackend(kind, &workers);
  });
  expect([&] { Detector detector(With(kind)); });
}

bool HasOpenCl() {
  try {
    Workers workers(1);
    MakeBackend(BackendKind::kOpenCl, &workers);
    return true;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnavailable);
    return false;
  }
}

TEST_F(BackendTest, ScalarAndSimdAreThere) {
  EXPECT_EQ(NameOf(BackendKind::kScalar), "scalar");
  EXPECT_PRED1(IsSimd, NameOf(BackendKind::kSimd));
}

// Where the build has no OpenCL, or the machine has no device.
TEST_F(BackendTest, AMissingOneIsAnErrorThatNamesIt) {
  if (HasOpenCl()) {
    EXPECT_EQ(NameOf(BackendKind::kOpenCl).substr(0, 7), "opencl/");
    GTEST_SKIP() << "this build has all backends";
  }
  ExpectRefused(BackendKind::kOpenCl, ErrorCode::kUnavailable, "backend 'opencl' ");
  Force("opencl");
  ExpectRefused(BackendKind::kAuto, ErrorCode::kUnavailable, "backend 'opencl' ");
}

TEST_F(BackendTest, AutoTakesTheVariable) {
  Force("scalar");
  EXPECT_EQ(NameOf(BackendKind::kAuto), "scalar");
  Force("simd");
  EXPECT_PRED1(IsSimd, NameOf(BackendKind::kAuto));
  if (!HasOpenCl()) return;
  Force("opencl");
  EXPECT_EQ(NameOf(BackendKind::kAuto).substr(0, 7), "opencl/");
}

TEST_F(BackendTest, AutoWithoutTheVariableIsSimd) {
  EXPECT_PRED1(IsSimd, NameOf(BackendKind::kAuto));
  EXPECT_PRED1(IsSimd, Detector().backend());
  for (const char* same : {"", "auto"}) {
    Force(same);
    EXPECT_PRED1(IsSimd, NameOf(BackendKind::kAuto));
  }
}

TEST_F(BackendTest, NonsenseInTheVariableIsAnError) {
  for (const char* nonsense : {"cuda", "Scalar", "scalar ", "simd/AVX2"}) {
    Force(nonsense);
    ExpectRefused(BackendKind::kAuto, ErrorCode::kInvalidArgument,
                  std::string("TOPOTAG_BACKEND: unknown backend '") + nonsense +
                      "': expected one of auto, simd, opencl, scalar");
  }
}

TEST_F(BackendTest, AnExplicitKindBeatsTheVariable) {
  for (const char* forced : {"simd", "opencl", "nonsense"}) {
    Force(forced);
    EXPECT_EQ(NameOf(BackendKind::kScalar), "scalar");
  }
  for (const char* forced : {"scalar", "opencl", "nonsense"}) {
    Force(forced);
    EXPECT_PRED1(IsSimd, NameOf(BackendKind::kSimd));
  }
}

TEST_F(BackendTest, NamesAreParsedBack) {
  for (const BackendKind kind :
       {BackendKind::kAuto, BackendKind::kScalar, BackendKind::kSimd, BackendKind::kOpenCl}) {
    EXPECT_EQ(ParseBackend(Name(kind)), kind);
  }
  EXPECT_THROW(ParseBackend(""), Error);
  EXPECT_THROW(ParseBackend("SIMD"), Error);
}

// What the detector's stages left behind is what fallback/ makes of the same part of the frame.
TEST_F(BackendTest, DetectorRunsTheStagesOfFallback) {
  for (const Preset preset : {Preset::kDefault, Preset::kPaper}) {
    const PaddedImage image = MakeImage({201, 150, 7, Content::kBlobs, 3});
    Options options = With(BackendKind::kScalar);
    options.preset = preset;
    options.roi = Rect{5, 9, 130, 97};
    Detector detector(options);
    detector.detect(image.view());
    const DetectorStages stages(detector);

    const ImageView part{image.view().row(9) + 5, 130, 97, image.view().stride};
    ThresholdParams params;
    params.preset = preset;
    scalar::ThresholdWorkspace threshold_workspace;
    ThresholdGrid grid;
    scalar::ThresholdMap(part, params, &threshold_workspace, &grid);
    BitImage bits;
    scalar::Binarize(part, grid, &bits);

    const Image map = stages.ThresholdMap(), binary = stages.Binary();
    const std::vector<uint32_t> labels = stages.Labels();
    ASSERT_EQ(labels.size(), 130U * 97U);
    std::vector<uint8_t> row(130);
    uint32_t seen = 0;
    for (int y = 0; y < 97; ++y) {
      scalar::ThresholdRow(grid, y, 130, row.data());
      for (int x = 0; x < 130; ++x) {
        ASSERT_EQ(map.row(y)[x], row[static_cast<size_t>(x)]);
        ASSERT_EQ(binary.row(y)[x], IsWhite(bits, x, y) ? 255 : 0);
        const uint32_t label = labels[static_cast<size_t>(130 * y + x)];
        ASSERT_LE(label, seen + 1);  // canonical: in raster order of first pixels
        seen = std::max(seen, label);
        // Pixels side by side: the same component where the same colour.
        if (x == 0) continue;
        const bool same = label == labels[static_cast<size_t>(130 * y + x - 1)];
        ASSERT_EQ(same, IsWhite(bits, x, y) == IsWhite(bits, x - 1, y));
      }
    }
    EXPECT_GE(seen, 2U);
  }
}

}  // namespace
}  // namespace topotag
