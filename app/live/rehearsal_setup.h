// Builds a rehearsal from a configuration: controller and twin in virtual time.
#pragma once

#include <utility>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {

/// Combines the controller of `config` with `twin`. The twin may have more axes than the controller.
inline rehearsal::Setup rehearsal_setup(const config::Config& config, twin::Config twin) {
  return {.controller = controller_config(config),
          .twin = std::move(twin),
          .database = config.database,
          .rates = config.bus.rates()};
}

inline rehearsal::Setup rehearsal_setup(const config::Config& config) {
  return rehearsal_setup(config, twin_config(config));
}

}  // namespace hystcan::app
