// Tests with the label `long` run longer: ctest -C long -L long.
#pragma once

#include <cstdlib>

namespace hystcan::support {

/// Returns true if this is a run at full length.
inline bool long_run() { return std::getenv("HYSTCAN_LONG_RUN") != nullptr; }

}  // namespace hystcan::support
