#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "config/files/csv.h"
#include "config/schema/check.h"
#include "config/schema/frames.h"
#include "controller/control/start_up.h"
#include "node/analogue/axis_check.h"
#include "node/analogue/device_name.h"
#include "twin/simulated_card.h"

namespace hystcan::config {
namespace {

/// The purpose of a channel. Two axes can share a digital line only if it has the same purpose for both.
enum class Purpose : std::uint8_t { output, input, enable, interlock, charge_pump };

constexpr bool is_line(Purpose purpose) { return purpose >= Purpose::enable; }
/// Returns true if several axes may use one line for this purpose. An interlock may be shared because it is
/// only read, and a charge pump because it toggles at the same SYNC for all axes.
constexpr bool may_be_shared(Purpose purpose) {
  return purpose == Purpose::interlock || purpose == Purpose::charge_pump;
}
constexpr std::string_view noun_of(Purpose purpose) {
  if (is_line(purpose)) return "line";
  return purpose == Purpose::output ? "output" : "input";
}

/// A channel of a card that an axis uses, and the configuration member that names the channel.
struct ChannelUse {
  std::string card;  ///< card with the channel, as node::identity_of() identifies it
  Purpose purpose{};
  const node::CardChannel* place = nullptr;
  const node::ActiveLevel* active = nullptr;  ///< active level of a digital line; null: not a digital line
  Member member;

  /// Returns true if this object and `other` are the same physical channel. An input, an output and a line
  /// with the same number on the same subdevice are different channels.
  bool is_same(const ChannelUse& other) const {
    return std::tuple(card, noun_of(purpose), place->subdevice, place->channel) ==
           std::tuple(other.card, noun_of(other.purpose), other.place->subdevice, other.place->channel);
  }
};

/// Returns the voltage range of a channel if it is known without the card: the file states it, or the card is
/// simulated. Otherwise returns `nullopt`. Throws ChannelError if the simulated card has no such range.
std::optional<node::VoltageRange> known_range(std::string_view key, const node::AnalogueConfig& analogue,
                                              const node::CardChannel& place) {
  const node::DeviceName card = node::device_named(place.device.empty() ? analogue.device : place.device);
  if (card.kind != node::CardKind::simulated) return node::parsed_range(place.range);
  return node::opened(key, [&] { return twin::SimulatedCard::range_of(card.bits, place); });
}

std::optional<node::VoltageRange> known_input_range(const node::AnalogueConfig& analogue) {
  return known_range("position_input", analogue, analogue.position_input.place);
}

/// Checks [axis.analogue] of one axis.
class AnalogueCheck : Checked {
 public:
  AnalogueCheck(const Checked& checked, const AxisConfig& axis)
      : Checked(checked), axis_(axis), analogue_(*axis.analogue), device_(named(analogue_.device)) {}

  /// Checks this axis, and that it uses no channel in `all`, the channels of earlier axes. Adds its own
  /// channels to `all`.
  void run(std::vector<ChannelUse>& all) const {
    for (const ChannelUse& use : uses()) {
      check_range_text(use);
      for (const ChannelUse& other : all)
        if (use.is_same(other)) check_shared(use, other);
      all.push_back(use);
    }
    check_watchdog();
    check_enable_delay();
  }

  /// Checks the voltage ranges that are known without the card. The other ranges are checked when the card is
  /// opened.
  void check_ranges(const node::WiredAnalogueAxis& wired) const try {
    if (const auto range = known_range("drive_output", analogue_, analogue_.drive_output))
      node::check_drives(analogue_, wired.drives, *range);
    if (const auto range = known_input_range(analogue_))
      node::check_positions(analogue_, wired.positions, *range);
  } catch (const node::ChannelError& error) {
    throw Error(document.place_at(path_of(config, *axis_.analogue) + "." + error.key), error);
  }

 private:
  node::DeviceName named(const std::string& device) const {
    if (auto card = node::DeviceName::parsed(device)) return *std::move(card);
    fail(device, "device is \"{}\", expected {}", in_one_line(shortened(device)), node::DeviceName::expected);
  }

