#include "host/photometric_fit.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "host/cholesky.h"

namespace topotag {
namespace {

constexpr int kUnknowns = kPhotometricUnknowns;
constexpr int kMaxIterations = 15;
constexpr int kMinPixels = 100;
// Pixels count that lie within so many widths of the point spread function from an edge.
constexpr double kReach = 0.8;
constexpr double kHuber = 2;            // robust sigmas
constexpr double kStartSigma = 0.1;     // of the contrast, before residuals are known
constexpr double kMinSigma = 0.288675;  // of a rounded level
// A step is the last one on its pixels where it takes less than this off the cost, in variances for
// each unknown: it is about as long as the noise of these pixels explains, far within the range in
// which the model is linear.
constexpr double kSettled = 2;
constexpr double kStuck = 1e-3;  // part of the cost: less of a fall is no progress
// Blocks of pixels that are enough for the first iterations.
constexpr int kCoarseBlocks = 16;
constexpr int kMaxCoarseStep = 8;
constexpr int kCoarseIterations = 4;
constexpr int kSigmaUpdates = 4;    // iterations in which the residuals' sigma is taken again
constexpr double kSigmaStep = 0.9;  // where it falls below this part
// A residual far beyond the noise: in robust sigmas, and in parts of the contrast.
constexpr double kOutlier = 5;
constexpr double kOutlierContrast = 0.1;
// A hole is not there where its residuals are beyond this part of the contrast in the mean.
constexpr double kNoHole = 0.2;

using Vector = PhotometricStep;
using Matrix = std::array<Vector, kPhotometricUnknowns>;

// Standard deviations of what is plausible, which decide where the pixels do not; 0 = free.
Vector Priors(const PhotometricState& state, double half_side) {
  Vector prior{};
  const double contrast = state.white - state.black;
  prior[kGainX] = prior[kGainY] = 0.5 / half_side;
  prior[kBlurXx] = prior[kBlurXy] = prior[kBlurYy] = 2;
  prior[kGrowth] = 0.2;
  prior[kBackground] = 255;
  prior[kBlack] = prior[kWhite] = std::max(contrast, 1.0);
  return prior;
}

// Share of sorted values below a level, by counting in equal steps.
class Histogram {
 public:
  explicit Histogram(double top) : scale_(kBins / top) {}
  void Add(double value) {
    ++bins_[static_cast<size_t>(std::min(value * scale_, kBins - 1.0))];
    ++count_;
  }
  int count() const { return count_; }
  double Median() const {
    size_t i = 0;
    int below = 0;
    while (2 * (below + bins_[i]) < count_) below += bins_[i++];
    return (static_cast<double>(i) + (0.5 * count_ - below) / std::max(bins_[i], 1)) / scale_;
  }

 private:
  static constexpr size_t kBins = 1024;
  double scale_;
  int count_ = 0;
  std::array<int, kBins> bins_{};
};

// Cholesky decomposition in place of the lower triangle.
// Of a size that the compiler knows, and by columns: its sums are vectors.
bool Factorize(Matrix* matrix) {
  Matrix& a = *matrix;
  // The transpose of the factor: rows are contiguous.
  Matrix t;
  for (size_t r = 0; r < kPhotometricUnknowns; ++r) {
    for (size_t c = 0; c < kPhotometricUnknowns; ++c) t[c][r] = c <= r ? a[r][c] : 0;
  }
  for (size_t k = 0; k < kPhotometricUnknowns; ++k) {
    if (!(t[k][k] > 0)) return false;
    const double inverse = 1 / std::sqrt(t[k][k]);
    for (double& x : t[k]) x *= inverse;
    for (size_t r = k + 1; r < kPhotometricUnknowns; ++r) {
      const double factor = t[k][r];
      for (size_t c = r; c < kPhotometricUnknowns; ++c) t[r][c] -= factor * t[k][c];
    }
  }
  for (size_t r = 0; r < kPhotometricUnknowns; ++r) {
    for (size_t c = 0; c <= r; ++c) a[r][c] = t[c][r];
  }
  return true;
}

void SolveFactorized(const Matrix& factor, Vector* x) {
  Vector& b = *x;
  for (size_t r = 0; r < kPhotometricUnknowns; ++r) {
    for (size_t c = 0; c < r; ++c) b[r] -= factor[r][c] * b[c];
    b[r] /= factor[r][r];
  }
  for (size_t r = kPhotometricUnknowns; r-- > 0;) {
    b[r] /= factor[r][r];
    for (size_t c = 0; c < r; ++c) b[c] -= factor[r][c] * b[r];
  }
}

class Fitter {
 public:
  Fitter(const ImageView& image, const UnitPattern& pattern, const Camera& camera,
         PhotometricWorkspace* workspace, PhotometricFit* fit)
      : image_(image), pattern_(pattern), camera_(camera), workspace_(*workspace), fit_(*fit) {}

