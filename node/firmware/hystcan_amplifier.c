#include "hystcan_amplifier.h"

#include <stddef.h>

// Identifier and error codes of emergencies (docs/protocol/nodes.md, "Faults of an amplifier")
enum { EMERGENCY = 0x080, CLEARED = 0x0000, DATA_SET = 0x6300, LIFE_GUARD = 0x8130 };

/// Checks a command frame. Returns false if its kind, length or CRC is wrong, or if its counter is repeated:
/// the node ignores such a frame.
static bool accept(struct hystcan_amplifier* amplifier, const struct hystcan_frame* frame) {
  const struct hystcan_message* message = amplifier->config->command;
  if (!hystcan_is_intact(message, frame)) return false;
  const uint32_t counter = hystcan_get_raw(&message->counter, frame->data);
  const bool is_repeated =
      message->counter.length != 0 && amplifier->has_counter && counter == amplifier->received_counter;
  amplifier->has_counter = true;
  amplifier->received_counter = counter;
  return !is_repeated;
}

static void note_emergency(struct hystcan_amplifier* amplifier, uint16_t code) {
  for (unsigned i = 0; i < amplifier->emergency_count; ++i)
    if (amplifier->emergencies[i] == code) return;
  amplifier->emergencies[amplifier->emergency_count++] = code;
}

HYSTCAN_OUT_OF_LINE static void send_emergencies(struct hystcan_amplifier* amplifier) {
  const struct hystcan_amplifier_config* config = amplifier->config;
  bool is_faulted = false;
  for (unsigned i = 0; i < config->axis_count; ++i) is_faulted = is_faulted || amplifier->axes[i].fault != 0;
  for (unsigned i = 0; i < amplifier->emergency_count; ++i) {
    const uint16_t code = amplifier->emergencies[i];
    const uint8_t error_register = is_faulted ? 0x01 : 0x00;  // bit 0: generic error
    const struct hystcan_frame frame = {.id = EMERGENCY + (uint32_t)config->node.number,
                                        .length = 8,
                                        .data = {(uint8_t)code, (uint8_t)(code >> 8), error_register}};
    config->node.send(config->node.context, &frame);
  }
  amplifier->emergency_count = 0;
}

/// Sends the status message of the axis `first`. The message also contains the signals of every later axis
/// that shares the message.
HYSTCAN_OUT_OF_LINE static void send_status(struct hystcan_amplifier* amplifier, unsigned first) {
  const struct hystcan_amplifier_config* config = amplifier->config;
  const struct hystcan_message* message = config->axes[first].status;
  struct hystcan_frame frame;
  hystcan_make_frame(message, &frame);
  bool fits = true;
  for (unsigned i = first; i < config->axis_count; ++i) {
    const struct hystcan_amplifier_axis_config* axis = &config->axes[i];
    if (axis->status != message) continue;
    const int32_t fault = amplifier->axes[i].fault;
    if (!hystcan_put_value(&axis->output, config->output(config->node.context, i), frame.data)) fits = false;
    hystcan_put_raw(&axis->state, axis->state_values[amplifier->axes[i].state], frame.data);
    hystcan_put_value(&axis->fault, fault > axis->fault.maximum ? axis->fault.maximum : fault, frame.data);
  }
  if (fits && !hystcan_node_is_silent(&amplifier->node))
    hystcan_node_send(&config->node, message, &frame, &amplifier->axes[first].sent_counter);
}

/// Sends the waiting emergencies, then every status that is due.
static void report(struct hystcan_amplifier* amplifier) {
  const struct hystcan_amplifier_config* config = amplifier->config;
  send_emergencies(amplifier);
  for (unsigned first = 0; first < config->axis_count; ++first) {
    const struct hystcan_message* message = config->axes[first].status;
    bool is_first = message != NULL, is_due = false;
    for (unsigned i = 0; i < first; ++i) is_first = is_first && config->axes[i].status != message;
    for (unsigned i = first; is_first && i < config->axis_count; ++i)
      is_due = is_due || (config->axes[i].status == message && amplifier->axes[i].status_is_due);
    if (!is_due) continue;
    send_status(amplifier, first);
    for (unsigned i = first; i < config->axis_count; ++i)
      if (config->axes[i].status == message) amplifier->axes[i].status_is_due = true;
  }
  for (unsigned i = 0; i < config->axis_count; ++i) {
    if (amplifier->axes[i].status_is_due) amplifier->axes[i].syncs_since_status = 0;
    amplifier->axes[i].status_is_due = false;
  }
}

