#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <numbers>
#include <ostream>

#include "config/schema/config.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::load_test {
namespace {

TEST(Shipped, ConfigurationsLoad) {
  for (const char* name :
       {"piezo.toml", "galfenol.toml", "lab_amplifier.toml", "p733.toml", "galfenol_unimorph.toml",
        "raster.toml", "soft_stage.toml", "fd_stage.toml", "fd_stage_learning.toml", "fd_eight.toml"})
    EXPECT_NO_THROW(load(std::string(HYSTCAN_SOURCE_DIR "/config/") + name)) << name;
}

TEST(Shipped, PiezoStageHasTwoAxesAsDocumented) {
  const Config config = load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  ASSERT_EQ(config.axes.size(), 2u);
  EXPECT_EQ(config.controller.rate_Hz, 1000.0);
  EXPECT_EQ(config.axes[1].wire.amplifier_node, 3);
  EXPECT_EQ(config.axes[0].twin.command_timeout, std::chrono::milliseconds(20));
  EXPECT_EQ(config.axes[0].control.delays.command_delay, std::chrono::milliseconds(1));
  EXPECT_EQ(config.axes[0].control.law.structure, controller::Structure::inverse_pi);
  EXPECT_EQ(to_string(config.axes[0].control.setpoint[1].shape), "staircase");
}

constexpr const char* dynamics_text =
    "\n[dynamics]\nresonance_Hz = 700.0\ndamping_ratio = 0.03\ndelay_s = 0.0002\n";

void append_to_models(const support::ShippedCopy& shipped) {
  for (const char* model : {"piezo.model.toml", "piezo.plant.toml"})
    std::ofstream(shipped / model, std::ios::app) << dynamics_text;
}

TEST(Load, TakesAMissingModeAndLagFromTheModelFiles) {
  const support::ShippedCopy shipped;
  append_to_models(shipped);
  shipped.edit(
      "piezo.toml",
      "amplifier_bandwidth_Hz = 1500.0\nresonance_Hz           = 500.0\ndamping_ratio          = 0.05\n",
      "sensor_delay_us = 50.0\n");
  shipped.edit("piezo.toml", "resonance_Hz       = 500.0        # P-733.2CL data sheet, unloaded\n", "");
  const Config config = load(shipped / "piezo.toml");
  const controller::Delays& delays = config.axes[0].control.delays;
  EXPECT_EQ(delays.resonance_Hz, 700.0);
  EXPECT_EQ(delays.damping_ratio, 0.03);
  EXPECT_NEAR(delays.amplifier_bandwidth_Hz, 1.0 / (2.0 * std::numbers::pi * 150e-6), 1e-9);
  EXPECT_EQ(config.axes[0].twin.plant.mode.natural_frequency_Hz, 700.0);
  EXPECT_EQ(config.axes[0].twin.plant.mode.damping_ratio, 0.05);  // as stated in the file
  EXPECT_EQ(config.axes[0].twin.plant.amplifier.bandwidth_Hz, 1500.0);
  EXPECT_EQ(config.axes[1].control.delays.resonance_Hz, 500.0);
}

TEST(Load, RefusesALagThatTheSensorAloneExceeds) {
  const support::ShippedCopy shipped;
  append_to_models(shipped);
  shipped.edit("piezo.toml", "amplifier_bandwidth_Hz = 1500.0\n", "sensor_delay_us = 300.0\n");
  const std::string refusal = support::refusal_of([&] { load(shipped / "piezo.toml"); });
  EXPECT_NE(
      refusal.find(
          "missing key amplifier_bandwidth_Hz, expected in [axis[0].control.delays]: without this key, the "
          "model's delay (0.0002 s) must exceed the sensor's delay (0.0003 s)"),
      std::string::npos)
      << refusal;
}

struct BadInput {
  const char* name;
  const char* file;
  const char* what;
  const char* with;
  const char* message;  ///< text that the error must contain, after the place of the file

