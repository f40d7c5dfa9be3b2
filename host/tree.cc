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
constexpr int kNoNode = 3;  // hole_count of a component that cannot be a node

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
  nodes_.clear();
  CountChildren(components);
  CollectMembers(components);
  if (members_.size() == 1) return;
  features_.Reserve(members_.size());
  backend->Measure(components, slot_.data(), members_.size(), features_.data());
  for (uint32_t slot = 1; slot < members_.size(); ++slot) {
    if (members_[slot].depth == 0) BuildCandidate(slot);
  }
}

void TopologyTree::CountChildren(const Components& components) {
  children_.Reserve(components.label_end());
  for (const auto& [begin, end] : components.ranges) {
    std::fill(children_.data() + begin, children_.data() + end, 0);
    for (uint32_t label = begin; label < end; ++label) {
      if (components.root[label] == label) ++children_[components.parent[label]];
    }
  }
}

// Parents have smaller labels than their children: one pass in ascending order.
void TopologyTree::CollectMembers(const Components& components) {
  slot_.Reserve(components.label_end());
  members_.assign(1, Member{0, 0, 0, 0});
  slot_[0] = 0;
  for (const auto& [begin, end] : components.ranges) {
    for (uint32_t label = std::max(begin, 1u); label < end; ++label) {
      const uint32_t root = components.root[label];
      slot_[label] = root == label ? AddMember(components, label) : slot_[root];
    }
  }
}

// Slot of the component, 0 if it is no member.
uint32_t TopologyTree::AddMember(const Components& components, uint32_t root) {
  const uint32_t parent_slot = slot_[components.parent[root]];
  const int children = children_[root];
  const bool is_root =
      components.white[root] && children >= min_nodes_ - kMergedNodes && children <= max_nodes_;
  // A root may lie in a node of another one: then it is a hole of that node as well.
  const bool is_below = parent_slot != 0 && members_[parent_slot].depth < 3;
  if (!is_root && !is_below) return 0;
  const auto slot = static_cast<uint32_t>(members_.size());
  Member member{root, 0, 0, is_root ? 0 : members_[parent_slot].depth + 1};
  if (is_below) member.next = std::exchange(members_[parent_slot].first_child, slot);
  members_.push_back(member);
  return slot;
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
  Candidate candidate;
  candidate.root = members_[root_slot].component;
  candidate.white = features_[root_slot];
  candidate.first_node = static_cast<int>(nodes_.size());
  for (uint32_t slot = members_[root_slot].first_child; slot != 0; slot = members_[slot].next) {
    Node node;
    // A component that is no node may still be a small error node: it keeps its area.
    if (!BuildNode(slot, &node)) node.hole_count = kNoNode;
    nodes_.push_back(node);
  }
  std::sort(nodes_.begin() + candidate.first_node, nodes_.end(), [](const Node& a, const Node& b) {
    return a.black.area != b.black.area ? a.black.area > b.black.area : a.component < b.component;
  });
  const bool doubtful = HasLikeNodes(candidate);
  if (RemoveErrorNodes(&candidate)) {
    std::sort(nodes_.begin() + candidate.first_node, nodes_.end(),
              [](const Node& a, const Node& b) { return a.component < b.component; });
    if (FindBaseline(&candidate)) {
      candidates_.push_back(candidate);
      return;
    }
  }
  if (doubtful) doubts_.push_back({candidate.root, candidate.white});
  nodes_.resize(static_cast<size_t>(candidate.first_node));
}

// Whether the children (by falling area) could be the nodes of a marker, whole or in pieces.
bool TopologyTree::HasLikeNodes(const Candidate& candidate) const {
  const Node* begin = nodes_.data() + candidate.first_node;
  const Node* end = nodes_.data() + nodes_.size();
  uint64_t cover = 0;
  int count = 0;
  for (const Node* node = begin; node != end; ++node) {
    if (node->black.area * kMaxNodeAreaRatio < begin->black.area) break;
    cover += node->black.area;
    ++count;
  }
  return count >= min_nodes_ - kMergedNodes &&
         100 * cover > kMinCoverPercent * candidate.white.area &&
         100 * cover < kMaxCoverPercent * candidate.white.area;
}

// False unless exactly one node has two holes, and all others one or none.
bool TopologyTree::FindBaseline(Candidate* candidate) const {
  int baselines = 0;
  for (int i = 0; i < candidate->node_count; ++i) {
    const int holes = nodes_.data()[candidate->first_node + i].hole_count;
    if (holes == kNoNode) return false;
    if (holes != 2) continue;
    candidate->baseline = i;
    ++baselines;
  }
  return baselines == 1;
}

// Leaves, of children by falling area, the nodes of the largest family whose surplus nodes are all
// errors. False where there is none.
bool TopologyTree::RemoveErrorNodes(Candidate* candidate) {
  const auto begin = nodes_.begin() + candidate->first_node;
  const int count = static_cast<int>(nodes_.end() - begin);
  uint32_t baseline_area = 0;
  if (params_.baseline_reference) {
    const auto baseline =
        std::find_if(begin, nodes_.end(), [](const Node& node) { return node.hole_count == 2; });
    if (baseline == nodes_.end()) return false;
    baseline_area = baseline->black.area;
  }

  int kept = 0;
  for (const Family& family : params_.families) {
    const int nodes = family.node_count();
    if (nodes > count || nodes <= kept) continue;
    const uint32_t reference =
        params_.baseline_reference ? baseline_area : begin[nodes - 1].black.area;
    if (params_.baseline_reference &&
        IsBelowPercent(begin[nodes - 1].black.area, params_.theta1_percent, reference)) {
      continue;
    }
    if (nodes < count &&
        !IsBelowPercent(begin[nodes].black.area, params_.theta1_percent, reference)) {
      continue;
    }
    kept = nodes;
    candidate->family = family;
  }
  if (kept == 0) return false;
  candidate->node_count = kept;
  nodes_.resize(nodes_.size() - static_cast<size_t>(count - kept));
  return true;
}

}  // namespace topotag
