// Every fault of a card under `hystcan node`, on simulated converters. Each fault leads to the reaction in
// docs/safety.md; the axis tracks again after the fault has ended and was cleared.
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <vector>

#include "tests/support/fault_rig.h"

namespace hystcan::support::card_fault_test {
namespace {

using controller::AxisState;
using controller::Cause;
using std::chrono::milliseconds;
using Kind = controller::Request::Kind;

struct Row {
  const char* name;
  void (*begin)(FaultyCard&);
  std::vector<Cause> causes;  ///< any of these causes; empty: the axis does not fault
  double within_ms;           ///< since the beginning of the fault
  can::Duration lasts = milliseconds(300);
};
std::ostream& operator<<(std::ostream& out, const Row& row) { return out << row.name; }

std::optional<double> fail(double) { return std::nullopt; }

/// Returns the first voltage at every conversion.
FaultyCard::Reading stuck() {
  return [kept = std::optional<double>()](double volts) mutable {
    if (!kept) kept = volts;
    return kept;
  };
}

const std::vector<Row> rows{
    {"InputAtItsRail",
     [](FaultyCard& card) { card.position = [](double) { return 10.0; }; },
     {Cause::sensor_status},
     2},
    {"InputThatFails", [](FaultyCard& card) { card.position = fail; }, {Cause::sensor_status}, 2},
    {"InputThatIsStuck",
     [](FaultyCard& card) { card.position = stuck(); },
     {Cause::position_frozen, Cause::following_error},
     52},
    {"InputThatIsDisturbedOnce",
     [](FaultyCard& card) { card.position = [](double volts) { return volts + 2.4; }; },
     {},
     0,
     milliseconds(1)},
    {"InputThatIsDisturbed",
     [](FaultyCard& card) { card.position = [](double volts) { return volts + 2.4; }; },
     {Cause::position_jumped},
     6},
    {"OutputThatFails",
     [](FaultyCard& card) { card.drive = fail; },
     {Cause::amplifier_fault, Cause::node_emergency},
     3},
    {"OutputThatIsStuck",
     [](FaultyCard& card) { card.drive = stuck(); },
     {Cause::output_differs, Cause::following_error},
     100},
    {"MonitorThatFails",
     [](FaultyCard& card) { card.monitor = fail; },
     {Cause::amplifier_fault, Cause::node_emergency},
     12},
    {"Interlock",
     [](FaultyCard& card) { card.interlock_is_active = true; },
     {Cause::amplifier_fault, Cause::node_emergency},
     2},
    {"CardThatIsGone",
     [](FaultyCard& card) { card.position = card.monitor = card.drive = fail; },
     {Cause::sensor_status, Cause::amplifier_fault, Cause::node_emergency},
     2},
};

class CardFault : public testing::TestWithParam<Row> {};

TEST_P(CardFault, CausesTheExpectedReactionAndCanBeCleared) {
  const Row& row = GetParam();
  FaultRig rig(one_axis_on_a_card());
  rig.start();
  ASSERT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
  rig.run_for(milliseconds(200));
  const can::Time begun = rig.clock().now();
  row.begin(rig.card());
  rig.run_for(row.lasts);
  ASSERT_EQ(rig.faults(), row.causes.empty() ? 0u : 1u) << to_string(rig.axis().fault().cause);
  if (!row.causes.empty()) {
    const Cause cause = rig.axis().fault().cause;
    EXPECT_NE(std::ranges::find(row.causes, cause), row.causes.end()) << to_string(cause);
    EXPECT_LE(1e3 * can::seconds(rig.decided_at() - begun), row.within_ms);
    EXPECT_NE(rig.stage().amplifier.state(), can::AmpState::enabled);
  }
  rig.card().position = rig.card().monitor = rig.card().drive = {};
  rig.card().interlock_is_active = false;
  rig.run_for(milliseconds(50));
  if (!row.causes.empty()) {
    EXPECT_NEAR(rig.stage().plant.drive(), 0.0, 1e-3);
    ASSERT_EQ(rig.ask(Kind::clear), "");
    ASSERT_EQ(rig.ask(Kind::enable), "");
    ASSERT_TRUE(rig.tracks()) << to_string(rig.axis().fault().cause);
  }
  rig.run_for(milliseconds(300));
  EXPECT_EQ(rig.axis().state(), AxisState::tracking) << to_string(rig.axis().fault().cause);
}

INSTANTIATE_TEST_SUITE_P(, CardFault, testing::ValuesIn(rows),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace hystcan::support::card_fault_test
