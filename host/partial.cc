#include "host/partial.h"

#include <algorithm>
#include <cmath>

#include "host/cells.h"
#include "host/grid_block.h"
#include "host/lattice.h"
#include "host/local_map.h"
#include "host/model.h"
#include "host/spots.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr int kMaxLattices = 4;      // that one place is looked through for
constexpr double kMinContrast = 12;  // grey levels
constexpr double kGridFit = 0.5;     // of a node to the grid, units
constexpr double kGridFitRms = 0.25;
constexpr int kMinMeasured = 5;  // nodes that the pose rests on
// Brightness of holes over the body, in parts of the contrast: the least of one, where no other
// node has one; their least distance to solid nodes; a node this near to the middle between both
// kinds, in parts of that, is neither.
constexpr double kMinHole = 0.3;
constexpr double kMinSpread = 0.25;
constexpr double kUndecided = 0.2;

// One lattice on its way to a marker. Columns and rows are those of the lattice.
class Reader {
 public:
  Reader(const ImageView& image, const Camera* camera, const Spots& spots, const Lattice& lattice)
      : spots_(spots), lattice_(lattice), map_{lattice.map, camera}, grey_(image, map_) {}

  bool FitInk() {
    Point2 at[Lattice::kMaxCells];
    float black[Lattice::kMaxCells], white[Lattice::kMaxCells];
    for (int i = 0; i < lattice_.count; ++i) {
      const Lattice::Cell& cell = lattice_.cells[static_cast<size_t>(i)];
      at[i] = CellPoint(cell.col, cell.row);
      MeasureInk(grey_, at[i], &black[i], &white[i]);
    }
    ink_.black = FitInkPlane(at, black, lattice_.count);
    ink_.white = FitInkPlane(at, white, lattice_.count);
    for (int i = 0; i < lattice_.count; ++i) {
      if (!(ink_.white.At(at[i]) - ink_.black.At(at[i]) > kMinContrast)) return false;
    }
    return true;
  }

  // The columns and rows in which nodes are seen.
  void FindExtent() {
    first_col_ = lattice_.first_col;
    last_col_ = lattice_.last_col;
    first_row_ = lattice_.first_row;
    last_row_ = lattice_.last_row;
    for (bool grows = true; grows;) {
      grows = false;
      if (Cols() < Family::kMaxN && HasNodes(first_col_ - 1, first_row_, 0, 1, Rows())) {
        --first_col_;
        grows = true;
      }
      if (Cols() < Family::kMaxN && HasNodes(last_col_ + 1, first_row_, 0, 1, Rows())) {
        ++last_col_;
        grows = true;
      }
      if (Rows() < Family::kMaxN && HasNodes(first_col_, first_row_ - 1, 1, 0, Cols())) {
        --first_row_;
        grows = true;
      }
      if (Rows() < Family::kMaxN && HasNodes(first_col_, last_row_ + 1, 1, 0, Cols())) {
        ++last_row_;
        grows = true;
      }
    }
  }
  int Cols() const { return last_col_ - first_col_ + 1; }
  int Rows() const { return last_row_ - first_row_ + 1; }

  // How bright holes and solid nodes are, by the nodes whose topology is whole.
  void FindKinds() {
    double sum[2] = {0, 0};
    int count[2] = {0, 0};
    for (int i = 0; i < lattice_.count; ++i) {
      const Lattice::Cell& place = lattice_.cells[static_cast<size_t>(i)];
      if (!spots_.spot[place.spot].is_single) continue;
      const CellReading cell = ReadWhole(CellPoint(place.col, place.row));
      if (!cell.is_node || !cell.is_clean) continue;
      const int kind = spots_.node[place.spot]->hole_count == 1;
      sum[kind] += cell.hole;
      ++count[kind];
    }
    solid_ = count[0] > 0 ? sum[0] / count[0] : 0;
    has_rings_ = count[1] > 0;
    ring_ = has_rings_ ? sum[1] / count[1] : solid_ + 2 * kMinHole;
  }

