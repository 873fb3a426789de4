// A CAN database in Vector's DBC format: which messages exist, and where in them each signal lies.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <variant>
#include <vector>

namespace hystcan::can {

enum class ByteOrder : std::uint8_t { little_endian, big_endian };

/// What a signal's raw bits are: an integer, or an IEEE 754 number (SIG_VALTYPE_). `unreadable` is said to be
/// one, of a width that none has: as an integer it would be a wrong number.
enum class ValueType : std::uint8_t { integer, float32, float64, unreadable };

/// How a signal takes part in multiplexing: `M` is a switch, `m3` is present where the switch reads 3.
struct Multiplexing {
  struct Range {
    std::uint64_t low = 0;
    std::uint64_t high = 0;  ///< belongs to it
  };
  bool is_switch = false;
  std::optional<std::uint32_t> present_at;  ///< as the signal's own line says
  std::optional<std::size_t> switched_by;   ///< index of the switch among the message's signals
  std::vector<Range> ranges;                ///< bits of the switch where it is present (SG_MUL_VAL_, or m3)
};

/// The value of an attribute (BA_): INT and HEX, FLOAT, STRING or the name of an ENUM's item.
using AttributeValue = std::variant<std::int64_t, double, std::string>;
using Attributes = std::map<std::string, AttributeValue, std::less<>>;

/// physical = raw * scale + offset.  `start_bit` as the DBC writes it: the least significant bit of a
/// little-endian signal, the most significant of a big-endian one, in the sawtooth numbering of the format.
struct Signal {
  std::string name;
  std::uint32_t start_bit = 0;
  std::uint16_t length = 0;  ///< bits; a codec takes 1..64
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
  Attributes attributes;              ///< those given to it; attribute() knows defaults, too
  std::optional<double> start_value;  ///< GenSigStartValue, raw
};

/// Of 1 to 64 bits, and of a known kind.
bool is_decodable(const Signal& signal);

/// Bytes of payload that the signal reaches into.
std::size_t bytes_needed(const Signal& signal);

struct Message {
  std::uint32_t id = 0;
  bool extended = false;
  std::string name;
  std::uint16_t length = 0;  ///< bytes; more than 64 where a transport protocol carries it (J1939)
  bool fd = false;           ///< CAN FD: by VFrameFormat, without one by its length
  std::string sender;
  std::string comment;
  std::vector<Signal> signals;
  Attributes attributes;
  std::optional<double> cycle_time_ms;  ///< GenMsgCycleTime, where it is not 0

  const Signal* find(std::string_view signal) const;  ///< null where absent
};

struct Node {
  std::string name;
  std::string comment;
  Attributes attributes;
};

/// BA_DEF_ and its default, BA_DEF_DEF_.
struct AttributeDefinition {
  enum class Type : std::uint8_t { integer, hexadecimal, real, text, enumeration };

  std::string object;  ///< "" network, "BU_" node, "BO_" message, "SG_" signal, "EV_", "BU_SG_REL_", ...
  Type type = Type::text;
  std::vector<std::string> items;  ///< of an enumeration
  std::optional<AttributeValue> default_value;
};

/// BA_REL_: an attribute of a node together with a message, a signal, an environment variable.
struct RelationAttribute {
  std::string name;
  std::string node;
  std::string message;  ///< empty where it is none
  std::string object;   ///< signal or environment variable
  AttributeValue value;
};

struct Database {
  std::string version;
  std::string comment;
  std::vector<Node> nodes;
  std::vector<Message> messages;
  std::map<std::string, std::map<std::int64_t, std::string>, std::less<>> value_tables;  ///< VAL_TABLE_
  std::map<std::string, AttributeDefinition, std::less<>> attribute_definitions;
  Attributes attributes;  ///< of the network
  std::vector<RelationAttribute> relation_attributes;
  std::vector<std::string> warnings;  ///< what is odd but readable: `FILE:LINE:COLUMN: what`
  std::unordered_map<std::uint32_t, std::size_t> message_by_id;  ///< key_of() to the last of that identifier

  const Message* find(std::string_view message) const;  ///< the first; null where absent

  static std::uint32_t key_of(std::uint32_t id, bool extended) { return extended ? id | 1U << 31U : id; }
};

/// The attribute given to an object, else its default. Null where there is neither.
const AttributeValue* attribute(const Database& database, const Attributes& given, std::string_view name);

/// what() is `FILE:LINE:COLUMN: what, expected what`.
class DbcError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws DbcError where the text is not a DBC; what real files hold against its letter is a warning. Texts
/// come out as UTF-8. docs/protocol.md says what is tolerated, and how.
Database parse_dbc(std::string_view text, const std::string& file_name);

/// Throws DbcError, also where the file can't be read.
Database load_dbc(const std::filesystem::path& file);

}  // namespace hystcan::can
