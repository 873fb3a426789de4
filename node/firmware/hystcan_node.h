// The common part of hystcan_amplifier.h and hystcan_sensor.h: "Node life", "SDO", "Background slots".
//
// These headers are the amplifier node and the sensor node of docs/protocol as firmware: C11 without an
// operating system, a heap, floating point or a C library (except memset and memcpy, which compilers call
// implicitly).
//
// The caller owns the bus, the clock and the device. It zeroes a node, sets its configuration and starts it.
// Then it passes each received frame to the node, and calls the node at the times that the node requests:
//
//   static struct hystcan_sensor sensor = {.config = &config};
//   hystcan_sensor_start(&sensor, now);
//   hystcan_sensor_on_frame(&sensor, &frame, arrival);   each received frame
//   hystcan_sensor_on_time(&sensor, now);                at hystcan_sensor_due(), or every millisecond
//
// A node receives NMT (0x000), SYNC (0x080), heartbeats (0x700) and SDO requests (0x600) with its own number;
// an amplifier also receives its command. A node ignores every other frame. No function is reentrant: call
// all of them from one thread, or from interrupts of one priority.
//
// A device with several axes has them in one node: `axis` counts from 0.
//
// Quoted text in comments is the title of a section of docs/protocol/*.md. main_socketcan.c is an example
// of a caller, and tests/node compares these nodes with those of the twin.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "hystcan_frame.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A time of the caller's clock. The caller chooses one unit, such as 1 us, for all times and durations. The
/// type has 64 bits so that it never overflows: an old SYNC stays old.
typedef uint64_t hystcan_time;
#define HYSTCAN_NEVER UINT64_MAX

/// An object that was written by SDO.
struct hystcan_object {
  uint16_t index;
  uint8_t subindex;
  uint8_t bytes;
  uint32_t value;
};

struct hystcan_node_config {
  uint8_t number;  ///< 1..127
  uint8_t slots;   ///< number of slots in a round; 0: no slots
  uint8_t capacity;
  struct hystcan_object* objects;  ///< array of `capacity` objects
  uint32_t heartbeat_period;
  void* context;  ///< passed to all functions of the caller
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
  uint8_t state;      ///< enum hystcan_nmt
  uint8_t last_sync;  ///< counter of the last SYNC; 0: no SYNC since the boot-up
  uint8_t object_count;
  bool is_started;
  bool is_taken;  ///< another node has this number: this node is off and silent
  bool has_seen_slot;
  bool heartbeat_waits;  ///< true while a heartbeat waits for its slot
};

// ---- Only for the nodes

/// The effect of NMT on a node. The owner of the node must act on it.
enum hystcan_change {
  HYSTCAN_NOTHING,
  HYSTCAN_STATE_CHANGED,
  HYSTCAN_NODE_RESET,
  HYSTCAN_COMMUNICATION_RESET
};

/// Marks functions that have a frame on the stack. If such a function were inlined, its caller would keep the
/// frame on the stack during its other calls.
#ifdef __GNUC__
#define HYSTCAN_OUT_OF_LINE __attribute__((noinline))
#else
#define HYSTCAN_OUT_OF_LINE
#endif

/// Sends the boot-up message. Returns `reset`.
enum hystcan_change hystcan_node_boot_up(const struct hystcan_node_config* config, struct hystcan_node* node,
                                         enum hystcan_change reset, hystcan_time now);
/// Handles NMT, SDO and heartbeats with this number.
enum hystcan_change hystcan_node_handle(const struct hystcan_node_config* config, struct hystcan_node* node,
                                        const struct hystcan_frame* frame, hystcan_time now);
/// Returns true before the start, and if another node has this number.
bool hystcan_node_is_silent(const struct hystcan_node* node);
/// Sends the heartbeat when it is due. With slots, the heartbeat waits for its slot if there was one in the
/// last period.
void hystcan_node_beat(const struct hystcan_node_config* config, struct hystcan_node* node, hystcan_time now);
/// Call at each SYNC: sends a heartbeat that waits for the slot. Returns true if a status may follow.
bool hystcan_node_take_slot(const struct hystcan_node_config* config, struct hystcan_node* node,
                            hystcan_time now);
hystcan_time hystcan_node_due(const struct hystcan_node* node);
/// Adds the next counter and the CRC.
void hystcan_node_send(const struct hystcan_node_config* config, const struct hystcan_message* message,
                       struct hystcan_frame* frame, uint32_t* counter);
/// "One cycle": returns the counter, from 1 to 240, or 0 if the frame is not a SYNC.
enum { HYSTCAN_SYNC_COUNTER_MAX = 240 };
uint8_t hystcan_sync_counter(const struct hystcan_frame* frame);

#ifdef __cplusplus
}
#endif
