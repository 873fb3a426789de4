// Frames, the layout of messages and their protection, for hystcan_node.h. All tables are constant, so they
// may be in flash.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum hystcan_kind { HYSTCAN_DATA, HYSTCAN_FD, HYSTCAN_REMOTE };

struct hystcan_frame {
  uint32_t id;  ///< 11 bits, or 29 bits if `extended`
  bool extended;
  uint8_t kind;          ///< enum hystcan_kind
  bool bit_rate_switch;  ///< only used if `kind` is HYSTCAN_FD
  uint8_t length;        ///< payload bytes
  uint8_t data[64];
};

/// One signal of a DBC file, of at most 32 bits:
///
///   value = raw * scale + offset
///
/// `value` is an integer of the caller's unit, such as 1e-6 V or 1e-6 um. A value outside of
/// minimum..maximum is not sent.
struct hystcan_field {
  uint16_t start;  ///< start bit, as in the DBC
  uint8_t length;  ///< bits; 0: the message has no such signal
  bool big_endian;
  bool is_signed;
  uint32_t scale;  ///< > 0
  int32_t offset;
  int32_t minimum, maximum;  ///< range of `value`; both limits can be represented
};

/// Initialises a signed value of four bytes at the beginning of the payload, within +-`most`.
#define HYSTCAN_I32(most) \
  { .length = 32, .is_signed = true, .scale = 1, .minimum = -(most), .maximum = (most) }
/// Initialises an unsigned number of at most 30 bits.
#define HYSTCAN_BITS(first, count) \
  { .start = (first), .length = (count), .scale = 1, .maximum = (1 << (count)) - 1 }

enum hystcan_crc { HYSTCAN_NO_CRC, HYSTCAN_SAE_J1850, HYSTCAN_CRC_8H2F, HYSTCAN_CRC_16 };
enum hystcan_data_id { HYSTCAN_IDENTIFIER, HYSTCAN_NUMBER, HYSTCAN_NO_DATA_ID };

/// One message, and how it is protected ("Counter and CRC").
struct hystcan_message {
  uint32_t id;
  bool extended;
  uint8_t kind;  ///< HYSTCAN_DATA or HYSTCAN_FD
  bool bit_rate_switch;
  uint8_t length;                ///< payload bytes on the wire: a length that CAN or CAN FD allows
  struct hystcan_field counter;  ///< length 0: no counter
  struct hystcan_field crc;      ///< occupies whole bytes
  uint8_t polynomial;            ///< enum hystcan_crc
  uint8_t data_id;               ///< enum hystcan_data_id: bytes that the CRC covers before the payload
  uint16_t number;               ///< the data id, if `data_id` is HYSTCAN_NUMBER
};

/// Returns the bits of a signal, low bit first; 0 if there is no such signal.
uint32_t hystcan_get_raw(const struct hystcan_field* field, const uint8_t* data);
/// Writes the bits of a signal, which must be zero in the payload.
void hystcan_put_raw(const struct hystcan_field* field, uint32_t raw, uint8_t* data);
/// Returns the value of a signal that the message has, limited to the range of int32_t.
int32_t hystcan_get_value(const struct hystcan_field* field, const uint8_t* data);
/// Writes a value, rounded to the nearest raw value, halves to the even one. Returns false if the value does
/// not fit.
bool hystcan_put_value(const struct hystcan_field* field, int32_t value, uint8_t* data);

/// Makes an empty frame for this message.
void hystcan_make_frame(const struct hystcan_message* message, struct hystcan_frame* frame);
/// Adds the counter and the CRC.
void hystcan_seal(const struct hystcan_message* message, uint32_t counter, struct hystcan_frame* frame);
/// Returns true if kind, length and CRC of the frame match the message.
bool hystcan_is_intact(const struct hystcan_message* message, const struct hystcan_frame* frame);

#ifdef __cplusplus
}
#endif
