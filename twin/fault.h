// Injected faults of a simulated stage: the kinds, their sites, and their numeric values.
//
// A fault begins, lasts and ends. The nodes contain no fault code: a faulty frame is changed after its node
// sent it (twin/faulty_connection.h), a fault of the stage changes the plant. docs/twin.md has a table of the
// effects of each fault on the wire and the reactions of a controller.
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
  no_reply,           ///< no sample or status, and no answer to SDO; the heartbeat continues
  late,               ///< each sample or status is replaced by an earlier one
  duplicate,          ///< each sample or status is sent twice
  out_of_order,       ///< every two consecutive frames exchange their places
  frozen_value,       ///< the value is constant; counter and CRC are right
  frozen_counter,     ///< the counter is constant; the CRC is right
  wrong_crc,          ///< one bit of the CRC is flipped
  wrong_length,       ///< the frame has another length
  wrong_id_type,      ///< a 29-bit identifier instead of an 11-bit one, or the reverse
  out_of_range,       ///< the sample contains an impossible position
  sensor_bad_status,  ///< the status in the sample is bad
  no_heartbeat,       ///< all frames except the heartbeat are sent
  emergency,          ///< EMCY at the start of the fault, "no error" at its end
  error_passive,      ///< the node loses frames, because its error flags do not stop other nodes
  babbling_node,      ///< the node sends continuously with the highest priority
  watchdog_trip,      ///< commands do not reach the amplifier
  amplifier_trip,     ///< a cause inside the amplifier; it can't be cleared while the fault lasts
  node_reboot,        ///< no supply while the fault lasts, then power-on
  bus_off,            ///< the node neither sends nor receives while the fault lasts, then restarts
  parameter_drift,    ///< the stage's travel changes over the fault's duration and stays changed
  resonance_shift,    ///< the stage's resonance changes, as if a mass were added
  load_step,          ///< a force displaces the stage
  limited_output,     ///< the output magnitude does not increase, and the amplifier reports that it is
                      ///< enabled
  sensor_gain,        ///< the sample shows a multiple of the motion since the fault began
  sensor_offset,      ///< the sample is wrong by this value
  relay_opens,        ///< the amplifier disables itself; after the fault, it obeys the next Enable
};
inline constexpr std::size_t fault_count = 26;

enum class Node : std::uint8_t { sensor, amplifier };
constexpr auto words(Node) { return std::to_array<std::string_view>({"sensor", "amplifier"}); }
constexpr std::string_view to_string(Node node) { return word_of(node); }

/// The sites at which a kind of fault can act.
enum class FaultSite : std::uint8_t { either_node, sensor, amplifier, plant };

struct FaultTraits {
  Fault kind;
  std::string_view name;  ///< as in the configuration
  FaultSite site;
  std::string_view unit{};  ///< unit of the value; empty: the fault has no value
  double value = 0.0;       ///< default value
  double lowest = 0.0;
  double highest = 0.0;
};
const FaultTraits& traits(Fault kind);
inline std::string_view to_string(Fault kind) { return traits(kind).name; }
/// Returns true if the fault acts on one axis; false if it acts on all frames of the node, and thus on all
/// its axes.
bool acts_on_one_axis(Fault kind);
/// Returns the names of all kinds, in the order of the enumeration.
const std::array<std::string_view, fault_count>& words(Fault);

/// One fault of one axis.
struct FaultSpec {
  Fault kind = Fault::no_reply;
  std::string axis{};
  Node node = Node::sensor;  ///< ignored if the fault acts on the plant
  can::Duration begins{};    ///< since the start of the twin
  can::Duration lasts{};     ///< 0: until the fault is removed
  double value = 0.0;
  can::Duration repeat_every{};  ///< 0: the fault occurs once
};
/// Returns a fault of this kind with its default value and site.
FaultSpec fault_spec(Fault kind, std::string axis);
/// Returns "sensor of x: late, 3 cycles".
std::string describe(const FaultSpec& spec);

/// Random faults: a Poisson process. Every possible combination of kind, axis and node is equally likely.
struct RandomFaults {
  std::uint64_t seed = 1;
  double rate_per_hour = 60.0;  ///< total of all kinds
  can::Duration shortest{std::chrono::milliseconds(10)};
  can::Duration longest{std::chrono::seconds(1)};
  std::vector<Fault> kinds{};  ///< empty: all kinds
};

/// Returns the reason why this axis can't have this fault: its frames lack the field, the node is the wrong
/// one, or the value is out of range. nullopt if it can.
std::optional<std::string> reason_against(const FaultSpec& spec, const can::AxisWire& wire);

}  // namespace hystcan::twin
