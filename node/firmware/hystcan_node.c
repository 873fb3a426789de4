#include "hystcan_node.h"

#include <stddef.h>

// ---- Identifiers of frames (docs/protocol/frames.md, "Messages")

enum { NMT_ID = 0x000, SYNC_ID = 0x080, SDO_RESPONSE = 0x580, SDO_REQUEST = 0x600 };
enum { HEARTBEAT = 0x700 };

static bool is_classical(const struct hystcan_frame* frame, uint8_t length) {
  return frame->kind == HYSTCAN_DATA && !frame->extended && frame->length == length;
}

// ---- Counter and CRC (docs/protocol/frames.md, "Counter and CRC")

void hystcan_node_send(const struct hystcan_node_config* config, const struct hystcan_message* message,
                       struct hystcan_frame* frame, uint32_t* counter) {
  hystcan_seal(message, (*counter)++, frame);
  config->send(config->context, frame);
}

// ---- The SDO server (docs/protocol/cycle.md, "SDO")

enum { SDO_READ = 0x40, SDO_WRITE = 0x23, SDO_VALUE = 0x43, SDO_WRITTEN = 0x60, SDO_ABORT = 0x80 };
static const uint32_t OUT_OF_MEMORY = 0x05040005, NO_SUCH_OBJECT = 0x06020000, WRONG_LENGTH = 0x06070010;

/// Stores an object that a client has written. `found`: the stored object with the same index, or NULL.
/// Returns the abort code, or 0 if the write succeeded.
static uint32_t write_object(const struct hystcan_node_config* config, struct hystcan_node* node,
                             struct hystcan_object* found, const struct hystcan_object* written) {
  if (found != NULL && found->bytes != written->bytes) return WRONG_LENGTH;
  if (written->index < 0x2000 || written->index > 0x5FFF) return NO_SUCH_OBJECT;
  if (found == NULL) {
    if (node->object_count == config->capacity) return OUT_OF_MEMORY;
    found = &config->objects[node->object_count++];
  }
  *found = *written;
  return 0;
}

HYSTCAN_OUT_OF_LINE static void answer(const struct hystcan_node_config* config, struct hystcan_node* node,
                                       const struct hystcan_frame* request) {
  const uint8_t* data = request->data;
  const bool writes = (data[0] & 0xF3) == SDO_WRITE;
  if (!is_classical(request, 8) || (!writes && data[0] != SDO_READ)) return;
  struct hystcan_object object = {.index = (uint16_t)(data[1] | data[2] << 8),
                                  .subindex = data[3],
                                  .bytes = (uint8_t)(4 - (data[0] >> 2 & 3))};
  for (unsigned i = 0; i < object.bytes; ++i) object.value |= (uint32_t)data[4 + i] << 8 * i;
  struct hystcan_object* found = NULL;
  for (unsigned i = 0; i < node->object_count; ++i)
    if (config->objects[i].index == object.index && config->objects[i].subindex == object.subindex)
      found = &config->objects[i];
  struct hystcan_frame response = {.id = SDO_RESPONSE + (uint32_t)config->number,
                                   .length = 8,
                                   .data = {SDO_WRITTEN, data[1], data[2], data[3]}};
  uint32_t content = 0;
  const uint32_t abort_code = writes          ? write_object(config, node, found, &object)
                              : found == NULL ? NO_SUCH_OBJECT
                                              : 0;
  if (abort_code != 0) {
    response.data[0] = SDO_ABORT;
    content = abort_code;
  } else if (!writes) {
    response.data[0] = (uint8_t)(SDO_VALUE | (4 - found->bytes) << 2);
    content = found->value;
  }
  for (unsigned i = 0; i < 4; ++i) response.data[4 + i] = (uint8_t)(content >> 8 * i);
  config->send(config->context, &response);
}

// ---- NMT and heartbeat (docs/protocol/cycle.md, "Node life")

enum {
  NMT_START = 1,
  NMT_STOP = 2,
  NMT_ENTER_PRE_OPERATIONAL = 128,
  NMT_RESET_NODE = 129,
  NMT_RESET_COMMUNICATION = 130
};

HYSTCAN_OUT_OF_LINE static void send_heartbeat(const struct hystcan_node_config* config, uint8_t state) {
  const struct hystcan_frame frame = {
      .id = HEARTBEAT + (uint32_t)config->number, .length = 1, .data = {state}};
  config->send(config->context, &frame);
}

static enum hystcan_change enter_nmt(struct hystcan_node* node, uint8_t state) {
  if (state == node->state) return HYSTCAN_NOTHING;
  node->state = state;
  return HYSTCAN_STATE_CHANGED;
}

