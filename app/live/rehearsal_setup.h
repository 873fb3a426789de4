// A configuration as controller and twin in virtual time.
#pragma once

#include <utility>

#include "config/schema/config.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::app {

/// Combines the controller of `config` with this twin, which may have more axes.
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