static void leave_drive(struct hystcan_amplifier* amplifier, unsigned i, bool tripped) {
  amplifier->axes[i].enabling = HYSTCAN_NOT_ENABLING;
  amplifier->config->leave(amplifier->config->node.context, i, tripped);
}

/// Sets the state of an axis. Each change of the state makes a status due.
static void become(struct hystcan_amplifier_axis* axis, enum hystcan_amplifier_state state) {
  if (state == axis->state) return;
  axis->state = (uint8_t)state;
  axis->status_is_due = true;
}

/// Moves the output of axis `i` to its safe value and enters `state`: every state except HYSTCAN_ENABLED.
static void enter_safe(struct hystcan_amplifier* amplifier, unsigned i, enum hystcan_amplifier_state state) {
  leave_drive(amplifier, i, false);
  become(&amplifier->axes[i], state);
}

/// Latches a fault of axis `i` and makes an emergency with this error code due (docs/protocol/nodes.md,
/// "Faults of an amplifier").
static void trip(struct hystcan_amplifier* amplifier, unsigned i, uint8_t fault, uint16_t code) {
  amplifier->axes[i].fault |= fault;
  note_emergency(amplifier, code);
  leave_drive(amplifier, i, fault == HYSTCAN_COMMANDS_STOPPED);
  become(&amplifier->axes[i], HYSTCAN_FAULT);
}

/// Enables axis `i` when its relay has closed and its soft start has ended. If the deadline for the next
/// command with Enable has passed, the axis is not enabled (docs/protocol/nodes.md, "Enabling").
static void begin_to_drive(struct hystcan_amplifier* amplifier, unsigned i, hystcan_time now) {
  struct hystcan_amplifier_axis* axis = &amplifier->axes[i];
  if (now >= axis->deadline) {
    leave_drive(amplifier, i, false);
    return;
  }
  axis->enabling = HYSTCAN_NOT_ENABLING;
  become(axis, HYSTCAN_ENABLED);
}

/// Continues enabling axis `i` when its relay has closed: begins the soft start, if there is one.
static void on_relay(struct hystcan_amplifier* amplifier, unsigned i, hystcan_time now) {
  const struct hystcan_amplifier_config* config = amplifier->config;
  struct hystcan_amplifier_axis* axis = &amplifier->axes[i];
  if (config->axes[i].soft_start == 0) {
    begin_to_drive(amplifier, i, now);
    return;
  }
  axis->enabling = HYSTCAN_STARTS_SOFTLY;
  axis->enabling_since = now;
  config->approach(config->node.context, i, axis->setpoint, 0);
}

static void begin_to_enable(struct hystcan_amplifier* amplifier, unsigned i, hystcan_time now) {
  struct hystcan_amplifier_axis* axis = &amplifier->axes[i];
  if (axis->is_open || axis->enabling != HYSTCAN_NOT_ENABLING) return;
  axis->enabling = HYSTCAN_RELAY_CLOSES;
  axis->enabling_since = now + amplifier->config->axes[i].enable_delay;
  amplifier->config->connect(amplifier->config->node.context, i);
  if (now >= axis->enabling_since) on_relay(amplifier, i, now);
}

static void start_softly(struct hystcan_amplifier* amplifier, unsigned i, hystcan_time now) {
  const struct hystcan_amplifier_config* config = amplifier->config;
  struct hystcan_amplifier_axis* axis = &amplifier->axes[i];
  const hystcan_time elapsed = now - axis->enabling_since;
  if (now >= axis->deadline || elapsed >= config->axes[i].soft_start)
    begin_to_drive(amplifier, i, now);
  else
    config->approach(config->node.context, i, axis->setpoint, (uint32_t)elapsed);
}

/// Returns true if a command is too old to be obeyed (docs/protocol/nodes.md, "Stale commands"). `named`: the
/// SYNC counter in the command. `switches_off`: the command has neither Enable nor ClearFault.
static bool is_stale(const struct hystcan_amplifier* amplifier, uint32_t named, bool switches_off,
                     hystcan_time now) {
  const uint8_t last_sync = amplifier->node.last_sync;
  if (last_sync == 0 || named == 0 || named > HYSTCAN_SYNC_COUNTER_MAX) return true;
  const uint32_t syncs_since = (last_sync + HYSTCAN_SYNC_COUNTER_MAX - named) % HYSTCAN_SYNC_COUNTER_MAX;
  if (syncs_since > 1) return true;
  if (switches_off) return false;
  if (syncs_since == 1 && !amplifier->has_former_sync) return true;
  const hystcan_time named_at = syncs_since == 0 ? amplifier->sync_at : amplifier->former_sync_at;
  return now - named_at > 2 * (hystcan_time)amplifier->config->cycle;
}

