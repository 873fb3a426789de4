#include "app/live/machine_setup.h"

#include <spdlog/spdlog.h>

#include "app/live/realtime.h"
#include "can/socketcan/interface.h"
#include "config/schema/frames.h"

namespace hystcan::app {

void check_interface(const config::Config& config, const std::string& interface) {
  const can::Interface found = can::require_can_interface(interface);
  can::require_able_to_send(interface, found);
  can::require_bit_rate(interface, found, config.bus.rates());
  can::require_able_to_carry_fd(interface, found, config::fd_messages(config), config.bus.rates());
  spdlog::info(can::describe(interface, found));
  for (const std::string& warning : can::find_warnings(interface, found)) spdlog::warn(warning);
}

void become_realtime(const config::Config& config) {
  if (!config.controller.realtime) return;
  for (const std::string& refusal : apply(*config.controller.realtime)) spdlog::warn(refusal);
}

}  // namespace hystcan::app
