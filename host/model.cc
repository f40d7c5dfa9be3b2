#include "host/model.h"

#include <array>
#include <string>

#include "host/check.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr double kPitch = 4;  // units
constexpr double kBaselineStep = 2;
constexpr int kFamilies = Family::kMaxN - Family::kMinN + 1;

using Points = std::array<Point2, kMaxVertices + 1>;

constexpr std::array<Points, kFamilies> MakeTables() {
  std::array<Points, kFamilies> tables{};
  for (int n = Family::kMinN; n <= Family::kMaxN; ++n) {
    Points& table = tables[static_cast<size_t>(n - Family::kMinN)];
    const double first = -kPitch / 2 * (n - 1);
    for (int i = 0; i < n * n; ++i) {
      table[static_cast<size_t>(i)] = {first + kPitch * (i % n), first + kPitch * (i / n)};
    }
    table[1] = {first + kBaselineStep, first};
    table[static_cast<size_t>(n * n)] = {first + kBaselineStep / 2, first};
  }
  return tables;
}

constexpr std::array<Points, kFamilies> kTables = MakeTables();

void RequireVertex(Family family, int i) {
  if (i >= 0 && i < family.vertex_count()) return;
  FailArgument("vertex " + std::to_string(i) + " is not in the range 0.." +
               std::to_string(family.vertex_count() - 1) + " of " + family.name());
}

}  // namespace

const Point2* ModelTable(Family family) {
  return kTables[static_cast<size_t>(family.n() - Family::kMinN)].data();
}

Point2 ModelVertex(Family family, int i) {
  RequireVertex(family, i);
  return ModelTable(family)[i];
}

std::vector<Point2> ModelVertices(Family family) {
  const Point2* table = ModelTable(family);
  return {table, table + family.vertex_count()};
}

bool IdBit(Family family, uint64_t id, int vertex) {
  RequireVertex(family, vertex);
  return (VertexBits(family, id) >> vertex & 1) != 0;
}

}  // namespace topotag
