// Faults that can be injected into a simulated stage: the kinds, their sites, and their numeric values.
//
// A fault begins, lasts and ends. The nodes themselves have no code for faulty frames: a frame is changed
// after its node sent it (twin/faulty_connection.h). A fault of the stage changes the plant. A table in
// docs/twin.md shows the effect of each fault on the bus and the reaction of a controller.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/words.h"
#include "can/protocol/protocol.h"
#include "can/scheduler.h"

namespace hystcan::twin {

enum class Fault : std::uint8_t {
  no_reply,           ///< the node sends no samples, statuses or SDO answers; its heartbeat continues
  late,               ///< the node sends each sample or status late; the value is the delay in cycles
  duplicate,          ///< the node sends each sample or status twice
  out_of_order,       ///< of each pair of samples or statuses, the second is sent before the first
  frozen_value,       ///< the position in the sample, or the output in the status, is constant
  frozen_counter,     ///< the counter in the sample or status is constant; the CRC is correct
  wrong_crc,          ///< one bit of the CRC in each sample or status is flipped
  wrong_length,       ///< the sample or status has a random wrong length
  wrong_id_type,      ///< the sample or status has a 29-bit instead of an 11-bit identifier, or the reverse
  out_of_range,       ///< the sample contains an impossible position
  sensor_bad_status,  ///< the status in the sample reports an error of the sensor
  no_heartbeat,       ///< the node sends all its frames except the heartbeat
  emergency,          ///< the node sends EMCY when the fault begins, and "no error" when it ends
  error_passive,      ///< the node misses some frames on the bus, and their senders do not repeat them
  babbling_node,      ///< the node sends continuously, with the highest priority
  watchdog_trip,      ///< commands do not reach the amplifier, so its watchdog trips
  amplifier_trip,     ///< the amplifier has an internal fault; it can't be cleared while the fault lasts
  node_reboot,        ///< the node loses its supply; when the fault ends, the node powers on
  bus_off,            ///< the node neither sends nor receives; when the fault ends, the node restarts
  parameter_drift,    ///< the stage's travel changes over the fault's duration and stays changed
  resonance_shift,    ///< the stage's resonance changes, as if a mass were added
  load_step,          ///< a force displaces the stage
  limited_output,     ///< the output's magnitude does not exceed the fault's value, and the amplifier
                      ///< still reports that it is enabled
  sensor_gain,        ///< sample = position at the begin of the fault + value * (motion since the begin)
  sensor_offset,      ///< the fault's value is added to the position in the sample
  relay_opens,        ///< the amplifier disables itself; after the fault, it obeys the next Enable
};
inline constexpr std::size_t fault_count = 26;

enum class Node : std::uint8_t { sensor, amplifier };
constexpr auto words(Node) { return std::to_array<std::string_view>({"sensor", "amplifier"}); }
constexpr std::string_view to_string(Node node) { return word_of(node); }

/// The place at which a kind of fault acts. A fault of `either_node` acts on the sensor's or the amplifier's
/// node.
enum class FaultSite : std::uint8_t { either_node, sensor, amplifier, plant };

struct FaultTraits {
  Fault kind;
  std::string_view name;  ///< name of the kind in the configuration
  FaultSite site;
  std::string_view unit{};  ///< unit of the fault's value; empty: the fault has no value
  double value = 0.0;       ///< default of the fault's value
  double lowest = 0.0;
  double highest = 0.0;
};
const FaultTraits& traits(Fault kind);
inline std::string_view to_string(Fault kind) { return traits(kind).name; }
/// Returns true if a fault of this kind acts on one axis; false if it acts on all frames of the node, and
/// therefore on all axes of the node.
bool acts_on_one_axis(Fault kind);
/// Returns the names of all kinds of fault, in the order of the enumeration.
const std::array<std::string_view, fault_count>& words(Fault);

/// One fault to inject: its kind, its place, its times and its value.
struct FaultSpec {
  Fault kind = Fault::no_reply;
  std::string axis{};
  Node node = Node::sensor;  ///< node of the axis on which the fault acts; ignored for a fault of the plant
  can::Duration begins{};    ///< time from the start of the twin to the begin of the fault
  can::Duration lasts{};     ///< duration of the fault; 0: until the fault is removed
  double value = 0.0;
  can::Duration repeat_every{};  ///< time from one begin to the next; 0: the fault occurs once
};
/// Returns a fault of this kind on this axis, with the kind's default value and site.
FaultSpec fault_spec(Fault kind, std::string axis);
/// Returns the fault in words, for example "sensor of x: late, 3 cycles".
std::string describe(const FaultSpec& spec);

/// Settings of random faults, which begin as a Poisson process. Every possible combination of kind, axis and
/// node is equally likely.
struct RandomFaults {
  std::uint64_t seed = 1;
  double rate_per_hour = 60.0;  ///< mean number of faults per hour, the total of all kinds
  can::Duration shortest{std::chrono::milliseconds(10)};
  can::Duration longest{std::chrono::seconds(1)};
  std::vector<Fault> kinds{};  ///< kinds to choose from; empty: all kinds
};

/// Returns the reason why the axis can't have the fault; nullopt if it can. Examples of reasons: the axis's
/// frame lacks the field that the fault changes, the fault is not of this node, the value is out of range.
std::optional<std::string> reason_against(const FaultSpec& spec, const can::AxisWire& wire);

}  // namespace hystcan::twin