  friend void PrintTo(const BadInput& input, std::ostream* out) { *out << input.name; }
};

class InvalidConfiguration : public testing::TestWithParam<BadInput> {};

TEST_P(InvalidConfiguration, IsRefusedInOneLineWithPlaceAndExpectation) {
  const BadInput& bad = GetParam();
  const support::ShippedCopy shipped;
  shipped.edit(bad.file, bad.what, bad.with);
  const std::string refusal = support::refusal_of<std::runtime_error>([&] { load(shipped / "piezo.toml"); });
  EXPECT_NE(refusal.find(bad.message), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("expected"), std::string::npos) << refusal;
  EXPECT_EQ(refusal.find('\n'), std::string::npos) << refusal;
  const std::string place = (shipped / "").string();
  ASSERT_TRUE(refusal.starts_with(place)) << refusal;
  int line = 0;
  int column = 0;
  EXPECT_EQ(std::sscanf(refusal.c_str() + refusal.find(':', place.size()), ":%d:%d: ", &line, &column), 2)
      << refusal;
}

INSTANTIATE_TEST_SUITE_P(
    Config, InvalidConfiguration,
    testing::Values(
        BadInput{"UnknownKey", "piezo.toml", "rate_Hz = 1000.0", "rate_Hz = 1000.0\nrate = 3",
                 "unknown key rate"},
        BadInput{"UnknownTable", "piezo.toml", "[bus]", "[buss]\nx = 1\n[bus]", "unknown key buss"},
        BadInput{"MissingKey", "piezo.toml", "ki_per_s           = 409.0", "", "missing key ki_per_s"},
        BadInput{
            "MissingResonance", "piezo.toml", "resonance_Hz           = 500.0\n", "",
            "missing key resonance_Hz, expected in [axis[0].control.delays], or [dynamics] in the axis's "
            "model file"},
        BadInput{
            "MissingBandwidthOfTheTwin", "piezo.toml",
            "bandwidth_Hz       = 1500.0       # assumed, small signal into 1.5 uF\n", "",
            "missing key bandwidth_Hz, expected in [axis[0].twin], or [dynamics] in the axis's model file"},
        BadInput{"MisspeltKey", "piezo.toml", "rate_Hz = 1000.0", "rate_hz = 1000.0", "unknown key rate_hz"},
        BadInput{"MissingTable", "piezo.toml", "[twin]\nseed         = 1\nheartbeat_ms = 100.0\n", "",
                 "missing key twin"},
        BadInput{"MissingDriveUnit", "piezo.toml", "drive_unit     = \"V\"", "", "missing key drive_unit"},
        BadInput{"WrongType", "piezo.toml", "rate_Hz = 1000.0", "rate_Hz = \"fast\"",
                 "rate_Hz is of type string"},
        BadInput{"FractionForAWholeNumber", "piezo.toml", "amplifier_node = 1", "amplifier_node = 1.5",
                 "expected a whole number"},
        BadInput{"NotANumber", "piezo.toml", "kp                 = 0.0", "kp = nan", "kp is nan"},
        BadInput{"Infinite", "piezo.toml", "slew_V_per_s       = 20_000.0", "slew_V_per_s = inf",
                 "slew_V_per_s is inf"},
        BadInput{"NegativeRate", "piezo.toml", "rate_Hz = 1000.0", "rate_Hz = -1000.0", "rate_Hz is -1000"},
        BadInput{"TimeThatWouldBeZero", "piezo.toml", "heartbeat_ms = 100.0", "heartbeat_ms = 4e-7",
                 "heartbeat_ms is 4e-07, expected at least a nanosecond, 1e-06"},
        BadInput{"NotToml", "piezo.toml", "[controller]", "[controller", "expected TOML"},
        BadInput{"UnknownStructure", "piezo.toml", "\"inverse+pi\"", "\"pid\"", "structure is \"pid\""},
        BadInput{"NoKindOfASetpoint", "piezo.toml", "kind         = \"triangle\"", "",
                 "missing key kind, expected in [axis[0].control.setpoint[0]]"},
        BadInput{"MisspeltKindOfASetpoint", "piezo.toml", "kind         = \"triangle\"",
                 "kindd = \"triangle\"", "unknown key kindd (did you mean kind?)"},
        BadInput{
            "ModeWithoutDamping", "piezo.toml", "damping_ratio          = 0.05", "damping_ratio = 0.0",
            "no kp or ki_per_s above 0 is stable for the plant in [axis.control.delays], whose damping_ratio "
            "is 0"},
        BadInput{"UnknownSetpoint", "piezo.toml", "\"triangle\"", "\"zigzag\"", "kind is \"zigzag\""},
        BadInput{"UnitOfAnotherDrive", "piezo.toml", "drive_max_V        = 100.0", "drive_max_A = 100.0",
                 "unknown key drive_max_A"},
        BadInput{"TwoNodesWithOneId", "piezo.toml", "sensor_node    = 2", "sensor_node    = 1",
                 "node 1 is used by axis[0].amplifier_node"},
        BadInput{"TheControllersNodeId", "piezo.toml", "rate_Hz = 1000.0", "rate_Hz = 1000.0\nnode = 3",
                 "node 3 is used by controller.node"},
        BadInput{"TwoAxesWithOneName", "piezo.toml", "name           = \"y\"", "name = \"x\"",
                 "the name x is used by another axis"},
        BadInput{"NodeIdAgainstTheDbc", "piezo.toml", "amplifier_node = 1", "amplifier_node = 5",
                 "message XAmpCommand has identifier 0x201"},
        BadInput{"NoSuchMessages", "piezo.toml", "message_prefix = \"X\"", "message_prefix = \"Q\"",
                 "no message QAmpCommand"},
        BadInput{"SignalMissingInTheDbc", "hystcan.dbc", "SG_ Setpoint", "SG_ Setpunkt",
                 "has no signal Setpoint"},
        BadInput{"OverlappingSignalsInTheDbc", "hystcan.dbc", "SG_ Enable : 32|1", "SG_ Enable : 16|1",
                 "overlaps another"},
        BadInput{"CrcOutOfItsPlace", "hystcan.dbc", "SG_ Crc : 56|8", "SG_ Crc : 52|4",
                 "is not the last byte of the message"},
        BadInput{"EmptyInterface", "piezo.toml", "\"vcan0\"", "\"\"", "interface is empty"},
        BadInput{"DelayOfAnotherRate", "piezo.toml", "rate_Hz = 1000.0", "rate_Hz = 2000.0",
                 "command_delay_us is 1000, expected 500"},
        BadInput{"DelayOffByMoreThanItsRounding", "piezo.toml", "command_delay_us       = 1000.0",
                 "command_delay_us = 1000.6", "command_delay_us is 1000.6, expected 1000"},
        BadInput{"NameWithAComma", "piezo.toml", "\"x\"", "\"a,b\"",
                 "name is \"a,b\", expected 1 to 64 letters"},
        BadInput{"NameThatIsAPath", "piezo.toml", "\"x\"", "\"../../x\"",
                 "name is \"../../x\", expected 1 to 64 letters"},
        BadInput{"NameThatIsAFolder", "piezo.toml", "\"x\"", "\"..\"",
                 "name is \"..\", expected 1 to 64 letters"},
        BadInput{"NameThatIsAFormula", "piezo.toml", "\"x\"", "\"=1+1\"",
                 "name is \"=1+1\", expected 1 to 64 letters"},
        BadInput{"NameThatIsACommandOfTeX", "piezo.toml", "\"x\"", "'\\input{x}'",
                 "name is \"\\input{x}\", expected 1 to 64 letters"},
        BadInput{"UnitsAgainstTheDbc", "piezo.toml", "dbc               = \"hystcan.dbc\"",
                 "dbc = \"galfenol.dbc\"", "has the unit \"A\""},
        BadInput{"DriveShortOfTheThreshold", "piezo.toml", "drive_max_V        = 100.0", "drive_max_V = 90.0",
                 "the drive must reach input_max, the upper threshold of the model"},
        BadInput{"DriveBeyondTheSignal", "piezo.toml", "drive_max_V        = 100.0", "drive_max_V = 1e5",
                 "does not fit signal Setpoint"},
        BadInput{"SafeDriveOutOfRange", "piezo.toml", "safe_drive_V       = 0.0", "safe_drive_V = -5.0",
                 "safe_drive is -5"},
        BadInput{"SetpointOutOfRange", "piezo.toml", "high_um      = 27.0", "high_um = 45.0",
                 "the setpoint reaches 45"},
        BadInput{"TriangleBeyondTheReferenceSlew", "piezo.toml", "repeat             = true",
                 "reference_slew_um_per_s = 479", "the triangle moves at up to 480 um/s"},
        BadInput{"RiseBeyondTheReferenceAcceleration", "piezo.toml", "repeat             = true",
                 "reference_acceleration_um_per_s2 = 1e5",
                 "the staircase accelerates at up to 141130 um/s^2"},
        BadInput{"MultiSineOutOfRange", "piezo.toml", "kind         = \"triangle\"",
                 "kind = \"multi-sine\"\ncentre_um = 32.0\namplitudes_um = [1.0, 2.0]\nfrequencies_Hz = "
                 "[5.0, 7.0]\n"
                 "duration_s = 1.0\n[[axis.control.setpoint]]\nkind = \"triangle\"",
                 "um, expected -3 to 34 um"},
        BadInput{
            "MultiSineWithoutAFrequency", "piezo.toml", "kind         = \"triangle\"",
            "kind = \"multi-sine\"\ncentre_um = 15.0\namplitudes_um = [1.0, 2.0]\nfrequencies_Hz = [5.0]\n"
            "duration_s = 1.0\n[[axis.control.setpoint]]\nkind = \"triangle\"",
            "1 frequencies, expected 2"},
        BadInput{"InPositionWithoutATolerance", "piezo.toml", "tolerance_um = 0.05\n", "",
                 "missing key tolerance_um"},
        BadInput{"InPositionTimeoutWithinItsWindow", "piezo.toml", "timeout_ms   = 1000.0",
                 "timeout_ms = 10.0", "timeout_ms is 10, expected at least window_ms, 20"},
        BadInput{"HeartbeatTimeoutTooShort", "piezo.toml", "rate_Hz = 1000.0",
                 "rate_Hz = 1000.0\nheartbeat_timeout_ms = 150.0", "heartbeat_timeout_ms is shorter"},
        BadInput{"StatusTimeoutTooShort", "piezo.toml", "[axis.control.delays]",
                 "status_timeout_ms = 19.0\n[axis.control.delays]",
                 "status_timeout_ms is 19, expected at least two periods of status_every, 20, or 0"},
        BadInput{"ModelNotMonotone", "piezo.model.toml", "[0, 0.222,", "[0, -0.222,", "expected"},
        BadInput{"ModelConvergesTooFast", "piezo.model.toml", "k_ascending  = 0.035", "k_ascending  = 5.0",
                 "k_ascending"},
        BadInput{"ModelThresholdsSwapped", "piezo.model.toml", "input_max    = 100.0", "input_max = -1.0",
                 "input_max is -1"},
        BadInput{"ModelOfAnotherKind", "piezo.model.toml", "\"recursive-memory\"", "\"preisach\"",
                 "kind is \"preisach\""},
        BadInput{"ModelInAnotherUnit", "piezo.model.toml", "\"V\"", "\"A\"", "input_unit is \"A\""},
        BadInput{"TruthInAnotherUnit", "piezo.plant.toml", "\"V\"", "\"A\"", "input_unit is \"A\""},
        BadInput{"CreepThatEndsBeforeItBegins", "piezo.toml", "[axis.twin]",
                 "[axis.twin.creep]\nper_decade = 0.015\nfrom_s = 1.0\nto_s = 0.5\n[axis.twin]",
                 "to_s is 0.5, expected more than from_s, 1"},
        BadInput{"SecondModeOfMoreThanAll", "piezo.toml", "[axis.twin]",
                 "[axis.twin.second_mode]\nresonance_Hz = 1200.0\ndamping_ratio = 0.02\nshare = 1.1\n"
                 "[axis.twin]",
                 "share is 1.1"},
        BadInput{"TemperatureThatTurnsTheStrokeRound", "piezo.toml", "[axis.twin]",
                 "[axis.twin.temperature]\nswing_K = 20.0\nperiod_s = 60.0\nexpansion_um_per_K = 0.1\n"
                 "gain_per_K = -0.05\n[axis.twin]",
                 "gain_per_K is -0.05, expected a magnitude of less than 1 / swing_K, 0.05"},
        BadInput{"TwinCoupledToItself", "piezo.toml", "[axis.twin]",
                 "[[axis.twin.coupling]]\nfrom = \"x\"\num_per_um = 0.01\n[axis.twin]",
                 "from is \"x\", expected the name of another axis"},
        BadInput{"CoefficientNotANumber", "piezo.model.toml", "[0, 0.222,", "[0, \"a\",",
                 "ascending is of type string"}),
    [](const auto& test) { return test.param.name; });

/// Replaces `what` in a copy of the shipped configuration. Expects a refusal in the line of `name`, and
/// returns the rest of the message.
std::string refused_at(const std::string& name, const std::string& what, const std::string& with) {
  const support::ShippedCopy shipped;
  shipped.edit("piezo.toml", what, with);
  const std::string text = support::read_file(shipped / "piezo.toml");
  const std::string folder = shipped.folder().string() + "/";
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(text.find(name)), '\n');
  std::string message = support::refusal_of([&] { load(shipped / "piezo.toml"); });
  for (auto at = message.find(folder); at != std::string::npos; at = message.find(folder))
    message.erase(at, folder.size());
  EXPECT_TRUE(message.starts_with("piezo.toml:" + std::to_string(line) + ":")) << message;
  return message.substr(message.find(": ") + 2);
}

