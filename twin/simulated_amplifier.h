// The amplifier of a simulated plant, as the output that its bus node drives.
#pragma once

#include "node/drive_output.h"
#include "twin/plant.h"

namespace hystcan::twin {

class SimulatedAmplifier final : public node::DriveOutput {
 public:
  SimulatedAmplifier(const Amplifier::Config& config, Plant& plant) : config_(config), plant_(plant) {}

  bool reaches(double drive) const override {
    return drive >= config_.drive_min && drive <= config_.drive_max;
  }
  void go_to(double drive, can::Time from, can::Duration within) override;
  void leave(node::WatchdogAction action, can::Time from) override;
  double output(can::Time at) override;

 private:
  Amplifier::Config config_;
  Plant& plant_;
};

}  // namespace hystcan::twin
