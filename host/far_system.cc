#include <algorithm>
#include <cmath>

#include "host/cholesky.h"
#include "host/far_fit.h"

namespace topotag {
namespace {

constexpr double kMinBlur = 0.35, kMaxBlur = 2.5;
constexpr double kPixelVariance = 1.0 / 12;
// Priors: spreads of the unknowns, and of the noise that they are weighed against.
constexpr double kNoise = 3;
constexpr double kSideSpread = 100;         // grey levels
constexpr double kBlurSpread = 0.3;         // pixels
constexpr double kPerspectiveSpread = 0.1;  // change of scale over half a side
constexpr double kHoleSpread = 200;
constexpr double kGainSpread = 0.2;  // over half a side

double Square(double x) { return x * x; }

}  // namespace

int FarFit::Vertex(int column, int row) const {
  const int n = family_.n();
  if (column < 0 || row < 0 || column >= n || row >= n) return -1;
  const int vertex = row * n + column;
  return vertex < 2 ? -1 : vertex;
}

// The blur in tag units at the marker's centre.
bool FarFit::SetModel(double tolerance) {
  const double ux = map_[0] - map_[2] * map_[6], uy = map_[1] - map_[2] * map_[7];
  const double vx = map_[3] - map_[5] * map_[6], vy = map_[4] - map_[5] * map_[7];
  const double a = ux * lens_[0] + uy * lens_[2], b = ux * lens_[1] + uy * lens_[3];
  const double c = vx * lens_[0] + vy * lens_[2], d = vx * lens_[1] + vy * lens_[3];
  const double variance = blur_ * blur_ + kPixelVariance;
  const double covariance[3] = {variance * (a * a + b * b), variance * (a * c + b * d),
                                variance * (c * c + d * d)};
  if (!(covariance[0] > 0 && covariance[2] > 0 && covariance[0] < 25 && covariance[2] < 25)) {
    return false;
  }
  model_.Set(family_, shape_, covariance, tolerance);
  return true;
}

// The Gauss-Newton system at the unknowns, and the residual there.
void FarFit::Accumulate(bool holes_free) {
  const int unknowns = kDense + (holes_free ? family_.vertex_count() : 0);
  stride_ = unknowns;
  std::fill_n(normal_, unknowns * unknowns, 0.0);
  std::fill_n(gradient_, unknowns, 0.0);
  std::fill_n(flip_square_, kMaxVertices, 0.0F);
  std::fill_n(flip_product_, kMaxVertices, 0.0F);
  Quad dense[kDense][kDense / 4] = {};
  Quad slope[kDense / 4] = {};
  Quad mixed[kMaxVertices][kDense / 4];
  if (holes_free) std::fill_n(mixed[0], family_.vertex_count() * kDense / 4, Quad{});

  const double ux = map_[0] - map_[2] * map_[6], uy = map_[1] - map_[2] * map_[7];
  const double vx = map_[3] - map_[5] * map_[6], vy = map_[4] - map_[5] * map_[7];
  const double a = ux * lens_[0] + uy * lens_[2], b = ux * lens_[1] + uy * lens_[3];
  const double c = vx * lens_[0] + vy * lens_[2], d = vx * lens_[1] + vy * lens_[3];
  // d value / d blur = blur (Laplacian in pixels).
  const auto luu = static_cast<float>(blur_ * (a * a + b * b));
  const auto luv = static_cast<float>(2 * blur_ * (a * c + b * d));
  const auto lvv = static_cast<float>(blur_ * (c * c + d * d));
  float m[8];
  for (int i = 0; i < 8; ++i) m[i] = static_cast<float>(map_[i]);
  const auto gain_u = static_cast<float>(gain_[0]), gain_v = static_cast<float>(gain_[1]);
  const float limit = static_cast<float>(family_.white_side() / 2.0 + kBeyondWhite);

  double residual = 0, sum = 0, squares = 0;
  int count = 0;
  for (size_t i = 0; i < pixel_count_; ++i) {
    const Pixel& p = pixels_[i];
    const float w = 1 / (1 + m[6] * p.x + m[7] * p.y);
    const float u = (m[0] * p.x + m[1] * p.y + m[2]) * w;
    const float v = (m[3] * p.x + m[4] * p.y + m[5]) * w;
    if (!(std::abs(u) < limit && std::abs(v) < limit)) continue;
    const FarCell cell = model_.Cell(u, v);
    int vertex[4];
    Quad holes{};
    for (int k = 0; k < 4; ++k) {
      vertex[k] = Vertex(cell.column + k % 2, cell.row + k / 2);
      if (vertex[k] >= 0) holes[k] = hole_[vertex[k]];
    }
    FarSample s;
    model_.Evaluate(u, v, cell, levels_, holes, &s);
    const float gain = 1 + gain_u * u + gain_v * v;
    const float plain = s.value;
    s.value *= gain;
    s.u = s.u * gain + plain * gain_u;
    s.v = s.v * gain + plain * gain_v;
    float nodes = s.basis.nodes;
    for (int k = 0; k < 4; ++k) {
      if (!holes_free && vertex[k] >= 0 && (bits_ >> vertex[k] & 1) != 0) nodes -= s.basis.holes[k];
    }
    const float e = p.grey - s.value;
    const float xw = p.x * w, yw = p.y * w;
    const float f = -(s.u * u + s.v * v);
    const Quad row[kDense / 4] = {
        MakeQuad(gain) * Quad{1, nodes, s.basis.frame, luu * s.uu + luv * s.uv + lvv * s.vv},
        MakeQuad(gain) * s.basis.sides, Quad{s.u * xw, s.u * yw, s.u * w, s.v * xw},
        Quad{s.v * yw, s.v * w, f * xw, f * yw}, Quad{plain * u, plain * v, 0, 0}};
    const Quad error = MakeQuad(e);
    for (int k = 0; k < kDense / 4; ++k) {
      slope[k] += error * row[k];
      for (int j = 0; j < 4; ++j) {
        const Quad factor = MakeQuad(row[k][j]);
        for (int q = 0; q <= k; ++q) dense[4 * k + j][q] += factor * row[q];
      }
    }
    for (int k = 0; k < 4; ++k) {
      if (vertex[k] < 0) continue;
      const auto h = static_cast<size_t>(vertex[k]);
      const float value = gain * s.basis.holes[k];
      if (!holes_free) {
        flip_square_[h] += value * value;
        flip_product_[h] += value * e;
        continue;
      }
      const Quad factor = MakeQuad(value);
      for (int q = 0; q < kDense / 4; ++q) mixed[h][q] += factor * row[q];
      gradient_[kDense + h] += value * e;
      for (int j = 0; j <= k; ++j) {
        if (vertex[j] < 0) continue;
        Normal(kDense + static_cast<int>(h), kDense + vertex[j]) += value * gain * s.basis.holes[j];
      }
    }
    residual += e * e;
    sum += p.grey;
    squares += p.grey * p.grey;
    ++count;
  }
  for (int i = 0; i < kDense; ++i) {
    gradient_[i] = slope[i / 4][i % 4];
    for (int k = 0; k <= i; ++k) Normal(i, k) = dense[i][k / 4][k % 4];
  }
  if (holes_free) {
    for (int h = 0; h < family_.vertex_count(); ++h) {
      for (int k = 0; k < kDense; ++k) Normal(kDense + h, k) = mixed[h][k / 4][k % 4];
    }
  }
  stats_.count = count;
  stats_.residual = residual;
  const double spread = squares - sum * sum / std::max(count, 1);
  stats_.correlation = spread > residual ? std::sqrt(1 - residual / spread) : 0;
}

// What is known before: as further observations.
void FarFit::AddPriors(bool affine) {
  const double noise = kNoise * kNoise;
  Normal(kBlur, kBlur) += noise / Square(kBlurSpread);
  gradient_[kBlur] += noise / Square(kBlurSpread) * (kStartBlur - blur_);
  for (int i = 0; i < 3; ++i) Normal(i, i) += 1e-6;
  for (int i = 0; i < 4; ++i) {
    Normal(kSides + i, kSides + i) += noise / Square(kSideSpread);
    gradient_[kSides + i] -= noise / Square(kSideSpread) * levels_.sides[i];
  }
  // Perspective changes the scale by (g6, g7) (pixels).
  const double area = std::max(std::abs(map_[0] * map_[4] - map_[1] * map_[3]), 1e-12);
  const double half = family_.white_side() / 2.0 / std::sqrt(area);
  const double spread = affine ? 1e-6 : kPerspectiveSpread / half;
  for (int i = kMap + 6; i < kMap + 8; ++i) {
    Normal(i, i) += noise / Square(spread);
    gradient_[i] -= affine ? 0 : noise / Square(spread) * map_[i - kMap];
  }
  for (int i = 0; i < 2; ++i) {
    const double weight = noise * Square(family_.white_side() / 2.0 / kGainSpread);
    Normal(kGain + i, kGain + i) += weight;
    gradient_[kGain + i] -= weight * gain_[i];
    Normal(kGain + 2 + i, kGain + 2 + i) += 1;
  }
  for (int h = kDense; h < stride_; ++h) Normal(h, h) += noise / Square(kHoleSpread);
}

// What the system's unknowns change by, in the gradient's place.
bool FarFit::Solve(bool affine) {
  AddPriors(affine);
  if (!Factorize(normal_, stride_)) return false;
  SolveFactorized(normal_, stride_, gradient_);
  return std::all_of(gradient_, gradient_ + stride_, [](double x) { return std::isfinite(x); });
}

void FarFit::Move(bool holes_free) {
  levels_.white += static_cast<float>(gradient_[0]);
  levels_.node += static_cast<float>(gradient_[1]);
  levels_.frame += static_cast<float>(gradient_[2]);
  blur_ = std::clamp(blur_ + std::clamp(gradient_[kBlur], -0.3, 0.3), kMinBlur, kMaxBlur);
  for (int i = 0; i < 2; ++i) gain_[i] += gradient_[kGain + i];
  for (int i = 0; i < 4; ++i) levels_.sides[i] += static_cast<float>(gradient_[kSides + i]);
  // Steps beyond half a unit leave the range of the linearisation.
  const double shift = std::max(std::abs(gradient_[kMap + 2]), std::abs(gradient_[kMap + 5]));
  const double scale = shift > 0.7 ? 0.7 / shift : 1;
  for (int i = 0; i < 8; ++i) map_[i] += scale * gradient_[kMap + i];
  for (int h = 0; h < family_.vertex_count(); ++h) {
    if (holes_free) {
      hole_[h] += static_cast<float>(gradient_[kDense + h]);
    } else {
      hole_[h] = (bits_ >> h & 1) != 0 ? -levels_.node : 0;
    }
  }
}

}  // namespace topotag
