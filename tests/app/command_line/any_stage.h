// Stages drawn at random, similar to the soft stage but with another kind of hysteresis than the controller's
// model. The stated values of each stage are up to 8 % off.
//
//   cycle rate 500, 1000, 1500 Hz; mode 0.1 to 2.5 times as high, damping 0.01 to 0.1; amplifier 300 to 3000
//   Hz; sensor without a delay, or up to 0.6 ms; noise 0.5 to 5 nm; creep up to 3 % a decade
#pragma once

#include <random>
#include <string>
#include <vector>

#include "config/document/toml_edit.h"
#include "config/schema/config.h"

namespace hystcan::any_stage_test {

struct Stage {
  double rate_Hz, mode_Hz, damping_ratio, amplifier_Hz, sensor_delay_us, noise_um, creep_per_decade;

  std::string text() const;
};

/// Draws numbers between 0 and 1, equal on every machine.
class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double part() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  double off() { return 1.0 + 0.08 * (2.0 * part() - 1.0); }
  double between(double lo, double hi) { return lo + (hi - lo) * part(); }

 private:
  std::mt19937_64 random_;
};

Stage drawn(Draw& draw);

/// Returns a model file of 100 um at -20 to 120 V. Its kind alternates between Preisach, Prandtl-Ishlinskii
/// and recursive-memory.
std::string hysteresis(unsigned kind, Draw& draw);

/// 1 to `usual`, 1 to 200 in a long run, or only HYSTCAN_STAGE, to examine a failed stage.
struct Seeds {
  unsigned first, last;
};
Seeds seeds(unsigned usual);

/// Returns the soft stage with these dynamics, configured with the values of `draw` and a cautious integral
/// loop.
std::string configured(config::TomlEdit edit, const Stage& stage, Draw& draw);

struct Errors {
  double samples_um = 0.0, true_um = 0.0, stroke_um = 0.0;
  bool faulted = true;
};

/// Runs the reference of `config` on a stage with `resonance` times its mode frequency.
Errors errors_of(const config::Config& config, twin::Config stage, double resonance = 1.0);
/// Tries the mode at its frequency, and 10 % lower and higher.
bool faults(const config::Config& config, const twin::Config& stage);

/// Prints the median, the 90 % quantile and the maximum of a figure.
void print_shares(const char* what, std::vector<double> values);

}  // namespace hystcan::any_stage_test
