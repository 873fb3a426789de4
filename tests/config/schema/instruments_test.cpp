// The keys of the twin's amplifier and sensor.
#include <gtest/gtest.h>

#include <ostream>

#include "config/schema/config.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::instruments_test {
namespace {

constexpr const char* piezo = HYSTCAN_SOURCE_DIR "/config/piezo.toml";
constexpr const char* galfenol = HYSTCAN_SOURCE_DIR "/config/galfenol.toml";

Setting of_twin(const std::string& key, const std::string& value) { return {"axis[0].twin." + key, value}; }

std::string refusal_of(const char* file, const std::vector<Setting>& settings) {
  return support::refusal_of([&] { load(file, settings); });
}

TEST(Instruments, ReadAVoltageDriveInItsUnits) {
  const Config config =
      load(piezo, {of_twin("current_limit_A", "0.14"), of_twin("load_uF", "1.5"), of_twin("load_ohm", "1e5"),
                   of_twin("drive_resolution_V", "0.002"), of_twin("drive_noise_V_per_rtHz", "3e-6"),
                   of_twin("ripple_V", "0.001"), of_twin("ripple_Hz", "100.0"),
                   of_twin("watchdog_action", "\"ramp\""), of_twin("watchdog_ramp_V_per_s", "200.0")});
  const twin::AxisConfig& axis = config.axes[0].twin;
  EXPECT_EQ(axis.plant.amplifier.current_limit_A, 0.14);
  EXPECT_EQ(axis.plant.amplifier.load_uF, 1.5);
  EXPECT_EQ(axis.plant.amplifier.load_ohm, 1e5);
  EXPECT_EQ(axis.plant.amplifier.resolution, 0.002);
  EXPECT_EQ(axis.plant.amplifier.ramp_per_s, 200.0);
  EXPECT_EQ(axis.drive_noise.density_per_rtHz, 3e-6);
  EXPECT_EQ(axis.drive_noise.ripple, 0.001);
  EXPECT_EQ(axis.drive_noise.ripple_Hz, 100.0);
  EXPECT_EQ(axis.watchdog_action, node::WatchdogAction::ramp);
}

TEST(Instruments, ReadACurrentDriveInItsUnits) {
  const Config config = load(galfenol, {of_twin("voltage_limit_V", "20.0"), of_twin("load_mH", "10.0"),
                                        of_twin("load_ohm", "4.0"), of_twin("watchdog_action", "\"off\"")});
  const twin::AxisConfig& axis = config.axes[0].twin;
  EXPECT_EQ(axis.plant.amplifier.voltage_limit_V, 20.0);
  EXPECT_EQ(axis.plant.amplifier.load_mH, 10.0);
  EXPECT_EQ(axis.watchdog_action, node::WatchdogAction::off);
}

TEST(Instruments, ReadTheSensorsTable) {
  const Config config = load(
      piezo, {of_twin("sensor.bandwidth_Hz", "10000.0"), of_twin("sensor.noise_density_um_per_rtHz", "1e-6"),
              of_twin("sensor.delay_us", "20.0"), of_twin("sensor.drift_um_per_h", "0.01"),
              of_twin("sensor.nonlinearity_percent", "0.03"), of_twin("sensor.range_min_um", "-3.0"),
              of_twin("sensor.range_max_um", "33.0"), of_twin("sensor.gain_error_percent", "0.1"),
              of_twin("sensor.offset_um", "-0.2"), of_twin("sensor.skew_ppm", "-30.0")});
  const twin::Sensor::Config& sensor = config.axes[0].twin.sensor;
  EXPECT_EQ(sensor.bandwidth_Hz, 10'000.0);
  EXPECT_EQ(sensor.noise_density_um_per_rtHz, 1e-6);
  EXPECT_EQ(sensor.delay, std::chrono::microseconds(20));
  EXPECT_EQ(sensor.drift_um_per_h, 0.01);
  EXPECT_EQ(sensor.nonlinearity_percent, 0.03);
  EXPECT_EQ(sensor.range_min_um, -3.0);
  EXPECT_EQ(sensor.range_max_um, 33.0);
  EXPECT_EQ(sensor.gain_error_percent, 0.1);
  EXPECT_EQ(sensor.offset_um, -0.2);
  EXPECT_EQ(config.axes[0].twin.sample_clock.skew_ppm, -30.0);
}

TEST(Instruments, RunFreeAtTheControllersRateByDefault) {
  EXPECT_EQ(load(piezo, {of_twin("sensor.sampling", "\"free\"")}).axes[0].twin.sample_clock.rate_Hz, 1000.0);
  const Config faster =
      load(piezo, {of_twin("sensor.sampling", "\"free\""), of_twin("sensor.sample_rate_Hz", "1500.0")});
  EXPECT_EQ(faster.axes[0].twin.sample_clock.sampling, node::Sampling::free);
  EXPECT_EQ(faster.axes[0].twin.sample_clock.rate_Hz, 1500.0);
}

TEST(Instruments, NeedADelayWithinTheBusTransmissionOnReceipt) {
  const Setting receipt = of_twin("apply", "\"receipt\"");
  const Setting slow{"axis[0].control.ki_per_s",
                     "50.0"};  // a loop with less delay is less stable at this mode
  const auto delay = [](const char* us) { return Setting{"axis[0].control.delays.command_delay_us", us}; };
  EXPECT_EQ(load(piezo, {receipt, slow, delay("400.0")}).axes[0].twin.apply, node::Apply::receipt);
  EXPECT_NE(refusal_of(piezo, {receipt, slow, delay("0.0")})
                .find("command_delay_us is 0, expected more than 0 and at most"),
            std::string::npos);
  EXPECT_NE(refusal_of(piezo, {receipt, slow, delay("1500.0")}).find("takes effect on receipt"),
            std::string::npos);
  EXPECT_NE(refusal_of(piezo, {slow, delay("400.0")}).find("expected 1000, one cycle"), std::string::npos);
}

TEST(Instruments, InterpolateOnlyFromSyncToSync) {
  const Setting interpolate = of_twin("interpolate", "true");
  EXPECT_TRUE(load(piezo, {interpolate}).axes[0].twin.interpolate);
  EXPECT_NE(refusal_of(piezo, {interpolate,
                               of_twin("apply", "\"receipt\""),
                               {"axis[0].control.delays.command_delay_us", "400.0"}})
                .find("interpolate is true with apply \"receipt\", expected apply = \"sync\""),
            std::string::npos);
}

TEST(Instruments, InterpolateOverTheCycleThatTheControllerHas) {
  EXPECT_EQ(twin_config(load(piezo)).cycle, std::chrono::milliseconds(1));
}

struct Disagreement {
  const char* name;
  const char* file;
  std::vector<Setting> settings;
  const char* message;

  friend void PrintTo(const Disagreement& disagreement, std::ostream* out) { *out << disagreement.name; }
};

class EveryDisagreement : public testing::TestWithParam<Disagreement> {};

TEST_P(EveryDisagreement, IsRefused) {
  const std::string refusal = refusal_of(GetParam().file, GetParam().settings);
  EXPECT_NE(refusal.find(GetParam().message), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("expected"), std::string::npos) << refusal;
}

INSTANTIATE_TEST_SUITE_P(
    Config, EveryDisagreement,
    testing::Values(
        Disagreement{"CurrentIntoNothing", piezo, {of_twin("current_limit_A", "0.1")}, "load_uF is 0"},
        Disagreement{"VoltageAcrossNothing", galfenol, {of_twin("voltage_limit_V", "20.0")}, "load_mH is 0"},
        Disagreement{
            "TooLittleVoltage",
            galfenol,
            {of_twin("voltage_limit_V", "5.0"), of_twin("load_mH", "10.0"), of_twin("load_ohm", "4.0")},
            "voltage_limit_V is 5, expected at least 12: 3 A must flow through load_ohm"},
        Disagreement{"VoltageOfAVoltageDrive", piezo, {of_twin("voltage_limit_V", "5.0")}, "voltage_limit_V"},
        Disagreement{"RampWithoutASpeed",
                     piezo,
                     {of_twin("watchdog_action", "\"ramp\"")},
                     "missing key watchdog_ramp_V_per_s"},
        Disagreement{"OffWithoutALoad", piezo, {of_twin("watchdog_action", "\"off\"")}, "time constant is 0"},
        Disagreement{"UnknownWatchdogAction",
                     piezo,
                     {of_twin("watchdog_action", "\"stop\"")},
                     "watchdog_action is \"stop\""},
        Disagreement{"RippleWithoutAFrequency", piezo, {of_twin("ripple_V", "0.01")}, "ripple_Hz is 0"},
        Disagreement{"RippleBeyondTheSubStep",
                     piezo,
                     {of_twin("ripple_V", "0.01"), of_twin("ripple_Hz", "20000.0")},
                     "at most 10000"},
        Disagreement{"DensityWithoutABandwidth",
                     piezo,
                     {of_twin("sensor.noise_density_um_per_rtHz", "1e-6")},
                     "bandwidth_Hz is 0"},
        Disagreement{"NonlinearityWithoutARange",
                     piezo,
                     {of_twin("sensor.nonlinearity_percent", "0.1")},
                     "range_min_um or range_max_um is missing"},
        Disagreement{"RangeTheWrongWay",
                     piezo,
                     {of_twin("sensor.range_min_um", "5.0"), of_twin("sensor.range_max_um", "1.0")},
                     "range_max_um is 1"},
        Disagreement{"UnknownSensorKey", piezo, {of_twin("sensor.bandwith_Hz", "1.0")}, "unknown key"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace hystcan::config::instruments_test
