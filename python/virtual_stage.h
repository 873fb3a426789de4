// A rehearsal that is run step by step, keeps every cycle, and takes the commands of a control socket.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/live/live_config.h"
#include "config/schema/config.h"
#include "controller/cycle_record.h"
#include "controller/reference/motion.h"
#include "controller/requests.h"
#include "rehearsal/rehearsal.h"

namespace hystcan::python {

class VirtualStage {
 public:
  static constexpr double longest_s = 1e6;

  /// `references`: instead of the configured ones, each followed once, by the name of the axis. Throws Error.
  VirtualStage(const std::filesystem::path& config, const std::vector<config::Setting>& overrides,
               const std::map<std::string, controller::MonotoneCubic>& references);

  const std::vector<std::string>& axes() const { return live_.axis_names(); }
  double time_s();
  /// Calls `go_on` some times a second; it throws to end the run.
  void run_until(double time_s, const std::function<void()>& go_on);
  /// Until every axis has finished its reference once, or one faults. Throws Error if none begins to track.
  void run_to_the_end(const std::function<void()>& go_on);

  /// Name and values of each column of every cycle so far.
  std::vector<std::pair<std::string, std::vector<double>>> signals(
      const std::optional<std::string>& axis) const;
  std::map<std::string, std::string> status();

  /// Runs the few cycles that the answers take. Throw Error if a request is refused.
  void set(const std::string& axis, const std::string& key, const std::string& toml_value);
  void ask(controller::Request::Kind kind, const std::optional<std::string>& axis, double position_um);

 private:
  void take(const controller::CycleRecord& record);
  void ask_all(std::vector<std::unique_ptr<controller::Request>> requests);
  bool has_faulted();
  bool has_finished();

  config::Config config_;
  app::LiveConfig live_;
  std::vector<std::vector<std::vector<double>>> columns_;  ///< [axis][column]
  std::vector<double> true_um_;                            ///< newest of each axis
  controller::RequestLink requests_;
  std::vector<std::optional<double>> tracks_since_s_;
  std::vector<double> lengths_s_;  ///< of one pass of each reference
  std::unique_ptr<rehearsal::Rehearsal> loop_;
};

}  // namespace hystcan::python
