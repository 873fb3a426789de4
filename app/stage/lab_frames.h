// Finds the signals of an axis in a lab's own DBC. A DBC does not define the role of a signal, for example
// which one is the setpoint. An option states each role; without the option, the user chooses from a list of
// the possible signals.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/stage/questions.h"
#include "app/stage/stage_facts.h"

namespace hystcan::app {

/// The signals as MESSAGE.SIGNAL, by a key of [axis.frames] such as "command.setpoint". The list has one
/// value for all axes, or one for each axis. The value of "status.states" is a text of raw values:
/// off/ready/enabled/fault, for example 0/16/32/64,65.
using StatedRoles = std::map<std::string, std::vector<std::string>>;

/// Adds a role from a text such as "status.state=AmpGet.St". Throws Error if there is no such role.
void add_role(StatedRoles& roles, const std::string& text);

/// Sets the frames of all axes, whose names and units must be set before. If the DBC has standard frames,
/// sets their prefixes and node numbers; otherwise sets the lab's own frames. Throws Error if a required role
/// is neither stated nor answered; the message names the option and the possible signals.
void find_frames(StageFacts& stage, const StatedRoles& stated, Questions& questions);

}  // namespace hystcan::app
