// Counts the allocations of a program: the program that links this has its operator new replaced.
#pragma once

#include <cstdint>

namespace hystcan::support {

std::uint64_t allocations_so_far();

}  // namespace hystcan::support
