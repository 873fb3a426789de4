// Random traffic for the nodes of a twin: SYNCs and commands of a controller that are lost, late, repeated or
// damaged, NMT, SDO, frames of other nodes, silence.
#pragma once

#include <cstdint>
#include <deque>
#include <random>
#include <vector>

#include "can/dbc/database.h"
#include "can/protocol/protocol.h"
#include "twin/config.h"

namespace hystcan::firmware {

class Traffic {
 public:
  struct Item {
    can::Duration at;  ///< from the start of the cycle, in whole microseconds
    can::Frame frame;
  };

  Traffic(std::uint64_t seed, const twin::Config& config, const can::Database& database);

  /// Returns the frames of the next cycle, in order of time.
  std::vector<Item> next_cycle();

  /// Returns true with this probability.
  bool chance(double probability) { return uniform() < probability; }
  /// Returns 0 to `count` - 1.
  unsigned pick(unsigned count) { return static_cast<unsigned>(uniform() * count); }

 private:
  /// The traffic during some cycles.
  enum class Mode : std::uint8_t {
    drive,
    switch_off,
    clear_faults,
    anything,
    no_sync,
    no_commands,
    silence,
    objects
  };
  struct Command {
    can::E2eProtector protector;
    std::vector<can::Layout<can::AmpCommand>> axes;
    std::vector<double> setpoints;
    double drive_min, drive_max;
    std::optional<can::Frame> last;
  };

  double uniform() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }
  can::Duration within(double from, double to);
  void choose_mode();
  void add_sync(std::vector<Item>& items);
  void add_command(Command& command, std::vector<Item>& items);
  can::Frame command_frame(Command& command);
  can::AmpCommand axis_command(Command& command, std::size_t axis);
  void add_nmt(std::vector<Item>& items);
  void add_sdo(std::vector<Item>& items);
  void add_noise(std::vector<Item>& items);
  can::Frame damaged(can::Frame frame);
  std::uint8_t any_node();

  std::mt19937_64 random_;
  can::Duration cycle_;
  std::vector<std::uint8_t> nodes_;
  std::vector<Command> commands_;
  std::deque<Item> later_;  ///< `at` counts from the start of the present cycle
  Mode mode_ = Mode::drive;
  unsigned cycles_left_ = 0;
  std::uint8_t sync_ = 0;
  unsigned written_ = 0;  ///< objects, one after the other
};

}  // namespace hystcan::firmware
