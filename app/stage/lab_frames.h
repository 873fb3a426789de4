// The signals of a lab's own DBC that have a role in the frames of an axis. A DBC does not define what a
// signal means: each role is stated, or asked for with a list of the signals that may have it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/stage/questions.h"
#include "app/stage/stage_facts.h"

namespace hystcan::app {

/// MSG.SIG by the keys of `[axis.frames]`: "command.setpoint". One holds for all axes, or each axis has its
/// own. "status.states" has the raw values of off/ready/enabled/fault: 0/16/32/64,65.
using StatedRoles = std::map<std::string, std::vector<std::string>>;

/// Adds "status.state=AmpGet.St". Throws Error if there is no such role.
void add_role(StatedRoles& roles, const std::string& text);

/// Fills in the frames of the axes, whose names and units are known: the prefixes and nodes of the standard
/// frames, or the lab's own. Throws Error if a role that is needed is neither stated nor asked for; the error
/// has its option and the signals that may have it.
void find_frames(StageFacts& stage, const StatedRoles& stated, Questions& questions);

}  // namespace hystcan::app