/// Obeys a command for axis `i` (docs/protocol/nodes.md, "What an amplifier node does", the table of Enable
/// and ClearFault). The caller must have refused commands that are too old.
static void obey(struct hystcan_amplifier* amplifier, unsigned i, bool enable, bool clear, int32_t setpoint,
                 hystcan_time now) {
  const struct hystcan_amplifier_axis_config* config = &amplifier->config->axes[i];
  struct hystcan_amplifier_axis* axis = &amplifier->axes[i];
  if (axis->state == HYSTCAN_FAULT) {  // a command that clears a fault does not enable
    if (!clear || axis->has_cause) return;
    axis->fault = 0;
    note_emergency(amplifier, CLEARED);
    enter_safe(amplifier, i, HYSTCAN_READY);
  } else if (!enable) {
    enter_safe(amplifier, i, HYSTCAN_READY);  // immediately, not at the next SYNC
  } else if (setpoint < config->drive_minimum || setpoint > config->drive_maximum) {
    trip(amplifier, i, HYSTCAN_OUT_OF_RANGE, DATA_SET);
  } else {
    axis->setpoint = setpoint;
    axis->deadline = now + config->command_timeout;
    if (axis->state != HYSTCAN_ENABLED) begin_to_enable(amplifier, i, now);
  }
}

static void on_command(struct hystcan_amplifier* amplifier, unsigned i, const uint8_t* data,
                       hystcan_time now) {
  const struct hystcan_amplifier_axis_config* config = &amplifier->config->axes[i];
  const bool enable = config->enable.length == 0 || hystcan_get_raw(&config->enable, data) != 0;
  const bool clear = hystcan_get_raw(&config->clear_fault, data) != 0;
  if (config->sync_counter.length == 0 ||
      !is_stale(amplifier, hystcan_get_raw(&config->sync_counter, data), !enable && !clear, now))
    obey(amplifier, i, enable, clear, hystcan_get_value(&config->setpoint, data), now);
}

/// Sends each status whose last transmission was `status_every` SYNCs ago (docs/protocol/nodes.md, "Status").
/// If nodes have slots, sends only the status that has waited the longest.
static void report_regularly(struct hystcan_amplifier* amplifier) {
  const struct hystcan_amplifier_config* config = amplifier->config;
  unsigned oldest = 0;
  for (unsigned i = 1; i < config->axis_count; ++i)
    if (amplifier->axes[i].syncs_since_status > amplifier->axes[oldest].syncs_since_status) oldest = i;
  for (unsigned i = 0; i < config->axis_count; ++i)
    if ((config->node.slots == 0 || i == oldest) &&
        amplifier->axes[i].syncs_since_status >= config->axes[i].status_every)
      amplifier->axes[i].status_is_due = true;
  report(amplifier);
}

static void on_sync(struct hystcan_amplifier* amplifier, uint8_t sync, hystcan_time now) {
  const struct hystcan_amplifier_config* config = amplifier->config;
  const uint8_t last_sync = amplifier->node.last_sync;
  if (sync != last_sync) {
    amplifier->has_former_sync = last_sync != 0 && sync == last_sync % HYSTCAN_SYNC_COUNTER_MAX + 1;
    amplifier->former_sync_at = amplifier->sync_at;
  }
  amplifier->sync_at = now;
  amplifier->node.last_sync = sync;
  for (unsigned i = 0; i < config->axis_count; ++i) {
    struct hystcan_amplifier_axis* axis = &amplifier->axes[i];
    if (axis->state == HYSTCAN_ENABLED) config->write(config->node.context, i, axis->setpoint);
    if (axis->enabling == HYSTCAN_STARTS_SOFTLY) start_softly(amplifier, i, now);
  }
  report(amplifier);
  const bool may_report = hystcan_node_take_slot(&config->node, &amplifier->node, now);
  if (amplifier->node.state != HYSTCAN_OPERATIONAL) return;
  for (unsigned i = 0; i < config->axis_count; ++i)
    if (amplifier->axes[i].syncs_since_status < UINT16_MAX) ++amplifier->axes[i].syncs_since_status;
  if (may_report) report_regularly(amplifier);
}

