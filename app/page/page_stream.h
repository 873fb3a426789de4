// One stream as the clients of the page get it: each lane has the rows of one rate, made once for all clients of that rate.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>

#include "app/page/http_server.h"
#include "app/page/row_decimator.h"
#include "app/page/row_history.h"
#include "app/page/stream_source.h"

namespace hystcan::app {

class PageStream final : public StreamHandler {
 public:
  struct Hooks {
    std::function<void()> changed;                         ///< it has begun or ended
    std::function<void(std::span<const double> row)> row;  ///< in the history already
    std::function<void(std::uint32_t lost)> batch;         ///< the lanes have new rows
  };

  /// `kind`: of its binary messages.
  PageStream(std::string name, std::uint32_t kind, Hooks hooks);

  void begun(const nlohmann::json& greeting) override;
  void received(std::span<const double> values, std::uint32_t lost) override;
  void ended(const std::string& reason) override;

  std::uint32_t kind() const { return kind_; }
  bool is_there() const { return history_.has_value(); }
  /// Null if it is not there.
  const nlohmann::json& greeting() const { return greeting_; }
  const RowHistory& history() const { return *history_; }
  /// For the client: `stream`.
  nlohmann::json message() const;

  /// The rates of all clients, rows per axis and second.
  void set_rates(const std::set<double>& rates);
  /// What the last batch gave at this rate; null if nothing.
  RowBlock rows_at(double rate) const;
  /// What is in the history, in a few thousand rows. In small blocks: on one processor, a kernel that is not preemptible
  /// does nothing else while it takes a block.
  std::vector<RowBlock> past() const;

 private:
  struct Lane {
    RowDecimator decimator;
    RowBlock rows{};
  };

  double rate_Hz() const { return greeting_.at("rate_Hz").get<double>(); }
  Lane lane_for(double rate) const;

  std::string name_;
  std::uint32_t kind_;
  Hooks hooks_;
  nlohmann::json greeting_;
  std::string reason_ = "not connected yet";
  RowLayout layout_;
  std::size_t axes_ = 0;
  std::optional<RowHistory> history_;
  std::set<double> rates_;
  std::map<double, Lane> lanes_;
};

}  // namespace hystcan::app
