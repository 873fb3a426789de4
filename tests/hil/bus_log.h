// Reads a candump log using only docs/protocol.md, without hystcan's code, like docs/decode.py: a decoder by
// the authors of the encoder would agree with the encoder's errors. In C++, because Python takes a second of
// the guest's time per log.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hystcan::hil {

/// Returns the output of docs/decode.py for a log of the two shipped axes; with `series`, also each value of
/// each axis: {"X": {"AmpStatus": [[time s, value, byte 4]...]}}. Null if a line is not in candump's format.
[[nodiscard]] nlohmann::json decoded(const std::string& log, bool series);

}  // namespace hystcan::hil
