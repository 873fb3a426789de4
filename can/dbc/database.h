// A CAN database in Vector's DBC format: the messages, and the position of each signal in its message.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace hystcan::can {

enum class ByteOrder : std::uint8_t { little_endian, big_endian };

/// The type of a signal's raw bits: an integer or an IEEE 754 number (SIG_VALTYPE_). An `unreadable` signal
/// is declared as IEEE 754 but has another width; decoding it as an integer would give a wrong number.
enum class ValueType : std::uint8_t { integer, float32, float64, unreadable };

/// The multiplexing of a signal. In the DBC, `M` marks a switch signal; a signal with the mark `m3` is
/// present in a frame if the value of the switch signal in this frame is 3.
struct Multiplexing {
  struct Range {
    std::uint64_t low = 0;
    std::uint64_t high = 0;  ///< the range includes this value
  };
  bool is_switch = false;
  std::optional<std::uint32_t> present_at;  ///< number in the mark of the signal: 3 for `m3`
  std::optional<std::size_t> switched_by;   ///< index of the switch signal among the message's signals
  /// Values of the switch signal at which this signal is present, from SG_MUL_VAL_ or a mark like `m3`. The
  /// ranges ascend and do not overlap.
  std::vector<Range> ranges;
};

/// One signal:
///
///   physical = raw * scale + offset
///
/// `start_bit` is the number in the DBC: the position of the least significant bit of a little-endian signal,
/// or of the most significant bit of a big-endian signal. Position 8 k + i is bit i of byte k; i = 0 is the
/// lowest bit of the byte.
struct Signal {
  std::string name;
  std::string short_name;  ///< shortened name in the SG_ line if an attribute has the long name; else empty
  std::uint32_t start_bit = 0;
  std::uint16_t length = 0;  ///< number of bits; SignalCodec accepts 1..64
  ByteOrder byte_order = ByteOrder::little_endian;
  bool is_signed = false;
  ValueType value_type = ValueType::integer;
  double scale = 1.0;
  double offset = 0.0;
  double minimum = 0.0;  ///< physical range; minimum == maximum == 0 if the DBC states no range
  double maximum = 0.0;
  std::string unit;
  std::map<std::int64_t, std::string> values;  ///< names of raw values (VAL_)
  Multiplexing multiplexing;
};

/// Returns true if the signal has 1 to 64 bits and a readable value type.
bool is_decodable(const Signal& signal);

/// Returns the shortest payload length that contains the whole signal, in bytes.
std::size_t bytes_needed(const Signal& signal);

struct Message {
  std::uint32_t id = 0;
  bool extended = false;
  std::string name;
  std::string short_name;        ///< shortened name in the BO_ line if an attribute has the long name; else
                                 ///< empty
  std::uint16_t length = 0;      ///< bytes; more than 64 if a transport protocol carries the message (J1939)
  bool fd = false;               ///< true for a CAN FD frame, according to the attribute VFrameFormat or, if
                                 ///< the attribute is missing, to the length
  bool bit_rate_switch = false;  ///< true if the CAN FD data phase uses the data bit rate (CANFD_BRS not 0)
  std::string sender;
  std::vector<Signal> signals;

  /// Finds a signal by its name, or by its short name if only one signal has it. Null if not found.
  const Signal* find(std::string_view signal) const;
};

struct Database {
  std::vector<Message> messages;
  std::vector<std::string> warnings;  ///< text for each accepted irregularity: `FILE:LINE:COLUMN: TEXT`
  std::size_t further_warnings = 0;   ///< number of warnings that are not stored in `warnings`
  std::map<std::uint32_t, std::size_t> message_by_id;  ///< index of the message with a key, which is made by
                                                       ///< key_of(); the last message if several have the key

  /// Finds the first message of this name, or the only message of this short name. Null if not found.
  const Message* find(std::string_view message) const;

  static std::uint32_t key_of(std::uint32_t id, bool extended) { return extended ? id | 1U << 31U : id; }
};

/// The size limits of a DBC. Within these limits, parsing time and memory are proportional to the file size.
namespace dbc {
inline constexpr std::size_t largest_file = std::size_t{16} << 20U;  ///< maximum file size in bytes (16 MiB)
inline constexpr std::size_t longest_name = 1024;    ///< maximum bytes of a name, a number or a unit
inline constexpr std::size_t longest_text = 65'536;  ///< maximum bytes of a comment or an attribute value
inline constexpr std::size_t most_nodes = 65'536;
inline constexpr std::size_t most_messages = 65'536;
inline constexpr std::size_t most_signals = 65'536;  ///< maximum number of signals in one message
inline constexpr std::size_t most_items = 65'536;    ///< maximum number of entries in one list, such as
                                                     ///< receivers or value names
inline constexpr std::size_t most_warnings = 1000;   ///< number of stored warnings; the rest is only counted
}  // namespace dbc

/// Parses the text of a DBC. Throws Error if the text is not a valid DBC or exceeds the size limits in the
/// namespace `dbc`. Known irregularities of real files give a warning; docs/protocol/dbc.md lists them. All
/// texts are converted to UTF-8. Comments, receivers and most attributes are checked but not stored.
Database parse_dbc(std::string_view text, const std::string& file_name);

/// Loads a DBC file with parse_dbc(). Also throws Error if the file can't be read.
Database load_dbc(const std::filesystem::path& file);

}  // namespace hystcan::can
