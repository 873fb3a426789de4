// Reads a candump log by docs/protocol.md alone, without hystcan's code, as docs/decode.py does: what one
// hand builds on both sides agrees with itself. In C++, because a guest takes a second of its time for a log
// in Python.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hystcan::hil {

/// What docs/decode.py prints about the log of the shipped two axes, and with `series` each value of each
/// axis: {"X": {"AmpStatus": [[time s, value, byte 4]...]}}. Null for a line that candump does not write.
[[nodiscard]] nlohmann::json decoded(const std::string& log, bool series);

}  // namespace hystcan::hil
