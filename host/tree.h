#ifndef TOPOTAG_HOST_TREE_H_
#define TOPOTAG_HOST_TREE_H_

#include <array>
#include <cstdint>
#include <vector>

#include "host/backend.h"
#include "host/pipeline.h"

namespace topotag {

struct TreeParams {
  std::vector<Family> families;
  /// A white area may have this many children more than the largest family has nodes (tau of
  /// section 4.2; the paper takes 0). With fewer than its nodes no marker can be decoded.
  int tau = 16;
  /// theta1 of section 4.2: a node below this part of the reference area is an error, per cent.
  int theta1_percent = 30;
  /// Reference area: that of the baseline node (the paper), else that of the smallest node kept.
  /// The latter also holds under strong perspective, where near nodes are many times larger.
  bool baseline_reference = false;
  /// Whether lost baseline nodes are looked for.
  bool lost_baselines = false;
  /// White areas of which width and height of the box together are less, pixels, are too small for
  /// any marker: neither candidates nor doubts.
  int min_extent = 0;
};

/// A black node of a candidate with its white holes, largest first.
struct Node {
  uint32_t component = 0;
  int hole_count = 0;
  std::array<Feature, 2> holes{};
  Feature black;
};

/// A white area whose subtree has the topology of a marker of `family`.
struct Candidate {
  Family family{Family::kMinN};
  uint32_t root = 0;
  int baseline = 0;  ///< index of the node with two holes
  int first_node = 0;
  int node_count = 0;
  Feature white;  ///< of the root itself, without its nodes
};

/// A white area with at least as many nodes of like size as a marker has, that is no candidate: the
/// threshold may have opened or closed holes, or cut nodes into pieces.
struct Doubt {
  uint32_t root = 0;
  Feature white;  ///< of the root itself
  bool has_holes =
      false;  ///< one of its nodes is like a baseline node, or has one hole in its middle
};

/// A black component like a baseline node in a white area that is neither candidate nor doubt: the
/// marker's may have run out into what surrounds it.
struct LostBaseline {
  Point2 center, p1, p2;  ///< pixels; either hole may be p1
  double area = 0;        ///< holes included
};

/// Finds the candidates of a frame. Paper: section 4.2.
///
/// In: components. Out: white areas with exactly the nodes of a family below them: one with two
/// holes, the others with one or none, depth 3, after small error nodes are removed. Candidates
/// are in the order of their roots, nodes in the order of their components.
class TopologyTree {
 public:
  explicit TopologyTree(TreeParams params);

  void Find(const Components& components, Backend* backend);

  const std::vector<Candidate>& candidates() const { return candidates_; }
  const std::vector<Doubt>& doubts() const { return doubts_; }
  const std::vector<LostBaseline>& lost_baselines() const { return lost_baselines_; }
  const Node* nodes(const Candidate& candidate) const {
    return nodes_.data() + candidate.first_node;
  }

 private:
  /// A possible root (depth 0), or what lies below one: 1 nodes, 2 holes, 3 what is inside holes.
  struct Member {
    uint32_t component;
    uint32_t next = 0;  ///< slot of the next sibling, 0 = none
    uint32_t first_child = 0;
    int depth;
    bool is_lost = false;  ///< of depth 1: no possible root, candidate or doubt is around it
  };

  /// A child of the possible root that is being looked at.
  struct Child {
    uint32_t area;
    uint32_t slot;
  };

  void CountChildren(const Components& components);
  void CollectMembers(const Components& components);
  void AddMember(uint32_t component, bool white, bool has_nodes, uint32_t parent_slot);
  bool BuildNode(uint32_t slot, Node* node) const;
  void BuildCandidate(uint32_t root_slot);
  bool HasLikeNodes(const Feature& white) const;
  int NodesOfLargestFamily(Family* family) const;
  bool BuildNodes(int count, Candidate* candidate);
  bool IsBaseline(uint32_t slot, LostBaseline* baseline) const;
  bool IsRing(uint32_t slot) const;
  bool IsSmall(const Feature& white) const {
    return white.max_x - white.min_x + white.max_y - white.min_y + 2 < params_.min_extent;
  }

  TreeParams params_;
  int min_nodes_;
  int max_nodes_;
  Buffer<uint32_t> children_;  ///< of each root, how many
  Buffer<uint32_t> slot_;      ///< of each label, index into members_; 0 = none
  std::vector<Member> members_;
  Buffer<Feature> features_;
  std::vector<Child> children_by_area_;  ///< falling
  std::vector<Node> nodes_;
  std::vector<Candidate> candidates_;
  std::vector<Doubt> doubts_;
  std::vector<LostBaseline> lost_baselines_;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_TREE_H_
