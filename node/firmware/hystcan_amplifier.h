// The amplifier node as firmware (docs/protocol/nodes.md, "What an amplifier node does"). hystcan_node.h
// describes how to call a node.
#pragma once

#include "hystcan_node.h"

#ifdef __cplusplus
extern "C" {
#endif

enum hystcan_amplifier_state { HYSTCAN_OFF, HYSTCAN_READY, HYSTCAN_ENABLED, HYSTCAN_FAULT };

/// Bits of the signal `fault` in the status.
enum { HYSTCAN_COMMANDS_STOPPED = 0x01, HYSTCAN_OUT_OF_RANGE = 0x02, HYSTCAN_INTERNAL_CAUSE = 0x80 };

struct hystcan_amplifier_axis_config {
  // Signals of the command. If the command has no signal `enable`, each command enables the amplifier. If the
  // command has no signal `sync_counter`, the amplifier does not detect commands that are too old.
  struct hystcan_field setpoint, enable, clear_fault, sync_counter;
  const struct hystcan_message* status;       ///< status message; axes with the same pointer share one
                                              ///< message; NULL: the axis has no status
  struct hystcan_field output, state, fault;  ///< signals of the status; a fault above fault.maximum is sent
                                              ///< as this maximum
  uint8_t state_values[4];                    ///< raw value of the signal `state` for each state; the index
                                              ///< is an enum hystcan_amplifier_state
  int32_t drive_minimum, drive_maximum;       ///< range of setpoints; a setpoint outside the range trips the
                                              ///< axis
  uint32_t command_timeout;                   ///< the watchdog trips the amplifier after this time
                                              ///< without a command
  uint32_t enable_delay;                      ///< time from the command Enable until the relay at the output
                                              ///< has closed
  uint32_t soft_start;                        ///< time after `enable_delay` until the output follows the
                                              ///< setpoints
  uint16_t status_every;                      ///< number of SYNCs from one regular status to the next
};

/// Configuration of an amplifier node. Setpoints and outputs are integers, in the unit of the fields
/// `setpoint` and `output`.
struct hystcan_amplifier_config {
  struct hystcan_node_config node;
  const struct hystcan_message* command;
  const struct hystcan_amplifier_axis_config* axes;
  uint8_t axis_count;
  /// SYNC period of the controller, in the unit of hystcan_time. A command with Enable or ClearFault is
  /// ignored if the SYNC whose counter is in the command arrived more than two periods ago.
  uint32_t cycle;
  /// Sets the output of an axis to the setpoint. Called at each SYNC. The device may interpolate until the
  /// next SYNC.
  void (*write)(void* context, unsigned axis, int32_t setpoint);
  /// Closes the relay at the output of an axis. Called when enabling begins, also if the relay is still
  /// closed.
  void (*connect)(void* context, unsigned axis);
  /// Moves the output of an axis to the safe value and opens its relay. If `tripped` (the watchdog has
  /// tripped), performs the watchdog action of the device instead.
  void (*leave)(void* context, unsigned axis, bool tripped);
  /// Moves the output of an axis during a soft start along a straight line to the setpoint. Called at each
  /// SYNC. `elapsed`: time since the soft start began. At this time, the output must have passed the share
  /// `elapsed` / `soft_start` of the line (`soft_start`: configured duration of the soft start). If `elapsed`
  /// is 0, the line begins at the present output. NULL if there is no soft start.
  void (*approach)(void* context, unsigned axis, int32_t setpoint, uint32_t elapsed);
  /// Measures the output of an axis and returns it, in the unit of the field `output`.
  int32_t (*output)(void* context, unsigned axis);
};

enum hystcan_enabling { HYSTCAN_NOT_ENABLING, HYSTCAN_RELAY_CLOSES, HYSTCAN_STARTS_SOFTLY };

struct hystcan_amplifier_axis {
  hystcan_time deadline;        ///< time at which the watchdog trips if no command with Enable arrives before
  hystcan_time enabling_since;  ///< time at which the relay will have closed, if `enabling` is
                                ///< HYSTCAN_RELAY_CLOSES; start of the soft start, if `enabling`
                                ///< is HYSTCAN_STARTS_SOFTLY
  int32_t setpoint;             ///< last commanded setpoint; the output gets it at the next SYNC
  uint32_t sent_counter;        ///< counter of the next status message; if several axes share the message,
                                ///< only the `sent_counter` of the first of them is used
  uint16_t syncs_since_status;
  uint8_t state;     ///< state of the amplifier, an enum hystcan_amplifier_state
  uint8_t fault;     ///< bits of the faults that are latched
  uint8_t enabling;  ///< progress of enabling, an enum hystcan_enabling
  bool status_is_due;
  bool has_cause;  ///< true while the cause of a fault within the amplifier exists
  bool is_open;    ///< true while the interlock of the axis is open
};

struct hystcan_amplifier {
  const struct hystcan_amplifier_config* config;
  struct hystcan_amplifier_axis* axes;  ///< array of `axis_count` axes
  struct hystcan_node node;
  hystcan_time sync_at;         ///< time at which the last SYNC arrived
  hystcan_time former_sync_at;  ///< arrival time of the SYNC before the last SYNC; valid if has_former_sync
  uint32_t received_counter;    ///< counter of the last intact command frame; valid if has_counter
  uint16_t emergencies[2];      ///< error codes of emergencies that are not sent yet
  uint8_t emergency_count;
  bool has_former_sync;
  bool has_counter;
};

void hystcan_amplifier_start(struct hystcan_amplifier* amplifier, hystcan_time now);
void hystcan_amplifier_on_frame(struct hystcan_amplifier* amplifier, const struct hystcan_frame* frame,
                                hystcan_time arrival);
/// Checks relay and watchdog of each axis, and sends the heartbeat if it is due.
void hystcan_amplifier_on_time(struct hystcan_amplifier* amplifier, hystcan_time now);
hystcan_time hystcan_amplifier_due(const struct hystcan_amplifier* amplifier);
/// Reports to the node that a fault within the amplifier has begun (`lasts` is true), for example a high
/// temperature, or that it has ended (`lasts` is false). `code`: error code of the emergency, 0x5000 or a
/// more exact code of CiA 301.
void hystcan_amplifier_set_cause(struct hystcan_amplifier* amplifier, unsigned axis, bool lasts,
                                 uint16_t code);
/// Reports to the node whether the interlock of an axis is open. While the interlock is open, the axis is
/// disabled and ignores the command Enable. An open interlock is not a fault.
void hystcan_amplifier_set_interlock(struct hystcan_amplifier* amplifier, unsigned axis, bool is_open);

#ifdef __cplusplus
}
#endif
