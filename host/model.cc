#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr double kPitch = 4;  // units
constexpr double kBaselineStep = 2;

uint64_t ReverseBits(uint64_t v) {
  v = (v >> 1 & 0x5555555555555555) | (v & 0x5555555555555555) << 1;
  v = (v >> 2 & 0x3333333333333333) | (v & 0x3333333333333333) << 2;
  v = (v >> 4 & 0x0f0f0f0f0f0f0f0f) | (v & 0x0f0f0f0f0f0f0f0f) << 4;
  return __builtin_bswap64(v);
}

}  // namespace

Point2 ModelVertex(Family family, int i) {
  const int n = family.n();
  const double first = -kPitch / 2 * (n - 1);
  if (i == 1) return {first + kBaselineStep, first};
  return {first + kPitch * (i % n), first + kPitch * (i / n)};
}

std::vector<Point2> ModelVertices(Family family) {
  std::vector<Point2> vertices;
  for (int i = 0; i < family.vertex_count(); ++i) vertices.push_back(ModelVertex(family, i));
  return vertices;
}

uint64_t VertexBits(Family family, uint64_t id) {
  return ReverseBits(id) >> (64 - family.vertex_count());
}

uint64_t IdFromVertexBits(Family family, uint64_t bits) {
  return ReverseBits(bits) >> (64 - family.vertex_count());
}

bool IdBit(Family family, uint64_t id, int vertex) {
  return (VertexBits(family, id) >> vertex & 1) != 0;
}

}  // namespace topotag
