// What goes wrong at a simulated stage on purpose: the kinds, whom each target, and the number each takes.
//
// A fault begins, lasts and ends. The nodes stay honest: what is wrong with a frame is done to it behind the
// node that sent it (twin/faulty_connection.h), what is wrong with the stage is done to the plant.
// docs/twin.md has the table: what is on the wire, and what a controller makes of it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "can/protocol/protocol.h"
#include "can/scheduler.h"
#include "model/words.h"

namespace hystcan::twin {

enum class Fault : std::uint8_t {
  no_reply,           ///< neither sample or status, nor an answer to SDO; the heartbeat goes on
  late,               ///< each sample or status in the place of a later one
  duplicate,          ///< each twice
  out_of_order,       ///< of two each, the second first
  frozen_value,       ///< the value stands still, counter and CRC do not
  frozen_counter,     ///< the counter stands still under a CRC that is right
  wrong_crc,          ///< one bit of the CRC flipped
  wrong_length,       ///< another length
  wrong_id_type,      ///< 29-bit in the place of 11-bit, or the reverse
  out_of_range,       ///< a position that no stage has
  sensor_bad_status,  ///< the sample says of itself that it is bad
  no_heartbeat,       ///< everything but the heartbeat
  emergency,          ///< EMCY at its beginning, "no error" at its end
  error_passive,      ///< the node misses frames: its error flags stop nobody
  babbling_node,      ///< the node sends and sends, of the highest priority
  watchdog_trip,      ///< commands do not reach the amplifier
  amplifier_trip,     ///< a cause within the amplifier, which can't be cleared while it lasts
  node_reboot,        ///< the supply is gone while it lasts, then power-on
  bus_off,            ///< the node neither hears nor is heard while it lasts, then restarts
  parameter_drift,    ///< the stage's travel changes over its duration, and stays so
  resonance_shift,    ///< of the stage, as by a mass that is put on it
  load_step,          ///< a force that displaces the stage
};
inline constexpr std::size_t fault_count = 22;

enum class Node : std::uint8_t { sensor, amplifier };
constexpr auto words(Node) { return std::to_array<std::string_view>({"sensor", "amplifier"}); }
constexpr std::string_view to_string(Node node) { return word_of(node); }

/// Where a kind of fault can act.
enum class FaultSite : std::uint8_t { either_node, sensor, amplifier, plant };

struct FaultTraits {
  Fault kind;
  std::string_view name;  ///< as in the configuration
  FaultSite site;
  std::string_view unit{};  ///< of its number; empty: it takes none
  double value = 0.0;       ///< where none is given
  double lowest = 0.0;
  double highest = 0.0;
};
const FaultTraits& traits(Fault kind);
inline std::string_view to_string(Fault kind) { return traits(kind).name; }
/// The names of all kinds, in their order.
const std::array<std::string_view, fault_count>& words(Fault);

/// One fault of one axis.
struct FaultSpec {
  Fault kind = Fault::no_reply;
  std::string axis{};
  Node node = Node::sensor;  ///< means nothing where the plant is struck
  can::Duration begins{};    ///< since the twin's start
  can::Duration lasts{};     ///< 0: until it is healed
  double value = 0.0;
  can::Duration repeat_every{};  ///< 0: once
};
/// A fault of this kind with the kind's own number, at the node that it target.
FaultSpec fault_spec(Fault kind, std::string axis);
/// "sensor of x: late by 3 cycles".
std::string describe(const FaultSpec& order);

/// Faults that come by themselves: a Poisson process, each of every kind, axis and node that can be struck,
/// alike.
struct RandomFaults {
  std::uint64_t seed = 1;
  double rate_per_hour = 60.0;  ///< of all kinds together
  can::Duration shortest{std::chrono::milliseconds(10)};
  can::Duration longest{std::chrono::seconds(1)};
  std::vector<Fault> kinds{};  ///< empty: all
};

/// Why this axis can't have this fault: its frames lack the field, the node is the wrong one, the number is
/// out of range. Empty: it can.
std::string why_not(const FaultSpec& order, const can::AxisWire& wire);

}  // namespace hystcan::twin
