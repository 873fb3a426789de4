// What an error frame tells, in words: the classes and details of linux/can/error.h.
#pragma once

#include <string>
#include <vector>

#include "can/frame.h"

namespace hystcan::can {

/// Each cause that the frame names, without numbers, so that causes can be counted: "bus-off", "not
/// acknowledged", "stuff error". A class that no detail belongs to stands for itself; at least one cause.
std::vector<std::string> error_causes(const Frame& error_frame);

/// One line: causes, bit of lost arbitration, place of a protocol error, error counters.
std::string describe_error(const Frame& error_frame);

}  // namespace hystcan::can
