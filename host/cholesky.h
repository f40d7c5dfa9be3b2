#ifndef TOPOTAG_HOST_CHOLESKY_H_
#define TOPOTAG_HOST_CHOLESKY_H_

namespace topotag {

/// Cholesky decomposition in place of a symmetric n x n matrix, row-major: the lower triangle of
/// `a` becomes L, a = L L'. The upper triangle is neither read nor written.
/// @return false, with `a` spoilt, where the matrix is not positive definite to rounding.
bool Factorize(double* a, int n);

/// Solves L L' x = b in place.
void SolveFactorized(const double* factor, int n, double* b);

/// Inverse of a symmetric positive definite n x n matrix.
/// @param a        becomes its factor
/// @param inverse  n x n, both triangles written
/// @return as Factorize
bool InvertPositive(double* a, int n, double* inverse);

}  // namespace topotag

#endif  // TOPOTAG_HOST_CHOLESKY_H_
