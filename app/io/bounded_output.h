// Writes to a stream that perhaps nobody reads.
#pragma once

#include <chrono>
#include <cstdint>
#include <string_view>

namespace hystcan::app {

enum class Written : std::uint8_t { all, timed_out, failed };

/// Writes the text to the descriptor and waits at most `patience` for its reader. Removes what was written from the
/// text. It does not use the buffers of stdio.
Written write_within(int descriptor, std::string_view& text, std::chrono::milliseconds patience);

}  // namespace hystcan::app