enum hystcan_change hystcan_node_boot_up(const struct hystcan_node_config* config, struct hystcan_node* node,
                                         enum hystcan_change reset, hystcan_time now) {
  node->is_started = true;
  node->last_sync = 0;
  node->heartbeat_waits = false;
  if (reset == HYSTCAN_NODE_RESET) node->object_count = 0;
  node->state = HYSTCAN_PRE_OPERATIONAL;
  send_heartbeat(config, HYSTCAN_BOOT_UP);
  node->heartbeat_due = now + config->heartbeat_period;
  return reset;
}

static enum hystcan_change obey_nmt(const struct hystcan_node_config* config, struct hystcan_node* node,
                                    const struct hystcan_frame* frame, hystcan_time now) {
  if (!is_classical(frame, 2) || (frame->data[1] != 0 && frame->data[1] != config->number))
    return HYSTCAN_NOTHING;
  switch (frame->data[0]) {
    case NMT_START:
      return enter_nmt(node, HYSTCAN_OPERATIONAL);
    case NMT_STOP:
      return enter_nmt(node, HYSTCAN_STOPPED);
    case NMT_ENTER_PRE_OPERATIONAL:
      return enter_nmt(node, HYSTCAN_PRE_OPERATIONAL);
    case NMT_RESET_NODE:
      return hystcan_node_boot_up(config, node, HYSTCAN_NODE_RESET, now);
    case NMT_RESET_COMMUNICATION:
      return hystcan_node_boot_up(config, node, HYSTCAN_COMMUNICATION_RESET, now);
    default:
      return HYSTCAN_NOTHING;
  }
}

/// Returns true if the frame is a heartbeat of another node with the same number (docs/protocol/bus.md, "Two
/// controllers or two twins on one bus"). Its state must be a valid NMT state.
static bool is_of_namesake(const struct hystcan_node_config* config, const struct hystcan_frame* frame) {
  if (frame->id != HEARTBEAT + (uint32_t)config->number || !is_classical(frame, 1)) return false;
  const uint8_t state = frame->data[0];
  return state == HYSTCAN_BOOT_UP || state == HYSTCAN_STOPPED || state == HYSTCAN_OPERATIONAL ||
         state == HYSTCAN_PRE_OPERATIONAL;
}

bool hystcan_node_is_silent(const struct hystcan_node* node) { return !node->is_started || node->is_taken; }

enum hystcan_change hystcan_node_handle(const struct hystcan_node_config* config, struct hystcan_node* node,
                                        const struct hystcan_frame* frame, hystcan_time now) {
  if (is_of_namesake(config, frame)) {
    node->is_taken = true;
    return enter_nmt(node, HYSTCAN_STOPPED);
  }
  if (hystcan_node_is_silent(node)) return HYSTCAN_NOTHING;
  if (frame->id == NMT_ID) return obey_nmt(config, node, frame, now);
  if (frame->id == SDO_REQUEST + (uint32_t)config->number && node->state != HYSTCAN_STOPPED)
    answer(config, node, frame);
  return HYSTCAN_NOTHING;
}

uint8_t hystcan_sync_counter(const struct hystcan_frame* frame) {
  const bool is_sync =
      frame->id == SYNC_ID && is_classical(frame, 1) && frame->data[0] <= HYSTCAN_SYNC_COUNTER_MAX;
  return is_sync ? frame->data[0] : 0;
}

void hystcan_node_beat(const struct hystcan_node_config* config, struct hystcan_node* node,
                       hystcan_time now) {
  if (hystcan_node_is_silent(node) || now < node->heartbeat_due) return;
  node->heartbeat_waits = node->has_seen_slot && now - node->last_slot < config->heartbeat_period;
  if (!node->heartbeat_waits) send_heartbeat(config, node->state);
  // Skips the heartbeats that became due while the caller did not call the node.
  do node->heartbeat_due += config->heartbeat_period;
  while (node->heartbeat_due <= now);
}

bool hystcan_node_take_slot(const struct hystcan_node_config* config, struct hystcan_node* node,
                            hystcan_time now) {
  if (config->slots == 0) return true;
  if (node->last_sync % config->slots != config->number % config->slots) return false;
  if (hystcan_node_is_silent(node)) return true;
  node->has_seen_slot = true;
  node->last_slot = now;
  if (!node->heartbeat_waits) return true;
  node->heartbeat_waits = false;
  send_heartbeat(config, node->state);
  return false;
}

hystcan_time hystcan_node_due(const struct hystcan_node* node) {
  return hystcan_node_is_silent(node) ? HYSTCAN_NEVER : node->heartbeat_due;
}
