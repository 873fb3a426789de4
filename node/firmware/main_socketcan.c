// An example program that runs the reference node (docs/protocol.md) on SocketCAN: the amplifier and the
// sensor of one axis.
//
//   gcc -std=c11 -O2 node/firmware/*.c -o example_node
//   ./example_node vcan0 1 2 1000    amplifier node 1 and sensor node 2, which are axis X of
//                                    config/piezo.toml; a cycle takes 1000 us (1 / rate_Hz)
//   ./example_node vcan0 1 0 1000    0: without the sensor, because a real one is on the bus
//   ./example_node vcan0 1 2 1000 fd       command, status and sample are CAN FD with bit-rate switch
//   ./example_node vcan0 1 2 1000 fd 24    heartbeat and status have slots, in rounds of 24 cycles
//
// To make firmware, replace this file and keep the other files, which need no operating system. All numbers
// are integers: times in us, drives in 1e-6 V, positions in 1e-6 um.
#define _DEFAULT_SOURCE

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "hystcan_amplifier.h"
#include "hystcan_sensor.h"

// ---- The messages of config/hystcan.dbc

enum { TRANSMIT = 0x180, COMMAND = 0x200, SDO_REQUESTS = 0x600, HEARTBEATS = 0x700 };
enum { LARGEST_NODE = 127, MOST_SLOTS = 240, OBJECTS = 16 };

static struct hystcan_message message(int id, bool fd) {
  return (struct hystcan_message){.id = (uint32_t)id,
                                  .kind = fd ? HYSTCAN_FD : HYSTCAN_DATA,
                                  .bit_rate_switch = fd,
                                  .length = 8,
                                  .counter = HYSTCAN_BITS(48, 4),
                                  .crc = HYSTCAN_BITS(56, 8),
                                  .polynomial = HYSTCAN_SAE_J1850};
}

static struct hystcan_message command, status, sample;

static const struct hystcan_sensor_axis_config sensor_axis = {
    .position = HYSTCAN_I32(2000000000), .sync_counter = HYSTCAN_BITS(32, 8), .status = HYSTCAN_BITS(40, 8)};

static const struct hystcan_amplifier_axis_config amplifier_axis = {.setpoint = HYSTCAN_I32(1000000000),
                                                                    .enable = HYSTCAN_BITS(32, 1),
                                                                    .clear_fault = HYSTCAN_BITS(33, 1),
                                                                    .sync_counter = HYSTCAN_BITS(40, 8),
                                                                    .status = &status,
                                                                    .output = HYSTCAN_I32(1000000000),
                                                                    .state = HYSTCAN_BITS(32, 8),
                                                                    .fault = HYSTCAN_BITS(40, 8),
                                                                    .state_values = {0, 1, 2, 3},
                                                                    // Simulated amplifier, in 1e-6 V and us:
                                                                    .drive_minimum = -20000000,
                                                                    .drive_maximum = 120000000,
                                                                    .command_timeout = 20000,
                                                                    .enable_delay = 5000,
                                                                    .status_every = 10};

// ---- The simulated device: its output equals the last written value, and its stage moves by 0.3 um/V

enum { SAFE_DRIVE = 0 };

static int32_t simulated_output = SAFE_DRIVE;

static void write_drive(void* context, unsigned axis, int32_t setpoint) {
  (void)context, (void)axis;
  simulated_output = setpoint;
}

static void close_relay(void* context, unsigned axis) { (void)context, (void)axis; }

static void go_to_safe_drive(void* context, unsigned axis, bool tripped) {
  (void)context, (void)axis, (void)tripped;
  simulated_output = SAFE_DRIVE;
}

static int32_t read_output(void* context, unsigned axis) {
  (void)context, (void)axis;
  return simulated_output;
}

static uint8_t read_position(void* context, unsigned axis, int32_t* measured) {
  (void)context, (void)axis;
  *measured = (int32_t)(3 * (int64_t)simulated_output / 10);
  return 0;
}

// ---- The bus and the clock

static int bus = -1;

static hystcan_time now_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (hystcan_time)now.tv_sec * 1000000 + (hystcan_time)now.tv_nsec / 1000;
}

// Sends a frame. A frame that the bus does not accept is dropped, because the next frame has newer values.
static void send_frame(void* context, const struct hystcan_frame* sent) {
  (void)context;
  struct canfd_frame frame = {
      .can_id = sent->id, .len = sent->length, .flags = sent->bit_rate_switch ? CANFD_BRS : 0};
  memcpy(frame.data, sent->data, sent->length);
  if (write(bus, &frame, sent->kind == HYSTCAN_FD ? CANFD_MTU : CAN_MTU) < 0) perror("send");
}

// Receives one frame. Returns false if no frame is waiting.
static bool receive_frame(struct hystcan_frame* received) {
  struct canfd_frame frame;
  const ssize_t size = recv(bus, &frame, sizeof frame, MSG_DONTWAIT);
  if (size != (ssize_t)CANFD_MTU && size != (ssize_t)CAN_MTU) return false;
  *received = (struct hystcan_frame){.id = frame.can_id,
                                     .kind = size == (ssize_t)CANFD_MTU ? HYSTCAN_FD : HYSTCAN_DATA,
                                     .length = frame.len};
  memcpy(received->data, frame.data, frame.len);
  return true;
}

