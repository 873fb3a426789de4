// Counts the allocations of a program: linking this file replaces operator new.
#pragma once

#include <cstdint>

namespace hystcan::support {

std::uint64_t allocations_so_far();

}  // namespace hystcan::support
