// Counts what the program allocates: this program's operator new is replaced.
#pragma once

#include <cstdint>

namespace hystcan::support {

std::uint64_t allocations_so_far();

}  // namespace hystcan::support
