// The loop through the converters of a simulated card, in virtual time, and the effect of their resolution
// (docs/analogue.md).
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "can/sim/sim_bus.h"
#include "config/schema/config.h"
#include "controller/controller.h"
#include "node/analogue/analogue_station.h"
#include "tests/support/refusal.h"
#include "twin/simulated_card.h"

namespace hystcan::node::analogue_loop_test {
namespace {

/// Axis x of the shipped piezo stage. 100 V are 9 V, 30 um are 9 V; 0 um are 0.5 V.
config::Config on_a_card(const std::string& device, const std::string& range) {
  const auto of_axis = [](const std::string& key, const std::string& value) {
    return config::Setting{"axis[0]." + key, value};
  };
  config::Config config = config::load(
      HYSTCAN_SOURCE_DIR "/config/piezo.toml",
      {of_axis("analogue.device", "\"" + device + "\""), of_axis("analogue.volts_per_drive", "0.09"),
       of_axis("analogue.position_um_per_V", "3.3"), of_axis("analogue.position_zero_um", "-1.65"),
       of_axis("analogue.drive_output.channel", "0"), of_axis("analogue.drive_output.range", range),
       of_axis("analogue.position_input.channel", "0"), of_axis("analogue.position_input.range", range),
       of_axis("twin.resolution_um", "0.0"), of_axis("control.repeat", "false")});
  config.axes.resize(1);
  config.axes[0].control.setpoint = {
      {.shape = controller::Triangle{.low_um = 3.0, .high_um = 27.0, .frequency_Hz = 10.0, .cycles = 10.0},
       .transition_s = 0.2},
      {.shape = controller::Hold{.level_um = 15.0, .duration_s = 2.0}}};
  return config;
}

/// Root mean square of numbers, and of their deviations from the mean.
class Spread {
 public:
  void add(double value) {
    ++count_;
    sum_ += value;
    squares_ += value * value;
  }
  double rms() const { return std::sqrt(squares_ / count_); }
  double deviation() const { return std::sqrt(squares_ / count_ - std::pow(sum_ / count_, 2)); }

 private:
  double count_ = 0.0, sum_ = 0.0, squares_ = 0.0;
};

/// Controller, nodes on the card, and the stage.
class AnalogueLoop {
 public:
  explicit AnalogueLoop(const config::Config& config)
      : axes_(analogue_axes(config)),
        twin_(twin_config(config)),
        bus_(clock_, config.bus.rates()),
        devices_([this] {
          AllDevices all;
          all.push_back(std::make_unique<AnalogueDevices>(axes_.front(), cards_));
          return all;
        }()),
        station_(devices_, twin_, config.database, clock_, attach_),
        controller_(controller_config(config), config.database, clock_, attach_,
                    [this](const controller::CycleRecord& record) { take(record.report); }) {
    station_.axes().front()->sensor.on_sample([this](can::Time, const can::SensorSample&) {
      true_um_ = card_->plant("x").position_um();  // at the time of the sample
    });
    station_.station().start([] {});
    controller_.start();
    clock_.run_until(clock_.now() + std::chrono::seconds(6));
  }

  controller::AxisState state() const { return controller_.axis(0).state(); }
  double tracking_nm() const { return 1e3 * tracking_.rms(); }
  double noise_nm() const { return 1e3 * hold_.deviation(); }

 private:
  void take(const controller::AxisReport& report) {
    if (report.state != controller::AxisState::tracking || report.point.in_transition ||
        report.point.finished || report.point.shape_time_s < 0.2)
      return;
    if (report.point.segment == 0)
      tracking_.add(report.reference_um - true_um_);
    else
      hold_.add(true_um_);
  }

  std::vector<WiredAnalogueAxis> axes_;
  twin::Config twin_;
  can::VirtualClock clock_;
  can::SimBus bus_;
  can::Attach attach_ = [this](std::span<const can::Filter> filters) {
    return bus_.attach(can::TransmitOrder::as_sent, filters);
  };
  twin::SimulatedCard* card_ = nullptr;
  Cards cards_{[this](const std::string& device) {
    auto card = std::make_unique<twin::SimulatedCard>(device, twin_, axes_, clock_);
    card_ = card.get();
    return card;
  }};
  AllDevices devices_;
  AnalogueStation station_;
  controller::Controller controller_;
  double true_um_ = 0.0;
  Spread tracking_, hold_;
};

TEST(SimulatedCard, ClosesTheLoopWithItsStage) {
  const AnalogueLoop loop(on_a_card("simulated", "\"-10..10 V\""));
  EXPECT_EQ(loop.state(), controller::AxisState::tracking);
  EXPECT_LT(loop.tracking_nm(), 60.0);
  EXPECT_LT(loop.noise_nm(), 3.0);
}

TEST(SimulatedCard, ConvertsWithItsBits) {
  const config::Config config = on_a_card("simulated:12", "\"0..10 V\"");
  can::VirtualClock clock;
  twin::SimulatedCard card("simulated:12", twin_config(config), analogue_axes(config), clock);
  const double step_V = 10.0 / 4095.0;
  EXPECT_DOUBLE_EQ(card.output(config.axes[0].analogue->drive_output)->range().step, step_V);
  const double volts = *card.input(config.axes[0].analogue->position_input.place)->read();
  EXPECT_NEAR(volts, 0.5, 1.5 * step_V) << "0 um";
  EXPECT_NEAR(volts / step_V, std::round(volts / step_V), 1e-9);
}

TEST(SimulatedCard, RefusesAnUnavailableRangeOrNumberOfBits) {
  const auto refusal_of = [](const std::string& device, const std::string& range) {
    return support::refusal_of([&] { AnalogueLoop(on_a_card(device, range)); });
  };
  EXPECT_EQ(
      refusal_of("simulated", "\"0..5 V\""),
      "axis[0].analogue.drive_output.range: simulated: channel 0 has no range \"0..5 V\"; available ranges: "
      "-10..10 V, 0..10 V");
  EXPECT_EQ(refusal_of("simulated:99", "\"0..10 V\""),
            "axis[0].analogue.device: device is \"simulated:99\", expected comedi:/dev/comedi0, iio:ad5791, "
            "simulated or simulated:BITS with 2 to 24 bits");
}

TEST(LongConverterBits, CostPositionNoiseAndTracking) {
  double last_nm = 1e9;
  std::printf("| bits | noise, 0..10 V | tracking | noise, ±10 V | tracking |\n|---|---|---|---|---|\n");
  for (const int bits : {12, 14, 16, 18, 24}) {
    std::string row = fmt::format("| {} |", bits);
    for (const char* range : {"\"0..10 V\"", "\"-10..10 V\""}) {
      const AnalogueLoop loop(on_a_card(fmt::format("simulated:{}", bits), range));
      ASSERT_EQ(loop.state(), controller::AxisState::tracking);
      row += fmt::format(" {:.2f} nm | {:.1f} nm |", loop.noise_nm(), loop.tracking_nm());
      if (range[1] == '0') {
        EXPECT_LT(loop.noise_nm(), last_nm + 0.05) << bits;
        last_nm = loop.noise_nm();
      }
    }
    std::printf("%s\n", row.c_str());
  }
}

}  // namespace
}  // namespace hystcan::node::analogue_loop_test
