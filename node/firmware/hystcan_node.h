// What hystcan_amplifier.h and hystcan_sensor.h have in common: "Node life", "SDO", "Background slots".
//
// They are the amplifier node and the sensor node of docs/protocol as firmware: C11 without an operating
// system, a heap, floating point or a C library (but memset and memcpy, which compilers call by themselves).
//
// The caller owns the bus, the clock and the device. It zeroes a node, gives it its configuration and starts
// it. From then on it passes each received frame to the node, and calls it at the times that it states:
//
//   static struct hystcan_sensor sensor = {.config = &config};
//   hystcan_sensor_start(&sensor, now);
//   hystcan_sensor_on_frame(&sensor, &frame, arrival);   each received frame
//   hystcan_sensor_on_time(&sensor, now);                at hystcan_sensor_due(), or every millisecond
//
// A node receives NMT (0x000), SYNC (0x080), heartbeats (0x700) and SDO requests (0x600) of its own number,
// and an amplifier its command. It ignores every other frame. No function is reentrant: frames, times and
// causes come from one thread, or from interrupts of one priority.
//
// A device with several axes has them in one node: `axis` counts from 0.
//
// Comments in quotes name a section of docs/protocol/*.md. main_socketcan.c is an example of a caller, and
// tests/node compares these nodes with those of the twin.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "hystcan_frame.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A time of the caller's clock. The caller chooses the unit, such as 1 us, for all times and durations. It
/// has 64 bits because it never overflows: an old SYNC stays old.
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
  uint8_t slots;   ///< of a round; 0: none
  uint8_t capacity;
  struct hystcan_object* objects;  ///< as many as `capacity`
  uint32_t heartbeat_period;
  void* context;  ///< for all functions of the caller
  /// Hands the frame to the bus and does not wait. A frame that the bus does not take is dropped.
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
  uint8_t last_sync;  ///< 0: no SYNC since the boot-up
  uint8_t object_count;
  bool is_started;
  bool is_taken;  ///< another node has this number: this one is off and silent
  bool has_seen_slot;
  bool heartbeat_waits;  ///< for the slot
};

// ---- For the nodes alone

/// What NMT has done to a node. The owner acts on it.
enum hystcan_change {
  HYSTCAN_NOTHING,
  HYSTCAN_STATE_CHANGED,
  HYSTCAN_NODE_RESET,
  HYSTCAN_COMMUNICATION_RESET
};

/// For functions that hold a frame. As a part of its caller, one would have the frame on the stack while the
/// caller calls others.
#ifdef __GNUC__
#define HYSTCAN_OUT_OF_LINE __attribute__((noinline))
#else
#define HYSTCAN_OUT_OF_LINE
#endif

/// Sends the boot-up message. Returns `reset`.
enum hystcan_change hystcan_node_boot_up(const struct hystcan_node_config* config, struct hystcan_node* node,
                                         enum hystcan_change reset, hystcan_time now);
/// NMT, heartbeats of this number, SDO.
enum hystcan_change hystcan_node_handle(const struct hystcan_node_config* config, struct hystcan_node* node,
                                        const struct hystcan_frame* frame, hystcan_time now);
/// True before the start, and where another node has this number.
bool hystcan_node_is_silent(const struct hystcan_node* node);
/// Sends the heartbeat when it is due. It waits for the slot if one has come in the last period.
void hystcan_node_beat(const struct hystcan_node_config* config, struct hystcan_node* node, hystcan_time now);
/// With each SYNC: sends a heartbeat that waits for the slot. Returns whether a status may follow.
bool hystcan_node_take_slot(const struct hystcan_node_config* config, struct hystcan_node* node,
                            hystcan_time now);
hystcan_time hystcan_node_due(const struct hystcan_node* node);
/// Adds the next counter and the CRC.
void hystcan_node_send(const struct hystcan_node_config* config, const struct hystcan_message* message,
                       struct hystcan_frame* frame, uint32_t* counter);
/// "One cycle": the counter runs from 1 to 240. Returns 0 if the frame is not a SYNC.
enum { HYSTCAN_SYNC_COUNTER_MAX = 240 };
uint8_t hystcan_sync_counter(const struct hystcan_frame* frame);

#ifdef __cplusplus
}
#endif
