#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "config/schema/check.h"

namespace hystcan::config {
namespace {

/// A channel in use, and the member that names it.
struct ChannelUse {
  std::string_view device;
  std::string_view kind;  ///< two kinds of channels of a subdevice are different channels
  const node::CardChannel* place = nullptr;
  Member member;

  bool is_same(const ChannelUse& other) const {
    return std::tie(device, kind, place->subdevice, place->channel) ==
           std::tie(other.device, other.kind, other.place->subdevice, other.place->channel);
  }
};

std::vector<ChannelUse> uses_of(const node::AnalogueConfig& a) {
  std::vector<ChannelUse> uses;
  const auto add = [&](std::string_view kind, const node::CardChannel& place, const Member& member) {
    uses.push_back({place.device.empty() ? a.device : place.device, kind, &place, member});
  };
  add("output", a.drive_output, a.drive_output);
  add("input", a.position_input.place, a.position_input);
  if (a.output_input) add("input", *a.output_input, *a.output_input);
  for (const auto* line : {&a.enable_line, &a.interlock_line, &a.charge_pump_line})
    if (*line) add("line", (*line)->place, **line);
  return uses;
}

void check_scales(const Checked& checked, const node::AnalogueConfig& a) {
  if (a.volts_per_drive == 0.0)
    checked.fail(a.volts_per_drive, "volts_per_drive is 0, expected the volts of one unit of the drive");
  if (a.position_um_per_V == 0.0)
    checked.fail(a.position_um_per_V, "position_um_per_V is 0, expected the scale of the sensor");
}

}  // namespace

void check_analogue(const Checked& checked) {
  std::vector<ChannelUse> all;
  for (const AxisConfig& axis : checked.config.axes) {
    if (!axis.analogue) continue;
    check_scales(checked, *axis.analogue);
    for (const ChannelUse& use : uses_of(*axis.analogue)) {
      for (const ChannelUse& other : all)
        if (use.is_same(other))
          checked.fail(use.member, "{} {} of subdevice {} is already in use by {}, expected another one",
                       use.kind, use.place->channel, use.place->subdevice,
                       path_of(checked.config, other.member));
      all.push_back(use);
    }
  }
}

}  // namespace hystcan::config
