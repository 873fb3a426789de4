// A reference node for docs/protocol.md in C11: the amplifier and the sensor of one axis, on SocketCAN.
//
//   gcc -std=c11 -O2 docs/example_node.c -o example_node
//   ./example_node vcan0 1 2 1000    amplifier node 1 and sensor node 2, which are axis X of
//                                    config/piezo.toml; a cycle takes 1000 us (1 / rate_Hz)
//   ./example_node vcan0 1 0 1000    0: without the sensor, because a real one is on the bus
//   ./example_node vcan0 1 2 1000 fd       command, status and sample are CAN FD with bit-rate switch
//   ./example_node vcan0 1 2 1000 fd 24    heartbeat and status have slots, in rounds of 24 cycles
//
// Comments in quotes name a section of docs/protocol/*.md. To make firmware of it, replace the last two
// parts: the device, and the bus and the clock. All numbers on the wire are integers of 1e-6 units.
#define _DEFAULT_SOURCE

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

// ---- "Messages"

enum { NMT_ID = 0x000, SYNC_ID = 0x080, EMCY = 0x080, TRANSMIT = 0x180, COMMAND = 0x200 };
enum { HEARTBEAT = 0x700, SYNC_COUNTER_MAX = 240, COMMAND_ENABLE = 0x01, COMMAND_CLEAR_FAULT = 0x02 };
enum { FAULT_COMMAND_TIMEOUT = 0x01, FAULT_OUT_OF_RANGE = 0x02 };

enum nmt_command {
  NMT_START = 1,
  NMT_STOP = 2,
  NMT_ENTER_PRE_OPERATIONAL = 128,
  NMT_RESET_NODE = 129,
  NMT_RESET_COMMUNICATION = 130
};
enum nmt_state { BOOT_UP = 0x00, STOPPED = 0x04, OPERATIONAL = 0x05, PRE_OPERATIONAL = 0x7F };
enum amplifier_state { OFF = 0, READY = 1, ENABLED = 2, FAULT = 3 };

// ---- The parameters of this device

enum {
  HEARTBEAT_MS = 100,       // at most half of the controller's heartbeat_timeout_ms
  COMMAND_TIMEOUT_MS = 20,  // of the watchdog
  ENABLE_DELAY_MS = 5,      // of the relay at the output
  STATUS_EVERY = 10,        // SYNCs
  DRIVE_MIN = -20000000,    // 1e-6 V; a setpoint outside is a fault
  DRIVE_MAX = 120000000,
  SAFE_DRIVE = 0
};

// What both nodes have: the NMT state, the heartbeat, and the counters on the wire.
struct node {
  int bus;
  bool fd;  // command, status and sample are CAN FD; NMT, SYNC, heartbeat and emergency are always classical
  uint8_t id;  // 0: this node does not exist
  enum nmt_state state;
  unsigned slots;  // of a round; 0: none
  uint64_t heartbeat_due_ms;
  bool heartbeat_waits;   // for the slot
  uint64_t last_slot_ms;  // 0: none yet
  uint8_t last_sync;      // 0: no SYNC since the boot-up
  uint8_t sent_counter;   // of the next status or sample
};

struct amplifier {
  struct node node;
  enum amplifier_state state;
  uint8_t fault;             // latched causes
  int32_t setpoint;          // takes effect at the next SYNC
  int received_counter;      // of the last accepted command; -1: none yet
  uint64_t cycle_us;         // from SYNC to SYNC, as set in the controller
  uint64_t sync_us;          // when the last SYNC arrived
  uint64_t former_sync_us;   // and the one before it; 0: it was not received since the boot-up
  uint64_t deadline_ms;      // of the next command with Enable
  bool is_enabling;          // the relay is closing
  uint64_t relay_closed_ms;  // while is_enabling
  unsigned syncs_since_status;
  int32_t output;  // of the simulated power stage
};

struct sensor {
  struct node node;
  const struct amplifier* stage;  // the simulated stage follows this amplifier
};

static int32_t read_output(const struct amplifier* amplifier);
static void write_output(struct amplifier* amplifier, int32_t drive);
static bool read_position(const struct sensor* sensor, int32_t* position);
static void send_frame(const struct node* node, uint32_t base, const uint8_t* data, uint8_t length, bool fd);
static uint64_t now_us(void);

