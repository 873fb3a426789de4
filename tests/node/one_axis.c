// Amplifier and sensor of axis X of config/piezo.toml on a microcontroller, without drivers. `scripts/check
// firmware` links and measures them.
#include <stddef.h>

#include "node/firmware/hystcan_amplifier.h"
#include "node/firmware/hystcan_sensor.h"

enum { OBJECTS = 4 };

// Registers; the drivers are omitted.
#define DAC (*(volatile int32_t*)0x40007408)
#define ADC ((volatile int32_t*)0x4001204C)
#define CAN_MAILBOX (*(volatile uint32_t*)0x40006580)
#define TIMER_US (*(volatile uint32_t*)0x40000024)

static void send_frame(void* context, const struct hystcan_frame* frame) {
  (void)context;
  CAN_MAILBOX = frame->id;
}
static void write_drive(void* context, unsigned axis, int32_t setpoint) {
  (void)context, (void)axis;
  DAC = setpoint;
}
static void close_relay(void* context, unsigned axis) { (void)context, (void)axis; }
static void go_to_safe_drive(void* context, unsigned axis, bool tripped) {
  (void)context, (void)axis, (void)tripped;
  DAC = 0;
}
static int32_t read_output(void* context, unsigned axis) {
  (void)context, (void)axis;
  return ADC[0];
}
static uint8_t read_position(void* context, unsigned axis, int32_t* position) {
  (void)context, (void)axis;
  *position = ADC[1];
  return 0;
}

static const struct hystcan_message command = {.id = 0x201,
                                               .length = 8,
                                               .counter = HYSTCAN_BITS(48, 4),
                                               .crc = HYSTCAN_BITS(56, 8),
                                               .polynomial = HYSTCAN_SAE_J1850};
static const struct hystcan_message status = {.id = 0x181,
                                              .length = 8,
                                              .counter = HYSTCAN_BITS(48, 4),
                                              .crc = HYSTCAN_BITS(56, 8),
                                              .polynomial = HYSTCAN_SAE_J1850};
static const struct hystcan_message sample = {.id = 0x182,
                                              .length = 8,
                                              .counter = HYSTCAN_BITS(48, 4),
                                              .crc = HYSTCAN_BITS(56, 8),
                                              .polynomial = HYSTCAN_SAE_J1850};
static const struct hystcan_amplifier_axis_config amplifier_axis = {.setpoint = HYSTCAN_I32(1000000000),
                                                                    .enable = HYSTCAN_BITS(32, 1),
                                                                    .clear_fault = HYSTCAN_BITS(33, 1),
                                                                    .sync_counter = HYSTCAN_BITS(40, 8),
                                                                    .status = &status,
                                                                    .output = HYSTCAN_I32(1000000000),
                                                                    .state = HYSTCAN_BITS(32, 8),
                                                                    .fault = HYSTCAN_BITS(40, 8),
                                                                    .state_values = {0, 1, 2, 3},
                                                                    .drive_minimum = -20000000,
                                                                    .drive_maximum = 120000000,
                                                                    .command_timeout = 20000,
                                                                    .enable_delay = 5000,
                                                                    .status_every = 10};
static const struct hystcan_sensor_axis_config sensor_axis = {
    .position = HYSTCAN_I32(2000000000), .sync_counter = HYSTCAN_BITS(32, 8), .status = HYSTCAN_BITS(40, 8)};

static struct hystcan_object amplifier_objects[OBJECTS], sensor_objects[OBJECTS];
static const struct hystcan_amplifier_config amplifier_config = {.node = {.number = 1,
                                                                          .capacity = OBJECTS,
                                                                          .objects = amplifier_objects,
                                                                          .heartbeat_period = 100000,
                                                                          .send = send_frame},
                                                                 .command = &command,
                                                                 .axes = &amplifier_axis,
                                                                 .axis_count = 1,
                                                                 .cycle = 1000,
                                                                 .write = write_drive,
                                                                 .connect = close_relay,
                                                                 .leave = go_to_safe_drive,
                                                                 .output = read_output};
static const struct hystcan_sensor_config sensor_config = {.node = {.number = 2,
                                                                    .capacity = OBJECTS,
                                                                    .objects = sensor_objects,
                                                                    .heartbeat_period = 100000,
                                                                    .send = send_frame},
                                                           .sample = &sample,
                                                           .axes = &sensor_axis,
                                                           .axis_count = 1,
                                                           .measure = read_position};

static struct hystcan_amplifier_axis axis;
static struct hystcan_amplifier amplifier = {.config = &amplifier_config, .axes = &axis};
static struct hystcan_sensor sensor = {.config = &sensor_config};

void* memset(void* to, int value, size_t size) {
  for (size_t i = 0; i < size; ++i) ((volatile uint8_t*)to)[i] = (uint8_t)value;
  return to;
}

void run(void);
void run(void) {
  hystcan_amplifier_start(&amplifier, TIMER_US);
  hystcan_sensor_start(&sensor, TIMER_US);
  for (;;) {
    const struct hystcan_frame frame = {.id = CAN_MAILBOX};
    hystcan_sensor_on_frame(&sensor, &frame, TIMER_US);
    hystcan_amplifier_on_frame(&amplifier, &frame, TIMER_US);
    if (TIMER_US >= hystcan_sensor_due(&sensor)) hystcan_sensor_on_time(&sensor, TIMER_US);
    if (TIMER_US >= hystcan_amplifier_due(&amplifier)) hystcan_amplifier_on_time(&amplifier, TIMER_US);
    if (CAN_MAILBOX == 0) hystcan_amplifier_set_cause(&amplifier, 0, DAC != 0, 0x4200);
    hystcan_amplifier_set_interlock(&amplifier, 0, DAC == 0);
  }
}