  std::vector<ChannelUse> uses() const {
    std::vector<ChannelUse> uses;
    const auto add = [&](Purpose purpose, const node::CardChannel& place, const Member& member,
                         const node::ActiveLevel* active = nullptr) {
      const node::DeviceName device = place.device.empty() ? device_ : named(place.device);
      const std::string card = identity_of(device);
      if (device.kind == node::CardKind::simulated && !is_line(purpose) && card != identity_of(device_))
        fail(place.device,
             "device is \"{}\", expected the device of the axis, or a real card: a simulated card has "
             "channels only for the axes that name it as their own device",
             place.device);
      if (device.kind == node::CardKind::iio && is_line(purpose))
        fail(member,
             "IIO devices have no digital lines, expected a device with digital lines; or remove this key");
      uses.push_back({card, purpose, &place, active, member});
    };
    add(Purpose::output, analogue_.drive_output, analogue_.drive_output);
    add(Purpose::input, analogue_.position_input.place, analogue_.position_input);
    if (analogue_.output_input) add(Purpose::input, *analogue_.output_input, *analogue_.output_input);
    const auto add_line = [&](Purpose purpose, const std::optional<node::LineConfig>& line) {
      if (line) add(purpose, line->place, *line, &line->active);
    };
    add_line(Purpose::enable, analogue_.enable_line);
    add_line(Purpose::interlock, analogue_.interlock_line);
    add_line(Purpose::charge_pump, analogue_.charge_pump_line);
    return uses;
  }

  void check_range_text(const ChannelUse& use) const {
    const std::string& range = use.place->range;
    if (!range.empty() && !node::parsed_range(range))
      fail(range, "range is \"{}\", expected a range like 0..10 V", in_one_line(shortened(range)));
  }

  void check_shared(const ChannelUse& use, const ChannelUse& other) const {
    const std::string theirs = path_of(config, other.member);
    if (use.purpose != other.purpose || !may_be_shared(use.purpose))
      fail(use.member, "{} {} of subdevice {} is already in use by {}, expected an unused channel or line",
           noun_of(use.purpose), use.place->channel, use.place->subdevice, theirs);
    if (*use.active != *other.active)
      fail(*use.active, "active is \"{}\", expected \"{}\" as in {}, which uses the same line",
           word_of(*use.active), word_of(*other.active), theirs);
  }

  double cycle_ms() const { return 1e3 * can::seconds(controller::cycle_of(config.controller)); }

  void check_watchdog() const {
    const can::Duration& timeout = analogue_.amplifier.command_timeout;
    const double timeout_ms = 1e3 * can::seconds(timeout);
    if (timeout_ms < 2.0 * cycle_ms())
      fail(timeout, "command_timeout_ms is {:g}, expected at least two cycles, {:g}", timeout_ms,
           2.0 * cycle_ms());
    const double tried_ms = 1e3 * controller::watchdog_timeout_s;
    if (axis_.control.verify_watchdog && timeout_ms >= tried_ms)
      fail(timeout,
           "command_timeout_ms is {:g}, expected less than {:g}, the time for which "
           "verify_watchdog waits for a trip",
           timeout_ms, tried_ms);
  }

  /// Checks that the amplifier's enable_delay_ms is not longer than the controller waits. The controller
  /// waits for the enable_delay_ms of [axis.control]. If the amplifier reports its state, the controller then
  /// waits up to enable_timeout_s longer for the state enabled, and faults the axis after this time.
  void check_enable_delay() const {
    const can::Duration& delay = analogue_.amplifier.enable_delay;
    const double delay_ms = 1e3 * can::seconds(delay);
    const double control_ms = 1e3 * can::seconds(axis_.control.enable_delay);
    if (!reports_state(axis_.wire) && delay_ms > control_ms)
      fail(delay,
           "enable_delay_ms is {:g}, expected at most {:g}, the enable_delay_ms of [axis.control]: the "
           "amplifier does not report when its output is connected",
           delay_ms, control_ms);
    const double longest_ms =
        std::max(0.0, control_ms + 1e3 * axis_.control.supervision.enable_timeout_s - 2.0 * cycle_ms());
    if (reports_state(axis_.wire) && delay_ms > longest_ms)
      fail(delay,
           "enable_delay_ms is {:g}, expected at most {:g}, the time for which the controller waits for "
           "the state enabled; raise enable_delay_ms of [axis.control] for a longer wait",
           delay_ms, longest_ms);
  }

  const AxisConfig& axis_;
  const node::AnalogueConfig& analogue_;
  node::DeviceName device_;
};

}  // namespace

void check_analogue(const Checked& checked) {
  std::vector<ChannelUse> all;
  std::vector<node::WiredAnalogueAxis> wired = analogue_axes(checked.config);
  auto next = wired.begin();
  for (const AxisConfig& axis : checked.config.axes) {
    if (!axis.analogue) continue;
    const AnalogueCheck check(checked, axis);
    check.run(all);
    check.check_ranges(*next++);
  }
}

std::vector<std::string> stroke_warnings(const Config& config) {
  std::vector<std::string> warnings;
  for (const node::WiredAnalogueAxis& axis : analogue_axes(config))
    if (const auto range = known_input_range(axis.config))
      if (const auto warning = node::stroke_warning(axis.config, axis.positions, *range); !warning.empty())
        warnings.push_back(fmt::format("axis {}: {}", axis.wire.name, warning));
  return warnings;
}

}  // namespace hystcan::config