static uint64_t now_ms(void) { return now_us() / 1000; }

// ---- "Counter and CRC"

static uint8_t crc_with(uint8_t crc, uint8_t byte) {
  crc ^= byte;
  for (int bit = 0; bit < 8; ++bit) crc = (uint8_t)(crc & 0x80 ? crc << 1 ^ 0x1D : crc << 1);
  return crc;
}

static uint8_t crc_of(uint32_t id, const uint8_t* data) {
  uint8_t crc = crc_with(crc_with(0xFF, (uint8_t)id), (uint8_t)(id >> 8));
  for (int i = 0; i < 7; ++i) crc = crc_with(crc, data[i]);
  return crc ^ 0xFF;
}

static void put_i32(uint8_t* data, int32_t value) {
  for (int i = 0; i < 4; ++i) data[i] = (uint8_t)((uint32_t)value >> 8 * i);
}

static int32_t get_i32(const uint8_t* data) {
  uint32_t raw = 0;
  for (int i = 0; i < 4; ++i) raw |= (uint32_t)data[i] << 8 * i;
  return (int32_t)raw;
}

// Sends a status or a sample: the value and two bytes, which get the counter and the CRC.
static void send_protected(struct node* node, int32_t value, uint8_t byte4, uint8_t byte5) {
  uint8_t data[8] = {0, 0, 0, 0, byte4, byte5, node->sent_counter, 0};
  put_i32(data, value);
  data[7] = crc_of(TRANSMIT + node->id, data);
  node->sent_counter = (node->sent_counter + 1) & 0x0F;
  send_frame(node, TRANSMIT, data, sizeof data, node->fd);
}

enum { FD_FLAG = 0x04 };  // CANFD_FDF of Linux 5.18 and later

static bool is_fd(const struct canfd_frame* frame) { return (frame->flags & FD_FLAG) != 0; }

// "Counter and CRC": a frame of the wrong kind, with a wrong length, a wrong CRC or a repeated counter counts
// as not sent.
static bool accept_command(struct amplifier* amplifier, const struct canfd_frame* frame) {
  if (is_fd(frame) != amplifier->node.fd || frame->len != 8) return false;
  if (frame->data[7] != crc_of(frame->can_id, frame->data)) return false;
  const int counter = frame->data[6] & 0x0F;
  if (counter == amplifier->received_counter) return false;
  amplifier->received_counter = counter;
  return true;
}

// ---- "Node life"

static void send_heartbeat(struct node* node, enum nmt_state state) {
  const uint8_t data = (uint8_t)state;
  send_frame(node, HEARTBEAT, &data, 1, false);
  node->heartbeat_due_ms = now_ms() + HEARTBEAT_MS;
}

// When it is due. It waits for the slot, "Background slots", if one has come in the last period.
static void beat(struct node* node) {
  const uint64_t now = now_ms();
  if (now < node->heartbeat_due_ms) return;
  node->heartbeat_waits = node->last_slot_ms != 0 && now - node->last_slot_ms < HEARTBEAT_MS;
  if (node->heartbeat_waits)
    node->heartbeat_due_ms = now + HEARTBEAT_MS;
  else
    send_heartbeat(node, node->state);
}

// With each SYNC. Returns whether a status that is due may follow it; the heartbeat goes before it.
static bool take_slot(struct node* node, uint8_t sync) {
  if (node->slots == 0) return true;
  if (sync % node->slots != node->id % node->slots) return false;
  node->last_slot_ms = now_ms();
  if (!node->heartbeat_waits) return true;
  node->heartbeat_waits = false;
  send_heartbeat(node, node->state);
  return false;
}

static void boot_up(struct node* node) {
  node->last_sync = 0;
  node->heartbeat_waits = false;
  node->sent_counter = 0;
  node->state = PRE_OPERATIONAL;
  send_heartbeat(node, BOOT_UP);
}

// Returns whether the frame is an NMT command for this node that it knows.
static bool obey_nmt(struct node* node, const struct canfd_frame* frame) {
  if (frame->can_id != NMT_ID || frame->len != 2 || is_fd(frame)) return false;
  if (frame->data[1] != 0 && frame->data[1] != node->id) return false;  // 0: all nodes
  switch (frame->data[0]) {
    case NMT_START:
      node->state = OPERATIONAL;
      return true;
    case NMT_STOP:
      node->state = STOPPED;
      return true;
    case NMT_ENTER_PRE_OPERATIONAL:
      node->state = PRE_OPERATIONAL;
      return true;
    case NMT_RESET_NODE:
    case NMT_RESET_COMMUNICATION:
      boot_up(node);
      return true;
    default:
      return false;
  }
}

