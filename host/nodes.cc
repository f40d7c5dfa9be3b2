#include "host/nodes.h"

#include <algorithm>
#include <utility>

namespace topotag {
namespace {

// Components that are looked at, before the small ones are left out.
constexpr size_t kMaxSlots = 4096;
// A hole smaller than this part of its node's black area is an error.
constexpr uint32_t kMinHoleFraction = 50;

// Two holes of a baseline node are of 1 unit, 2 units apart. Those of neighbouring nodes that have
// run together are 4 units apart.
bool ArePair(const Feature& a, const Feature& b) {
  constexpr double kMaxRatio = 1.8;    // of one hole to the other
  constexpr double kMinSpacing = 1.5;  // squared, in parts of their area; both shrink and grow
  constexpr double kMaxSpacing = 14;
  const double p = a.area, q = b.area;
  if (p > kMaxRatio * q || q > kMaxRatio * p) return false;
  const double dx = static_cast<double>(a.sum_x) / p - static_cast<double>(b.sum_x) / q;
  const double dy = static_cast<double>(a.sum_y) / p - static_cast<double>(b.sum_y) / q;
  const double spacing = (dx * dx + dy * dy) / ((p + q) / 2);
  return kMinSpacing < spacing && spacing < kMaxSpacing;
}

void AddHole(const Feature& hole, Node* node) {
  if (hole.area * uint64_t{kMinHoleFraction} < node->black.area) return;
  if (node->hole_count == 0 || hole.area > node->holes[0].area) {
    node->holes[1] = std::exchange(node->holes[0], hole);
  } else if (node->hole_count == 1 || hole.area > node->holes[1].area) {
    node->holes[1] = hole;
  }
  node->hole_count = std::min(node->hole_count + 1, 2);
}

}  // namespace

void NodeCollector::Find(const Components& components, Backend* backend) {
  nodes_.clear();
  sees_baseline_ = false;
  children_.Reserve(components.label_end());
  slot_.Reserve(components.label_end());
  component_.assign(1, 0);
  owner_.assign(1, 0);
  const uint32_t* root = components.root.data();
  const uint32_t* parent = components.parent.data();
  for (const auto& [begin, end] : components.ranges) {
    std::fill(children_.data() + begin, children_.data() + end, 0);
    for (uint32_t label = begin; label < end; ++label) {
      if (root[label] == label) ++children_[parent[label]];
    }
  }
  slot_[0] = 0;
  for (const auto& [begin, end] : components.ranges) {
    for (uint32_t label = std::max(begin, 1u); label < end; ++label) {
      slot_[label] = 0;
      if (root[label] != label) {
        slot_[label] = slot_[root[label]];
        continue;
      }
      const bool white = components.white[label] != 0;
      const uint32_t around = slot_[parent[label]];
      // White below a node that is itself no hole.
      if (white ? around == 0 : children_[label] > kMaxHoles) continue;
      if (component_.size() == kMaxSlots) return;
      slot_[label] = static_cast<uint32_t>(component_.size());
      component_.push_back(label);
      owner_.push_back(white ? around : 0);
    }
  }
  features_.Reserve(component_.size());
  backend->Measure(components, slot_.data(), component_.size(), features_.data());
  last_hole_.assign(component_.size(), 0);
  std::vector<uint32_t>& index = component_;  // of each slot's node, from here on
  for (uint32_t slot = 1; slot < index.size(); ++slot) {
    const Feature& feature = features_[slot];
    if (owner_[slot] != 0) {
      const uint32_t node = index[owner_[slot]];
      if (node < nodes_.size()) AddHole(feature, &nodes_[node]);
      uint32_t& last = last_hole_[owner_[slot]];
      for (uint32_t hole = last; hole != 0; hole = last_hole_[hole]) {
        sees_baseline_ |= ArePair(features_[hole], feature);
      }
      last_hole_[slot] = std::exchange(last, slot);
      continue;
    }
    const uint32_t component = std::exchange(index[slot], UINT32_MAX);
    if (feature.area < kMinArea) continue;
    if (nodes_.size() == kMaxNodes) {
      nodes_.clear();
      return;
    }
    index[slot] = static_cast<uint32_t>(nodes_.size());
    Node node;
    node.component = component;
    node.black = feature;
    nodes_.push_back(node);
  }
}

}  // namespace topotag
