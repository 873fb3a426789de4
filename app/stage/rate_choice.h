// Chooses a better control rate. Setpoints that change once in a cycle excite a mode near a multiple of the
// rate, and the samples do not show it: changing the rate by some percent can change the true error tenfold.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/stage/promise.h"
#include "config/schema/config.h"

namespace hystcan::app {

struct RateOffer {
  double rate_Hz = 0.0;
  std::vector<Promise> promises{};  ///< one for each axis; empty: an axis does not track
  double share = 1.0;               ///< promised error, relative to that at the present rate
};

/// Returns the same stage with loops for this rate, Hz.
using ConfigAtRate = std::function<config::Config(double rate_Hz)>;

/// Returns rates near the configured one that the bus allows: the best two whose setpoints can reduce the
/// error by a quarter, and the fastest of the others whose setpoints do not increase it.
std::vector<double> rates_to_try(const config::Config& config);

/// Returns the promises with the best of the three feed-forwards; empty if an axis does not track.
std::vector<Promise> promises_with_best_feed_forward(config::Config config);

/// Returns the rate at which the promised error is lower by a quarter; `nullopt` if there is no such rate. Of
/// nearly equal rates it returns the slowest. `present`: the promises at the present rate.
std::optional<RateOffer> better_rate(const ConfigAtRate& at_rate, const std::vector<double>& rates_Hz,
                                     const std::vector<Promise>& present);

/// Returns a text for each axis, for example "at 1250 Hz: 0.17 um instead of 1.4".
std::vector<std::string> texts_of(const RateOffer& offer, const std::vector<Promise>& present);

}  // namespace hystcan::app
