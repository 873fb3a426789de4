// Writes and reads CAN frames: a message of the DBC, with its signals, its counter and its CRC.
// hystcan_node.h uses this file. The node never changes a hystcan_message, so that the caller can store it in
// flash memory.
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
  uint8_t kind;          ///< kind of the frame, an enum hystcan_kind
  bool bit_rate_switch;  ///< true: the payload has the faster bit rate; only for HYSTCAN_FD
  uint8_t length;        ///< length of the payload in bytes
  uint8_t data[64];
};

/// One signal of a DBC file, of at most 32 bits:
///
///   value = raw * scale + offset
///
/// `value` is an integer in a unit that the caller chooses, such as 1e-6 V or 1e-6 um. A value outside of
/// minimum..maximum is not sent.
struct hystcan_field {
  uint16_t start;  ///< start bit, as in the DBC
  uint8_t length;  ///< number of bits; 0: the message has no such signal
  bool big_endian;
  bool is_signed;
  uint32_t scale;  ///< factor from the raw value to `value`, above 0
  int32_t offset;
  int32_t minimum, maximum;  ///< range of `value`; both limits must fit into the bits of the signal
};

/// Initialises a hystcan_field: a signed value of four bytes at the beginning of the payload, in the range
/// -most..most.
#define HYSTCAN_I32(most) \
  { .length = 32, .is_signed = true, .scale = 1, .minimum = -(most), .maximum = (most) }
/// Initialises a hystcan_field: an unsigned number of `count` bits, at most 30, from start bit `first` on.
#define HYSTCAN_BITS(first, count) \
  { .start = (first), .length = (count), .scale = 1, .maximum = (1 << (count)) - 1 }

enum hystcan_crc { HYSTCAN_NO_CRC, HYSTCAN_SAE_J1850, HYSTCAN_CRC_8H2F, HYSTCAN_CRC_16 };
enum hystcan_data_id { HYSTCAN_IDENTIFIER, HYSTCAN_NUMBER, HYSTCAN_NO_DATA_ID };

/// One message, with its counter and its CRC (docs/protocol/frames.md, "Counter and CRC").
struct hystcan_message {
  uint32_t id;
  bool extended;
  uint8_t kind;  ///< HYSTCAN_DATA or HYSTCAN_FD
  bool bit_rate_switch;
  uint8_t length;                ///< payload bytes on the wire: a length that CAN or CAN FD allows
  struct hystcan_field counter;  ///< signal of the counter; its length is 0 if there is no counter
  struct hystcan_field crc;      ///< signal of the CRC; must occupy whole bytes
  uint8_t polynomial;            ///< kind of the CRC, an enum hystcan_crc
  uint8_t data_id;               ///< an enum hystcan_data_id: the CRC covers the identifier, `number` or
                                 ///< nothing in addition to the payload
  uint16_t number;               ///< two bytes that the CRC covers in addition to the payload if `data_id` is
                                 ///< HYSTCAN_NUMBER; they are not sent
};

/// Returns the bits of a signal as a number; 0 if the message has no such signal.
uint32_t hystcan_get_raw(const struct hystcan_field* field, const uint8_t* data);
/// Writes the bits of a signal into the payload. These bits must be zero before the call.
void hystcan_put_raw(const struct hystcan_field* field, uint32_t raw, uint8_t* data);
/// Returns the value of a signal, limited to the range of int32_t. The message must have this signal.
int32_t hystcan_get_value(const struct hystcan_field* field, const uint8_t* data);
/// Writes a value into the payload, rounded to the nearest raw value (a half is rounded to the even raw
/// value). The bits of the signal must be zero before the call. Returns false if the value is outside of
/// minimum..maximum. Does nothing if the message has no such signal.
bool hystcan_put_value(const struct hystcan_field* field, int32_t value, uint8_t* data);

/// Makes a frame for this message whose payload is zero.
void hystcan_make_frame(const struct hystcan_message* message, struct hystcan_frame* frame);
/// Adds the counter and the CRC to a frame of this message.
void hystcan_seal(const struct hystcan_message* message, uint32_t counter, struct hystcan_frame* frame);
/// Returns true if kind, identifier type, length and CRC of the frame are right for the message.
bool hystcan_is_intact(const struct hystcan_message* message, const struct hystcan_frame* frame);

#ifdef __cplusplus
}
#endif
