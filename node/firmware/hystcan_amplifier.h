// "What an amplifier node does", docs/protocol/nodes.md. hystcan_node.h describes how to call a node.
#pragma once

#include "hystcan_node.h"

#ifdef __cplusplus
extern "C" {
#endif

enum hystcan_amplifier_state { HYSTCAN_OFF, HYSTCAN_READY, HYSTCAN_ENABLED, HYSTCAN_FAULT };

/// Bits of the fault in the status.
enum { HYSTCAN_COMMANDS_STOPPED = 0x01, HYSTCAN_OUT_OF_RANGE = 0x02, HYSTCAN_INTERNAL_CAUSE = 0x80 };

struct hystcan_amplifier_axis_config {
  // Signals of the command. Without `enable`, a setpoint alone enables; without `sync_counter`, no command is
  // stale.
  struct hystcan_field setpoint, enable, clear_fault, sync_counter;
  const struct hystcan_message* status;       ///< shared by axes with the same message; NULL: no status
  struct hystcan_field output, state, fault;  ///< signals of the status; a larger fault is sent as the
                                              ///< maximum
  uint8_t state_values[4];                    ///< raw values, indexed by enum hystcan_amplifier_state
  int32_t drive_minimum, drive_maximum;       ///< a setpoint outside of this range is a fault
  uint32_t command_timeout;                   ///< the watchdog trips the amplifier after this time
                                              ///< without a command
  uint32_t enable_delay;                      ///< time until the relay at the output has closed
  uint32_t soft_start;                        ///< time after `enable_delay` until the output follows the
                                              ///< setpoints
  uint16_t status_every;                      ///< number of SYNCs per status
};

/// Configuration of an amplifier node. Drives are integers in the unit of the fields `setpoint` and `output`.
struct hystcan_amplifier_config {
  struct hystcan_node_config node;
  const struct hystcan_message* command;
  const struct hystcan_amplifier_axis_config* axes;
  uint8_t axis_count;
  uint32_t cycle;  ///< SYNC period, as set in the controller ("Stale commands")
  /// Writes the drive at a SYNC. The device may interpolate until the next SYNC.
  void (*write)(void* context, unsigned axis, int32_t setpoint);
  /// Closes the relay at the output when enabling begins. May be called while the relay is closed.
  void (*connect)(void* context, unsigned axis);
  /// Moves to the safe drive and opens the relay. If `tripped`, performs the device's watchdog action
  /// instead.
  void (*leave)(void* context, unsigned axis, bool tripped);
  /// Moves the drive at each SYNC of a soft start, along a straight line to the setpoint. `elapsed` /
  /// soft_start is the part of the line that has passed; at 0 the line starts at the present output. NULL if
  /// there is no soft start.
  void (*approach)(void* context, unsigned axis, int32_t setpoint, uint32_t elapsed);
  /// Measures the output.
  int32_t (*output)(void* context, unsigned axis);
};

enum hystcan_enabling { HYSTCAN_NOT_ENABLING, HYSTCAN_RELAY_CLOSES, HYSTCAN_STARTS_SOFTLY };

struct hystcan_amplifier_axis {
  hystcan_time deadline;        ///< latest time for the next command with Enable
  hystcan_time enabling_since;  ///< start of the soft start; before it, the time when the relay has closed
  int32_t setpoint;             ///< takes effect at the next SYNC
  uint32_t sent_counter;        ///< counter of the next status, in the first axis of a message
  uint16_t syncs_since_status;
  uint8_t state;     ///< enum hystcan_amplifier_state
  uint8_t fault;     ///< latched causes
  uint8_t enabling;  ///< enum hystcan_enabling
  bool status_is_due;
  bool has_cause;  ///< true while a cause within the amplifier lasts
  bool is_open;    ///< true while the interlock is open
};

struct hystcan_amplifier {
  const struct hystcan_amplifier_config* config;
  struct hystcan_amplifier_axis* axes;  ///< array of `axis_count` axes
  struct hystcan_node node;
  hystcan_time sync_at;         ///< when the last SYNC arrived
  hystcan_time former_sync_at;  ///< when the SYNC before it arrived
  uint32_t received_counter;    ///< counter of the last accepted command
  uint16_t emergencies[2];      ///< error codes to be sent
  uint8_t emergency_count;
  bool has_former_sync;
  bool has_counter;
};

void hystcan_amplifier_start(struct hystcan_amplifier* amplifier, hystcan_time now);
void hystcan_amplifier_on_frame(struct hystcan_amplifier* amplifier, const struct hystcan_frame* frame,
                                hystcan_time arrival);
/// Serves relay, watchdog and heartbeat.
void hystcan_amplifier_on_time(struct hystcan_amplifier* amplifier, hystcan_time now);
hystcan_time hystcan_amplifier_due(const struct hystcan_amplifier* amplifier);
/// Begins (`lasts`) or ends (not `lasts`) a cause within the amplifier, such as its temperature. `code`: the
/// error code of the emergency, 0x5000 or a more exact code of CiA 301.
void hystcan_amplifier_set_cause(struct hystcan_amplifier* amplifier, unsigned axis, bool lasts,
                                 uint16_t code);
/// Sets the interlock. While it is open, the axis is disabled and ignores Enable. An open interlock is not a
/// fault.
void hystcan_amplifier_set_interlock(struct hystcan_amplifier* amplifier, unsigned axis, bool is_open);

#ifdef __cplusplus
}
#endif