  // The only place of the baseline node among all n x n blocks of cells.
  bool FindBaseline(int n) {
    const double least = (solid_ + ring_) / 2;
    int found = 0;
    float holes[2] = {0, 0};
    bool is_clean = false;
    for (int col = last_col_ - n + 1; col <= first_col_; ++col) {
      for (int row = last_row_ - n + 1; row <= first_row_; ++row) {
        for (int turn = 0; turn < 4; ++turn) {
          const GridBlock frame(col, row, n, turn);
          if (!IsBaseline(grey_, CellPoint(frame.col, frame.row),
                          CellPoint1(frame.x_col, frame.x_row),
                          CellPoint1(frame.y_col, frame.y_row), ink_, static_cast<float>(least),
                          holes, &is_clean)) {
            continue;
          }
          frame_ = frame;
          baseline_is_clean_ = is_clean;
          ++found;
        }
      }
    }
    if (found != 1) return false;
    if (!has_rings_) ring_ = (holes[0] + holes[1]) / 2;
    return ring_ - solid_ > kMinSpread;
  }

  // A side whose outer gap is seen along most of it, at both ends of the columns or of the rows:
  // the grid does not go on behind an occluder there.
  bool HasEnds(int n) const {
    const auto is_white = [&](Point2 p) {
      return grey_.At(p) > (ink_.black.At(p) + ink_.white.At(p)) / 2;
    };
    // Behind the gap, between two columns, a grid that goes on would be white.
    const auto sees_end = [&](int col, int row, int along_col, int along_row, Point2 out) {
      int gaps = 0, frame = 0;
      for (int i = 0; i < n; ++i) {
        const Point2 p = CellPoint(col + i * along_col, row + i * along_row);
        const Point2 beyond{p.x + 3 * out.x + 2 * along_col, p.y + 3 * out.y + 2 * along_row};
        gaps += is_white({p.x + 2 * out.x, p.y + 2 * out.y});
        frame += i + 1 < n && !std::isnan(grey_.At(beyond)) && !is_white(beyond);
      }
      return 2 * gaps >= n && 2 * frame >= n - 1;
    };
    const int col = frame_.block_col, row = frame_.block_row;
    const bool cols = Cols() == n && sees_end(col, row, 0, 1, {-1, 0}) &&
                      sees_end(col + n - 1, row, 0, 1, {1, 0});
    const bool rows = Rows() == n && sees_end(col, row, 1, 0, {0, -1}) &&
                      sees_end(col, row + n - 1, 1, 0, {0, 1});
    return cols || rows;
  }

  // Bits of the vertices; false where more than `hidden_nodes`, or half of them, are hidden. Where
  // any is, what hides it may leave something like a node in its neighbours too: those must be free
  // of it.
  bool ReadBits(Family family, int hidden_nodes, Decoded* decoded) const {
    const int n = family.n();
    uint64_t whole, rings;
    if (!FindVertices(n, &whole, &rings)) return false;
    uint64_t bits = 0, known = 0, clean = 0;
    double certainty[kMaxVertices];
    for (int i = 2; i < family.vertex_count(); ++i) {
      const bool is_whole = (whole >> i & 1) != 0;
      const Point2 center = frame_.Cell(i % n, i / n);
      const CellReading cell = is_whole ? ReadWhole(center) : ReadCell(grey_, center, ink_, false);
      bool bit;
      bool is_known = IsKnown(cell, &bit);
      // What darkens a part of a node may darken its hole.
      if (is_whole && !cell.is_clean) is_known &= bit == (rings >> i & 1);
      certainty[i] = 2 * std::abs((cell.hole - solid_) / (ring_ - solid_) - 0.5);
      known |= uint64_t{is_known} << i;
      bits |= uint64_t{bit} << i;
      clean |= uint64_t{cell.is_clean} << i;
    }
    const uint64_t all = VertexBits(family, family.size() - 1);
    if (known != all) known &= clean;
    decoded->quality.decision = 1;
    for (int i = 2; i < family.vertex_count(); ++i) {
      if ((known >> i & 1) == 0) continue;
      decoded->quality.decision = std::min(decoded->quality.decision, certainty[i]);
    }
    decoded->quality.sharpness = ring_ - solid_;
    decoded->hidden = all & ~known;
    decoded->unmeasured = (all & ~(known & clean)) | (baseline_is_clean_ ? 0 : 3);
    const int hidden = __builtin_popcountll(decoded->hidden);
    if (hidden > hidden_nodes || hidden > family.bits() / 2) return false;
    decoded->family = family;
    decoded->id = IdFromVertexBits(family, bits & known);
    return true;
  }

