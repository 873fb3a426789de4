// When faults begin and end: by the configuration's schedule, at random from a seed, and at run time. In the
// scheduler's time, real or virtual; the same seed gives the same faults.
//
// A fault that is on and begins again goes on with the new value and the new end. A drift's travel changes
// linearly from what it is to 1 + value, and stays there when it has ended: back is another drift, of value
// 0, or remove().
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "twin/amplifier_node.h"
#include "twin/fault.h"
#include "twin/faulty_connection.h"
#include "twin/plant.h"
#include "twin/sensor_node.h"

namespace hystcan::twin {

/// What the faults of one axis act on. All of it outlives the scheduler.
struct FaultTarget {
  const can::AxisWire& wire;
  Plant& plant;
  AmplifierNode& amplifier;
  SensorNode& sensor;
  FaultyConnection& amplifier_line;
  FaultyConnection& sensor_line;
};

class FaultScheduler {
 public:
  enum class Event : std::uint8_t { begins, ends };
  using Teller = std::function<void(const FaultSpec&, Event, can::Time)>;
  struct Active {
    FaultSpec order;
    can::Time began{};
    can::Time ends{};
    double gain_before = 1.0;  ///< of a drift
  };

  /// Throws std::invalid_argument where an order can't be carried out.
  FaultScheduler(can::Scheduler& scheduler, std::vector<FaultTarget> targets,
                 const std::vector<FaultSpec>& orders, const std::optional<RandomFaults>& random);

  /// Told of every begin and end.
  void on_event(Teller teller) { teller_ = std::move(teller); }
  /// The schedule counts from `start`; what should have begun by now begins now.
  void start(can::Time start);
  /// Ends every fault; none begins any more.
  void stop();

  /// Begins now. Throws std::invalid_argument where it can't.
  void inject(const FaultSpec& order);
  /// Ends what is on, of this kind and this axis where they are given, and takes back what has drifted. The
  /// number of faults that were on.
  std::size_t remove(std::optional<Fault> kind = {}, std::string_view axis = {});
  const std::vector<Active>& active() const { return active_; }

 private:
  struct Planned {
    FaultSpec order;
    can::Time begins{};
  };

  std::size_t target_of(const FaultSpec& order) const;
  void list_targets();
  void plan_next_random();
  void draw();
  double uniform() { return static_cast<double>(random_source_() >> 11U) * 0x1p-53; }
  void wake();
  void begin_what_is_due(can::Time now);
  void end_what_is_due(can::Time now);
  void arm();
  void begin(const FaultSpec& order);
  void release(const FaultSpec& order);
  void drift(const Active& active, can::Time now);
  void disturb(std::size_t target, const std::function<void(Disturbance&)>& change);
  void tell(const FaultSpec& order, Event event) const;

  can::Scheduler& scheduler_;
  std::vector<FaultTarget> targets_;
  std::vector<Disturbance> disturbances_;  ///< of each target's plant
  std::vector<FaultSpec> orders_;
  std::optional<RandomFaults> random_;
  std::vector<FaultSpec> random_faults_;  ///< at random: each with its own number
  std::mt19937_64 random_source_;
  can::Time next_random_ = can::Time::max();
  std::vector<Planned> planned_;
  std::vector<Active> active_;
  Teller teller_;
  std::unique_ptr<can::Timer> timer_;
};

}  // namespace hystcan::twin
