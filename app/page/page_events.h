// Creates the events that all pages show as text: changes of state and faults, which it finds in the
// controller's rows, and actions of users. A page that connects later gets the last events, too. Also
// collects histograms of the cycle times from the same rows.
//
// docs/page_protocol.md describes the message `event`.
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

/// Returns the events of a command, made from its answer: one event for each setting that the command
/// changed, otherwise one event in total. `by`: author of the command, for example "page 3".
std::vector<nlohmann::json> command_events(const std::string& by, const nlohmann::json& command,
                                           const nlohmann::json& answer);

class PageEvents {
 public:
  explicit PageEvents(PageClients& clients);

  /// Call this function when a controller's stream begins. Throws Error if a column is missing.
  void begin(const StreamGreeting& greeting);
  void put(std::span<const double> row);

  /// Adds an event for an action of a user. `page`: number of the user's page. `level`: "info" or "warning".
  void add_act(std::uint64_t page, const std::string& level, const std::string& text);
  void add_command(std::uint64_t page, const nlohmann::json& command, const nlohmann::json& answer);
  /// Adds events for settings that were changed by the configuration file or by another program.
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
  std::vector<std::pair<double, double>> last_;  ///< state and fault of each axis in its previous row
  double newest_s_ = std::numeric_limits<double>::quiet_NaN();
  std::deque<nlohmann::json> events_;
  metrics::Histogram turnaround_us_, lateness_us_;
};

}  // namespace hystcan::app
