// Injected faults of a simulated stage: the kinds, where each one acts, and the number that it takes.
//
// A fault begins, lasts and ends. The nodes themselves contain no faults: a faulty frame is changed after its
// node has sent it (twin/faulty_connection.h), a fault of the stage changes the plant.
// A table in docs/twin.md lists what each fault does on the wire and how a controller reacts.
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
  late,               ///< each sample or status is sent instead of a later one
  duplicate,          ///< each sample or status is sent twice
  out_of_order,       ///< the second of each two is sent first
  frozen_value,       ///< the value is constant, counter and CRC are right
  frozen_counter,     ///< the counter is constant, the CRC is right
  wrong_crc,          ///< one bit of the CRC is flipped
  wrong_length,       ///< the frame has another length
  wrong_id_type,      ///< a 29-bit identifier instead of an 11-bit one, or the reverse
  out_of_range,       ///< the sample holds an impossible position
  sensor_bad_status,  ///< the status in the sample is bad
  no_heartbeat,       ///< all frames but the heartbeat are sent
  emergency,          ///< EMCY at the beginning of the fault, "no error" at its end
  error_passive,      ///< the node loses frames, because its error flags do not stop other nodes
  babbling_node,      ///< the node sends continuously with the highest priority
  watchdog_trip,      ///< commands do not reach the amplifier
  amplifier_trip,     ///< a cause within the amplifier; it can't be cleared while the fault lasts
  node_reboot,        ///< no supply while the fault lasts, then power-on
  bus_off,            ///< the node neither sends nor receives while the fault lasts, then restarts
  parameter_drift,    ///< the stage's travel changes over the fault's duration and stays changed
  resonance_shift,    ///< the stage's resonance changes, as if a mass were added
  load_step,          ///< a force displaces the stage
  limited_output,     ///< the output goes no further from zero, and the amplifier says that it is enabled
  sensor_gain,        ///< the sample shows a multiple of the motion since the fault began
  sensor_offset,      ///< the sample is off by this much
  relay_opens,        ///< the amplifier leaves Enable by itself; after the fault it obeys the next Enable
};
inline constexpr std::size_t fault_count = 26;

enum class Node : std::uint8_t { sensor, amplifier };
constexpr auto words(Node) { return std::to_array<std::string_view>({"sensor", "amplifier"}); }
constexpr std::string_view to_string(Node node) { return word_of(node); }

/// Where a kind of fault can act.
enum class FaultSite : std::uint8_t { either_node, sensor, amplifier, plant };

struct FaultTraits {
  Fault kind;
  std::string_view name;  ///< as in the configuration
  FaultSite site;
  std::string_view unit{};  ///< of the number; empty: the fault takes no number
  double value = 0.0;       ///< default
  double lowest = 0.0;
  double highest = 0.0;
};
const FaultTraits& traits(Fault kind);
inline std::string_view to_string(Fault kind) { return traits(kind).name; }
/// True: it acts on one axis. False: on the node, with what it sends and receives, and so on all its axes.
bool acts_on_one_axis(Fault kind);
/// The names of all kinds, in their order.
const std::array<std::string_view, fault_count>& words(Fault);

/// One fault of one axis.
struct FaultSpec {
  Fault kind = Fault::no_reply;
  std::string axis{};
  Node node = Node::sensor;  ///< has no meaning where the fault acts on the plant
  can::Duration begins{};    ///< since the twin's start
  can::Duration lasts{};     ///< 0: until it is removed
  double value = 0.0;
  can::Duration repeat_every{};  ///< 0: once
};
/// A fault of this kind with its default number, at the node on which it acts.
FaultSpec fault_spec(Fault kind, std::string axis);
/// "sensor of x: late, 3 cycles".
std::string describe(const FaultSpec& spec);

/// Random faults: a Poisson process. Every possible combination of kind, axis and node is equally likely.
struct RandomFaults {
  std::uint64_t seed = 1;
  double rate_per_hour = 60.0;  ///< total of all kinds
  can::Duration shortest{std::chrono::milliseconds(10)};
  can::Duration longest{std::chrono::seconds(1)};
  std::vector<Fault> kinds{};  ///< empty: all
};

/// The reason why this axis can't have this fault: its frames lack the field, the node is the wrong one, or
/// the number is out of range.
std::optional<std::string> reason_against(const FaultSpec& spec, const can::AxisWire& wire);

}  // namespace hystcan::twin