/// Changes the states of all axes after an NMT command (docs/protocol/cycle.md, "Node life"). Every NMT
/// command except start leads to HYSTCAN_OFF. A node that boots up sends no status.
static void on_nmt(struct hystcan_amplifier* amplifier, enum hystcan_change change) {
  const bool is_operational = amplifier->node.state == HYSTCAN_OPERATIONAL;
  if (is_operational) amplifier->has_counter = false;
  for (unsigned i = 0; i < amplifier->config->axis_count; ++i) {
    struct hystcan_amplifier_axis* axis = &amplifier->axes[i];
    if (change == HYSTCAN_NODE_RESET) axis->fault = axis->has_cause ? HYSTCAN_INTERNAL_CAUSE : 0;
    if (change != HYSTCAN_STATE_CHANGED) {
      axis->state = HYSTCAN_OFF;
      axis->syncs_since_status = 0;
      axis->sent_counter = 0;
    }
    enter_safe(amplifier, i,
               !is_operational    ? HYSTCAN_OFF
               : axis->fault != 0 ? HYSTCAN_FAULT
                                  : HYSTCAN_READY);
  }
  report(amplifier);
}

void hystcan_amplifier_start(struct hystcan_amplifier* amplifier, hystcan_time now) {
  if (amplifier->node.is_taken) return;
  on_nmt(amplifier,
         hystcan_node_boot_up(&amplifier->config->node, &amplifier->node, HYSTCAN_NODE_RESET, now));
}

void hystcan_amplifier_on_frame(struct hystcan_amplifier* amplifier, const struct hystcan_frame* frame,
                                hystcan_time arrival) {
  const struct hystcan_amplifier_config* config = amplifier->config;
  struct hystcan_node* node = &amplifier->node;
  const uint8_t sync = hystcan_sync_counter(frame);
  if (frame->id == config->command->id) {
    if (node->state != HYSTCAN_OPERATIONAL || !accept(amplifier, frame)) return;
    for (unsigned i = 0; i < config->axis_count; ++i) on_command(amplifier, i, frame->data, arrival);
    report(amplifier);
  } else if (sync != 0) {
    on_sync(amplifier, sync, arrival);
  } else {
    const enum hystcan_change change = hystcan_node_handle(&config->node, node, frame, arrival);
    if (change != HYSTCAN_NOTHING) on_nmt(amplifier, change);
  }
}

/// Trips each enabled axis whose commands have stopped (docs/protocol/nodes.md, "Watchdog"). Continues
/// enabling each axis whose relay has closed. Sends the heartbeat if it is due.
void hystcan_amplifier_on_time(struct hystcan_amplifier* amplifier, hystcan_time now) {
  for (unsigned i = 0; i < amplifier->config->axis_count; ++i) {
    struct hystcan_amplifier_axis* axis = &amplifier->axes[i];
    if (axis->enabling == HYSTCAN_RELAY_CLOSES && now >= axis->enabling_since) on_relay(amplifier, i, now);
    if (axis->state == HYSTCAN_ENABLED && now >= axis->deadline)
      trip(amplifier, i, HYSTCAN_COMMANDS_STOPPED, LIFE_GUARD);
  }
  report(amplifier);
  hystcan_node_beat(&amplifier->config->node, &amplifier->node, now);
}

hystcan_time hystcan_amplifier_due(const struct hystcan_amplifier* amplifier) {
  hystcan_time due = hystcan_node_due(&amplifier->node);
  for (unsigned i = 0; i < amplifier->config->axis_count; ++i) {
    const struct hystcan_amplifier_axis* axis = &amplifier->axes[i];
    if (axis->enabling == HYSTCAN_RELAY_CLOSES && axis->enabling_since < due) due = axis->enabling_since;
    if (axis->state == HYSTCAN_ENABLED && axis->deadline < due) due = axis->deadline;
  }
  return due;
}

void hystcan_amplifier_set_cause(struct hystcan_amplifier* amplifier, unsigned axis, bool lasts,
                                 uint16_t code) {
  amplifier->axes[axis].has_cause = lasts;
  if (!lasts) return;
  if (amplifier->node.state == HYSTCAN_OPERATIONAL)
    trip(amplifier, axis, HYSTCAN_INTERNAL_CAUSE, code);
  else  // a node that is not operational reports the fault later, after NMT start
    amplifier->axes[axis].fault |= HYSTCAN_INTERNAL_CAUSE;
  report(amplifier);
}

void hystcan_amplifier_set_interlock(struct hystcan_amplifier* amplifier, unsigned axis, bool is_open) {
  const uint8_t state = amplifier->axes[axis].state;
  amplifier->axes[axis].is_open = is_open;
  if (!is_open || (state != HYSTCAN_ENABLED && state != HYSTCAN_READY)) return;
  enter_safe(amplifier, axis, HYSTCAN_READY);
  report(amplifier);
}
