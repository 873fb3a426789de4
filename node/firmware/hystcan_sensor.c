#include "hystcan_sensor.h"

HYSTCAN_OUT_OF_LINE static void sample(struct hystcan_sensor* sensor) {
  const struct hystcan_sensor_config* config = sensor->config;
  struct hystcan_frame frame;
  hystcan_make_frame(config->sample, &frame);
  bool fits = true;
  for (unsigned i = 0; i < config->axis_count; ++i) {
    const struct hystcan_sensor_axis_config* axis = &config->axes[i];
    int32_t position = 0;
    const uint8_t status = config->measure(config->node.context, i, &position);
    if (!hystcan_put_value(&axis->position, position, frame.data) ||
        !hystcan_put_value(&axis->status, status, frame.data))
      fits = false;
    hystcan_put_raw(&axis->sync_counter, sensor->node.last_sync, frame.data);
  }
  if (fits) hystcan_node_send(&config->node, config->sample, &frame, &sensor->sent_counter);
}

void hystcan_sensor_start(struct hystcan_sensor* sensor, hystcan_time now) {
  if (sensor->node.is_taken) return;
  hystcan_node_boot_up(&sensor->config->node, &sensor->node, HYSTCAN_NODE_RESET, now);
  sensor->sent_counter = 0;
}

void hystcan_sensor_on_frame(struct hystcan_sensor* sensor, const struct hystcan_frame* frame,
                             hystcan_time arrival) {
  struct hystcan_node* node = &sensor->node;
  const uint8_t sync = hystcan_sync_counter(frame);
  if (sync == 0) {
    if (hystcan_node_handle(&sensor->config->node, node, frame, arrival) > HYSTCAN_STATE_CHANGED)
      sensor->sent_counter = 0;
    return;
  }
  if (sync == node->last_sync) return;  // the same SYNC was received twice
  node->last_sync = sync;
  if (node->state == HYSTCAN_OPERATIONAL) sample(sensor);
  hystcan_node_take_slot(&sensor->config->node, node, arrival);
}

void hystcan_sensor_on_time(struct hystcan_sensor* sensor, hystcan_time now) {
  hystcan_node_beat(&sensor->config->node, &sensor->node, now);
}

hystcan_time hystcan_sensor_due(const struct hystcan_sensor* sensor) {
  return hystcan_node_due(&sensor->node);
}