// "One cycle": the counter runs from 1 to 240. 0: the frame is not a SYNC.
static uint8_t sync_counter_of(const struct canfd_frame* frame) {
  if (frame->can_id != SYNC_ID || frame->len != 1 || is_fd(frame)) return 0;
  return frame->data[0] <= SYNC_COUNTER_MAX ? frame->data[0] : 0;
}

// ---- "What an amplifier node does"

// "Status": at each change of state, and at the tenth SYNC after the last one, or in the next slot.
static void send_status(struct amplifier* amplifier) {
  amplifier->syncs_since_status = 0;
  send_protected(&amplifier->node, read_output(amplifier), (uint8_t)amplifier->state, amplifier->fault);
}

// In every state but ENABLED the output has its safe value. Every change of state is reported.
static void enter(struct amplifier* amplifier, enum amplifier_state state) {
  if (state != ENABLED) {
    amplifier->is_enabling = false;
    write_output(amplifier, SAFE_DRIVE);
  }
  if (state == amplifier->state) return;
  amplifier->state = state;
  send_status(amplifier);
}

static void send_emergency(const struct amplifier* amplifier, uint16_t code) {
  const uint8_t error_register = amplifier->fault != 0 ? 0x01 : 0x00;  // bit 0: generic error
  const uint8_t data[8] = {(uint8_t)code, (uint8_t)(code >> 8), error_register};
  send_frame(&amplifier->node, EMCY, data, sizeof data, false);
}

// "Faults of an amplifier": latched; the emergency first, then the status.
static void trip(struct amplifier* amplifier, uint8_t fault, uint16_t emergency_code) {
  amplifier->fault |= fault;
  send_emergency(amplifier, emergency_code);
  enter(amplifier, FAULT);
}

static void clear_fault(struct amplifier* amplifier) {
  amplifier->fault = 0;  // a device with a cause of its own keeps the fault while the cause lasts
  send_emergency(amplifier, 0x0000);
  enter(amplifier, READY);
}

// "Node life": every command but start leads to OFF.
static void on_nmt(struct amplifier* amplifier, uint8_t command, enum nmt_state before) {
  if (command == NMT_RESET_NODE) amplifier->fault = 0;  // reset communication keeps it
  if (command == NMT_RESET_NODE || command == NMT_RESET_COMMUNICATION) {
    amplifier->state = OFF;  // a node that boots up sends no status
    amplifier->syncs_since_status = 0;
  }
  if (amplifier->node.state != OPERATIONAL) {
    enter(amplifier, OFF);
  } else if (before != OPERATIONAL) {
    amplifier->received_counter = -1;
    enter(amplifier, amplifier->fault != 0 ? FAULT : READY);
  }
}

// "Stale commands": older than one SYNC or than two cycles, or without a SYNC to refer to. Firmware takes the
// times of arrival where it receives the frames.
static bool is_stale(const struct amplifier* amplifier, uint8_t flags, uint8_t named) {
  const uint8_t last_sync = amplifier->node.last_sync;
  if (last_sync == 0 || named == 0 || named > SYNC_COUNTER_MAX) return true;
  const int syncs_since = (last_sync - named + SYNC_COUNTER_MAX) % SYNC_COUNTER_MAX;
  if (syncs_since > 1) return true;
  if ((flags & (COMMAND_ENABLE | COMMAND_CLEAR_FAULT)) == 0) return false;  // it switches off
  const uint64_t named_us = syncs_since == 0 ? amplifier->sync_us : amplifier->former_sync_us;
  return named_us == 0 || now_us() - named_us > 2 * amplifier->cycle_us;
}

