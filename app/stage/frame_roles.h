// Which message and signal of a lab's DBC has which role for an axis, by likeness of names, units and ranges.
//
// A proposal for the engineer's eye: a DBC does not say what a signal means. `hystcan check` then says which
// functions are lost without the roles that are not found.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/dbc/database.h"
#include "can/protocol/layout.h"
#include "model/reference_curve.h"

namespace hystcan::app {

struct AxisRoles {
  struct Row {
    std::string role;  ///< "command.setpoint"
    std::string message, signal;
    std::string because;  ///< "mV, set"
  };
  std::string message_prefix;  ///< of the standard frames; empty: `frames`
  std::optional<can::AxisFrames> frames{};
  std::vector<Row> rows;                         ///< of the lab's own frames
  std::vector<std::string> not_found;            ///< roles, and what a DBC cannot say
  std::vector<std::string> enable_candidates{};  ///< signals of the lab's command that may be its enable
  std::optional<int> amplifier_node{}, sensor_node{};  ///< from the identifiers of standard frames
};

struct AxisFacts;

/// One for each axis, whose name, drives and travel are known; no message has two roles. Throws Error
/// if an axis has no setpoint or no position in the DBC; the message lists what is there in these units.
std::vector<AxisRoles> propose_roles(const can::Database& database, const std::vector<AxisFacts>& axes,
                                     const std::string& file);

/// Some signals may be the enable of the lab's command, and no name says which: the user has to.
bool asks_for_enable(const AxisRoles& roles);
/// Stated in the place of a signal: the command has no enable.
inline constexpr std::string_view no_enable = "none";
/// The enable as the user states it: one of the candidates, or `no_enable`.
void state_enable(AxisRoles& roles, const std::string& signal);

/// A table for the terminal.
std::string table_of(const AxisRoles& roles, const std::string& axis);

}  // namespace hystcan::app
