// [[twin.fault]] and [twin.random_faults] of a file.
#include <gtest/gtest.h>

#include <ostream>
#include <string>

#include "config/schema/config.h"
#include "tests/support/refusal.h"
#include "tests/support/shipped.h"

namespace hystcan::config::twin_fault_config_test {
namespace {

using std::chrono::milliseconds;
using twin::Fault;

constexpr const char* place = "[[axis]]\nname           = \"x\"";

/// The shipped stage with these lines in [twin].
struct WithFaults {
  explicit WithFaults(const std::string& lines) { files.edit("piezo.toml", place, lines + "\n" + place); }
  Config read() const { return load(files / "piezo.toml"); }
  std::string refusal() const {
    return support::refusal_of([&] { read(); });
  }
  support::ShippedCopy files;
};

TEST(FaultConfig, IsEmptyInTheShippedFiles) {
  const Config config = load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  EXPECT_TRUE(config.twin.faults.empty());
  EXPECT_FALSE(config.twin.random_faults);
}

TEST(FaultConfig, HasTheDefaultsOfItsKind) {
  const Config config = WithFaults(R"(
[[twin.fault]]
kind = "late"
axis = "x"
node = "amplifier"
at_s = 2.5
duration_s = 0.25
value = 3
repeat_every_s = 10
[[twin.fault]]
kind = "amplifier_trip"
axis = "y"
at_s = 1
duration_s = 0.5
[twin.random_faults]
rate_per_hour = 12.0
kinds = ["wrong_crc", "load_step"]
)")
                            .read();
  ASSERT_EQ(config.twin.faults.size(), 2u);
  const twin::FaultSpec& first = config.twin.faults[0];
  EXPECT_EQ(first.kind, Fault::late);
  EXPECT_EQ(first.node, twin::Node::amplifier);
  EXPECT_EQ(first.begins, milliseconds(2500));
  EXPECT_EQ(first.lasts, milliseconds(250));
  EXPECT_EQ(first.value, 3.0);
  EXPECT_EQ(first.repeat_every, milliseconds(10'000));
  EXPECT_EQ(config.twin.faults[1].node, twin::Node::amplifier) << "the node on which it acts";
  ASSERT_TRUE(config.twin.random_faults);
  EXPECT_EQ(config.twin.random_faults->rate_per_hour, 12.0);
  EXPECT_EQ(config.twin.random_faults->kinds, (std::vector{Fault::wrong_crc, Fault::load_step}));
}

TEST(FaultConfig, IsPrintedAsInTheFile) {
  const WithFaults with("[[twin.fault]]\nkind = \"load_step\"\naxis = \"x\"\nat_s = 1\nduration_s = 2\n");
  const std::string shown = echo(with.files / "piezo.toml");
  EXPECT_NE(shown.find("[[twin.fault]]\nkind"), std::string::npos) << shown;
  EXPECT_NE(shown.find("load_step"), std::string::npos);
  EXPECT_EQ(shown.find("node = \"sensor\""), std::string::npos) << "a stage is no node";
}

struct InvalidKey {
  const char* name;
  const char* lines;
  const char* message;

  friend void PrintTo(const InvalidKey& key, std::ostream* out) { *out << key.name; }
};
class InvalidFault : public testing::TestWithParam<InvalidKey> {};

TEST_P(InvalidFault, IsRefusedWithItsExpectation) {
  const std::string refusal = WithFaults(std::string(GetParam().lines)).refusal();
  EXPECT_NE(refusal.find(GetParam().message), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("expected"), std::string::npos) << refusal;
}

#define FAULT(kind, more) "[[twin.fault]]\nkind = \"" kind "\"\nat_s = 1\nduration_s = 1\n" more "\n"
INSTANTIATE_TEST_SUITE_P(
    , InvalidFault,
    testing::Values(
        InvalidKey{"UnknownKind", FAULT("slow", "axis = \"x\""), "kind is \"slow\""},
        InvalidKey{"UnknownAxis", FAULT("late", "axis = \"z\""), "axis is \"z\""},
        InvalidKey{"NoAxis", FAULT("late", ""), "missing key axis"},
        InvalidKey{"WrongNode", FAULT("out_of_range", "axis = \"x\"\nnode = \"amplifier\""),
                   "is a fault of the sensor"},
        InvalidKey{"NodeOfAStage", FAULT("load_step", "axis = \"x\"\nnode = \"sensor\""), "unknown key node"},
        InvalidKey{"ValueOutOfRange", FAULT("late", "axis = \"x\"\nvalue = 17"), "value is 17"},
        InvalidKey{"ValueOfAKindWithoutOne", FAULT("wrong_crc", "axis = \"x\"\nvalue = 1"),
                   "unknown key value"},
        InvalidKey{"BrokenCycle", FAULT("late", "axis = \"x\"\nvalue = 1.5"), "expected a whole number"},
        InvalidKey{"OverlappingRepeats", FAULT("late", "axis = \"x\"\nrepeat_every_s = 0.5"),
                   "repeat_every_s is 0.5"},
        InvalidKey{"UnknownRandomKind",
                   "[twin.random_faults]\nrate_per_hour = 1.0\nkinds = [\"late\", \"x\"]\n",
                   "kinds has \"x\""},
        InvalidKey{"NoRate", "[twin.random_faults]\nseed = 2\n", "missing key rate_per_hour"},
        InvalidKey{"DurationsTurnedRound",
                   "[twin.random_faults]\nrate_per_hour = 1.0\nduration_min_s = 2.0\nduration_max_s = 1.0\n",
                   "duration_max_s is 1"}),
    [](const auto& test) { return std::string(test.param.name); });
#undef FAULT

TEST(FaultConfig, NeedsTheFieldThatTheFaultChanges) {
  const support::ShippedCopy files;
  files.edit("lab_amplifier.toml", "status    = \"Err\"", "");
  ASSERT_NO_THROW(load(files / "lab_amplifier.toml"));
  files.edit(
      "lab_amplifier.toml", "[[axis]]",
      "[[twin.fault]]\nkind = \"sensor_bad_status\"\naxis = \"x\"\nat_s = 1\nduration_s = 1\n[[axis]]");
  const std::string refusal = support::refusal_of([&] { load(files / "lab_amplifier.toml"); });
  EXPECT_NE(refusal.find("SensPos has no status, expected a message with this signal"), std::string::npos)
      << refusal;
}

}  // namespace
}  // namespace hystcan::config::twin_fault_config_test