  // The map of the tag, from the lattice's nodes and from the holes of the baseline node where it
  // is whole.
  bool FitTag(Family family, Decoded* decoded) const {
    const int n = family.n();
    const Point2* model = ModelTable(family);
    Point2 from[Lattice::kMaxCells + 2], to[Lattice::kMaxCells + 2];
    float areas[Lattice::kMaxCells];
    uint64_t whole, rings;
    if (!FindVertices(n, &whole, &rings)) return false;
    for (int i = 0; i < lattice_.count; ++i) {
      const Lattice::Cell& cell = lattice_.cells[static_cast<size_t>(i)];
      from[i] = model[frame_.Vertex(cell.col, cell.row, n)];
      to[i] = spots_.spot[cell.spot].at;
    }
    const int count = lattice_.count;
    // The lattice's map with the tag's axes.
    const Homography guess = frame_.Compose(lattice_.map, n);
    Homography inverse;
    if (!FitHomography(from, to, count, guess, &decoded->map.ideal) ||
        !Invert(decoded->map.ideal, &inverse)) {
      return false;
    }
    decoded->map.camera = map_.camera;
    double sum = 0;
    for (int i = 0; i < count; ++i) {
      const Point2 tag = inverse.Map(to[i]);
      const double dx = tag.x - from[i].x, dy = tag.y - from[i].y;
      const double error = dx * dx + dy * dy;
      if (!(error < kGridFit * kGridFit)) return false;
      sum += error;
      Jacobian2 j;
      decoded->map.ideal.Map(from[i], &j);
      const Spot& spot = spots_.spot[lattice_.cells[static_cast<size_t>(i)].spot];
      areas[i] = static_cast<float>(spot.area / std::abs(j[0] * j[3] - j[1] * j[2]));
    }
    std::nth_element(areas, areas + count / 2, areas + count);
    decoded->node_area = areas[count / 2];
    // Where the bodies are touched all around, the nodes that are whole in the bit image have to
    // do.
    const int measured = family.vertex_count() - __builtin_popcountll(decoded->unmeasured);
    if (measured < kMinMeasured) decoded->unmeasured &= ~whole;
    return sum < kGridFitRms * kGridFitRms * count;
  }

 private:
  static Point2 CellPoint1(int col, int row) {
    return {static_cast<double>(col), static_cast<double>(row)};
  }

  // The vertices that the lattice's nodes are, and those with a hole, as in VertexBits.
  bool FindVertices(int n, uint64_t* whole, uint64_t* rings) const {
    *whole = *rings = 0;
    for (int i = 0; i < lattice_.count; ++i) {
      const Lattice::Cell& cell = lattice_.cells[static_cast<size_t>(i)];
      const int vertex = frame_.Vertex(cell.col, cell.row, n);
      if (vertex < 0) return false;
      if (!spots_.spot[cell.spot].is_single) continue;
      if (vertex == 0) return false;
      *whole |= uint64_t{1} << vertex;
      *rings |= uint64_t{spots_.node[cell.spot]->hole_count == 1} << vertex;
    }
    return true;
  }