TEST(Load, AMissingFileIsReportedAtTheKeyThatNamesIt) {
  EXPECT_EQ(refused_at("x.model.toml", "\"piezo.model.toml\"", "\"x.model.toml\""),
            "model: no such file: x.model.toml");
  EXPECT_EQ(refused_at("x.plant.toml", "\"piezo.plant.toml\"", "\"x.plant.toml\""),
            "model: no such file: x.plant.toml");
  EXPECT_EQ(refused_at("x.dbc", "\"hystcan.dbc\"", "\"x.dbc\""), "dbc: no such file: x.dbc");
  EXPECT_EQ(
      refused_at("x.csv", "[[axis.control.setpoint]]",
                 "[[axis.control.setpoint]]\nkind = \"csv\"\nfile = \"x.csv\"\n[[axis.control.setpoint]]"),
      "file: no such file: x.csv");
}

TEST(Load, AFolderInPlaceOfAFileIsReportedAtTheKeyThatNamesIt) {
  EXPECT_EQ(refused_at("\"/\"", "\"piezo.model.toml\"", "\"/\""), "model: / is a folder, expected a file");
}

TEST(Load, RefusesAnInvalidInterfaceName) {
  EXPECT_EQ(refused_at("abcdefghijklmnop", "\"vcan0\"", "\"abcdefghijklmnop\""),
            "interface is \"abcdefghijklmnop\", expected the name of an interface: "
            "1 to 15 characters without spaces, / and :");
}