// Opens a socket that receives only the data frames that these two nodes process. Returns -1 on failure.
static int open_bus(const char* interface, uint32_t amplifier, uint32_t sensor, int fd) {
  const canid_t exact = CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG;
  const struct can_filter filters[] = {{0x000, exact},
                                       {0x080, exact},
                                       {COMMAND + amplifier, exact},
                                       {SDO_REQUESTS + amplifier, exact},
                                       {SDO_REQUESTS + sensor, exact},
                                       {HEARTBEATS + amplifier, exact},
                                       {HEARTBEATS + sensor, exact}};
  struct ifreq request = {0};
  strncpy(request.ifr_name, interface, IFNAMSIZ - 1);
  const int opened = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  if (opened < 0 || ioctl(opened, SIOCGIFINDEX, &request) < 0) return -1;
  if (setsockopt(opened, SOL_CAN_RAW, CAN_RAW_FILTER, filters, sizeof filters) < 0) return -1;
  if (setsockopt(opened, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &fd, sizeof fd) < 0) return -1;
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = request.ifr_ifindex};
  return bind(opened, (const struct sockaddr*)&address, sizeof address) < 0 ? -1 : opened;
}

// Runs the nodes whose number is not 0, until another node on the bus has the number of one of these nodes.
static int run(struct hystcan_amplifier* amplifier, struct hystcan_sensor* sensor) {
  const bool has_amplifier = amplifier->config->node.number != 0,
             has_sensor = sensor->config->node.number != 0;
  if (has_amplifier) hystcan_amplifier_start(amplifier, now_us());
  if (has_sensor) hystcan_sensor_start(sensor, now_us());
  while (!amplifier->node.is_taken && !sensor->node.is_taken) {
    struct pollfd ready = {.fd = bus, .events = POLLIN};
    struct hystcan_frame frame;
    poll(&ready, 1, 1);
    while (receive_frame(&frame)) {
      // The sensor processes a SYNC before the amplifier, so that it measures before the output moves.
      if (has_sensor) hystcan_sensor_on_frame(sensor, &frame, now_us());
      if (has_amplifier) hystcan_amplifier_on_frame(amplifier, &frame, now_us());
    }
    if (has_sensor) hystcan_sensor_on_time(sensor, now_us());
    if (has_amplifier) hystcan_amplifier_on_time(amplifier, now_us());
  }
  fprintf(stderr, "another node on the bus also has the number %d: give each node its own number\n",
          amplifier->node.is_taken ? amplifier->config->node.number : sensor->config->node.number);
  return 1;
}

// Returns the number in a text; -1 if the text is not a number from 0 to `largest`.
static int number(const char* text, long largest) {
  char* end = NULL;
  const long value = strtol(text, &end, 10);
  return end != text && *end == '\0' && value >= 0 && value <= largest ? (int)value : -1;
}

static struct hystcan_node_config node_config(int node, int slots, struct hystcan_object* objects) {
  return (struct hystcan_node_config){.number = (uint8_t)node,
                                      .slots = (uint8_t)slots,
                                      .objects = objects,
                                      .capacity = OBJECTS,
                                      .heartbeat_period = 100000,  // us; at most half of heartbeat_timeout_ms
                                      .send = send_frame};
}

int main(int argc, char** argv) {
  const bool fd = argc >= 6 && strcmp(argv[5], "fd") == 0;
  const bool is_complete = argc == 5 || (fd && argc <= 7);
  const int amplifier_id = is_complete ? number(argv[2], LARGEST_NODE) : -1;
  const int sensor_id = is_complete ? number(argv[3], LARGEST_NODE) : -1;
  const int cycle_us = is_complete ? number(argv[4], 10000000) : -1;
  const int slots = argc == 7 ? number(argv[6], MOST_SLOTS) : 0;
  if (amplifier_id < 0 || sensor_id < 0 || amplifier_id == sensor_id || cycle_us <= 0 || slots < 0) {
    fprintf(stderr,
            "usage: %s INTERFACE AMPLIFIER_NODE SENSOR_NODE CYCLE_US [fd [SLOTS]]    (node 0: none)\n",
            argv[0]);
    return 2;
  }
  command = message(COMMAND + amplifier_id, fd);
  status = message(TRANSMIT + amplifier_id, fd);
  sample = message(TRANSMIT + sensor_id, fd);
  struct hystcan_object amplifier_objects[OBJECTS], sensor_objects[OBJECTS];
  const struct hystcan_amplifier_config amplifier_config = {
      .node = node_config(amplifier_id, slots, amplifier_objects),
      .command = &command,
      .axes = &amplifier_axis,
      .axis_count = 1,
      .cycle = (uint32_t)cycle_us,
      .write = write_drive,
      .connect = close_relay,
      .leave = go_to_safe_drive,
      .output = read_output};
  const struct hystcan_sensor_config sensor_config = {.node = node_config(sensor_id, slots, sensor_objects),
                                                      .sample = &sample,
                                                      .axes = &sensor_axis,
                                                      .axis_count = 1,
                                                      .measure = read_position};
  struct hystcan_amplifier_axis axis = {0};
  struct hystcan_amplifier amplifier = {.config = &amplifier_config, .axes = &axis};
  struct hystcan_sensor sensor = {.config = &sensor_config};
  bus = open_bus(argv[1], (uint32_t)amplifier_id, (uint32_t)sensor_id, fd);
  if (bus < 0) {
    perror(argv[1]);
    return 1;
  }
  fprintf(stderr, "%s: amplifier node %d, sensor node %d\n", argv[1], amplifier_id, sensor_id);
  return run(&amplifier, &sensor);
}
