// Setpoints that change once in a cycle ring a mode near a multiple of the rate, and the samples do not show
// it: some per cent more or less of the rate can change the true error tenfold.
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
  std::vector<Promise> promises{};  ///< of each axis; empty: an axis does not track
  double share = 1.0;               ///< of what is promised at the present rate
};

/// The same stage with loops for this rate, Hz.
using ConfigAtRate = std::function<config::Config(double rate_Hz)>;

/// Rates that the bus allows, near that of the configuration: the best two whose setpoints can do better by a
/// quarter, and the fastest of the others whose setpoints do no worse.
std::vector<double> rates_to_try(const config::Config& config);

/// The least that is promised with one of the three feed-forwards; empty: an axis does not track.
std::vector<Promise> promises_with_best_feed_forward(config::Config config);

/// The one of these rates at which the axes are promised less by a quarter; none where there is none. The
/// slowest of those that are nearly as good. `present`: what is promised now.
std::optional<RateOffer> better_rate(const ConfigAtRate& at_rate, const std::vector<double>& rates_Hz,
                                     const std::vector<Promise>& present);

/// "at 1250 Hz: 0.17 um instead of 1.4", of each axis.
std::vector<std::string> texts_of(const RateOffer& offer, const std::vector<Promise>& present);

}  // namespace hystcan::app
