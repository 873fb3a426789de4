// Has the stage arrived? Judged while the reference rests:
//
//   in_position   |error| <= tolerance for `window` without a break; lost at once where the error leaves it
//   failed        not in position `timeout` after the reference came to rest, or after the position was lost.
//                 Arriving late is still arriving: failed goes to in_position by the same window
//   moving        neither yet
//
// A reference at rest that is somewhere else than in the cycle before has jumped, and everything begins anew.
// A cycle without a sample judges no error: the window stands still, the timeout runs on. Whoever waits has
// an answer at the first state that is not `moving`.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace hystcan::controller {

enum class Arrival : std::uint8_t { not_judged, moving, in_position, failed };
std::string_view to_string(Arrival arrival);

struct InPosition {
  struct Config {
    double tolerance_um = 0.0;
    std::chrono::nanoseconds window{0};
    std::chrono::nanoseconds timeout{0};
  };
  struct State {
    Arrival arrival = Arrival::moving;
    double reference_um = 0.0;
    double within_s = -1.0;  ///< inside the tolerance; < 0: outside
    double trying_s = -1.0;  ///< since the reference came to rest or the position was lost; < 0: it moves
  };
  struct Input {
    double reference_um = 0.0;
    bool reference_rests = false;
    std::optional<double> error_um;  ///< reference minus measured; empty: no sample
    double dt_s = 0.0;               ///< since the cycle before
  };

  static Arrival step(const Config& config, State& state, const Input& input);
};

}  // namespace hystcan::controller
