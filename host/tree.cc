#include "host/tree.h"

#include <algorithm>
#include <utility>

namespace topotag {
namespace {

// Nodes of one marker differ in area by the baseline node's double width and by perspective.
constexpr uint64_t kMaxNodeAreaRatio = 12;
// The nodes of a marker cover between these parts of the white area's own pixels, per cent: without
// blur 45 to 90, and less in an outer shape that is larger than the square.
constexpr uint64_t kMinCoverPercent = 15;
constexpr uint64_t kMaxCoverPercent = 300;

// Nodes that may have run together in a doubtful marker.
constexpr int kMergedNodes = 4;

// A hole smaller than this part of its node's black area is noise: a real one has an eighth.
constexpr uint32_t kMinHoleFraction = 50;

// A baseline node is 5 x 3 units, with two holes of 1 unit 2 units apart, blurred and tilted.
constexpr uint32_t kMinBaselineArea = 40;  // pixels
constexpr double kMaxHoleRatio = 1.6;      // of one hole to the other
constexpr double kMinHolePart = 1 / 40.0;  // of a hole to the whole node
constexpr double kMaxHolePart = 1 / 8.0;
constexpr double kMinSpacing = 4 / 15.0 / 2.5;  // squared, in parts of the area
constexpr double kMaxSpacing = 4 / 15.0 * 2.5;
constexpr double kMaxOffset =
    0.12;  // of the holes' middle from the node's, in parts of the spacing
// A node with a hole: 3 x 3 units with one of 1 unit in its middle.
constexpr uint32_t kMinRingArea = 24;  // pixels
constexpr double kMinRingHole = 1 / 30.0;
constexpr double kMaxRingHole = 1 / 4.0;
constexpr double kMaxRingOffset = 0.01;  // squared, in parts of the area

Point2 Centroid(const Feature& feature) {
  return {static_cast<double>(feature.sum_x) / feature.area,
          static_cast<double>(feature.sum_y) / feature.area};
}

bool IsBelowPercent(uint32_t area, int percent, uint32_t reference) {
  return uint64_t{100} * area < static_cast<uint64_t>(percent) * reference;
}

}  // namespace

TopologyTree::TopologyTree(TreeParams params) : params_(std::move(params)) {
  const auto [smallest, largest] =
      std::minmax_element(params_.families.begin(), params_.families.end());
  min_nodes_ = smallest->node_count();
  max_nodes_ = largest->node_count() + params_.tau;
}

void TopologyTree::Find(const Components& components, Backend* backend) {
  candidates_.clear();
  doubts_.clear();
  lost_baselines_.clear();
  nodes_.clear();
  CountChildren(components);
  CollectMembers(components);
  if (members_.size() == 1) return;
  features_.Reserve(members_.size());
  backend->Measure(components, slot_.data(), members_.size(), features_.data());
  for (uint32_t slot = 1; slot < members_.size(); ++slot) {
    if (members_[slot].depth == 0) BuildCandidate(slot);
  }
  for (uint32_t slot = 1; slot < members_.size(); ++slot) {
    LostBaseline lost;
    if (members_[slot].is_lost && IsBaseline(slot, &lost)) lost_baselines_.push_back(lost);
  }
}

// In this and the next pass, most labels are of no interest, and whether one is a root is as good
// as random: no branch depends on it.
void TopologyTree::CountChildren(const Components& components) {
  children_.Reserve(components.label_end());
  const uint32_t* root = components.root.data();
  const uint32_t* parent = components.parent.data();
  uint32_t* children = children_.data();
  for (const auto& [begin, end] : components.ranges) {
    std::fill(children + begin, children + end, 0);
    for (uint32_t label = begin; label < end; ++label) {
      children[parent[label]] += root[label] == label;
    }
  }
}

// Parents have smaller labels than their children: one pass in ascending order.
void TopologyTree::CollectMembers(const Components& components) {
  slot_.Reserve(components.label_end());
  members_.assign(1, Member{0, 0, 0, 0});
  slot_[0] = 0;
  const auto min_children = static_cast<uint32_t>(std::max(min_nodes_ - kMergedNodes, 1));
  const uint32_t more_children = static_cast<uint32_t>(max_nodes_) - min_children;
  for (const auto& [begin, end] : components.ranges) {
    for (uint32_t label = std::max(begin, 1u); label < end; ++label) {
      const uint32_t root = components.root[label];
      slot_[label] = 0;
      slot_[label] = slot_[root];  // 0 for the root itself
      const uint32_t parent_slot = slot_[components.parent[label]];
      const bool has_nodes = children_[label] - min_children <= more_children;
      const bool has_two_holes = children_[label] == 2;
      if ((has_nodes || has_two_holes || parent_slot != 0) && root == label) {
        AddMember(label, components.white[label] != 0, has_nodes, parent_slot);
      }
    }
  }
}

void TopologyTree::AddMember(uint32_t component, bool white, bool has_nodes, uint32_t parent_slot) {
  // A root may lie in a node of another one: then it is a hole of that node as well.
  const bool is_root = white && has_nodes;
  const bool is_below = parent_slot != 0 && members_[parent_slot].depth < 3;
  // Black with two holes.
  const bool is_lost = !white && !has_nodes && parent_slot == 0 && params_.lost_baselines;
  if (!is_root && !is_below && !is_lost) return;
  const auto slot = static_cast<uint32_t>(members_.size());
  slot_[component] = slot;
  const int depth = is_root ? 0 : is_lost ? 1 : members_[parent_slot].depth + 1;
  Member member{component, 0, 0, depth, is_lost};
  if (is_below) member.next = std::exchange(members_[parent_slot].first_child, slot);
  members_.push_back(member);
}

// False where the component cannot be a node: more than two holes, or something in a hole.
bool TopologyTree::BuildNode(uint32_t slot, Node* node) const {
  node->component = members_[slot].component;
  node->black = features_[slot];
  uint32_t area[3] = {0, 0, 0};  // of the three largest holes
  uint32_t hole_slot[2] = {0, 0};
  for (uint32_t hole = members_[slot].first_child; hole != 0; hole = members_[hole].next) {
    const uint32_t a = features_[hole].area;
    if (a > area[0]) {
      area[2] = std::exchange(area[1], std::exchange(area[0], a));
      hole_slot[1] = std::exchange(hole_slot[0], hole);
    } else if (a > area[1]) {
      area[2] = std::exchange(area[1], a);
      hole_slot[1] = hole;
    } else {
      area[2] = std::max(area[2], a);
    }
  }
  if (area[0] * uint64_t{kMinHoleFraction} < node->black.area) return true;
  const bool two = !IsBelowPercent(area[1], params_.theta1_percent, area[0]);
  if (two && !IsBelowPercent(area[2], params_.theta1_percent, area[1])) return false;
  node->hole_count = two ? 2 : 1;
  for (int i = 0; i < node->hole_count; ++i) {
    node->holes[static_cast<size_t>(i)] = features_[hole_slot[i]];
    const uint32_t inside = members_[hole_slot[i]].first_child;
    for (uint32_t spot = inside; spot != 0; spot = members_[spot].next) {
      if (!IsBelowPercent(features_[spot].area, params_.theta1_percent, area[i])) return false;
    }
  }
  return true;
}

void TopologyTree::BuildCandidate(uint32_t root_slot) {
  if (IsSmall(features_[root_slot])) return;
  children_by_area_.clear();
  for (uint32_t slot = members_[root_slot].first_child; slot != 0; slot = members_[slot].next) {
    children_by_area_.push_back({features_[slot].area, slot});
  }
  std::sort(children_by_area_.begin(), children_by_area_.end(), [](const Child& a, const Child& b) {
    return a.area != b.area ? a.area > b.area : a.slot < b.slot;
  });
  Candidate candidate;
  candidate.root = members_[root_slot].component;
  candidate.white = features_[root_slot];
  const bool is_doubtful = HasLikeNodes(candidate.white);
  const int count = NodesOfLargestFamily(&candidate.family);
  if (count != 0 && BuildNodes(count, &candidate)) {
    candidates_.push_back(candidate);
  } else if (is_doubtful) {
    LostBaseline baseline;
    const auto is_ring = [this](const Child& child) { return IsRing(child.slot); };
    const auto is_baseline = [&](const Child& child) { return IsBaseline(child.slot, &baseline); };
    const auto begin = children_by_area_.begin(), end = children_by_area_.end();
    const bool has_holes =
        std::count_if(begin, end, is_ring) > 1 || std::any_of(begin, end, is_baseline);
    doubts_.push_back({candidate.root, candidate.white, has_holes});
  } else if (params_.lost_baselines) {
    for (const Child& child : children_by_area_) members_[child.slot].is_lost = true;
  }
}

// Whether a black component is like a baseline node. Most are told by their number of holes and
// their size.
bool TopologyTree::IsBaseline(uint32_t slot, LostBaseline* baseline) const {
  const Feature& f = features_[slot];
  if (children_[members_[slot].component] != 2 || f.area < kMinBaselineArea) return false;
  Node node;
  if (!BuildNode(slot, &node) || node.hole_count != 2) return false;
  const Feature& larger = node.holes[0];
  const Feature& smaller = node.holes[1];
  *baseline = {Centroid(f), Centroid(larger), Centroid(smaller),
               static_cast<double>(f.area + larger.area + smaller.area)};
  const double dx = baseline->p2.x - baseline->p1.x, dy = baseline->p2.y - baseline->p1.y;
  const double off_x = (baseline->p1.x + baseline->p2.x) / 2 - baseline->center.x;
  const double off_y = (baseline->p1.y + baseline->p2.y) / 2 - baseline->center.y;
  const double spacing = dx * dx + dy * dy;
  const double area = baseline->area;
  return larger.area < kMaxHoleRatio * smaller.area && larger.area < kMaxHolePart * area &&
         smaller.area > kMinHolePart * area && spacing > kMinSpacing * area &&
         spacing < kMaxSpacing * area &&
         off_x * off_x + off_y * off_y < kMaxOffset * kMaxOffset * spacing;
}

// Whether a black component is like a node with a hole.
bool TopologyTree::IsRing(uint32_t slot) const {
  const Feature& f = features_[slot];
  const uint32_t hole_slot = members_[slot].first_child;
  if (children_[members_[slot].component] != 1 || hole_slot == 0 || f.area < kMinRingArea) {
    return false;
  }
  const Feature& hole = features_[hole_slot];
  const Point2 a = Centroid(f), b = Centroid(hole);
  const double area = static_cast<double>(f.area) + hole.area;
  const double dx = a.x - b.x, dy = a.y - b.y;
  return hole.area > kMinRingHole * area && hole.area < kMaxRingHole * area &&
         dx * dx + dy * dy < kMaxRingOffset * area;
}

// Whether the children could be the nodes of a marker, whole or in pieces.
bool TopologyTree::HasLikeNodes(const Feature& white) const {
  const uint64_t largest = children_by_area_[0].area;
  uint64_t cover = 0;
  int count = 0;
  for (const Child& child : children_by_area_) {
    if (child.area * kMaxNodeAreaRatio < largest) break;
    cover += child.area;
    ++count;
  }
  return count >= min_nodes_ - kMergedNodes && 100 * cover > kMinCoverPercent * white.area &&
         100 * cover < kMaxCoverPercent * white.area;
}

// Nodes of the largest family for which all further children are errors; 0 where there is none.
int TopologyTree::NodesOfLargestFamily(Family* family) const {
  const size_t count = children_by_area_.size();
  uint32_t baseline_area = 0;
  if (params_.baseline_reference) {
    const auto baseline = std::find_if(
        children_by_area_.begin(), children_by_area_.end(), [this](const Child& child) {
          Node node;
          return BuildNode(child.slot, &node) && node.hole_count == 2;
        });
    if (baseline == children_by_area_.end()) return 0;
    baseline_area = baseline->area;
  }
  const auto is_error = [&](const Child& child, uint32_t reference) {
    return IsBelowPercent(child.area, params_.theta1_percent, reference);
  };
  int kept = 0;
  for (const Family& candidate : params_.families) {
    const auto nodes = static_cast<size_t>(candidate.node_count());
    if (nodes > count || candidate.node_count() <= kept) continue;
    const Child& smallest = children_by_area_[nodes - 1];
    const uint32_t reference = params_.baseline_reference ? baseline_area : smallest.area;
    if (is_error(smallest, reference)) continue;
    if (nodes < count && !is_error(children_by_area_[nodes], reference)) continue;
    kept = candidate.node_count();
    *family = candidate;
  }
  return kept;
}

// Appends the `count` largest children as the candidate's nodes, in the order of their components.
// False, and nothing is left, unless exactly one has two holes and all others one or none.
bool TopologyTree::BuildNodes(int count, Candidate* candidate) {
  candidate->first_node = static_cast<int>(nodes_.size());
  candidate->node_count = count;
  const auto begin = children_by_area_.begin();
  std::sort(begin, begin + count, [](const Child& a, const Child& b) { return a.slot < b.slot; });
  nodes_.resize(nodes_.size() + static_cast<size_t>(count));
  int baselines = 0;
  for (int i = 0; i < count; ++i) {
    Node& node = nodes_[static_cast<size_t>(candidate->first_node + i)];
    node = Node();
    if (!BuildNode(begin[i].slot, &node) || (node.hole_count == 2 && ++baselines > 1)) {
      baselines = 0;
      break;
    }
    if (node.hole_count == 2) candidate->baseline = i;
  }
  if (baselines == 1) return true;
  nodes_.resize(static_cast<size_t>(candidate->first_node));
  return false;
}

}  // namespace topotag
