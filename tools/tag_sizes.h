#ifndef TOPOTAG_TOOLS_TAG_SIZES_H_
#define TOPOTAG_TOOLS_TAG_SIZES_H_

#include <string>

#include "topotag/options.h"

namespace topotag::tools {

/// Adds the sizes of "0.05,3x3=0.03,4x4:0-9,278=0.1", metres: of all markers, of a family, of IDs
/// of a family; the most specific one counts.
/// @param options  its families are those that are looked for
/// @throws UsageError that names --tag-size: what is no such list, no size greater than 0, a family
///         that is not looked for, an ID that does not exist, a size that is given twice.
void AddTagSizes(const std::string& text, Options* options);

}  // namespace topotag::tools

#endif  // TOPOTAG_TOOLS_TAG_SIZES_H_
