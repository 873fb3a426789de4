// `hystcan tune` on stages that nobody has tuned it for: drawn at random about the soft stage, whose hysteresis is of
// another kind than the controller's model. What is configured of each is up to 8 % off.
//
//   cycle rate 500, 1000, 1500 Hz; mode 0.1 to 2 times as high, damping 0.01 to 0.1; amplifier 300 to 3000 Hz; sensor
//   without a delay, or up to 0.6 ms, which nobody has stated; noise 0.5 to 5 nm; creep up to 2 % a decade
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "app/live/rehearsal_setup.h"
#include "app/report/report.h"
#include "config/document/toml_edit.h"
#include "config/schema/config.h"
#include "tests/app/commands/cli.h"
#include "tests/support/long_run.h"

namespace hystcan::any_stage_test {
namespace {

struct Stage {
  double rate_Hz, mode_Hz, damping_ratio, amplifier_Hz, sensor_delay_us, noise_um, creep_per_decade;

  std::string text() const {
    char line[200];
    std::snprintf(line, sizeof line,
                  "%4.0f Hz, mode %.2f of it, damping %.3f, amplifier %4.0f Hz, sensor %3.0f us", rate_Hz,
                  mode_Hz / rate_Hz, damping_ratio, amplifier_Hz, sensor_delay_us);
    return line;
  }
};

/// Between 0 and 1, the same on every machine.
class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double part() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  double off() { return 1.0 + 0.08 * (2.0 * part() - 1.0); }

 private:
  std::mt19937_64 random_;
};

Stage drawn(Draw& draw) {
  Stage stage{};
  stage.rate_Hz = 500.0 * std::floor(1.0 + 3.0 * draw.part());
  stage.mode_Hz = stage.rate_Hz * 0.1 * std::pow(20.0, draw.part());
  stage.damping_ratio = 0.01 * std::pow(10.0, draw.part());
  stage.amplifier_Hz = 300.0 * std::pow(10.0, draw.part());
  stage.sensor_delay_us = std::max(0.0, std::round(600.0 * (2.0 * draw.part() - 1.0)));
  stage.noise_um = 0.0005 * std::pow(10.0, draw.part());
  stage.creep_per_decade = 0.02 * draw.part();
  return stage;
}

std::string number(double value) {
  const std::string text = std::to_string(value);  // with a point, as TOML has floats
  return text;
}

/// The soft stage with these dynamics; configured so are those of `draw`, and a cautious integral loop.
std::string configured(config::TomlEdit edit, const Stage& stage, Draw& draw) {
  const double resonance_Hz = stage.mode_Hz * draw.off(), damping_ratio = stage.damping_ratio * draw.off();
  const std::string control = "axis[0].control.", delays = control + "delays.", twin = "axis[0].twin.";
  edit.comment_out(control + "notch");
  edit.set("controller.rate_Hz", number(stage.rate_Hz));
  edit.set(control + "ki_per_s",
           number(std::min(3.14159 * damping_ratio * resonance_Hz, 0.1 * stage.rate_Hz)));
  edit.set(delays + "second_order", "false");
  edit.set(delays + "command_delay_us", number(std::round(1e6 / stage.rate_Hz)));
  edit.set(delays + "amplifier_bandwidth_Hz", number(stage.amplifier_Hz * draw.off()));
  edit.set(delays + "resonance_Hz", number(resonance_Hz));
  edit.set(delays + "damping_ratio", number(damping_ratio));
  edit.set(twin + "resonance_Hz", number(stage.mode_Hz));
  edit.set(twin + "damping_ratio", number(stage.damping_ratio));
  edit.set(twin + "bandwidth_Hz", number(stage.amplifier_Hz));
  edit.set(twin + "noise_um_rms", number(stage.noise_um));
  edit.set(twin + "sensor.delay_us", number(stage.sensor_delay_us));
  edit.set(twin + "creep.per_decade", number(stage.creep_per_decade));
  edit.set(twin + "creep.from_s", "0.1");
  edit.set(twin + "creep.to_s", "100.0");
  return edit.text();
}

struct Errors {
  double samples_um = 0.0, true_um = 0.0;
  bool faulted = true;
};

struct Row {
  Stage stage;
  std::string refusal;
  Errors before, after;
  bool faulted_before = false, faults_after = false;  ///< with the mode as it is, 10 % lower or higher
  bool stable = false;                                ///< at every corner
  double promised_um = 0.0;                           ///< the true error

