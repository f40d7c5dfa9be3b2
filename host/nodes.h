#ifndef TOPOTAG_HOST_NODES_H_
#define TOPOTAG_HOST_NODES_H_

#include <vector>

#include "host/backend.h"
#include "host/buffer.h"
#include "host/tree.h"

namespace topotag {

/// All black components that may be nodes, whatever white area they lie in: what a tree needs to be
/// whole, an occluder breaks.
class NodeCollector {
 public:
  /// Nodes of at least kMinArea pixels with at most kMaxHoles white areas in them, in the order of
  /// their components; none where there are more than kMaxNodes, as in texture.
  void Find(const Components& components, Backend* backend);
  const std::vector<Node>& nodes() const { return nodes_; }
  /// Whether a black component, of any size, has two holes that may be those of a baseline node.
  bool sees_baseline() const { return sees_baseline_; }

  static constexpr uint32_t kMinArea = 9;
  static constexpr uint32_t kMaxHoles = 6;
  static constexpr size_t kMaxNodes = 192;

 private:
  Buffer<uint32_t> children_;                ///< of each root, how many
  Buffer<uint32_t> slot_;                    ///< of each label, index into features_; 0 = none
  std::vector<uint32_t> component_, owner_;  ///< of each slot; the owner of a hole is its node
  std::vector<uint32_t> last_hole_;  ///< of each node; of each hole the one before; 0 = none
  Buffer<Feature> features_;
  std::vector<Node> nodes_;
  bool sees_baseline_ = false;
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_NODES_H_
