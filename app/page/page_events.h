// The events of the controller as texts for all pages: changes of state and faults, detected in its rows, and
// the actions of users. Pages that connect later also get the last events. Also collects the cycle times from
// the same rows.
//
// Each event is an `event` of docs/page_protocol.md.
#pragma once

#include <deque>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "app/page/capture.h"
#include "app/page/page_clients.h"
#include "config/schema/settings.h"
#include "metrics/statistics.h"

namespace hystcan::app {

/// Returns the events of a command and its answer: one for each setting that it changed, otherwise one. `by`:
/// "page 3".
std::vector<nlohmann::json> command_events(const std::string& by, const nlohmann::json& command,
                                           const nlohmann::json& answer);

class PageEvents {
 public:
  explicit PageEvents(PageClients& clients);

  /// Starts with a new controller. Throws Error if a column is missing.
  void begin(const StreamGreeting& greeting);
  void put(std::span<const double> row);

  /// Adds an action of this page; `level`: "info", "warning".
  void add_act(std::uint64_t page, const std::string& level, const std::string& text);
  void add_command(std::uint64_t page, const nlohmann::json& command, const nlohmann::json& answer);
  /// Adds changes of settings that no page made.
  void add_foreign_changes(const std::vector<config::Change>& changes);

  const std::deque<nlohmann::json>& newest() const { return events_; }
  const CycleColumns& columns() const { return at_; }
  const metrics::Histogram& turnaround_us() const { return turnaround_us_; }
  const metrics::Histogram& lateness_us() const { return lateness_us_; }

 private:
  nlohmann::json event_of(std::span<const double> row) const;
  void add(nlohmann::json event);

  PageClients& clients_;
  StreamGreeting greeting_;
  CycleColumns at_{};
  std::vector<std::pair<double, double>> last_;  ///< last state and fault of each axis
  double newest_s_ = std::numeric_limits<double>::quiet_NaN();
  std::deque<nlohmann::json> events_;
  metrics::Histogram turnaround_us_, lateness_us_;
};

}  // namespace hystcan::app
