// Reads the text of a DBC into the database.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "can/dbc/cursor.h"
#include "can/dbc/database.h"

namespace hystcan::can::dbc {

inline constexpr const char* message_id = "the identifier of a message";
inline constexpr const char* signal_name = "the name of a signal";
inline constexpr const char* frame_format = "VFrameFormat";  ///< attribute that states CAN or CAN FD
inline constexpr const char* bit_rate_switch = "CANFD_BRS";  ///< attribute that states the bit-rate switch
inline constexpr const char* quoted_text = "a text in quotes";

/// Maximum size of all copies together, in bytes. A section may apply to several objects, and each object
/// gets a copy of its content; for example, an attribute applies to all messages with the same identifier.
inline constexpr std::size_t largest_copies = std::size_t{64} << 20U;
inline constexpr std::size_t bytes_of_an_entry = 64;  ///< estimated size of a copy without its text

/// Returns the whole number in the token. Throws ParseError if the number is outside minimum..maximum; `what`
/// names the number in the error.
std::uint64_t natural(std::string_view token, std::uint64_t minimum, std::uint64_t maximum,
                      const std::string& what);

/// Returns the token in quotes, shortened if it is long.
std::string cited(std::string_view token);

/// Reads a DBC section by section. Each kind of section has one function, which starts with the cursor after
/// the section name.
///
/// The reader stores nodes, messages, value tables and attribute definitions immediately. Other sections have
/// details about these objects, for example value names and attributes. A section with details may be before
/// its message in the file. Therefore the reader applies all details after the last line. A section with
/// details names its message by identifier and its signal by name. If several messages or signals have the
/// same identifier or name, the section applies to all of them.
///
/// Comments, receivers, relations (BA_REL_) and most attributes are not stored. The reader checks their
/// syntax, and that their objects and attributes exist. A malformed comment (CM_), or a malformed definition
/// (BA_DEF_) of an attribute that is not stored, gives a warning and is skipped.
class Reader {
 public:
  explicit Reader(std::string_view text) : cursor_(text) {}

  /// Reads the whole text. Throws ParseError.
  Database read();

  /// An irregularity that the reader accepts, with its position in the text.
  using Warning = std::pair<const char*, std::string>;
  std::vector<Warning>& warnings() { return warnings_; }  ///< warnings of read()

 private:
  /// The names of a message and of its signals, as views into the text. A view also gives the position of the
  /// name for a warning.
  struct MessageText {
    std::string_view name;
    std::vector<std::string_view> signals;
    std::multimap<std::string_view, std::size_t> signal_by_name;
    std::optional<bool> fd;        ///< VFrameFormat states CAN FD; nullopt if the attribute is missing
    std::optional<bool> switches;  ///< CANFD_BRS is not 0; nullopt if the attribute is missing
  };

  /// The object that a comment or an attribute applies to.
  struct Subject {
    std::string_view kind;  ///< "" the network, "BU_" a node, "BO_" a message, "SG_" a signal, "EV_" an
                            ///< environment variable
    std::string_view name;  ///< name of the node, the signal or the environment variable
    std::string_view id;    ///< identifier of the message, if `kind` is "BO_" or "SG_"
  };

  /// The value of an attribute: a number or a text.
  struct Value {
    std::string_view token;
    bool is_text = false;
  };

  struct Attribute {
    std::string_view type;                ///< INT, HEX, FLOAT, STRING or ENUM
    std::vector<std::string_view> items;  ///< value names of an ENUM; minimum and maximum of a number
    std::optional<Value> default_value;
  };

  using Names = std::map<std::int64_t, std::string>;
  using Ranges = std::vector<Multiplexing::Range>;

  bool section();
  void read_section(std::string_view keyword, void (Reader::*read_one)());
  bool stray();
  void need_semicolon();
  void note(std::string_view at, std::string what);
  static void need_room(std::size_t count, std::size_t most, std::string_view at, const char* of);

  // Functions for the sections about the whole network
  void version();
  void new_symbols();
  void bit_timing();
  void nodes();

  // Functions for messages (BO_) and their signals (SG_)
  void message();
  void signal();
  void read_coding(Signal& signal, const std::string& of);
  void read_range(Signal& signal, const std::string& of);
  Multiplexing simple_multiplexing(std::string_view word, const std::string& of);
  char one_of(std::string_view marks, const std::string& words);
  void skip_receivers();
  void note_of_signal(std::string_view at, std::string what);
  void add_signal(Signal signal, std::string_view name, std::string_view start_bit);
  static void find_switch(Message& message);
  void note_overlaps(const Message& message, const MessageText& text);

