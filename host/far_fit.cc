#include "host/far_fit.h"

#include <algorithm>
#include <cmath>

#include "host/cholesky.h"

namespace topotag {
namespace {

constexpr int kFreeSteps = 4;
constexpr double kSmallShift = 0.05;  // units
constexpr int kFixedSteps = 2;
constexpr int kMaxRounds = 3;
constexpr double kMinCorrelation = 0.935;
constexpr double kMinMargin = 8;
constexpr double kMinStep = 0.2;
// The level that the model gives to nodes of a shape between two of its own may be below 0.
constexpr double kMinBlack = -30;
constexpr double kMaxWhite = 300;  // saturation hides how bright it is

// Of larger markers only some pixels are used, evenly spread.
constexpr double kEnoughPixels = 1500;
constexpr size_t kMaxPixels = 4096;

}  // namespace

bool FarFit::Gather(const ImageView& image, const Camera* camera, const Rect& whole,
                    const FarGuess& guess) {
  const TagMap map{guess.map, camera};
  const double half = family_.white_side() / 2.0 + kBeyondWhite + 1;
  double min_x = INFINITY, min_y = INFINITY, max_x = -INFINITY, max_y = -INFINITY;
  for (const Point2 corner : {Point2{-half, -half}, {half, -half}, {half, half}, {-half, half}}) {
    if (!(guess.map.Denominator(corner) > 0.05)) return false;
    const Point2 p = map.Pixel(corner);
    min_x = std::min(min_x, p.x), max_x = std::max(max_x, p.x);
    min_y = std::min(min_y, p.y), max_y = std::max(max_y, p.y);
  }
  if (!(min_x >= whole.x && min_y >= whole.y && max_x <= whole.x + whole.width - 1 &&
        max_y <= whole.y + whole.height - 1)) {
    return false;
  }
  const Point2 center = map.Pixel({0, 0});
  if (!PixelToIdeal(camera, center, &origin_)) return false;
  lens_ = {1, 0, 0, 1};
  Point2 right, down;
  if (map.HasLens()) {
    if (!PixelToIdeal(camera, {center.x + 1, center.y}, &right) ||
        !PixelToIdeal(camera, {center.x, center.y + 1}, &down)) {
      return false;
    }
    lens_ = {right.x - origin_.x, down.x - origin_.x, right.y - origin_.y, down.y - origin_.y};
  }
  const int x0 = static_cast<int>(std::ceil(min_x)), x1 = static_cast<int>(std::floor(max_x));
  const int y0 = static_cast<int>(std::ceil(min_y)), y1 = static_cast<int>(std::floor(max_y));
  pixel_count_ = 0;
  pixels_.Reserve(kMaxPixels);
  Homography inverse;
  if (!Invert(guess.map, &inverse)) return false;
  Jacobian2 j;
  guess.map.Map({0, 0}, &j);
  const double area = 4 * half * half * std::abs(j[0] * j[3] - j[1] * j[2]);
  const int every = 1 + static_cast<int>(std::min(area, 1e9) / kEnoughPixels);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0 + (every - (x0 + 3 * y) % every) % every; x <= x1; x += every) {
      Point2 ideal{double(x), double(y)};
      if (map.HasLens() && !PixelToIdeal(camera, ideal, &ideal)) return false;
      const Point2 tag = inverse.Map(ideal);
      if (!(std::abs(tag.x) < half + 0.5 && std::abs(tag.y) < half + 0.5)) continue;
      if (pixel_count_ == kMaxPixels) return false;
      pixels_[pixel_count_++] = {static_cast<float>(ideal.x - origin_.x),
                                 static_cast<float>(ideal.y - origin_.y),
                                 static_cast<float>(image.row(y)[x])};
    }
  }
  // The inverse map from the origin.
  const Matrix3& m = inverse.m;
  const double w = m[2][0] * origin_.x + m[2][1] * origin_.y + m[2][2];
  for (size_t r = 0; r < 2; ++r) {
    map_[3 * r] = m[r][0] / w;
    map_[3 * r + 1] = m[r][1] / w;
    map_[3 * r + 2] = (m[r][0] * origin_.x + m[r][1] * origin_.y + m[r][2]) / w;
  }
  map_[6] = m[2][0] / w;
  map_[7] = m[2][1] / w;
  return pixel_count_ > 50;
}