  bool HasNodes(int col, int row, int step_col, int step_row, int count) const {
    for (int i = 0; i < count; ++i) {
      const CellReading cell =
          ReadCell(grey_, CellPoint(col + i * step_col, row + i * step_row), ink_, false);
      bool bit;
      if (IsKnown(cell, &bit)) return true;
    }
    return false;
  }

  // A node that the bit image shows needs no other's levels, which a shadow may have changed.
  CellReading ReadWhole(Point2 center) const {
    float black, white;
    MeasureInk(grey_, center, &black, &white);
    return ReadCell(grey_, center, {{black, 0, 0}, {white, 0, 0}}, true);
  }

  // Whether a cell's bit is seen.
  bool IsKnown(const CellReading& cell, bool* bit) const {
    const double above = (cell.hole - solid_) / (ring_ - solid_);
    *bit = above > 0.5;
    return cell.is_node && std::abs(above - 0.5) >= kUndecided &&
           (*bit ? cell.shows_bright_center : cell.shows_dark_center);
  }

  const Spots& spots_;
  const Lattice& lattice_;
  TagMap map_;
  GreyReader grey_;
  InkLevels ink_;
  int first_col_ = 0, last_col_ = 0, first_row_ = 0, last_row_ = 0;
  double solid_ = 0, ring_ = 0;
  bool has_rings_ = false;
  bool baseline_is_clean_ = false;
  GridBlock frame_;
};

// Of the nodes that nothing touches.
double MeanContrast(const Decoded& decoded) {
  double sum = 0;
  int count = 0;
  for (int i = 2; i < decoded.family.vertex_count(); ++i) {
    if ((decoded.unmeasured >> i & 1) != 0) continue;
    const NodeLevels& levels = decoded.levels[static_cast<size_t>(i)];
    sum += levels.white - levels.black;
    ++count;
  }
  return sum / std::max(count, 1);
}

bool ReadLattice(const ImageView& image, const std::vector<Family>& families, const Camera* camera,
                 const Spots& spots, const Lattice& lattice, int hidden_nodes, Decoded* decoded) {
  Reader reader(image, camera, spots, lattice);
  if (!reader.FitInk()) return false;
  reader.FindKinds();
  reader.FindExtent();
  const int n = std::max(reader.Cols(), reader.Rows());
  if (n < Family::kMinN || n > Family::kMaxN) return false;
  const Family family(n);
  if (std::find(families.begin(), families.end(), family) == families.end()) return false;
  if (!reader.FindBaseline(n) || !reader.HasEnds(n) ||
      !reader.ReadBits(family, hidden_nodes, decoded) || !reader.FitTag(family, decoded) ||
      !IsInFront(decoded->map.ideal, family.white_side() / 2.0)) {
    return false;
  }
  const LocalMaps maps(decoded->map, ModelTable(family), family.vertex_count() + 1);
  float holes[kMaxVertices];
  if (!MeasureLevels(image, family, maps, decoded->levels.data(), holes)) return false;
  decoded->quality.contrast = MeanContrast(*decoded);
  return true;
}

}  // namespace

bool ReadPartial(const ImageView& image, const std::vector<Family>& families, const Node* nodes,
                 int count, const Camera* camera, const SearchArea& area, Point2 start,
                 int hidden_nodes, Decoded* decoded) {
  Spots spots;
  Point2 ideal_start;
  if (!GatherSpots(nodes, count, camera, area, &spots) ||
      !PixelToIdeal(camera, start, &ideal_start)) {
    return false;
  }
  SpotUse use[kMaxSpots] = {};
  Lattice lattice;
  for (int i = 0; i < kMaxLattices; ++i) {
    if (!GrowLattice(spots.spot, spots.count, ideal_start, use, &lattice)) return false;
    if (ReadLattice(image, families, camera, spots, lattice, hidden_nodes, decoded)) return true;
  }
  return false;
}

}  // namespace topotag
