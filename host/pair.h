#ifndef TOPOTAG_HOST_PAIR_H_
#define TOPOTAG_HOST_PAIR_H_

namespace topotag {

/// Two numbers at a time, in each lane the same operations as for one, on every CPU: the vector
/// extension that gcc and clang share.
using Pair = double __attribute__((vector_size(2 * sizeof(double))));

inline double SumLanes(Pair pair) { return pair[0] + pair[1]; }

}  // namespace topotag

#endif  // TOPOTAG_HOST_PAIR_H_
