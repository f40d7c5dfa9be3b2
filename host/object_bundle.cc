#include "host/object_bundle.h"

#include <algorithm>
#include <cmath>

#include "host/cholesky.h"

namespace topotag {
namespace {

constexpr int kMaxIterations = 50;
// Done where the next step would lower the cost, in variances of one measurement, by less.
constexpr double kStop = 1e-4;
// A sighting whose errors are this many standard deviations loses weight (Cauchy).
constexpr double kKernel = 4;

using Block = Matrix6;

double Rho(const MarkerEquations& equations, int freedom) {
  const double scale = kKernel * kKernel * freedom;
  return equations.cost == INFINITY ? INFINITY : scale * std::log1p(equations.cost / scale);
}

double RhoWeight(const MarkerEquations& equations, int freedom) {
  return 1 / (1 + equations.cost / (kKernel * kKernel * freedom));
}

// Part of the equations' matrix, with the rows from `row` and the columns from `column`, as a full
// block.
Block Part(const MarkerEquations& equations, size_t row, size_t column) {
  Block block;
  for (size_t i = 0; i < 6; ++i) {
    for (size_t k = 0; k < 6; ++k) {
      const size_t r = std::max(row + i, column + k), c = std::min(row + i, column + k);
      block[i][k] = equations.matrix[r][c];
    }
  }
  return block;
}

// Solves for every row: x with x (L L') = rows.
void SolveRows(const Block& factor, Block* rows) {
  for (auto& row : *rows) SolveFactorized(factor[0].data(), 6, row.data());
}

}  // namespace

ObjectBundle::ObjectBundle(std::vector<RigidTransform>* markers, std::vector<BundleView>* views)
    : markers_(*markers), views_(*views), unknowns_(6 * (static_cast<int>(markers->size()) - 1)) {}

double ObjectBundle::Cost() const {
  double cost = 0;
  for (const BundleView& view : views_) {
    for (const Sighting& one : view.sightings) {
      const RigidTransform& marker = markers_[static_cast<size_t>(one.marker)];
      cost += Rho(one.ByMarker(*view.camera, view.pose, marker), one.Freedom());
    }
  }
  return cost;
}

// Evaluates all sightings, weighted. @return the cost
double ObjectBundle::Build() {
  equations_.clear();
  double cost = 0;
  for (const BundleView& view : views_) {
    for (const Sighting& one : view.sightings) {
      const RigidTransform& marker = markers_[static_cast<size_t>(one.marker)];
      const MarkerEquations full = one.ByMarker(*view.camera, view.pose, marker);
      cost += Rho(full, one.Freedom());
      MarkerEquations& weighted = equations_.emplace_back();
      weighted.Add(full, RhoWeight(full, one.Freedom()));
    }
  }
  return cost;
}

// Eliminates the views: fills reduced_, right_ and factors_.
bool ObjectBundle::Reduce(double damping) {
  const size_t n = static_cast<size_t>(unknowns_);
  reduced_.assign(n * n, 0);
  right_.assign(n, 0);
  factors_.clear();
  const auto add = [&](int row, int column, const Block& block, double scale) {
    if (row == 0 || column == 0) return;
    const size_t r = 6 * static_cast<size_t>(row - 1), c = 6 * static_cast<size_t>(column - 1);
    for (size_t i = 0; i < 6; ++i) {
      for (size_t k = 0; k < 6; ++k) reduced_[(r + i) * n + c + k] += scale * block[i][k];
    }
  };
  const MarkerEquations* equations = equations_.data();
  std::vector<Block> gains;
  for (const BundleView& view : views_) {
    PoseEquations own;
    for (size_t s = 0; s < view.sightings.size(); ++s) {
      const Block part = Part(equations[s], 0, 0);
      for (size_t i = 0; i < 6; ++i) {
        own.gradient[i] += equations[s].gradient[i];
        for (size_t k = 0; k < 6; ++k) own.matrix[i][k] += part[i][k];
      }
    }
    for (size_t i = 0; i < 6; ++i) own.matrix[i][i] *= 1 + damping;
    if (!Factorize(own.matrix[0].data(), 6)) return false;
    factors_.push_back(own.matrix);
    gains.clear();
    for (size_t s = 0; s < view.sightings.size(); ++s) {
      gains.push_back(Part(equations[s], 6, 0));
      SolveRows(own.matrix, &gains.back());
    }
    for (size_t s = 0; s < view.sightings.size(); ++s) {
      const int marker = view.sightings[s].marker;
      Block part = Part(equations[s], 6, 6);
      for (size_t i = 0; i < 6; ++i) part[i][i] *= 1 + damping;
      add(marker, marker, part, 1);
      for (size_t o = 0; o < view.sightings.size(); ++o) {
        const Block other = Part(equations[o], 6, 0);
        Block product{};
        for (size_t i = 0; i < 6; ++i) {
          for (size_t k = 0; k < 6; ++k) {
            for (size_t m = 0; m < 6; ++m) product[i][k] += gains[s][i][m] * other[k][m];
          }
        }
        add(marker, view.sightings[o].marker, product, -1);
      }
      if (marker == 0) continue;
      double* right = right_.data() + 6 * (marker - 1);
      for (size_t i = 0; i < 6; ++i) {
        right[i] -= equations[s].gradient[i + 6];
        for (size_t m = 0; m < 6; ++m) right[i] += gains[s][i][m] * own.gradient[m];
      }
    }
    equations += view.sightings.size();
  }
  return true;
}

// Moves everything by one step. @return the expected fall of the cost, negative where there is no
// solution
double ObjectBundle::Step(double damping) {
  if (!Reduce(damping) || !Factorize(reduced_.data(), unknowns_)) return -1;
  SolveFactorized(reduced_.data(), unknowns_, right_.data());
  double gain = 0;
  const MarkerEquations* equations = equations_.data();
  for (size_t v = 0; v < views_.size(); ++v) {
    Vector6 step{};
    for (size_t s = 0; s < views_[v].sightings.size(); ++s) {
      const int marker = views_[v].sightings[s].marker;
      const double* moved = marker == 0 ? nullptr : right_.data() + 6 * (marker - 1);
      const Block mixed = Part(equations[s], 0, 6);
      for (size_t i = 0; i < 6; ++i) {
        step[i] -= equations[s].gradient[i];
        for (size_t k = 0; moved != nullptr && k < 6; ++k) step[i] -= mixed[i][k] * moved[k];
        if (moved != nullptr) gain -= equations[s].gradient[i + 6] * moved[i];
      }
    }
    SolveFactorized(factors_[v][0].data(), 6, step.data());
    for (size_t s = 0; s < views_[v].sightings.size(); ++s) {
      for (size_t i = 0; i < 6; ++i) gain -= equations[s].gradient[i] * step[i];
    }
    views_[v].pose = Moved(views_[v].pose, step.data());
    equations += views_[v].sightings.size();
  }
  for (size_t m = 1; m < markers_.size(); ++m) {
    markers_[m] = Moved(markers_[m], right_.data() + 6 * (m - 1));
  }
  return gain;
}

bool ObjectBundle::Adjust() {
  double damping = 1e-4;
  double cost = Build();
  for (int i = 0; i < kMaxIterations; ++i) {
    const std::vector<RigidTransform> markers = markers_;
    std::vector<RigidTransform> poses;
    for (const BundleView& view : views_) poses.push_back(view.pose);
    const double gain = Step(damping);
    const double moved = gain < 0 ? INFINITY : Cost();
    if (moved < cost) {
      cost = Build();
      damping = std::max(damping / 10, 1e-12);
      if (gain < kStop) break;
      continue;
    }
    markers_ = markers;
    for (size_t v = 0; v < views_.size(); ++v) views_[v].pose = poses[v];
    if (gain >= 0 && gain < kStop) break;
    damping = std::max(damping * 10, 1e-6);
    if (damping > 1e6) return false;
  }
  for (RigidTransform& marker : markers_) marker.R = Orthonormalized(marker.R);
  for (BundleView& view : views_) view.pose.R = Orthonormalized(view.pose.R);
  return std::isfinite(cost);
}

bool ObjectBundle::Covariance(std::vector<double>* covariance) {
  covariance->resize(static_cast<size_t>(unknowns_) * static_cast<size_t>(unknowns_));
  const double cost = Build();
  if (!Reduce(0) || !InvertPositive(reduced_.data(), unknowns_, covariance->data())) return false;
  int freedom = -unknowns_ - 6 * static_cast<int>(views_.size());
  for (const BundleView& view : views_) {
    for (const Sighting& one : view.sightings) freedom += one.Freedom();
  }
  // Errors are in standard deviations: where these are right, the cost is the degrees of freedom.
  const double scale = freedom > 0 ? std::max(cost / freedom, 1.0) : 1;
  for (double& value : *covariance) value *= scale;
  return true;
}

}  // namespace topotag
