// Every fault of the twin, with an amplifier that holds a setpoint and with one that interpolates. The twin
// begins each fault by its own schedule. The fault leads to the reaction in docs/twin.md, and the wire stays
// safe throughout. The reaction does not depend on the control structure: one fault is tested with each
// structure. If two axes share frames over CAN FD, a fault of the wire or of a node affects both. The nodes
// of `hystcan node` on a simulated card have these faults too.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include "base/words.h"
#include "tests/support/fault_rig.h"
#include "tests/support/shows.h"

namespace hystcan::support::twin_fault_test {
namespace {

using controller::AxisState;
using controller::Cause;
using controller::Structure;
using std::chrono::milliseconds;
using twin::Fault;
using twin::Node;
using Kind = controller::Request::Kind;

/// The fault begins between a quarter and a half of the sine, while the stage moves.
constexpr can::Duration begins = milliseconds(1710);

struct Row {
  Fault kind;
  Node node;
  can::Duration lasts;
  double value;               ///< for the kinds that have a value
  std::vector<Cause> causes;  ///< any of these causes; empty: the axis does not fault
  double within_ms;           ///< since the beginning of the fault
};
std::string name_of(const Row& row) {
  const bool of_plant = twin::traits(row.kind).site == twin::FaultSite::plant;
  const std::string lasts = std::to_string(row.lasts / milliseconds(1)) + "ms";
  return std::string(to_string(row.kind)) + "_" + (of_plant ? "plant" : std::string(to_string(row.node))) +
         "_" + lasts;
}
std::ostream& operator<<(std::ostream& out, const Row& row) { return out << name_of(row); }

constexpr auto brief = milliseconds(3);  ///< number of cycles that the controller bridges, at 1 kHz
constexpr auto half_s = milliseconds(500);

/// A silent amplifier lets the stage fall; the cause is the first supervision of the position that trips.
const std::vector<Cause> stage_falls{Cause::position_jumped, Cause::position_implausible,
                                     Cause::following_error};

// docs/twin.md has the figures for a cycle of 1 ms. They also hold for a shorter cycle: some are counted in
// cycles, the others are times of the nodes. The fault begins at any phase of a cycle.
const std::vector<Row> rows{
    {Fault::no_reply, Node::sensor, half_s, 0, {Cause::sample_missing}, 6},
    {Fault::no_reply, Node::sensor, brief, 0, {}, 0},
    {Fault::late, Node::sensor, half_s, 1, {Cause::sample_late}, 6},
    {Fault::late, Node::sensor, half_s, 5, {Cause::sample_missing}, 6},
    {Fault::duplicate, Node::sensor, half_s, 0, {}, 0},
    {Fault::out_of_order, Node::sensor, half_s, 0, {Cause::sample_late}, 12},
    {Fault::frozen_value, Node::sensor, half_s, 0, {Cause::position_frozen, Cause::following_error}, 52},
    {Fault::frozen_value, Node::sensor, brief, 0, {}, 0},
    {Fault::frozen_counter, Node::sensor, half_s, 0, {Cause::sample_missing}, 7},
    {Fault::wrong_crc, Node::sensor, half_s, 0, {Cause::sample_missing}, 6},
    {Fault::wrong_crc, Node::sensor, brief, 0, {}, 0},
    {Fault::wrong_length, Node::sensor, half_s, 0, {Cause::sample_missing}, 6},
    {Fault::wrong_id_type, Node::sensor, half_s, 0, {Cause::sample_missing}, 6},
    {Fault::out_of_range, Node::sensor, half_s, 1000, {Cause::position_implausible}, 2},
    {Fault::sensor_bad_status, Node::sensor, half_s, 0, {Cause::sensor_status}, 2},
    {Fault::no_heartbeat, Node::sensor, half_s, 0, {Cause::sensor_silent}, 302},
    {Fault::emergency, Node::sensor, half_s, 0x5000, {Cause::node_emergency}, 2},
    {Fault::error_passive, Node::sensor, half_s, 0.5, {Cause::sample_missing}, 100},
    {Fault::babbling_node, Node::sensor, half_s, 20'000, {Cause::commands_late}, 4},
    {Fault::node_reboot, Node::sensor, half_s, 0, {Cause::sample_missing}, 6},
    {Fault::node_reboot, Node::sensor, brief, 0, {Cause::node_restarted}, 6},
    {Fault::bus_off, Node::sensor, half_s, 0, {Cause::sample_missing}, 6},
    {Fault::no_reply, Node::amplifier, half_s, 0, {Cause::status_missing}, 412},
    {Fault::late, Node::amplifier, half_s, 1, {}, 0},
    {Fault::duplicate, Node::amplifier, half_s, 0, {}, 0},
    {Fault::out_of_order, Node::amplifier, half_s, 0, {}, 0},
    {Fault::frozen_value, Node::amplifier, half_s, 0, {Cause::output_differs}, 200},
    {Fault::frozen_counter, Node::amplifier, half_s, 0, {Cause::status_missing}, 412},
    {Fault::wrong_crc, Node::amplifier, half_s, 0, {Cause::status_missing}, 412},
    {Fault::wrong_length, Node::amplifier, half_s, 0, {Cause::status_missing}, 412},
    {Fault::wrong_id_type, Node::amplifier, half_s, 0, {Cause::status_missing}, 412},
    {Fault::no_heartbeat, Node::amplifier, half_s, 0, {Cause::amplifier_silent}, 302},
    {Fault::emergency, Node::amplifier, half_s, 0x5000, {Cause::node_emergency}, 2},
    {Fault::error_passive, Node::amplifier, half_s, 0.3, {}, 0},
    {Fault::babbling_node, Node::amplifier, half_s, 20'000, {Cause::commands_late}, 4},
    {Fault::watchdog_trip, Node::amplifier, milliseconds(100), 0, {Cause::amplifier_fault}, 22},
    {Fault::watchdog_trip, Node::amplifier, brief, 0, {}, 0},
    {Fault::amplifier_trip, Node::amplifier, half_s, 0, {Cause::amplifier_fault}, 2},
    {Fault::node_reboot, Node::amplifier, half_s, 0, stage_falls, 6},
    {Fault::node_reboot, Node::amplifier, brief, 0, {Cause::node_restarted}, 6},
    {Fault::bus_off, Node::amplifier, half_s, 0, stage_falls, 26},
    {Fault::parameter_drift, Node::sensor, half_s, -0.1, {}, 0},
    {Fault::resonance_shift, Node::sensor, half_s, -0.2, {}, 0},
    {Fault::load_step, Node::sensor, half_s, 1, {}, 0},
    {Fault::limited_output, Node::amplifier, half_s, 0, stage_falls, 6},
    {Fault::sensor_gain, Node::sensor, half_s, -1, {Cause::following_error}, 100},
    {Fault::sensor_offset, Node::sensor, half_s, 8, {Cause::position_jumped}, 6},
    {Fault::sensor_offset, Node::sensor, brief, 8, {}, 0},
    {Fault::relay_opens, Node::amplifier, brief, 0, {Cause::amplifier_not_enabled}, 2},
};

/// The nodes that answer the controller.
enum class Nodes : std::uint8_t {
  held,          ///< an amplifier that holds a setpoint
  interpolated,  ///< an amplifier that interpolates, and a controller configured for it
  shared,        ///< two axes share frames and nodes
  card           ///< the nodes of `hystcan node`
};
constexpr auto words(Nodes) {
  return std::to_array<std::string_view>({"held", "interpolated", "shared", "card"});
}

struct Case {
  Structure structure;
  Nodes nodes;
  Row row;
};
std::ostream& operator<<(std::ostream& out, const Case& one) { return out << one.row; }

/// The first cause differs if the cycle is shorter and the sample is sent before the status.
Row shared(Row row) {
  if (row.kind == Fault::amplifier_trip) row.causes.push_back(Cause::node_emergency);
  if (row.kind == Fault::node_reboot && row.node == Node::amplifier)
    row.causes.insert(row.causes.end(), stage_falls.begin(), stage_falls.end());
  return row;
}

/// The nodes of a card share one connection: a fault that stops it stops samples and statuses.
Row on_a_card(Row row) {
  const bool stops = row.kind == Fault::node_reboot || row.kind == Fault::bus_off ||
                     (row.kind == Fault::error_passive && row.node == Node::amplifier);
  if (!stops) return row;
  if (row.kind == Fault::error_passive) row.within_ms = 500;
  row.causes.push_back(Cause::sample_missing);
  if (row.kind == Fault::node_reboot && row.node == Node::amplifier)
    row.causes.insert(row.causes.end(), stage_falls.begin(), stage_falls.end());
  return row;
}

std::vector<Case> cases() {
  std::vector<Case> result;
  for (const Row& row : rows)
    for (const Nodes nodes : {Nodes::held, Nodes::interpolated})
      result.push_back({Structure::inverse_pi, nodes, row});
  for (const Structure structure :
       {Structure::average, Structure::inverse, Structure::pi, Structure::average_pi})
    result.push_back({structure,
                      Nodes::held,
                      {Fault::frozen_value,
                       Node::sensor,
                       half_s,
                       0,
                       {Cause::position_frozen, Cause::following_error},
                       52}});
  for (const Row& row : rows) result.push_back({Structure::inverse_pi, Nodes::shared, shared(row)});
  for (const Row& row : rows) result.push_back({Structure::inverse_pi, Nodes::card, on_a_card(row)});
  return result;
}

can::Duration duration(const Case& one, const config::Config& config) {
  if (one.row.lasts != brief) return one.row.lasts;
  return can::Duration(std::llround(3e9 / config.controller.rate_Hz));
}

config::Config config_for(const Case& one) {
  config::Config config = one.nodes == Nodes::shared ? two_axes_in_a_frame()
                          : one.nodes == Nodes::card ? one_axis_on_a_card()
                                                     : one_axis();
  controller::AxisConfig& axis = config.axes[0].control;
  axis.law.structure = one.structure;
  axis.delays.interpolated = config.axes[0].twin.interpolate = one.nodes == Nodes::interpolated;
  // The tracking error of the structure itself must not count as the fault.
  if (one.structure == Structure::pi || one.structure == Structure::average)
    axis.following_error.error_um = 9.0;
  twin::FaultSpec spec = twin::fault_spec(one.row.kind, "x");
  spec.node = one.row.node;
  spec.begins = begins;
  spec.lasts = duration(one, config);
  if (!twin::traits(one.row.kind).unit.empty()) spec.value = one.row.value;
  config.twin.faults = {spec};
  return config;
}

class TwinFault : public testing::TestWithParam<Case> {};

/// While the bus is saturated, frames wait in the queue of the controller's CAN driver. When the bus is free
/// they are sent, including one command from before the fault; by then the amplifier's watchdog has latched.
/// A frozen status reports that the output is not safe, whatever the true output is.
void expect_safe_wire(const FaultRig& rig, const Row& row) {
  const bool is_frozen = row.kind == Fault::frozen_value && row.node == Node::amplifier;
  for (std::size_t i = 0; i < rig.config().axes.size(); ++i) {
    const WireMonitor& monitor = rig.monitor(i);
    const std::uint64_t stale =
        row.kind == Fault::babbling_node ? monitor.count(Violation::enabled_while_faulted) : 0;
    const std::uint64_t untrue = is_frozen && i == 0 ? monitor.count(Violation::output_not_safe) : 0;
    EXPECT_GT(monitor.commands(), 0u);
    EXPECT_LE(stale, 1u);
    EXPECT_EQ(monitor.violations(), stale + untrue) << monitor.found().front();
  }
}

/// Returns true if, by docs/twin.md, the other axis of the faulty node is affected too. An emergency belongs
/// to the node and does not name an axis.
bool hits_both(const Row& row) {
  return !row.causes.empty() && (!twin::acts_on_one_axis(row.kind) || row.kind == Fault::amplifier_trip);
}

/// Runs until the fault begins.
void track(FaultRig& rig) {
  rig.start();
  ASSERT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
  rig.run_for(can::Time{begins} - rig.clock().now());
  ASSERT_EQ(rig.axis().state(), AxisState::tracking) << to_string(rig.axis().fault().cause);
}

TEST_P(TwinFault, CausesTheDocumentedReaction) {
  shows("S-070");
  const Row& row = GetParam().row;
  FaultRig rig(config_for(GetParam()));
  ASSERT_NO_FATAL_FAILURE(track(rig));
  const bool faulted = rig.reaches(AxisState::faulted, row.lasts + milliseconds(500));
  ASSERT_EQ(faulted, !row.causes.empty()) << to_string(rig.axis().fault().cause);
  if (faulted) {
    const Cause cause = rig.axis().fault().cause;
    EXPECT_NE(std::ranges::find(row.causes, cause), row.causes.end()) << to_string(cause);
    EXPECT_LE(1e3 * can::seconds(rig.decided_at() - can::Time{begins}), row.within_ms);
    rig.run_for(milliseconds(25));  // watchdog time of the amplifier, 20 ms, and its slew
    rig.stage().plant.advance_to(rig.clock().now());
    EXPECT_NEAR(rig.stage().plant.drive(), 0.0, 1e-3);
    EXPECT_NE(rig.stage().amplifier.state(), can::AmpState::enabled);
  }
  if (GetParam().nodes == Nodes::shared) {
    EXPECT_EQ(rig.axis(1).state(), hits_both(row) ? AxisState::faulted : AxisState::tracking)
        << to_string(rig.axis(1).fault().cause);
  }
  expect_safe_wire(rig, row);
}

TEST_P(TwinFault, HasNoEffectAfterItsEnd) {
  shows("S-071");
  const Row& row = GetParam().row;
  FaultRig rig(config_for(GetParam()));
  ASSERT_NO_FATAL_FAILURE(track(rig));
  rig.run_for(duration(GetParam(), rig.config()) / 3);
  EXPECT_EQ(rig.stage_faults().active().size(), 1u);
  rig.run_for(row.lasts + milliseconds(400));  // time for the heartbeats of returning nodes
  EXPECT_EQ(rig.stage_faults().active().size(), 0u);
  if (!row.causes.empty()) {
    ASSERT_EQ(rig.axis().state(), AxisState::faulted);
    EXPECT_NE(rig.stage().amplifier.state(), can::AmpState::enabled);
    const std::size_t hit = GetParam().nodes == Nodes::shared && hits_both(row) ? 2 : 1;
    for (const Kind kind : {Kind::clear, Kind::enable})
      for (std::size_t i = 0; i < hit; ++i) ASSERT_EQ(rig.ask(kind, i), "");
    ASSERT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
  }
  rig.run_for(milliseconds(600));
  for (std::size_t i = 0; i < rig.config().axes.size(); ++i)
    EXPECT_EQ(rig.axis(i).state(), AxisState::tracking) << to_string(rig.axis(i).fault().cause);
  expect_safe_wire(rig, row);
}

INSTANTIATE_TEST_SUITE_P(, TwinFault, testing::ValuesIn(cases()), [](const auto& test) {
  std::string name(to_string(test.param.structure));
  std::ranges::replace(name, '+', '_');
  return name + "_" + std::string(word_of(test.param.nodes)) + "_" + name_of(test.param.row) + "_" +
         std::to_string(test.index);
});

/// Returns true if a line of docs/twin.md describes this row: its kind, its place, and all causes or none.
bool describes(const std::string& line, const Row& row) {
  const auto has = [&](const std::string& text) { return line.find(text) != std::string::npos; };
  const bool of_plant = twin::traits(row.kind).site == twin::FaultSite::plant;
  if (!line.starts_with("| `") || !has("`" + std::string(to_string(row.kind)) + "`")) return false;
  if (!has(of_plant ? "| stage |" : "| either |") && !has("| " + std::string(to_string(row.node)) + " |"))
    return false;
  if (row.causes.empty()) return has("| none");
  return std::ranges::all_of(row.causes, [&](Cause cause) {
    return has("`" + std::string(to_string(cause)) + "`") || has("the same,");
  });
}

TEST(TwinFaultTable, DocumentsEveryKindAndTestedReaction) {
  std::ifstream document(HYSTCAN_SOURCE_DIR "/docs/twin.md");
  std::vector<std::string> lines;
  for (std::string line; std::getline(document, line);) lines.push_back(line);
  for (const std::string_view kind : words(twin::Fault{}))
    EXPECT_GE(std::ranges::count_if(lines,
                                    [&](const std::string& line) {
                                      return line.starts_with("| `" + std::string(kind) + "` |");
                                    }),
              1)
        << kind;
  for (const Row& row : rows)
    EXPECT_TRUE(std::ranges::any_of(lines, [&](const std::string& line) { return describes(line, row); }))
        << row;
}

TEST(TwinFaultTable, IsTestedForEveryKind) {
  for (std::size_t i = 0; i < twin::fault_count; ++i)
    EXPECT_NE(std::ranges::find(rows, static_cast<Fault>(i), &Row::kind), rows.end())
        << to_string(static_cast<Fault>(i));
}

}  // namespace
}  // namespace hystcan::support::twin_fault_test