bool FarFit::DecideBits() {
  bits_ = 0;
  if (!(levels_.node < 0)) return false;
  for (int h = 2; h < family_.vertex_count(); ++h) {
    const bool bit = hole_[h] > -levels_.node / 2;
    bits_ |= static_cast<uint64_t>(bit) << h;
    hole_[h] = bit ? -levels_.node : 0;
  }
  return true;
}

bool FarFit::Store(FarReading* reading) {
  AddPriors(false);
  if (!Factorize(normal_, stride_)) return false;
  const double variance = Variance();
  for (int i = 0; i < 8; ++i) {
    double column[kDense] = {};
    column[kMap + i] = variance;
    SolveFactorized(normal_, stride_, column);
    for (int k = 0; k < 8; ++k) {
      reading->covariance[static_cast<size_t>(k)][static_cast<size_t>(i)] = column[kMap + k];
    }
  }
  reading->bits = bits_;
  reading->correlation = stats_.correlation;
  reading->white = levels_.white;
  reading->black = levels_.white + levels_.node;
  reading->blur = blur_;
  reading->origin = origin_;
  reading->inverse.m = {
      {{map_[0], map_[1], map_[2]}, {map_[3], map_[4], map_[5]}, {map_[6], map_[7], 1}}};
  Homography from_origin;
  if (!Invert(reading->inverse, &from_origin)) return false;
  reading->map = from_origin;
  for (size_t c = 0; c < 3; ++c) {
    reading->map.m[0][c] += origin_.x * from_origin.m[2][c];
    reading->map.m[1][c] += origin_.y * from_origin.m[2][c];
  }
  return true;
}

bool FarFit::Run(const ImageView& image, const Camera* camera, const Rect& whole,
                 const FarGuess& guess, FarReading* reading) {
  family_ = guess.family;
  reading->correlation = 0;
  if (!Gather(image, camera, whole, guess)) return false;
  model_.Forget();
  shape_ = FarModel::kHexagon;
  blur_ = kStartBlur;
  levels_ = {200, -150, -150, Quad{}};
  gain_[0] = gain_[1] = 0;
  std::fill_n(hole_, kMaxVertices, 75.0F);
  for (int i = 0; i < kFreeSteps; ++i) {
    if (!SetModel(kCoarse)) return false;
    Accumulate(true);
    if (i == 2 && stats_.correlation < kEarlyCorrelation) return false;
    if (!Solve(true)) return false;
    Move(true);
    const double shift = std::abs(gradient_[kMap + 2]) + std::abs(gradient_[kMap + 5]);
    if (i >= 1 && shift < kSmallShift) break;
  }
  if (!DecideBits() || !ChooseShape()) return false;
  for (int round = 0; round < kMaxRounds; ++round) {
    for (int i = round == 0 ? 1 : 0; i < kFixedSteps; ++i) {
      if (!SetModel(kFine)) return false;
      Accumulate(false);
      if (!Solve(false)) return false;
      Move(false);
    }
    if (!SetModel(kFine)) return false;
    Accumulate(false);
    bool flipped;
    TestFlips(reading, &flipped);
    if (flipped) continue;
    if (!Store(reading)) return false;
    return reading->correlation > kMinCorrelation && reading->margin > kMinMargin &&
           reading->min_step > kMinStep && reading->black > kMinBlack &&
           reading->white > reading->black && reading->white < kMaxWhite && !IsPartOfLarger() &&
           AreHolesLocal();
  }
  return false;
}

}  // namespace topotag
