// The text of an error frame: the classes and details of linux/can/error.h.
#pragma once

#include <string>
#include <vector>

#include "can/frame.h"

namespace hystcan::can {

/// The causes of the frame without numbers, so that a caller can count them: "bus-off", "not acknowledged",
/// "stuff error". A class without details is a cause by itself. The result is never empty.
std::vector<std::string> error_causes(const Frame& error_frame);

/// One line: the causes, the bit of lost arbitration, the place of a protocol error and the error counters.
std::string describe_error(const Frame& error_frame);

}  // namespace hystcan::can