  // Functions for the sections with details about messages and signals
  Subject subject();
  void comment();
  Names value_names();
  void value_table();
  void values();
  void set_values(std::string_view id, std::string_view signal, std::string_view table, Names names);
  void value_type();
  void multiplexing();
  void set_multiplexing(std::string_view id, std::string_view switched, std::string_view by,
                        const Ranges& ranges);

  // Functions for the sections about attributes
  void definition();
  Value value();
  void attribute_default();
  void attribute();
  void relation();
  void set_long_name(const Subject& subject, std::string_view name);
  Value known_value(std::string_view name, const Value& value);
  void name_senders();
  void note_repeated_long_names();
  static bool is_fd(const Value& format);
  static bool switches(const Value& brs);
  void set_frame_formats();

  // Functions for sections that apply to several objects. `act` is called for each object with the given
  // identifier and name. It may store a copy of the content of the section in the object; `bytes` is the size
  // of this copy. count_copies() limits the size of all copies together.
  void count_copies(std::string_view at, std::size_t bytes);
  template <class Do>
  void for_objects(const Subject& subject, std::size_t bytes, Do&& act);
  template <class Do>
  void for_messages(std::string_view id, std::size_t bytes, Do&& act);
  template <class Do>
  void for_signals(std::string_view id, std::string_view name, std::size_t bytes, Do&& act);

  Cursor cursor_;
  Database database_;
  std::vector<Warning> warnings_;
  std::vector<MessageText> texts_;                 ///< names of each message in database_.messages
  bool in_message_ = false;                        ///< true while signal lines (SG_) may follow
  bool in_left_out_ = false;                       ///< true while the signal lines (SG_) of Vector's
                                                   ///< pseudo-message are read; they are not stored
  std::optional<std::uint64_t> left_out_;          ///< identifier of Vector's pseudo-message, which has no
                                                   ///< frame and is not stored
  std::vector<std::function<void()>> details_;     ///< functions that run after the last line; each
                                                   ///< function applies one section
  std::vector<std::function<void()>> long_names_;  ///< functions that run after details_; each function
                                                   ///< sets one long name
  std::size_t copied_ = 0;
  // The maps are trees, because a hostile file can choose keys for which each search in a hash table is slow.
  std::map<std::string_view, std::string> nodes_;  ///< long name of each node; empty if it has none
  std::map<std::string, Names> value_tables_;
  std::map<std::string, Attribute> attributes_;
  std::map<std::string_view, std::size_t> names_;    ///< index of each message by its name
  std::multimap<std::uint64_t, std::size_t> by_id_;  ///< index of each message by its identifier in the DBC
};

template <class Do>
void Reader::for_messages(std::string_view id, std::size_t bytes, Do&& act) {
  const std::uint64_t number = natural(id, 0, 0xFFFF'FFFF, message_id);
  const auto [first, last] = by_id_.equal_range(number);
  if (first == last && number != left_out_) note(id, "there is no message " + std::string(id));
  for (auto each = first; each != last; ++each) {
    if (each != first) count_copies(id, bytes_of_an_entry + bytes);
    act(each->second);
  }
}

template <class Do>
void Reader::for_signals(std::string_view id, std::string_view name, std::size_t bytes, Do&& act) {
  for_messages(id, bytes, [&](std::size_t index) {
    Message& message = database_.messages[index];
    const auto [first, last] = texts_[index].signal_by_name.equal_range(name);
    if (first == last) note(name, "message " + message.name + " has no signal " + std::string(name));
    for (auto each = first; each != last; ++each) {
      if (each != first) count_copies(name, bytes_of_an_entry + bytes);
      act(message.signals[each->second]);
    }
  });
}

/// Calls `act` with each object that `subject` means: a message, a signal, or the long name of a node. Does
/// nothing for the network and for environment variables, because the database does not store them.
template <class Do>
void Reader::for_objects(const Subject& subject, std::size_t bytes, Do&& act) {
  if (subject.kind == "BO_") {
    for_messages(subject.id, bytes, [&](std::size_t index) { act(database_.messages[index]); });
  } else if (subject.kind == "SG_") {
    for_signals(subject.id, subject.name, bytes, act);
  } else if (subject.kind == "BU_") {
    const auto found = nodes_.find(subject.name);
    if (found != nodes_.end())
      act(found->second);
    else if (subject.name != "Vector__XXX")
      note(subject.name, "there is no node " + std::string(subject.name));
  }
}

}  // namespace hystcan::can::dbc
