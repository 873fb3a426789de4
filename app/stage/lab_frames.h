// Assigns roles in the frames of an axis to signals of a lab's own DBC. A DBC does not define the meaning of
// a signal: each role is stated by an option, or asked with a list of the possible signals.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/stage/questions.h"
#include "app/stage/stage_facts.h"

namespace hystcan::app {

/// MSG.SIG for each key of `[axis.frames]`, such as "command.setpoint". One value applies to all axes, or
/// each axis has its own. "status.states" contains the raw values of off/ready/enabled/fault: 0/16/32/64,65.
using StatedRoles = std::map<std::string, std::vector<std::string>>;

/// Adds a role, for example "status.state=AmpGet.St". Throws Error if there is no such role.
void add_role(StatedRoles& roles, const std::string& text);

/// Sets the frames of the axes, whose names and units are known: the prefixes and nodes of the standard
/// frames, or the lab's own frames. Throws Error if a required role is neither stated nor asked; the error
/// contains its option and the possible signals.
void find_frames(StageFacts& stage, const StatedRoles& stated, Questions& questions);

}  // namespace hystcan::app