// "What an amplifier node does", the table of Enable and ClearFault. The command is accepted.
static void on_command(struct amplifier* amplifier, const uint8_t* data) {
  const int32_t setpoint = get_i32(data);
  const bool enable = (data[4] & COMMAND_ENABLE) != 0;
  if (is_stale(amplifier, data[4], data[5])) return;
  if (amplifier->state == FAULT) {  // a command that clears does not enable
    if ((data[4] & COMMAND_CLEAR_FAULT) != 0) clear_fault(amplifier);
    return;
  }
  if (!enable) {
    enter(amplifier, READY);  // at once, without a SYNC; the setpoint is not used
    return;
  }
  if (setpoint < DRIVE_MIN || setpoint > DRIVE_MAX) {
    trip(amplifier, FAULT_OUT_OF_RANGE, 0x6300);
    return;
  }
  amplifier->setpoint = setpoint;
  amplifier->deadline_ms = now_ms() + COMMAND_TIMEOUT_MS;
  if (amplifier->state == ENABLED || amplifier->is_enabling) return;
  amplifier->is_enabling = true;  // "Enabling": the state stays READY until the relay has closed
  amplifier->relay_closed_ms = now_ms() + ENABLE_DELAY_MS;
}

static void on_sync(struct amplifier* amplifier, uint8_t sync) {
  const uint8_t last_sync = amplifier->node.last_sync;
  const bool follows = last_sync != 0 && sync == last_sync % SYNC_COUNTER_MAX + 1;
  if (sync != last_sync) amplifier->former_sync_us = follows ? amplifier->sync_us : 0;
  amplifier->sync_us = now_us();
  amplifier->node.last_sync = sync;
  if (amplifier->state == ENABLED) write_output(amplifier, amplifier->setpoint);
  const bool may_send = take_slot(&amplifier->node, sync);
  if (amplifier->node.state != OPERATIONAL) return;
  if (++amplifier->syncs_since_status >= STATUS_EVERY && may_send) send_status(amplifier);
}

static void amplifier_on_frame(struct amplifier* amplifier, const struct canfd_frame* frame) {
  struct node* node = &amplifier->node;
  const enum nmt_state before = node->state;
  const uint8_t sync = sync_counter_of(frame);
  if (sync != 0) {
    on_sync(amplifier, sync);
  } else if (obey_nmt(node, frame)) {
    on_nmt(amplifier, frame->data[0], before);
  } else if (frame->can_id == COMMAND + (uint32_t)node->id && node->state == OPERATIONAL) {
    if (accept_command(amplifier, frame)) on_command(amplifier, frame->data);
  }
}

// "Watchdog": it acts on an enabled output only. If the commands have stopped, a relay that closes enables
// nothing.
static void amplifier_on_time(struct amplifier* amplifier) {
  const uint64_t now = now_ms();
  const bool has_command = now < amplifier->deadline_ms;
  if (amplifier->is_enabling && now >= amplifier->relay_closed_ms) {
    amplifier->is_enabling = false;
    if (has_command) enter(amplifier, ENABLED);
  }
  if (amplifier->state == ENABLED && !has_command) trip(amplifier, FAULT_COMMAND_TIMEOUT, 0x8130);
  beat(&amplifier->node);
}

// ---- "What a sensor node does"

static void sensor_on_frame(struct sensor* sensor, const struct canfd_frame* frame) {
  struct node* node = &sensor->node;
  const uint8_t sync = sync_counter_of(frame);
  if (sync == 0) {
    obey_nmt(node, frame);
    return;
  }
  const bool is_repeated = sync == node->last_sync;  // the same SYNC, received twice
  node->last_sync = sync;
  if (is_repeated) return;
  if (node->state == OPERATIONAL) {
    int32_t position = 0;
    const bool is_good = read_position(sensor, &position);
    send_protected(node, position, sync, is_good ? 0x00 : 0x01);
  }
  take_slot(node, sync);
}

// ---- The device: the output is what was written last, and the stage moves by 0.3 um/V

static void write_output(struct amplifier* amplifier, int32_t drive) { amplifier->output = drive; }
static int32_t read_output(const struct amplifier* amplifier) { return amplifier->output; }

// Returns false if the position is beyond the range of the sensor.
static bool read_position(const struct sensor* sensor, int32_t* position) {
  *position = (int32_t)(3 * (int64_t)sensor->stage->output / 10);
  return true;
}

// ---- The bus and the clock

static uint64_t now_us(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000 + (uint64_t)now.tv_nsec / 1000;
}

