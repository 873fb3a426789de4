// Writes a whole text to a descriptor, whatever interrupts it.
#pragma once

#include <cstddef>
#include <string_view>

namespace hystcan::app {

/// Returns zero or the errno. `done` is the number of bytes that were written in either case.
int write_all(int descriptor, std::string_view text, std::size_t& done);

}  // namespace hystcan::app
