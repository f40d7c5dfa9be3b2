#ifndef TOPOTAG_HOST_OPTIONS_CHECK_H_
#define TOPOTAG_HOST_OPTIONS_CHECK_H_

#include "topotag/options.h"

namespace topotag {

/// The same options, families in ascending order.
/// @throws Error (kInvalidArgument) that names the first that is not within its range.
Options ValidatedOptions(Options options);

}  // namespace topotag

#endif  // TOPOTAG_HOST_OPTIONS_CHECK_H_