TEST(Load, NamesAMissingConfiguration) { EXPECT_THROW(load("/nonexistent/x.toml"), Error); }

TEST(Load, AcceptsAPlantModelOfAnyKind) {
  const support::ShippedCopy shipped;
  std::ofstream(shipped / "piezo.plant.toml")
      << "[hysteresis]\nkind = \"preisach\"\ninput_unit = \"V\"\noutput_unit = \"um\"\n"
         "input_min = 0.0\ninput_max = 100.0\noffset = 0.0\ngain = 0.25\nweights = [2.0, 1.0, 2.0]\n";
  const Config config = load(shipped / "piezo.toml");
  for (const auto& axis : config.axes)
    EXPECT_EQ(std::get<model::PreisachParameters>(axis.twin.plant.hysteresis).weights,
              (std::vector<double>{2.0, 1.0, 2.0}));
}

TEST(Load, LeavesUnconfiguredEffectsOutOfThePlant) {
  const Config config = load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  for (const auto& axis : config.axes) {
    EXPECT_FALSE(axis.twin.plant.second_mode);
    EXPECT_FALSE(axis.twin.plant.creep);
    EXPECT_FALSE(axis.twin.plant.temperature);
    EXPECT_TRUE(axis.twin.couplings.empty());
  }
}

/// The [creep] table of a model file.
constexpr const char* creep_table = "[creep]\nper_decade = 0.02\nfrom_s = 0.01\nto_s = 3.0\n[hysteresis]";
constexpr model::OutputCreep::Config creep_of_table{.per_decade = 0.02, .from_s = 0.01, .to_s = 3.0};

