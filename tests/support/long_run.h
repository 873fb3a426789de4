// Tests of the label long look at more of the same: ctest -C long -L long.
#pragma once

#include <cstdlib>

namespace hystcan::support {

/// Whether this is a run at full length.
inline bool long_run() { return std::getenv("HYSTCAN_LONG_RUN") != nullptr; }

}  // namespace hystcan::support
