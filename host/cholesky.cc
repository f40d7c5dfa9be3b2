#include "host/cholesky.h"

#include <algorithm>
#include <cmath>

namespace topotag {
namespace {

// Of a pivot, in parts of the diagonal element that it is left of.
constexpr double kMinPivot = 1e-13;

}  // namespace

bool Factorize(double* a, int n) {
  for (int i = 0; i < n; ++i) {
    double* row = a + i * n;
    const double diagonal = row[i];
    for (int k = 0; k <= i; ++k) {
      const double* other = a + k * n;
      double sum = row[k];
      for (int j = 0; j < k; ++j) sum -= row[j] * other[j];
      row[k] = k < i ? sum / other[k] : sum;
    }
    if (!(row[i] > kMinPivot * diagonal)) return false;
    row[i] = std::sqrt(row[i]);
  }
  return true;
}

void SolveFactorized(const double* factor, int n, double* b) {
  for (int i = 0; i < n; ++i) {
    const double* row = factor + i * n;
    for (int j = 0; j < i; ++j) b[i] -= row[j] * b[j];
    b[i] /= row[i];
  }
  for (int i = n - 1; i >= 0; --i) {
    const double* row = factor + i * n;
    b[i] /= row[i];
    for (int j = 0; j < i; ++j) b[j] -= row[j] * b[i];
  }
}

bool InvertPositive(double* a, int n, double* inverse) {
  if (!Factorize(a, n)) return false;
  std::fill(inverse, inverse + n * n, 0.0);
  // Rows of the inverse are its columns, but for rounding.
  for (int i = 0; i < n; ++i) {
    inverse[i * n + i] = 1;
    SolveFactorized(a, n, inverse + i * n);
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) inverse[k * n + i] = inverse[i * n + k];
  }
  return true;
}

}  // namespace topotag
