#include "host/options_check.h"

#include <algorithm>
#include <string>

#include "host/check.h"
#include "host/ids.h"
#include "host/tag_size.h"
#include "topotag/marker.h"

namespace topotag {
namespace {

constexpr double kMaxMinSize = 1e6;  // pixels

void ValidateTagSize(double size, const std::string& what) {
  if (size == 0) return;  // unknown
  RequireRange(what, size, kMinTagSize, kMaxTagSize, "metres");
}

void ValidateTagSizes(const Options& options) {
  ValidateTagSize(options.tag_size, "tag size");
  for (const auto& [n, size] : options.family_tag_size) {
    const std::string name = Text(n, n);
    if (n < Family::kMinN || n > Family::kMaxN) {
      FailArgument("tag size of an unknown family " + name);
    }
    ValidateTagSize(size, "tag size of family " + name);
  }
  for (const auto& [key, size] : options.id_tag_size) {
    const auto& [n, id] = key;
    const std::string name = Text(n, n) + " ID " + std::to_string(id);
    if (n < Family::kMinN || n > Family::kMaxN || id >= Family(n).size()) {
      FailArgument("tag size of " + name + ", which does not exist");
    }
    ValidateTagSize(size, "tag size of " + name);
  }
}

}  // namespace

Options ValidatedOptions(Options options) {
  RequireEnum("preset", options.preset, Preset::kPaper);
  RequireEnum("backend", options.backend, BackendKind::kOpenCl);
  RequireEnum("pose mode", options.pose, PoseMode::kPhotometric);
  if (options.families.empty()) FailArgument("no family to detect");
  std::sort(options.families.begin(), options.families.end());
  const auto twin = std::adjacent_find(options.families.begin(), options.families.end());
  if (twin != options.families.end()) FailArgument("family " + twin->name() + " is named twice");
  if (options.threads < 1 || options.threads > kMaxThreads) {
    FailArgument("threads " + std::to_string(options.threads) + " is not in the range 1.." +
                 std::to_string(kMaxThreads));
  }
  if (options.camera) ValidateCamera(*options.camera);
  ValidateTagSizes(options);
  ValidateIds(options.ids);
  RequireRange("minimum size", options.min_size, 0, kMaxMinSize, "pixels");
  if (options.hidden_nodes < 0 || options.hidden_nodes > kMaxVertices) {
    FailArgument("hidden nodes " + std::to_string(options.hidden_nodes) +
                 " are not in the range 0.." + std::to_string(kMaxVertices));
  }
  if (options.roi && (options.roi->x < 0 || options.roi->y < 0 || options.roi->width < 1 ||
                      options.roi->height < 1)) {
    FailArgument("region of interest is empty or begins outside the frame");
  }
  return options;
}

}  // namespace topotag
