// The common part of the amplifier node and the sensor node as firmware: NMT, heartbeat, SDO server and slots
// (docs/protocol/cycle.md, "Node life", "SDO" and "Background slots").
//
// hystcan_amplifier.h is an amplifier node and hystcan_sensor.h is a sensor node that follow docs/protocol.
// They are written in C11 and need no operating system, heap, floating point or C library (except memset and
// memcpy, which compilers call implicitly).
//
// The caller owns the bus, the clock and the device. It zeroes a node, sets its configuration and starts it.
// Then it passes each received frame to the node, and calls the node at the times that the node requests:
//
//   static struct hystcan_sensor sensor = {.config = &config};
//   hystcan_sensor_start(&sensor, now);
//   hystcan_sensor_on_frame(&sensor, &frame, arrival);   each received frame
//   hystcan_sensor_on_time(&sensor, now);                at hystcan_sensor_due(), or every millisecond
//
// A node processes these frames: NMT (0x000), SYNC (0x080), heartbeats (0x700 + number of the node) and SDO
// requests (0x600 + number of the node). An amplifier also processes its command. A node ignores every other
// frame. No function is reentrant: call all functions from one thread, or from interrupts of one priority.
//
// A device with several axes is one node. The parameter `axis` of its functions counts the axes from 0.
//
// main_socketcan.c is an example of a caller. The tests in tests/node check that these nodes behave like the
// nodes of the twin.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "hystcan_frame.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A time by the caller's clock. The caller chooses one unit, such as 1 us, for all times and durations. The
/// type has 64 bits so that it never overflows: the age of an old SYNC never becomes small again.
typedef uint64_t hystcan_time;
#define HYSTCAN_NEVER UINT64_MAX

/// An entry of the node's object dictionary. The controller writes its value by SDO.
struct hystcan_object {
  uint16_t index;
  uint8_t subindex;
  uint8_t bytes;
  uint32_t value;
};

struct hystcan_node_config {
  uint8_t number;  ///< node id, 1..127
  uint8_t slots;   ///< number of cycles from one slot of the node to its next slot; the node sends
                   ///< heartbeats and regular statuses only in its slots; 0: it sends them at any time
  uint8_t capacity;
  struct hystcan_object* objects;  ///< array with space for `capacity` objects
  uint32_t heartbeat_period;
  void* context;  ///< the node passes this pointer to all functions of the caller
  /// Passes the frame to the bus without waiting. A frame that the bus does not accept is dropped.
  void (*send)(void* context, const struct hystcan_frame* frame);
};

enum hystcan_nmt {
  HYSTCAN_BOOT_UP = 0,
  HYSTCAN_STOPPED = 4,
  HYSTCAN_OPERATIONAL = 5,
  HYSTCAN_PRE_OPERATIONAL = 127
};

struct hystcan_node {
  hystcan_time heartbeat_due;
  hystcan_time last_slot;
  uint8_t state;      ///< NMT state, an enum hystcan_nmt
  uint8_t last_sync;  ///< counter of the last SYNC; 0: no SYNC since the boot-up
  uint8_t object_count;
  bool is_started;
  bool is_taken;  ///< true if another node on the bus has this number: this node is then off and silent
  bool has_seen_slot;
  bool heartbeat_waits;  ///< true while a heartbeat waits for its slot
};

// ---- The rest of this file is only for hystcan_amplifier.c and hystcan_sensor.c

/// The effect of a received frame on the NMT state of a node. The amplifier node and the sensor node must
/// change the states of their axes accordingly.
enum hystcan_change {
  HYSTCAN_NOTHING,
  HYSTCAN_STATE_CHANGED,
  HYSTCAN_NODE_RESET,
  HYSTCAN_COMMUNICATION_RESET
};

/// Marks functions that have a frame on the stack. If the compiler inlined such a function, its caller would
/// keep the frame on the stack while it calls other functions. The node would then need more stack.
#ifdef __GNUC__
#define HYSTCAN_OUT_OF_LINE __attribute__((noinline))
#else
#define HYSTCAN_OUT_OF_LINE
#endif

/// Boots the node up: sends the boot-up message and becomes pre-operational. `reset` is the kind of reset
/// that caused the boot-up; the function returns this value.
enum hystcan_change hystcan_node_boot_up(const struct hystcan_node_config* config, struct hystcan_node* node,
                                         enum hystcan_change reset, hystcan_time now);
/// Processes a received frame: an NMT command, an SDO request to this node, or a heartbeat. A heartbeat with
/// the number of this node means that another node has the same number. This node then becomes silent.
/// Returns the effect on the NMT state.
enum hystcan_change hystcan_node_handle(const struct hystcan_node_config* config, struct hystcan_node* node,
                                        const struct hystcan_frame* frame, hystcan_time now);
/// Returns true before the node is started, and if another node on the bus has the same number.
bool hystcan_node_is_silent(const struct hystcan_node* node);
/// Sends the heartbeat if it is due. If nodes have slots (cycles in which a node may send heartbeats and
/// regular statuses), the heartbeat waits for the next slot of this node. If the node had no slot for a
/// heartbeat period, for example without SYNC, it sends the heartbeat immediately.
void hystcan_node_beat(const struct hystcan_node_config* config, struct hystcan_node* node, hystcan_time now);
/// Call at each SYNC. Returns true if the node may send a regular status in this cycle. If nodes have slots,
/// a node may send heartbeats and regular statuses only in certain cycles, its slots. In a slot, this
/// function sends the heartbeat if one waits. If the slot is used for that, it returns false.
bool hystcan_node_take_slot(const struct hystcan_node_config* config, struct hystcan_node* node,
                            hystcan_time now);
hystcan_time hystcan_node_due(const struct hystcan_node* node);
/// Adds the next counter and the CRC to the frame and sends the frame. Increments `counter`.
void hystcan_node_send(const struct hystcan_node_config* config, const struct hystcan_message* message,
                       struct hystcan_frame* frame, uint32_t* counter);
/// Returns the counter of a SYNC, from 1 to 240; 0 if the frame is not a SYNC (docs/protocol/cycle.md, "One
/// cycle").
enum { HYSTCAN_SYNC_COUNTER_MAX = 240 };
uint8_t hystcan_sync_counter(const struct hystcan_frame* frame);

#ifdef __cplusplus
}
#endif
