// Which message and signal of a lab's DBC has which role for an axis, by likeness of names, units and ranges.
//
// A proposal for the engineer's eye: a DBC does not say what a signal means. `hystcan check` then says which
// functions are lost without the roles that are not found.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/stage/stage_facts.h"
#include "can/dbc/database.h"

namespace hystcan::app {

/// The axes, whose names, drives and travels are known, with their frames: the prefix and the nodes of the
/// standard ones, or the lab's own. No message has two roles. Throws Error if an axis has no setpoint or no
/// position in the DBC; the message lists what is there in these units.
std::vector<AxisFacts> propose_roles(const can::Database& database, std::vector<AxisFacts> axes,
                                     const std::string& file);

/// Some signals may be the enable of the lab's command, and no name says which: the user has to.
bool asks_for_enable(const AxisFacts& axis);
/// Stated in the place of a signal: the command has no enable.
inline constexpr std::string_view no_enable = "none";
/// The enable as the user states it: one of the candidates, or `no_enable`.
void state_enable(AxisFacts& axis, const std::string& signal);

/// A table for the terminal.
std::string table_of(const AxisFacts& axis);

}  // namespace hystcan::app
