// The last gate before the wire. It trusts no other part: whatever drive the law requests, the drive that
// leaves the gate is finite, in range, and no further from the last one than the slew limit allows.
#pragma once

#include <cstdint>
#include <string>

namespace hystcan::controller {

/// Why a drive was limited: bits, reported together with the drive.
namespace limit {
inline constexpr std::uint8_t none = 0;
inline constexpr std::uint8_t range = 0x01;       ///< beyond drive_min or drive_max
inline constexpr std::uint8_t slew = 0x02;        ///< further than slew * dt from the last drive
inline constexpr std::uint8_t not_finite = 0x04;  ///< NaN or infinite: the last drive is held
inline constexpr std::uint8_t model = 0x08;       ///< the demanded position lies outside the model's range
inline constexpr std::uint8_t not_invertible = 0x10;  ///< the model's branch is not increasing there
}  // namespace limit

std::string limits_to_string(std::uint8_t limits);

struct Gate {
  struct Config {
    double drive_min = 0.0;  ///< drive units
    double drive_max = 100.0;
    double slew_per_s = 1e4;  ///< drive units per second
    double safe_drive = 0.0;
  };
  struct Passed {
    double drive = 0.0;
    std::uint8_t limits = limit::none;
  };
  /// `last`: the drive that left the gate `dt_s` ago. If it is not finite, the safe drive leaves the gate.
  static Passed step(const Config& config, double last, double requested, double dt_s);
  /// Moves the drive closer to `target`, by at most `reach`. True: it is there, or at the bound before it.
  static bool approach(const Config& config, double& drive, double target, double reach, double dt_s);
};

}  // namespace hystcan::controller