TEST(Load, UsesTheCreepOfAModelFileForControllerAndTwin) {
  const support::ShippedCopy shipped;
  shipped.edit("piezo.model.toml", "[hysteresis]", creep_table);
  const Config of_model = load(shipped / "piezo.toml");
  EXPECT_EQ(of_model.axes[0].control.law.creep, creep_of_table);
  EXPECT_FALSE(of_model.axes[0].twin.plant.hysteresis_creep) << "the twin has a model file of its own";
  shipped.edit("piezo.plant.toml", "[hysteresis]", creep_table);
  EXPECT_EQ(load(shipped / "piezo.toml").axes[0].twin.plant.hysteresis_creep, creep_of_table);
}

TEST(Load, PrefersTheCreepTableToTheModelFileOfTheTwin) {
  const support::ShippedCopy shipped;
  shipped.edit("piezo.plant.toml", "[hysteresis]", creep_table);
  shipped.edit("piezo.toml", "[axis.twin]",
               "[axis.twin.creep]\nper_decade = 0.0\nfrom_s = 0.1\nto_s = 1000.0\n[axis.twin]");
  const Config config = load(shipped / "piezo.toml");
  EXPECT_FALSE(config.axes[0].twin.plant.hysteresis_creep);
  EXPECT_EQ(config.axes[1].twin.plant.hysteresis_creep, creep_of_table)
      << "of the other axis nothing was said";
}

