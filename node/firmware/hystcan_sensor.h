// The sensor node as firmware (docs/protocol/nodes.md, "What a sensor node does"). hystcan_node.h describes
// how to call a node.
#pragma once

#include "hystcan_node.h"

#ifdef __cplusplus
extern "C" {
#endif

struct hystcan_sensor_axis_config {
  struct hystcan_field position, sync_counter, status;
};

struct hystcan_sensor_config {
  struct hystcan_node_config node;
  const struct hystcan_message* sample;
  const struct hystcan_sensor_axis_config* axes;
  uint8_t axis_count;
  /// Measures the position of an axis now, in the unit of the field `position`. Returns the status of the
  /// sample: 0 if the sample is good, 1 if the position is outside the range of the sensor.
  uint8_t (*measure)(void* context, unsigned axis, int32_t* position);
};

struct hystcan_sensor {
  const struct hystcan_sensor_config* config;
  struct hystcan_node node;
  uint32_t sent_counter;
};

void hystcan_sensor_start(struct hystcan_sensor* sensor, hystcan_time now);
void hystcan_sensor_on_frame(struct hystcan_sensor* sensor, const struct hystcan_frame* frame,
                             hystcan_time arrival);
void hystcan_sensor_on_time(struct hystcan_sensor* sensor, hystcan_time now);
hystcan_time hystcan_sensor_due(const struct hystcan_sensor* sensor);

#ifdef __cplusplus
}
#endif
