// Chooses a better cycle rate. The setpoints change once per cycle and can excite a mode whose frequency is
// near a multiple of the rate, and the samples do not show the vibration. A change of the rate by some
// percent can therefore change the true error tenfold.
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
  std::vector<Promise> promises{};  ///< one promise for each axis; empty if an axis does not track
  double share = 1.0;               ///< promised error, as a share of the promised error at the present rate
};

/// Returns the configuration of the same stage at another cycle rate, with loops that are tuned for this
/// rate.
using ConfigAtRate = std::function<config::Config(double rate_Hz)>;

/// Returns rates near the configured rate that may be better and that the bus allows. The floor of a rate is
/// the squared error that no setpoints can avoid. The result contains
///   - at most two rates whose floor is at least a quarter smaller than the floor of the configured rate: the
///     rates with the smallest floors
///   - one further rate whose floor is at most the floor of the configured rate: the highest such rate above
///     the configured rate
std::vector<double> rates_to_try(const config::Config& config);

/// Tries the three kinds of feed-forward (feed_forwards in tuning.h). Returns the promises (predicted true
/// errors) of the kind with the smallest errors; empty if, with every kind, an axis does not track.
std::vector<Promise> promises_with_best_feed_forward(config::Config config);

/// Returns the rate with the smallest promised error; `nullopt` if this error is not at least a quarter
/// smaller than the error at the present rate. If several rates are within 10 % of the smallest error,
/// returns the slowest of them. `present`: the promises at the present rate.
std::optional<RateOffer> better_rate(const ConfigAtRate& at_rate, const std::vector<double>& rates_Hz,
                                     const std::vector<Promise>& present);

/// Returns a text for each axis, for example "x: at 1250 Hz: error 0.17 um instead of 1.4".
std::vector<std::string> texts_of(const RateOffer& offer, const std::vector<Promise>& present);

}  // namespace hystcan::app