  bool Run(const PhotometricState& start);

 private:
  bool Collect();
  void Evaluate(const PhotometricState& state, double huber, PhotometricSums* sums);
  double Sigma() const;
  double Cost(double limit) const;
  bool Solve(const PhotometricSums& sums, double damping, Vector* step, double* fall) const;
  bool Iterate();
  bool SetCovariance(const PhotometricSums& sums, double variance);
  void Summarise(const PhotometricSums& sums);
  template <typename Visit>
  void VisitPixels(const Visit& visit) const;

  const ImageView& image_;
  const UnitPattern& pattern_;
  const Camera& camera_;
  PhotometricWorkspace& workspace_;
  PhotometricFit& fit_;
  PixelView view_;
  double sigma_ = 0;
  double last_fall_ = 0;  // of the cost, by the step after the last residuals
  int step_ = 1;          // of the blocks of pixels that count
};

bool Fitter::Collect() {
  view_ = MakeView(camera_, fit_.state);
  workspace_.Reserve();
  fit_.pixels = CollectPixels(image_, pattern_, view_, kReach, &workspace_.pixels);
  return fit_.pixels >= kMinPixels;
}

void Fitter::Evaluate(const PhotometricState& state, double huber, PhotometricSums* sums) {
  EvaluatePhotometric(workspace_.pixels.blocks, MakeModel(camera_, view_, state, huber), step_,
                      sums, workspace_.residuals.data());
}

template <typename Visit>
void Fitter::VisitPixels(const Visit& visit) const {
  const PixelBlocks& p = workspace_.pixels.blocks;
  for (int b = 0; b < p.blocks;
       b += b < p.inner_blocks ? std::min(step_, p.inner_blocks - b) : step_) {
    const float* block = p.block(b);
    const float* residuals = workspace_.residuals.data() + static_cast<size_t>(b) * kPixelLanes;
    for (size_t k = 0; k < kPixelLanes; ++k) {
      if (block[kPixelWeight * kPixelLanes + k] > 0)
        visit(block + k, static_cast<double>(residuals[k]));
    }
  }
}

// From the median of the residuals.
double Fitter::Sigma() const {
  Histogram sizes(64);
  VisitPixels([&](const float*, double residual) { sizes.Add(std::abs(residual)); });
  return std::max(sizes.Median() / 0.6745, kMinSigma);
}

bool Fitter::Iterate() {
  PhotometricSums sums;
  PhotometricState& state = fit_.state;
  sigma_ = kStartSigma * (state.white - state.black);
  // The first iterations go most of the way, for which a part of the pixels is enough.
  const int coarse_step =
      std::clamp(workspace_.pixels.blocks.blocks / kCoarseBlocks, 1, kMaxCoarseStep);
  step_ = coarse_step;
  Evaluate(state, kHuber * sigma_, &sums);
  double damping = 1e-4;
  bool is_better = true;
  for (int i = 0; i < kMaxIterations && damping < 1e4; ++i) {
    // Residuals before the pose is right say little about the noise.
    if (is_better) {
      const double sigma = fit_.sigma = Sigma();
      if (i < kSigmaUpdates && sigma < kSigmaStep * sigma_) {
        sigma_ = sigma;
        sums[kCostSum] = Cost(kHuber * sigma_);
      }
    }
    Vector step;
    double fall;
    if (!Solve(sums, damping, &step, &fall)) return false;
    const PhotometricState next = Apply(state, step);
    if (!(next.pose.t[2] > 0)) return false;
    // The first step on all pixels is as long as the noise of a part of them explains.
    const double noise_fall = kUnknowns * sigma_ * sigma_ * (step_ == 1 ? coarse_step : 1);
    const bool is_settled = i > 0 && is_better && fall < kSettled * noise_fall;
    if (step_ > 1 && (is_settled || i == kCoarseIterations)) {
      step_ = 1;
      state = next;
      Evaluate(state, kHuber * sigma_, &sums);
      is_better = true;
      continue;
    }
    if (is_settled) {
      state = next;
      last_fall_ = fall;
      fit_.converged = true;
      break;
    }
    PhotometricSums next_sums;
    Evaluate(next, kHuber * sigma_, &next_sums);
    is_better = next_sums[kCostSum] < sums[kCostSum];
    if (is_better) {
      state = next;
      sums = next_sums;
      damping *= 0.1;
    } else if (step_ == 1 && fall < kStuck * sums[kCostSum]) {
      fit_.converged = true;  // as far as the model's own errors let it
      break;
    } else {
      damping = std::max(10 * damping, 1e-2);
    }
  }
  Summarise(sums);
  return true;
}

// The step that the equations ask for, and by how much the cost would fall.
bool Fitter::Solve(const PhotometricSums& sums, double damping, Vector* step, double* fall) const {
  const Vector prior = Priors(fit_.state, pattern_.reach());
  Matrix matrix;
  for (size_t r = 0; r < kPhotometricUnknowns; ++r) {
    for (size_t c = 0; c <= r; ++c) matrix[r][c] = sums[TriangleIndex(c, r)];
    matrix[r][r] *= 1 + damping;
    if (prior[r] > 0) matrix[r][r] += sigma_ * sigma_ / (prior[r] * prior[r]);
    (*step)[r] = -sums[kGradientSums + r];
  }
  const Vector downhill = *step;
  if (!Factorize(&matrix)) return false;
  SolveFactorized(matrix, step);
  *fall = 0;
  for (size_t r = 0; r < kPhotometricUnknowns; ++r) *fall += downhill[r] * (*step)[r];
  return true;
}

// Sum of Huber's function of the residuals.
double Fitter::Cost(double limit) const {
  double sum = 0;
  VisitPixels([&](const float*, double residual) {
    const double size = std::abs(residual), small = std::min(size, limit);
    sum += small * (2 * size - small);
  });
  return sum;
}

void Fitter::Summarise(const PhotometricSums& sums) {
  fit_.cost = (sums[kCostSum] - last_fall_) / fit_.pixels;
  Histogram steps(64);
  float last_x = 1e9f, last_y = 1e9f;
  double last = 0;
  int outliers = 0;
  double squares = 0, weights = 0;
  int linear = 0;
  std::array<int, kMaxVertices> in_hole{};
  std::array<double, kMaxVertices> hole_residual{};
  const double contrast = fit_.state.white - fit_.state.black;
  const double outlier = std::max(kOutlier * fit_.sigma, kOutlierContrast * contrast);
  const double limit = kHuber * sigma_;
  VisitPixels([&](const float* fields, double residual) {
    const float x = fields[kPixelX * kPixelLanes], y = fields[kPixelY * kPixelLanes];
    if (std::abs(x - last_x - 1) < 0.1f && std::abs(y - last_y) < 0.1f) {
      steps.Add(std::abs(residual - last));
    }
    last_x = x;
    last_y = y;
    last = residual;
    if (std::abs(residual) > outlier) ++outliers;
    int32_t flags;
    std::memcpy(&flags, fields + kPixelFlags * kPixelLanes, sizeof(flags));
    if ((flags & kInHole) != 0) {
      const auto node =
          static_cast<size_t>(pattern_.HoleAt(static_cast<int>(fields[kPixelU * kPixelLanes]),
                                              static_cast<int>(fields[kPixelV * kPixelLanes])));
      ++in_hole[node];
      hole_residual[node] += std::abs(residual);
    }
    // Huber's weights: the variance of the estimate is that of the bounded residuals over the
    // squared share of those that are not bounded.
    const double size = std::abs(residual);
    if (size < limit) {
      squares += size * size;
      ++linear;
    } else {
      squares += limit * limit;
      weights += limit / size;
    }
  });
  fit_.noise = steps.count() > 0 ? steps.Median() / (0.6745 * std::sqrt(2.0)) : 0;
  fit_.outliers = static_cast<double>(outliers) / fit_.pixels;
  int holes = 0, missing = 0;
  for (size_t k = 0; k < in_hole.size(); ++k) {
    if (in_hole[k] == 0) continue;
    ++holes;
    if (hole_residual[k] > kNoHole * contrast * in_hole[k]) ++missing;
  }
  fit_.missing_holes = holes > 0 ? static_cast<double>(missing) / holes : 0;
  weights += linear;
  // The matrix has the weights in it once.
  const double share = static_cast<double>(linear) / fit_.pixels;
  const double variance = (squares - last_fall_) / std::max(fit_.pixels - kUnknowns, 1) *
                          (weights / fit_.pixels) / (share * share);
  if (!SetCovariance(sums, std::max(variance, kMinSigma * kMinSigma))) fit_.converged = false;
}

bool Fitter::SetCovariance(const PhotometricSums& sums, double variance) {
  const Vector prior = Priors(fit_.state, pattern_.reach());
  // The pose comes last: what is left of the matrix there has the others marginalised.
  constexpr size_t kLast = kPhotometricUnknowns - 1;
  Matrix matrix;
  for (size_t r = 0; r < kPhotometricUnknowns; ++r) {
    for (size_t c = 0; c <= r; ++c) matrix[r][c] = sums[TriangleIndex(kLast - r, kLast - c)];
    const double width = prior[kLast - r];
    if (width > 0) matrix[r][r] += variance / (width * width);
  }
  if (!Factorize(&matrix)) return false;
  Matrix6 marginal;
  for (size_t r = 0; r < 6; ++r) {
    for (size_t c = 0; c <= r; ++c) {
      double sum = 0;
      for (size_t k = 0; k <= c; ++k)
        sum += matrix[kLast - 5 + r][kLast - 5 + k] * matrix[kLast - 5 + c][kLast - 5 + k];
      marginal[r][c] = sum;
    }
  }
  Matrix6 inverse;
  if (!InvertPositive(marginal[0].data(), 6, inverse[0].data())) return false;
  // Of (omega, tau), in the axes of the tag.
  Matrix6 local;
  const auto index = [](size_t k) { return 5 - (k < 3 ? kOmegaX + k : k - 3); };
  for (size_t r = 0; r < 6; ++r) {
    for (size_t c = 0; c < 6; ++c) local[r][c] = variance * inverse[index(r)][index(c)];
  }
  const Rigid& pose = fit_.state.pose;
  const Vector3 z = Cross(pose.x, pose.y);
  const Matrix3 axes{
      {{pose.x[0], pose.y[0], z[0]}, {pose.x[1], pose.y[1], z[1]}, {pose.x[2], pose.y[2], z[2]}}};
  for (size_t r = 0; r < 6; ++r) {
    for (size_t c = 0; c <= r; ++c) {
      double sum = 0;
      for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j) {
          sum += axes[r % 3][i] * local[r / 3 * 3 + i][c / 3 * 3 + j] * axes[c % 3][j];
        }
      }
      fit_.covariance[r][c] = fit_.covariance[c][r] = sum;
    }
  }
  return true;
}

bool Fitter::Run(const PhotometricState& start) {
  fit_ = {};
  fit_.state = start;
  if (!Collect() || !Iterate()) return false;
  Orthonormalize(&fit_.state.pose);
  return true;
}

}  // namespace

bool FitPhotometric(const ImageView& image, const UnitPattern& pattern, const Camera& camera,
                    const PhotometricState& start, PhotometricWorkspace* workspace,
                    PhotometricFit* fit) {
  return Fitter(image, pattern, camera, workspace, fit).Run(start);
}

}  // namespace topotag
