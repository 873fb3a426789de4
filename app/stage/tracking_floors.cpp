#include "app/stage/tracking_floors.h"

#include "controller/analysis/feed_forward_design.h"

namespace hystcan::app {

std::vector<std::optional<double>> tracking_floors_um(const twin::AxisConfig& stage,
                                                      const std::vector<controller::Segment>& setpoint,
                                                      double cycle_s) {
  const controller::Delays chain{.amplifier_bandwidth_Hz = stage.plant.amplifier.bandwidth_Hz,
                                 .resonance_Hz = stage.plant.mode.natural_frequency_Hz,
                                 .damping_ratio = stage.plant.mode.damping_ratio,
                                 .interpolated = stage.interpolate};
  std::vector<std::optional<double>> floors;
  floors.reserve(setpoint.size());
  for (const controller::Segment& segment : setpoint)
    floors.push_back(stage.plant.second_mode ? std::nullopt
                                             : controller::tracking_floor_um(chain, cycle_s, segment.shape));
  return floors;
}

}  // namespace hystcan::app
