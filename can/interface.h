// A network interface as the kernel describes it (rtnetlink).
#pragma once

#include <optional>
#include <string>

#include "can/bus.h"

namespace hystcan::can {

struct Interface {
  int index = 0;
  bool up = false;
  bool is_can = false;
  std::string kind;                       ///< "vcan", "vxcan", "can"; empty where the driver states none
  BusState bus_state = BusState::active;  ///< of the controller; `active` where the driver states none
};

/// Empty where there is no interface of this name. Throws InterfaceError where the kernel can't be asked.
std::optional<Interface> query_interface(const std::string& name);

/// The interface, if it can carry CAN frames now. Throws InterfaceError, with the cure, where it can't.
Interface require_can_interface(const std::string& name);

}  // namespace hystcan::can
