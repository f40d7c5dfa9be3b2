#ifndef TOPOTAG_HOST_IDS_H_
#define TOPOTAG_HOST_IDS_H_

#include <cstdint>
#include <map>
#include <vector>

#include "host/decode.h"

namespace topotag {

/// The IDs in use of families n, Options::ids.
using IdLists = std::map<int, std::vector<uint64_t>>;

/// @throws Error (kInvalidArgument): an unknown family, an ID out of its range, an empty list.
void ValidateIds(const IdLists& ids);

/// Which markers are in use. Families that are not named: all.
class IdsInUse {
 public:
  /// @param ids  valid
  explicit IdsInUse(IdLists ids);

  /// Whether the marker may be one in use. Where some of its bits are not known and just one ID in
  /// use fits, that becomes its ID.
  bool Admit(Decoded* decoded) const;

 private:
  IdLists ids_;  ///< sorted
};

}  // namespace topotag

#endif  // TOPOTAG_HOST_IDS_H_
