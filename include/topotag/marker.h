#ifndef TOPOTAG_MARKER_H_
#define TOPOTAG_MARKER_H_

#include <cstdint>
#include <string>
#include <vector>

#include "topotag/family.h"
#include "topotag/geometry.h"

namespace topotag {

enum class InnerShape { kSquare, kCircle, kHexagon };
enum class OuterShape { kSquare, kCircle, kButterfly, kPolygon };

/// @throws Error (kInvalidArgument) that lists the names.
InnerShape ParseInnerShape(const std::string& name);
const char* Name(InnerShape shape);
const char* Name(OuterShape shape);

/// What is printed: an ID of a family with its shapes. Lengths in units.
struct MarkerDesign {
  Family family{4};
  uint64_t id = 0;
  InnerShape inner = InnerShape::kSquare;
  OuterShape outer = OuterShape::kSquare;
  std::vector<Point2> polygon;  ///< outline of the white area for OuterShape::kPolygon
  double frame = 1;             ///< width of the black frame around the white area, >= 0
  double margin = 0;            ///< width of the white paper around the frame, >= 0
  bool inverted = false;        ///< white and black are exchanged, paper and frame included
};

/// A closed outline: a circle where radius > 0, else a simple polygon.
struct Outline {
  Point2 center;
  double radius = 0;
  std::vector<Point2> points;
};

/// A marker as nested areas, each painted over the ones before: paper (white), frame (black),
/// white area, nodes (black), holes (white). paper and frame are empty where their width is 0.
/// Node 0 is the baseline node: the union of its outlines is one area; every other node has one
/// outline. All in units, tag axes.
struct MarkerGeometry {
  std::vector<Outline> paper;
  std::vector<Outline> frame;
  Outline white;
  std::vector<std::vector<Outline>> nodes;
  std::vector<Outline> holes;
  Point2 min, max;  ///< bounding box of everything painted
};

/// @throws Error (kInvalidArgument): ID out of the family's range (the message names the range),
///         negative widths, a polygon that is not simple or leaves less than half a unit around
///         a node.
MarkerGeometry BuildMarkerGeometry(const MarkerDesign& design);

/// Model vertex i of a family in units: v0 = p1, v1 = p2, then row-major from cell (0, 2).
/// @throws Error (kInvalidArgument) unless 0 <= i < n*n.
Point2 ModelVertex(Family family, int i);
/// All n*n of them.
std::vector<Point2> ModelVertices(Family family);

/// The code of an ID as the bits of its vertices: bit i is that of model vertex i, 2 <= i < n*n,
/// 1 = a hole; bits 0 and 1 are 0. In the ID, vertex 2 is the most significant bit: the same bits
/// in reverse.
inline uint64_t VertexBits(Family family, uint64_t id) {
  uint64_t v = id;
  v = (v >> 1 & 0x5555555555555555) | (v & 0x5555555555555555) << 1;
  v = (v >> 2 & 0x3333333333333333) | (v & 0x3333333333333333) << 2;
  v = (v >> 4 & 0x0f0f0f0f0f0f0f0f) | (v & 0x0f0f0f0f0f0f0f0f) << 4;
  v = (v >> 8 & 0x00ff00ff00ff00ff) | (v & 0x00ff00ff00ff00ff) << 8;
  v = (v >> 16 & 0x0000ffff0000ffff) | (v & 0x0000ffff0000ffff) << 16;
  v = v >> 32 | v << 32;
  return v >> (64 - family.vertex_count());
}

/// Inverse of VertexBits.
inline uint64_t IdFromVertexBits(Family family, uint64_t bits) { return VertexBits(family, bits); }

/// Bit of one model vertex, 2 <= vertex < n*n; those of 0 and 1 are 0.
/// @throws Error (kInvalidArgument) unless 0 <= vertex < n*n.
bool IdBit(Family family, uint64_t id, int vertex);

/// An outline as a polygon; circles get `circle_segments` sides of equal area to the circle.
/// @throws Error (kInvalidArgument) unless there are 3 to 1e6 of them.
std::vector<Point2> Tessellate(const Outline& outline, int circle_segments);

/// Union of the baseline node's two equal outlines, the second shifted along +x, as one polygon.
/// One outline is its own union.
/// @throws Error (kInvalidArgument) as Tessellate; for other outlines than these.
std::vector<Point2> TessellateUnion(const std::vector<Outline>& outlines, int circle_segments);

/// Reads a polygon: one "x y" pair in units a line, blank lines and # comments ignored.
/// @throws Error (kFile, kParse) that names the file and the line.
std::vector<Point2> ReadPolygon(const std::string& path);

}  // namespace topotag

#endif  // TOPOTAG_MARKER_H_
