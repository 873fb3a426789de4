#include "app/stage/rate_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "app/stage/tuning.h"
#include "base/error.h"
#include "config/schema/bus_plan.h"
#include "controller/analysis/feed_forward_design.h"

namespace hystcan::app {
namespace {

constexpr std::array every_rate_Hz{100.0,  125.0,  160.0,  200.0,  250.0,  315.0,  400.0,
                                   500.0,  625.0,  800.0,  1000.0, 1250.0, 1600.0, 2000.0,
                                   2500.0, 3150.0, 4000.0, 5000.0, 6250.0, 8000.0, 10'000.0};
constexpr double farthest = 1.6;   // rates differ from the present rate at most by this factor
constexpr double worth_it = 0.75;  // a rate is better if its error is below this share of the present error
constexpr double nearly_as_good = 1.1;
// Maximum number of rates that are tried because of their small floor. The floor is the error that no
// setpoints can avoid.
constexpr std::size_t most_rehearsed = 2;

/// Returns the mean of the squared promised errors of all axes. Each error is in percent of the stroke.
double score(const std::vector<Promise>& promises) {
  if (promises.empty()) return std::numeric_limits<double>::infinity();
  double sum = 0.0;
  for (const Promise& promise : promises) sum += promise.percent() * promise.percent();
  return sum / static_cast<double>(promises.size());
}

/// Returns the floor of a rate: the squared error that no setpoints can avoid, added up over all axes and
/// segments. Each error is a share of the stroke.
double floor_of(const config::Config& config) {
  double sum = 0.0;
  for (const config::AxisConfig& axis : config.axes) {
    const double stroke_um = controller::model_reach_um(axis.control.law.model, axis.control.gate).span();
    for (const auto& floor_um :
         tracking_floors_um(axis.twin, axis.control.setpoint, 1.0 / config.controller.rate_Hz))
      if (floor_um) sum += (*floor_um / stroke_um) * (*floor_um / stroke_um);
  }
  return sum;
}

struct RateFloor {
  double rate_Hz;
  double floor;
};

}  // namespace

std::vector<double> rates_to_try(const config::Config& config) {
  const double present_Hz = config.controller.rate_Hz;
  config::Config other = config;
  other.controller.rate_Hz = std::min(farthest * present_Hz, config::rate_max_Hz);
  const double fastest_Hz = config::fastest_rate_Hz(other), present_floor = floor_of(config);
  std::vector<RateFloor> floors;
  // Highest rate above the present one that does not increase the floor (the error that no setpoints can
  // avoid). A higher rate can make the loop better.
  std::optional<RateFloor> fastest;
  for (const double rate_Hz : every_rate_Hz) {
    if (rate_Hz > fastest_Hz || rate_Hz < present_Hz / farthest || rate_Hz == present_Hz) continue;
    other.controller.rate_Hz = rate_Hz;
    const double floor = floor_of(other);
    if (floor <= worth_it * present_floor)
      floors.push_back({rate_Hz, floor});
    else if (rate_Hz > present_Hz && floor <= present_floor)
      fastest = {rate_Hz, floor};
  }
  std::ranges::sort(floors, {}, &RateFloor::floor);
  floors.resize(std::min(floors.size(), most_rehearsed));
  if (fastest) floors.push_back(*fastest);
  std::vector<double> rates_Hz(floors.size());
  std::ranges::transform(floors, rates_Hz.begin(), &RateFloor::rate_Hz);
  return rates_Hz;
}

std::vector<Promise> promises_with_best_feed_forward(config::Config config) {
  std::vector<Promise> best;
  for (const auto& [second_order, plant_inverse] : feed_forwards) {
    for (config::AxisConfig& axis : config.axes) {
      axis.control.delays.second_order = second_order;
      axis.control.delays.plant_inverse = plant_inverse;
      controller::plan_feed_forward(axis.control, config.controller.rate_Hz);
    }
    std::vector<Promise> floors = promises_of(config);
    if (score(floors) < score(best)) best = std::move(floors);
  }
  return best;
}

std::optional<RateOffer> better_rate(const ConfigAtRate& at_rate, const std::vector<double>& rates_Hz,
                                     const std::vector<Promise>& present) {
  std::vector<RateOffer> offers;
  for (const double rate_Hz : rates_Hz) {
    try {
      offers.push_back({rate_Hz, promises_with_best_feed_forward(at_rate(rate_Hz))});
    } catch (const Error&) {  // at this rate, a file or a setpoint is not valid
      continue;
    }
  }
  const double most = worth_it * worth_it * score(present);
  double least = most;
  for (const RateOffer& offer : offers) least = std::min(least, score(offer.promises));
  std::erase_if(offers, [&](const RateOffer& offer) {
    return !(score(offer.promises) < most) || score(offer.promises) > nearly_as_good * nearly_as_good * least;
  });
  if (offers.empty()) return std::nullopt;
  RateOffer best = *std::ranges::min_element(offers, {}, &RateOffer::rate_Hz);
  best.share = std::sqrt(score(best.promises) / score(present));
  return best;
}

std::vector<std::string> texts_of(const RateOffer& offer, const std::vector<Promise>& present) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < offer.promises.size(); ++i)
    texts.push_back(
        fmt::format("{}: at {:g} Hz: error {:.2g} um instead of {}", offer.promises[i].axis, offer.rate_Hz,
                    offer.promises[i].rms_um,
                    i < present.size() ? fmt::format("{:.2g}", present[i].rms_um) : std::string("a fault")));
  return texts;
}

}  // namespace hystcan::app
