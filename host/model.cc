#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr double kPitch = 4;  // units
constexpr double kBaselineStep = 2;

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

bool IdBit(Family family, uint64_t id, int vertex) {
  return (VertexBits(family, id) >> vertex & 1) != 0;
}

}  // namespace topotag
