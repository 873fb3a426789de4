// The promise of a loop, and the proposal of a better rate.
#include "app/stage/promise.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/live/rehearsal_setup.h"
#include "app/stage/rate_choice.h"
#include "config/schema/check.h"
#include "config/schema/config.h"

namespace hystcan::app::promise_test {
namespace {

Promise promise() {
  return {.axis = "x",
          .loop = "cautious",
          .rms_um = 0.78,
          .least_um = 0.551,
          .most_um = 1.07,
          .stroke_um = 195.0};
}

TEST(PromiseText, HasTheDocumentedText) {
  EXPECT_EQ(text_of(promise()),
            "promise x: 0.78 um RMS true (90 %: 0.55 to 1.1), 0.40 % of stroke; cautious");
}

TEST(PromiseText, HasTwoDigitsOfEverySize) {
  Promise other = promise();
  other.rms_um = 0.00996;
  other.least_um = 0.0996;
  other.most_um = 123.0;
  EXPECT_EQ(text_of(other), "promise x: 0.010 um RMS true (90 %: 0.10 to 120), 0.0051 % of stroke; cautious");
}

TEST(PromiseJson, HasTheNumbersInMicrometres) {
  const nlohmann::json json = to_json(promise());
  EXPECT_EQ(json["axis"], "x");
  EXPECT_EQ(json["loop"], "cautious");
  EXPECT_EQ(json["true_rms_um"], 0.78);
  EXPECT_EQ(json["interval_90_um"], (nlohmann::json{0.551, 1.07}));
}

/// The shipped piezo stage with one axis, a mode of this frequency and little damping, and an integral loop.
config::Config piezo(double resonance_Hz, double rate_Hz = 1000.0) {
  config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  config.axes.resize(1);
  config.controller.rate_Hz = rate_Hz;
  config::AxisConfig& axis = config.axes[0];
  axis.control.repeat = false;
  axis.control.law.notch.reset();
  axis.control.law.pi = {.kp = 0.0, .ki_per_s = 20.0};
  axis.control.delays.resonance_Hz = axis.twin.plant.mode.natural_frequency_Hz = resonance_Hz;
  axis.control.delays.damping_ratio = axis.twin.plant.mode.damping_ratio = 0.02;
  axis.control.delays.command_delay = std::chrono::nanoseconds(std::llround(1e9 / rate_Hz));
  config::derive(config, 0);
  return config;
}

std::vector<Promise> promised(const config::Config& config, const Uncertainty& uncertainty,
                              double misfit_um) {
  const identification::Misfit misfit{.speed = 100.0, .lowest = 0.005, .rms = {misfit_um}};
  PromiseBasis basis{.loop = "integral", .misfit = misfit, .uncertainty = uncertainty};
  return promises_of(rehearsal_setup(config), {basis});
}

TEST(PromiseOfALoop, GrowsWithTheResidualOfTheModel) {
  const config::Config config = piezo(500.0);
  const Promise small = promised(config, {}, 0.001).front(), large = promised(config, {}, 0.3).front();
  EXPECT_GT(large.rms_um, 2.0 * small.rms_um);
  EXPECT_LT(large.rms_um, 0.4) << "no loop makes a slow misfit larger";
  EXPECT_LT(small.least_um, small.rms_um);
  EXPECT_GT(small.most_um, small.rms_um);
}

TEST(PromiseOfALoop, IsWiderIfTheOriginOfADelayIsUnknown) {
  const config::Config config = piezo(500.0);
  const Promise known = promised(config, {}, 0.01).front(),
                unknown = promised(config, {.unshared_s = 5e-4, .share_error = 0.5}, 0.01).front();
  EXPECT_GT(unknown.most_um / unknown.least_um, 1.2 * known.most_um / known.least_um);
}

TEST(PromiseOfALoop, HardlyDependsOnAnUnknownShareOfTheDelay) {
  const config::Config config = piezo(500.0);
  const auto most_um = [&](double sensor_share) {
    const Uncertainty uncertainty{.unshared_s = 5e-4, .sensor_share = sensor_share, .share_error = 1.0};
    return promised(config, uncertainty, 0.01).front().most_um;
  };
  EXPECT_NEAR(most_um(0.95) / most_um(0.05), 1.0, 0.2);
}

TEST(PromiseOfALoop, IsWiderIfNoRecordShowsTheMode) {
  const config::Config config = piezo(720.0);
  const Promise known = promised(config, {}, 0.01).front(),
                unknown = promised(config, {.mode_error = 0.05}, 0.01).front();
  EXPECT_GT(unknown.most_um / unknown.least_um, 1.2 * known.most_um / known.least_um);
}

TEST(BetterRate, IsOfferedIfHeldSetpointsExciteTheMode) {
  const auto at_rate = [](double rate_Hz) { return piezo(977.0, rate_Hz); };
  const config::Config now = at_rate(1000.0);
  const std::vector<Promise> present = promises_of(now);
  const auto offer = better_rate(at_rate, rates_to_try(now), present);
  ASSERT_TRUE(offer.has_value());
  EXPECT_GT(offer->rate_Hz, 1100.0);
  ASSERT_EQ(present.size(), 1U);
  EXPECT_LT(offer->promises.front().rms_um, 0.75 * present.front().rms_um);
  EXPECT_NE(texts_of(*offer, present).front().find(" um instead of "), std::string::npos);
}

TEST(CheckOfTheRate, WarnsWithinFifteenPercentOfAMultiple) {
  for (const double resonance_Hz : {860.0, 1000.0, 1140.0, 2100.0})
    EXPECT_EQ(config::findings_of_rate(piezo(resonance_Hz).axes[0], 1000.0).size(), 1U) << resonance_Hz;
  for (const double resonance_Hz : {100.0, 500.0, 840.0, 1200.0, 2500.0})
    EXPECT_TRUE(config::findings_of_rate(piezo(resonance_Hz).axes[0], 1000.0).empty()) << resonance_Hz;
}

}  // namespace
}  // namespace hystcan::app::promise_test
