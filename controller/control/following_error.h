// Monitors the distance between stage and reference. The stage has lost its reference if, for `cycles` cycles
// in a row,
//
//   |r - y| > error_um + lag |r'|
//
// r is the reference and y the measured position. r' is the slope of the reference since the last cycle, and
// lag the time by which the stage follows a moving reference late.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/words.h"
#include "controller/reference/trajectory.h"

namespace hystcan::controller {

class FollowingError {
 public:
  struct Config {
    double error_um = 0.0;
    std::chrono::nanoseconds lag{0};
    unsigned cycles = 1;
  };

  explicit FollowingError(const Config& config) : config_(config) {}

  void restart() { *this = FollowingError(config_); }
  /// Called once in each cycle with a sample. Returns false if the error was too large in `cycles` calls in a
  /// row: the stage does not follow its reference any more.
  bool step(double reference_um, double position_um, double dt_s);

 private:
  Config config_;
  std::optional<double> last_reference_um_;
  unsigned exceeded_in_a_row_ = 0;
};

// Decides if the stage is in position, while the reference is at rest:
//
//   in_position   |error| <= tolerance for the whole `window`; ends as soon as the error is greater
//   failed        the stage is not in position `timeout` after the reference came to rest, or after the
//                 error ended the state in_position. If the stage arrives later, `failed` changes to
//                 `in_position` after the same window
//   moving        the stage is not in position yet, and `timeout` has not passed
//
// If a resting reference differs from the reference of the last cycle, it has jumped, and the decision starts
// again. In a cycle without a sample, the window stops and the timeout continues. A program that waits for
// the arrival can stop at the first state other than `moving`.

enum class Arrival : std::uint8_t { not_judged, moving, in_position, failed };
constexpr auto words(Arrival) {
  return std::to_array<std::string_view>({"not judged", "moving", "in position", "failed"});
}
constexpr std::string_view to_string(Arrival arrival) { return word_of(arrival); }

struct InPosition {
  struct Config {
    double tolerance_um = 0.0;
    std::chrono::nanoseconds window{0};
    std::chrono::nanoseconds timeout{0};
  };
  struct State {
    Arrival arrival = Arrival::moving;
    double reference_um = 0.0;
    double within_s = -1.0;  ///< time for which the error has been within the tolerance; < 0: it is not
    /// Time since the later of two events: the reference came to rest, or the state in_position ended
    /// because the error was too large. < 0: the reference moves.
    double trying_s = -1.0;
  };
  /// Called once in each cycle; returns the present decision. `position_um`: measured position, `nullopt` if
  /// there is no sample. `dt_s`: time since the last cycle.
  static Arrival step(const Config& config, State& state, const Trajectory::Point& reference,
                      const std::optional<double>& position_um, double dt_s);
};

}  // namespace hystcan::controller
