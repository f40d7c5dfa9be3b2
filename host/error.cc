#include "topotag/error.h"

#include "host/one_line.h"

namespace topotag {

Error::Error(ErrorCode code, const std::string& message)
    : std::runtime_error(OneLine(message)), code_(code) {}

}  // namespace topotag
