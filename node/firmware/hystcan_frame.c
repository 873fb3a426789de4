#include "hystcan_frame.h"

/// Returns the position in the payload of bit `i` of the raw value. Positions count from 0, the lowest bit of
/// byte 0.
static unsigned place_of(const struct hystcan_field* field, unsigned i) {
  if (!field->big_endian) return field->start + i;
  return ((field->start ^ 7u) + field->length - 1u - i) ^ 7u;
}

uint32_t hystcan_get_raw(const struct hystcan_field* field, const uint8_t* data) {
  uint32_t raw = 0;
  for (unsigned i = 0; i < field->length; ++i) {
    const unsigned place = place_of(field, i);
    raw |= (uint32_t)(data[place / 8] >> place % 8 & 1) << i;
  }
  return raw;
}

void hystcan_put_raw(const struct hystcan_field* field, uint32_t raw, uint8_t* data) {
  for (unsigned i = 0; i < field->length; ++i) {
    const unsigned place = place_of(field, i);
    data[place / 8] |= (uint8_t)((raw >> i & 1) << place % 8);
  }
}

int32_t hystcan_get_value(const struct hystcan_field* field, const uint8_t* data) {
  const unsigned unused = 32u - field->length;
  const uint32_t raw = hystcan_get_raw(field, data);
  const int64_t number = field->is_signed ? (int64_t)((int32_t)(raw << unused) >> unused) : (int64_t)raw;
  const int64_t value = number * field->scale + field->offset;
  if (value < INT32_MIN) return INT32_MIN;
  return value > INT32_MAX ? INT32_MAX : (int32_t)value;
}

bool hystcan_put_value(const struct hystcan_field* field, int32_t value, uint8_t* data) {
  if (field->length == 0) return true;
  if (value < field->minimum || value > field->maximum) return false;
  const bool is_below = value < field->offset;
  const uint32_t difference = (uint32_t)value - (uint32_t)field->offset;
  const uint32_t distance = is_below ? 0u - difference : difference;
  const uint32_t rest = distance % field->scale;
  uint32_t raw = distance / field->scale;
  if (rest > field->scale - rest || (rest == field->scale - rest && raw % 2 != 0)) ++raw;
  hystcan_put_raw(field, is_below ? 0u - raw : raw, data);
  return true;
}

// ---- Counter and CRC (docs/protocol/frames.md, "Counter and CRC")

/// The parameters of a CRC. An 8-bit CRC is computed in the upper half of 16 bits.
struct polynomial {
  uint16_t divisor, initial, final_xor;
  uint8_t bytes;
};

static const struct polynomial polynomials[] = {[HYSTCAN_SAE_J1850] = {0x1D00, 0xFF00, 0xFF00, 1},
                                                [HYSTCAN_CRC_8H2F] = {0x2F00, 0xFF00, 0xFF00, 1},
                                                [HYSTCAN_CRC_16] = {0x1021, 0xFFFF, 0x0000, 2}};

static uint16_t crc_with(const struct polynomial* polynomial, uint16_t crc, uint8_t byte) {
  crc = (uint16_t)(crc ^ byte << 8);
  for (int bit = 0; bit < 8; ++bit)
    crc = (uint16_t)((crc & 0x8000) != 0 ? crc << 1 ^ polynomial->divisor : crc << 1);
  return crc;
}

/// Computes the CRC of a frame: over the data id, then over the payload without the bytes of the CRC.
static uint16_t crc_of(const struct hystcan_message* message, const struct hystcan_frame* frame) {
  const struct polynomial* polynomial = &polynomials[message->polynomial];
  const unsigned own_byte = message->crc.start / 8u;
  const uint32_t id = message->data_id == HYSTCAN_NUMBER ? message->number : frame->id;
  unsigned id_bytes = message->data_id == HYSTCAN_IDENTIFIER && frame->extended ? 4 : 2;
  if (message->data_id == HYSTCAN_NO_DATA_ID) id_bytes = 0;
  uint16_t crc = polynomial->initial;
  for (unsigned i = 0; i < id_bytes; ++i) crc = crc_with(polynomial, crc, (uint8_t)(id >> 8 * i));
  for (unsigned i = 0; i < frame->length; ++i)
    if (i < own_byte || i >= own_byte + polynomial->bytes) crc = crc_with(polynomial, crc, frame->data[i]);
  return (uint16_t)((crc ^ polynomial->final_xor) >> (16 - 8 * polynomial->bytes));
}

void hystcan_make_frame(const struct hystcan_message* message, struct hystcan_frame* frame) {
  *frame = (struct hystcan_frame){.id = message->id,
                                  .extended = message->extended,
                                  .kind = message->kind,
                                  .bit_rate_switch = message->bit_rate_switch,
                                  .length = message->length};
}

void hystcan_seal(const struct hystcan_message* message, uint32_t counter, struct hystcan_frame* frame) {
  hystcan_put_raw(&message->counter, counter, frame->data);
  if (message->polynomial != HYSTCAN_NO_CRC)
    hystcan_put_raw(&message->crc, crc_of(message, frame), frame->data);
}

bool hystcan_is_intact(const struct hystcan_message* message, const struct hystcan_frame* frame) {
  if (frame->kind != message->kind || frame->extended != message->extended ||
      frame->length != message->length)
    return false;
  return message->polynomial == HYSTCAN_NO_CRC ||
         hystcan_get_raw(&message->crc, frame->data) == crc_of(message, frame);
}