// A frame that the bus does not take is dropped: a later one has newer values.
static void send_frame(const struct node* node, uint32_t base, const uint8_t* data, uint8_t length, bool fd) {
  struct canfd_frame frame = {.can_id = base + node->id, .len = length, .flags = fd ? CANFD_BRS : 0};
  memcpy(frame.data, data, length);
  if (write(node->bus, &frame, fd ? CANFD_MTU : CAN_MTU) < 0) perror("send");
}

// Returns false if no frame waits.
static bool receive_frame(int bus, struct canfd_frame* frame) {
  const ssize_t size = recv(bus, frame, sizeof *frame, MSG_DONTWAIT);
  frame->flags = size == (ssize_t)CANFD_MTU ? FD_FLAG : 0;
  return size == (ssize_t)CANFD_MTU || size == (ssize_t)CAN_MTU;
}

// Receives data frames with these standard identifiers only. Returns -1 if it fails.
static int open_bus(const char* interface, uint32_t command_id, int fd) {
  const canid_t exact = CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG;
  const struct can_filter filters[] = {{NMT_ID, exact}, {SYNC_ID, exact}, {command_id, exact}};
  struct ifreq request = {0};
  strncpy(request.ifr_name, interface, IFNAMSIZ - 1);
  const int bus = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  if (bus < 0 || ioctl(bus, SIOCGIFINDEX, &request) < 0) return -1;
  if (setsockopt(bus, SOL_CAN_RAW, CAN_RAW_FILTER, filters, sizeof filters) < 0) return -1;
  if (setsockopt(bus, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &fd, sizeof fd) < 0) return -1;
  const struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = request.ifr_ifindex};
  return bind(bus, (const struct sockaddr*)&address, sizeof address) < 0 ? -1 : bus;
}

// Returns -1 if the text is not a number from 0 to `largest`.
static int number(const char* text, long largest) {
  char* end = NULL;
  const long value = strtol(text, &end, 10);
  return end != text && *end == '\0' && value >= 0 && value <= largest ? (int)value : -1;
}

int main(int argc, char** argv) {
  const bool fd = argc >= 6 && strcmp(argv[5], "fd") == 0;
  const bool is_complete = argc == 5 || (fd && argc <= 7);
  const int amplifier_id = is_complete ? number(argv[2], 127) : -1;
  const int sensor_id = is_complete ? number(argv[3], 127) : -1;
  const int cycle_us = is_complete ? number(argv[4], 10000000) : -1;
  const int slots = argc == 7 ? number(argv[6], SYNC_COUNTER_MAX) : 0;
  if (amplifier_id < 0 || sensor_id < 0 || amplifier_id == sensor_id || cycle_us <= 0 || slots < 0) {
    fprintf(stderr,
            "usage: %s INTERFACE AMPLIFIER_NODE SENSOR_NODE CYCLE_US [fd [SLOTS]]    (node 0: without it)\n",
            argv[0]);
    return 2;
  }
  struct amplifier amplifier = {
      .node = {.id = (uint8_t)amplifier_id}, .received_counter = -1, .cycle_us = (uint64_t)cycle_us};
  struct sensor sensor = {.node = {.id = (uint8_t)sensor_id}, .stage = &amplifier};
  const int bus = open_bus(argv[1], COMMAND + (uint32_t)amplifier.node.id, fd);
  if (bus < 0) {
    perror(argv[1]);
    return 1;
  }
  amplifier.node.bus = sensor.node.bus = bus;
  amplifier.node.fd = sensor.node.fd = fd;
  amplifier.node.slots = sensor.node.slots = (unsigned)slots;
  fprintf(stderr, "%s: amplifier node %d, sensor node %d\n", argv[1], amplifier_id, sensor_id);
  if (amplifier.node.id != 0) boot_up(&amplifier.node);
  if (sensor.node.id != 0) boot_up(&sensor.node);
  for (;;) {
    struct pollfd ready = {.fd = bus, .events = POLLIN};
    struct canfd_frame frame;
    poll(&ready, 1, 1);
    while (receive_frame(bus, &frame)) {
      // The sensor comes first: it samples at the SYNC, before the output moves.
      if (sensor.node.id != 0) sensor_on_frame(&sensor, &frame);
      if (amplifier.node.id != 0) amplifier_on_frame(&amplifier, &frame);
    }
    if (sensor.node.id != 0) beat(&sensor.node);
    if (amplifier.node.id != 0) amplifier_on_time(&amplifier);
  }
}
