// The last check before a drive is sent. It does not trust any other part: the drive that leaves the gate is
// always finite and in range, and its distance from the last drive never exceeds the slew limit.
#pragma once

#include <cstdint>
#include <string>

namespace hystcan::controller {

/// The reasons for which a drive was limited. They are bits, reported together with the drive.
namespace limit {
inline constexpr std::uint8_t none = 0;
inline constexpr std::uint8_t range = 0x01;  ///< the drive is limited to drive_min or drive_max
inline constexpr std::uint8_t slew = 0x02;   ///< the change since the last drive is limited to slew * dt
/// The requested drive is NaN or infinite: the last drive is held.
inline constexpr std::uint8_t not_finite = 0x04;
inline constexpr std::uint8_t model = 0x08;  ///< the demanded position is outside the model's range
/// The model cannot be inverted at the demanded position, because its branch does not increase there.
inline constexpr std::uint8_t not_invertible = 0x10;
}  // namespace limit

std::string limits_to_string(std::uint8_t limits);

struct Gate {
  struct Config {
    double drive_min = 0.0;  ///< smallest drive, drive units
    double drive_max = 100.0;
    double slew_per_s = 1e4;  ///< maximum slew of the drive, drive units per second
    double safe_drive = 0.0;
  };
  struct Passed {
    double drive = 0.0;
    std::uint8_t limits = limit::none;
  };
  /// Limits the requested drive. `last`: the drive that left the gate `dt_s` ago. If `last` is not finite,
  /// the gate outputs the safe drive.
  static Passed step(const Config& config, double last, double requested, double dt_s);
  /// Moves `drive` towards `target` by at most `reach`, within the limits of the gate. Returns true if the
  /// drive has reached the target. If the target is out of range, returns true if the drive has reached the
  /// nearest end of the range.
  static bool approach(const Config& config, double& drive, double target, double reach, double dt_s);
};

}  // namespace hystcan::controller