  double better() const { return after.samples_um / before.samples_um; }
  double truly_better() const { return after.true_um / before.true_um; }
  /// How far the promise is from what came, as a factor.
  double miss() const { return std::max(after.true_um / promised_um, promised_um / after.true_um); }
};

class AnyStage : public Cli {
 protected:
  Errors run(const char* file, double resonance = 1.0) const {
    const config::Config config = config::load(shipped / file);
    twin::Config twin = twin_config(config);
    twin.axes[0].axis.plant.mode.natural_frequency_Hz *= resonance;
    const rehearsal::Outcome outcome = rehearsal::run_once(app::rehearsal_setup(config, twin), app::settle_s,
                                                           [](const controller::CycleRecord&) {});
    return {outcome.axes[0].statistics.total().rms_um(), outcome.true_errors[0].total().rms_um(),
            outcome.axes[0].fault.cause != controller::Cause::none};
  }
  /// With the mode as it is, or 10 % lower or higher.
  bool faults(const char* file) const {
    return run(file, 0.9).faulted || run(file).faulted || run(file, 1.1).faulted;
  }

  Row tuned(unsigned seed) const {
    Draw draw(seed);
    Row row;
    row.stage = drawn(draw);
    const std::filesystem::path written = shipped / "tuned.toml";
    std::filesystem::remove(written);
    write("any.toml", configured(config::TomlEdit::of_file(shipped / "soft_stage.toml"), row.stage, draw));
    row.before = run("any.toml");
    row.faulted_before = faults("any.toml");
    Process tune({HYSTCAN_PROGRAM, "tune", path("any.toml"), "--rehearse", "--write", written.string(),
                  "--output", path("fragment.toml"), "--json"});
    if (tune.wait() != done) {
      row.refusal = tune.err();
      return row;
    }
    const nlohmann::json proposed = nlohmann::json::parse(tune.out())["proposed"];
    row.after = run("tuned.toml");
    row.faults_after = faults("tuned.toml");
    row.stable = proposed["worst_margins"]["stable"];
    row.promised_um = 0.01 * proposed["predicted_true_rms_percent"].get<double>() * stroke_um("tuned.toml");
    return row;
  }

 private:
  double stroke_um(const char* file) const {
    const config::Config config = config::load(shipped / file);
    return rehearsal::run_once(app::rehearsal_setup(config), app::settle_s,
                               [](const controller::CycleRecord&) {})
        .axes[0]
        .stroke_um;
  }
};

/// Prints median, 90 % and the worst of a figure.
void print(const char* what, const std::vector<Row>& rows, double (Row::*of)() const) {
  std::vector<double> values;
  for (const Row& row : rows) values.push_back((row.*of)());
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  std::printf("%-40s median %.3f, 90 %% %.3f, worst %.3f\n", what, at(0.5), at(0.9), at(1.0));
}

TEST_F(AnyStage, GetsALoopThatIsNotWorseAndKeepsItsPromise) {
  const char* alone = std::getenv("HYSTCAN_STAGE");  // to look at one that failed
  const unsigned first = alone != nullptr ? static_cast<unsigned>(std::stoul(alone)) : 1;
  const unsigned last = alone != nullptr ? first : support::long_run() ? 200 : 20;
  std::vector<Row> rows;
  for (unsigned seed = first; seed <= last; ++seed) {
    Row row = tuned(seed);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ": " << row.stage.text());
    if (row.faulted_before && (row.faults_after || !row.refusal.empty())) {
      std::printf("no setpoints move it without a fault: %s\n", row.stage.text().c_str());
      continue;
    }
    EXPECT_EQ(row.refusal, "");
    if (!row.refusal.empty()) continue;
    EXPECT_FALSE(row.faults_after);
    EXPECT_TRUE(row.stable);
    if (row.before.faulted) {
      std::printf("has a loop for the first time: %s\n", row.stage.text().c_str());
      continue;
    }
    EXPECT_LT(row.better(), 1.02);
    rows.push_back(std::move(row));
  }
  ASSERT_FALSE(rows.empty());
  print("error at the samples, after / before", rows, &Row::better);
  print("true error, after / before", rows, &Row::truly_better);
  print("true error and the promised one", rows, &Row::miss);
  std::ranges::sort(rows, std::greater{}, &Row::miss);
  constexpr double within = 1.5;
  const auto missed = std::ranges::count_if(rows, [](const Row& row) { return row.miss() > within; });
  std::printf("promised within %g: all but %td of %zu; the ten that miss most:\n", within, missed,
              rows.size());
  for (std::size_t i = 0; i < std::min<std::size_t>(10, rows.size()); ++i)
    std::printf("  %.2f  %s: true error %.4f um, promised %.4f, before %.4f\n", rows[i].miss(),
                rows[i].stage.text().c_str(), rows[i].after.true_um, rows[i].promised_um,
                rows[i].before.true_um);
  // A mode near a whole multiple of the rate rings between the samples, which do not show it; where the mode is slow, the
  // record does not show whether the sensor has a delay.
  EXPECT_LE(missed, static_cast<std::ptrdiff_t>(rows.size() / 20));
}

}  // namespace
}  // namespace hystcan::any_stage_test
