// A CAN database in Vector's DBC format: which messages exist, and where in them each signal lies.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace hystcan::can {

enum class ByteOrder : std::uint8_t { little_endian, big_endian };

/// What a signal's raw bits are: an integer, or an IEEE 754 number (SIG_VALTYPE_).
enum class ValueType : std::uint8_t { integer, float32, float64 };

/// How a signal takes part in multiplexing: `M` is the switch, `m3` is present where the switch reads 3.
struct Multiplexing {
  bool is_switch = false;
  std::optional<std::uint32_t> present_at;
};

/// physical = raw * scale + offset.  `start_bit` as the DBC writes it: the least significant bit of a
/// little-endian signal, the most significant of a big-endian one, in the sawtooth numbering of the format.
struct Signal {
  std::string name;
  std::uint16_t start_bit = 0;
  std::uint16_t length = 0;  ///< bits, 1..64
  ByteOrder byte_order = ByteOrder::little_endian;
  bool is_signed = false;
  ValueType value_type = ValueType::integer;
  double scale = 1.0;
  double offset = 0.0;
  double minimum = 0.0;  ///< physical range; minimum == maximum == 0 means: none stated
  double maximum = 0.0;
  std::string unit;
  std::string comment;
  std::vector<std::string> receivers;
  std::map<std::int64_t, std::string> values;  ///< VAL_: names of raw values
  Multiplexing multiplexing;
};

struct Message {
  std::uint32_t id = 0;
  bool extended = false;
  std::string name;
  std::uint8_t length = 0;  ///< bytes
  std::string sender;
  std::string comment;
  std::vector<Signal> signals;

  const Signal* find(std::string_view signal) const;  ///< null where absent
};

struct Database {
  std::string version;
  std::vector<std::string> nodes;
  std::vector<Message> messages;

  const Message* find(std::string_view message) const;  ///< null where absent
};

/// what() is `FILE:LINE:COLUMN: what, expected what`.
class DbcError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws DbcError where the text is not a DBC, names a message or signal twice, or lays a signal outside its
/// message.
Database parse_dbc(std::string_view text, const std::string& file_name);

/// Throws DbcError, also where the file can't be read.
Database load_dbc(const std::filesystem::path& file);

}  // namespace hystcan::can
