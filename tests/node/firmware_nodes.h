// The nodes of node/firmware on a simulated bus, with the tables of a twin's configuration and the twin's
// devices.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "can/bus.h"
#include "can/dbc/database.h"
#include "can/scheduler.h"
#include "node/firmware/hystcan_amplifier.h"
#include "node/firmware/hystcan_sensor.h"
#include "twin/config.h"

namespace hystcan::firmware {

/// The caller of a node of any kind: passes it the frames and calls it at its due time.
class Caller {
 public:
  Caller(can::Scheduler& scheduler, std::unique_ptr<can::Bus> bus);
  virtual ~Caller() = default;
  Caller(const Caller&) = delete;
  Caller& operator=(const Caller&) = delete;

  void start();

 protected:
  hystcan_time now() const;
  can::Scheduler& scheduler() { return scheduler_; }
  void arm();
  void send(const hystcan_frame& frame);
  /// `objects`: capacity, equal to that of the twin.
  hystcan_node_config node_config(std::uint8_t number, const twin::CommonConfig& common);

 private:
  virtual void start_node() = 0;
  virtual void on_frame(const hystcan_frame& frame) = 0;
  virtual void on_time() = 0;
  virtual hystcan_time due() const = 0;

  can::Scheduler& scheduler_;
  std::unique_ptr<can::Bus> bus_;
  std::unique_ptr<can::Timer> timer_;
  std::vector<hystcan_object> objects_;
};

class Amplifier;
class Sensor;

/// All nodes of a twin.
class Nodes {
 public:
  /// Equals twin::Twin.
  Nodes(const twin::Config& config, const can::Database& database, can::Scheduler& scheduler,
        const can::Attach& attach);
  ~Nodes();

  void start();
  /// Equals node::AmplifierChannel. `axis` counts through the configuration.
  void set_internal_fault(std::size_t axis, bool lasts);
  void set_relay_open(std::size_t axis, bool is_open);

 private:
  struct Place {
    Amplifier* node;
    unsigned axis;
  };
  std::vector<std::unique_ptr<twin::Plant>> plants_;
  std::vector<std::unique_ptr<Caller>> nodes_;
  std::vector<Place> amplifiers_;
};

}  // namespace hystcan::firmware
