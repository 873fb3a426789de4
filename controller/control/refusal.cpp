#include "controller/control/refusal.h"

#include <array>

namespace hystcan::controller {
namespace {

struct RefusalTraits {
  std::string_view name;
  std::string_view text;
};

constexpr std::array<RefusalTraits, refusal_count> refusal_traits{{
    {"no_such_axis", "the axis does not exist"},
    {"faulted", "the axis is faulted: clear the fault first"},
    {"enabled_already", "the axis is already enabled"},
    {"not_enabled", "the axis is not enabled"},
    {"still_ramping", "the drive is still ramping to its safe value"},
    {"no_fault_to_clear", "there is no fault to clear"},
    {"not_tracking", "the axis does not track a reference"},
    {"position_out_of_range",
     "the position is outside position_min_um..position_max_um, or outside the range of the model"},
    {"open_loop", "the axis runs in open loop"},
    {"drive_out_of_range", "the present drive is outside the new drive_min..drive_max"},
    {"too_many_requests", "too many requests at once"},
}};

}  // namespace

std::string_view name_of(Refusal refusal) { return refusal_traits[static_cast<std::size_t>(refusal)].name; }

std::string_view to_string(Refusal refusal) { return refusal_traits[static_cast<std::size_t>(refusal)].text; }

}  // namespace hystcan::controller
