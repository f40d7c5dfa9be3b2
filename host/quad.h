#ifndef TOPOTAG_HOST_QUAD_H_
#define TOPOTAG_HOST_QUAD_H_

namespace topotag {

/// Four numbers at a time, in each lane the same operations as for one, on every CPU: the vector
/// extension that gcc and clang share.
using Quad = float __attribute__((vector_size(4 * sizeof(float))));

inline Quad MakeQuad(float a) { return Quad{a, a, a, a}; }
inline float SumLanes(Quad q) { return (q[0] + q[1]) + (q[2] + q[3]); }

}  // namespace topotag

#endif  // TOPOTAG_HOST_QUAD_H_