TEST(Load, ReadsTheSlowPhysicsOfThePlant) {
  const support::ShippedCopy shipped;
  shipped.edit("piezo.toml", "[axis.twin]",
               "[axis.twin.second_mode]\nresonance_Hz = 1200.0\ndamping_ratio = 0.02\nshare = 0.1\n"
               "[axis.twin.creep]\nper_decade = 0.015\nfrom_s = 0.1\nto_s = 1000.0\n"
               "[axis.twin.temperature]\nswing_K = 1.5\nperiod_s = 600.0\nexpansion_um_per_K = 0.1\n"
               "gain_per_K = 1e-3\n"
               "[[axis.twin.coupling]]\nfrom = \"y\"\num_per_um = 0.01\n[axis.twin]");
  const Config config = load(shipped / "piezo.toml");
  const twin::AxisConfig& x = config.axes[0].twin;
  EXPECT_EQ(x.plant.second_mode->mode.natural_frequency_Hz, 1200.0);
  EXPECT_EQ(x.plant.second_mode->mode.damping_ratio, 0.02);
  EXPECT_EQ(x.plant.second_mode->share, 0.1);
  EXPECT_EQ(x.plant.creep->per_decade, 0.015);
  EXPECT_EQ(x.plant.creep->to_s, 1000.0);
  EXPECT_EQ(x.plant.temperature->swing_K, 1.5);
  EXPECT_EQ(x.plant.temperature->gain_per_K, 1e-3);
  ASSERT_EQ(x.couplings.size(), 1u);
  EXPECT_EQ(x.couplings[0].index, 1u);
  EXPECT_FALSE(config.axes[1].twin.plant.creep) << "of the other axis nothing was said";
  const std::string text = echo(shipped / "piezo.toml");
  for (const char* table :
       {"[axis.twin.second_mode]", "[axis.twin.creep]", "[axis.twin.temperature]", "[[axis.twin.coupling]]"})
    EXPECT_NE(text.find(table), std::string::npos) << table;
}

TEST(Echo, PrintsTheValuesInForceAndMarksDefaults) {
  const std::string text = echo(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  EXPECT_NE(text.find("rate_Hz = 1000\n"), std::string::npos);
  EXPECT_NE(text.find("node = 127  # default"), std::string::npos);
  EXPECT_NE(text.find("substep_us = 50  # default"), std::string::npos);
  EXPECT_NE(text.find("[[axis.control.setpoint]]"), std::string::npos);
}

TEST(Echo, CanBeLoadedAsAConfiguration) {
  const support::ShippedCopy shipped;
  const std::string once = echo(shipped / "piezo.toml");
  std::ofstream(shipped / "echoed.toml") << once;
  EXPECT_NO_THROW(load(shipped / "echoed.toml"));
}

}  // namespace
}  // namespace hystcan::config::load_test
