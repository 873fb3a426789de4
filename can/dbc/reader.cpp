#include "can/dbc/reader.h"

#include <algorithm>
#include <cmath>

#include "can/dbc/text.h"

namespace hystcan::can::dbc {
namespace {

constexpr std::uint64_t extended_flag = 0x8000'0000;
constexpr std::uint64_t max_standard_id = 0x7FF;
constexpr std::uint64_t max_extended_id = 0x1FFF'FFFF;
constexpr std::uint64_t max_message_bytes = 0xFFFF;
constexpr std::uint64_t max_length = 0xFFFF;  // maximum bits of a signal; above 64, it is not decoded
constexpr std::uint64_t max_signal_bits = 64;
constexpr std::uint16_t max_classical_bytes = 8;
constexpr std::uint16_t max_fd_bytes = 64;
constexpr std::uint64_t independent_signals_id = 0xC000'0000;
constexpr std::string_view independent_signals_name = "VECTOR__INDEPENDENT_SIG_MSG";
constexpr const char* semicolon = "';' at the end of the section";
constexpr const char* colon = "':' after the section's name";

double finite(std::string_view token, const std::string& what) {
  const auto number = to_real(token);
  if (!number || !std::isfinite(*number))
    throw ParseError{token.data(), cited(token), what + " that a double can hold"};
  return *number;
}

double real(std::string_view token, const std::string& what) {
  const auto number = to_real(token);
  if (!number) throw ParseError{token.data(), cited(token), what};
  return *number;
}

/// Takes the rest of a section, up to ';'. Returns false if the section or a quoted text in it has no end.
bool ends_in_semicolon(Cursor& cursor) {
  try {
    return cursor.take_until_semicolon();
  } catch (const ParseError&) {
    return false;
  }
}

}  // namespace

std::string cited(std::string_view token) {
  constexpr std::size_t most = 60;
  const bool whole = token.size() <= most;
  return '\'' + std::string(token.substr(0, most)) + (whole ? "'" : "...'");
}

std::uint64_t natural(std::string_view token, std::uint64_t minimum, std::uint64_t maximum,
                      const std::string& what) {
  const auto number = to_natural(token);
  if (number && *number >= minimum && *number <= maximum) return *number;
  throw ParseError{token.data(), cited(token),
                   what + " from " + std::to_string(minimum) + " to " + std::to_string(maximum)};
}

Database Reader::read() {
  constexpr const char* beginning = "a DBC, which begins with VERSION, NS_, BS_, BU_ or BO_";
  if (cursor_.at_end()) cursor_.refuse(beginning);
  for (bool first = true; !cursor_.at_end(); first = false) {
    if (!section()) cursor_.refuse(first ? beginning : "a section of a DBC, such as BO_, CM_ or VAL_");
  }
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    find_switch(database_.messages[i]);
    note_overlaps(database_.messages[i], texts_[i]);
  }
  for (const auto& apply : details_) apply();
  for (const auto& apply : long_names_) apply();
  name_senders();
  note_repeated_long_names();
  set_frame_formats();
  return std::move(database_);
}

bool Reader::section() {
  struct Section {
    std::string_view keyword;
    void (Reader::*read)();
  };
  static constexpr Section known[] = {{"SG_", &Reader::signal},
                                      {"BO_", &Reader::message},
                                      {"VAL_", &Reader::values},
                                      {"CM_", &Reader::comment},
                                      {"BA_", &Reader::attribute},
                                      {"VERSION", &Reader::version},
                                      {"NS_", &Reader::new_symbols},
                                      {"BS_", &Reader::bit_timing},
                                      {"BU_", &Reader::nodes},
                                      {"VAL_TABLE_", &Reader::value_table},
                                      {"SIG_VALTYPE_", &Reader::value_type},
                                      {"SG_MUL_VAL_", &Reader::multiplexing},
                                      {"BA_DEF_", &Reader::definition},
                                      {"BA_DEF_REL_", &Reader::definition},
                                      {"BA_DEF_DEF_", &Reader::attribute_default},
                                      {"BA_DEF_DEF_REL_", &Reader::attribute_default},
                                      {"BA_REL_", &Reader::relation}};
  const std::string_view word = cursor_.peek_word();
  const auto* found = std::find_if(std::begin(known), std::end(known),
                                   [&](const Section& each) { return each.keyword == word; });
  if (found != std::end(known)) {
    cursor_.take_word();
    if (found->keyword != "SG_") in_message_ = found->keyword == "BO_";
    read_section(found->keyword, found->read);
    return true;
  }
  if (is_section(word) || looks_like_section(word)) {
    in_message_ = false;
    if (!is_section(word)) note(word, "section " + std::string(word) + " is unknown: skipped");
    cursor_.take_word();
    if (!cursor_.take_until_semicolon()) need_semicolon();
    return true;
  }
  return stray();
}

/// Reads one section. Skips a malformed comment (CM_) or attribute definition (BA_DEF_) with a warning,
/// unless it has VFrameFormat or CANFD_BRS (frame format). Throws ParseError for all other errors.
void Reader::read_section(std::string_view keyword, void (Reader::*read_one)()) {
  Cursor start = cursor_;
  try {
    (this->*read_one)();
  } catch (const ParseError& error) {
    Cursor rest = start;
    const bool ends = (keyword == "CM_" || keyword == "BA_DEF_") && ends_in_semicolon(rest);
    const std::string_view text(start.place(),
                                static_cast<std::size_t>(ends ? rest.place() - start.place() : 0));
    if (!ends || text.size() > longest_text || text.find(frame_format) != std::string_view::npos ||
        text.find(bit_rate_switch) != std::string_view::npos)
      throw;
    note({error.where, 1}, "found " + error.found + ", expected " + error.expected + ": this " +
                               std::string(keyword) + " is skipped");
    cursor_ = rest;
  }
}

/// Skips an extra ';' or a comment that begins with '//', with a warning: the format has neither.
bool Reader::stray() {
  const std::string_view here(cursor_.place(), 1);
  if (cursor_.take(';')) {
    note(here, "an extra ';': skipped");
    return true;
  }
  if (cursor_.next() != '/') return false;
  const std::string_view line = cursor_.take_line();
  if (!line.starts_with("//")) throw ParseError{here.data(), "'/'", "a section such as BO_, CM_ or VAL_"};
  note(here, "a comment after '//' is not part of the format: the comment is skipped");
  return true;
}

/// Takes the ';' at the end of a section. Warns if ';' is missing before the next section or the file's end.
void Reader::need_semicolon() {
  if (cursor_.take(';')) return;
  if (cursor_.at_end())
    return note(cursor_.take_line(), "the file ends before the last ';': it may be incomplete");
  const std::string_view next = cursor_.peek_word();
  if (!is_section(next) || !cursor_.at_line_start()) cursor_.refuse(semicolon);
  note(next, "found '" + std::string(next) + "' before " + semicolon);
}

void Reader::note(std::string_view at, std::string what) {
  if (warnings_.size() < most_warnings)
    warnings_.emplace_back(at.data(), std::move(what));
  else
    ++database_.further_warnings;
}

/// Counts the bytes of one more copy of a section. Without the limit, a small file could fill the memory.
void Reader::count_copies(std::string_view at, std::size_t bytes) {
  copied_ += bytes;
  if (copied_ <= largest_copies) return;
  throw ParseError{at.data(), "too many messages or signals that each store a copy of this section",
                   "at most " + std::to_string(largest_copies) + " bytes for all copies of sections"};
}

void Reader::need_room(std::size_t count, std::size_t most, std::string_view at, const char* of) {
  if (count < most) return;
  throw ParseError{at.data(), std::to_string(most + 1) + ' ' + of, "at most " + std::to_string(most)};
}

void Reader::version() {
  cursor_.need_quoted("the version in quotes", longest_text);
  cursor_.take(';');
}

/// Skips the list of section names after NS_. Stops at a line that begins the next section.
void Reader::new_symbols() {
  if (!cursor_.take(':')) cursor_.refuse(colon);
  while (!cursor_.at_end()) {
    const std::string_view word = cursor_.peek_word();
    if (word.empty() || word == "BS_" || word == "BU_" || word == "BO_" || word == "VERSION") return;
    Cursor ahead = cursor_;
    if (ahead.take_line().find_first_of("\":;=|") != std::string_view::npos) return;
    cursor_ = ahead;
  }
}

void Reader::bit_timing() {
  cursor_.need(':', colon);
  cursor_.take_any_of("0123456789:,.;");
}

void Reader::nodes() {
  cursor_.need(':', colon);
  while (true) {
    const std::string_view word = cursor_.peek_word();
    if (word.empty() || is_section(word)) break;
    if (cursor_.at_line_start() && looks_like_section(word)) break;
    need_room(nodes_.size(), most_nodes, word, "nodes");
    const std::string_view name = cursor_.need_word("the name of a node");
    if (!nodes_.try_emplace(name).second) note(name, "node " + std::string(name) + " occurs a second time");
    cursor_.take(',');
  }
  cursor_.take(';');
}

void Reader::message() {
  const std::string_view id_token = cursor_.need_number(message_id);
  const std::string_view name = cursor_.need_word("the name of a message");
  const std::string of = " of message " + std::string(name);
  cursor_.need(':', "':' after the name" + of);
  const std::string_view length = cursor_.need_number("the length" + of + " in bytes");
  std::string_view sender;
  if (cursor_.next_is_on_this_line())
    sender = cursor_.need_word("the sender" + of);
  else
    note(name, "message " + std::string(name) + " has no sender");
  cursor_.take(';');
  need_room(database_.messages.size(), most_messages, id_token, "messages");

  const std::uint64_t id = natural(id_token, 0, 0xFFFF'FFFF, message_id);
  in_left_out_ = id == independent_signals_id || name == independent_signals_name;
  if (in_left_out_) {
    left_out_ = id;
    return;
  }
  Message message;
  message.name = to_utf8(name);
  message.sender = to_utf8(sender);
  message.extended = id > max_standard_id;
  message.id = static_cast<std::uint32_t>(id & ~extended_flag);
  if (message.id > max_extended_id) {
    throw ParseError{id_token.data(), cited(id_token),
                     "an identifier of 11 bits, or of 29 bits with bit 31 set"};
  }
  if (message.extended && (id & extended_flag) == 0)
    note(id_token, "identifier " + std::string(id_token) + " of message " + message.name +
                       " has more than 11 bits, but bit 31 is not set: it is read as extended");
  message.length = static_cast<std::uint16_t>(
      natural(length, 0, max_message_bytes, "a length of message " + message.name + " in bytes"));
  message.fd = message.length > max_classical_bytes && message.length <= max_fd_bytes;

  const std::size_t index = database_.messages.size();
  if (!names_.emplace(name, index).second)
    note(name, "message " + message.name + " occurs a second time: this name selects the first message");
  if (!database_.message_by_id.insert_or_assign(Database::key_of(message.id, message.extended), index)
           .second) {
    note(id_token, "identifier " + std::string(id_token) +
                       " occurs a second time: its frames are decoded as the last of these messages");
  }
  by_id_.emplace(id, index);
  texts_.push_back({name, {}, {}, {}, {}});
  database_.messages.push_back(std::move(message));
}

void Reader::signal() {
  const std::string_view name = cursor_.need_word(signal_name);
  if (!in_message_) throw ParseError{name.data(), "signal " + std::string(name), "a message (BO_) before it"};
  const std::string of = " of signal " + std::string(name);
  Signal signal;
  signal.name = to_utf8(name);
  const auto multiplexing = cursor_.take_word();
  cursor_.need(':', "':' after the name" + of);
  if (multiplexing) signal.multiplexing = simple_multiplexing(*multiplexing, of);
  const std::string_view start_bit = cursor_.need_number("the start bit" + of);
  signal.start_bit =
      static_cast<std::uint32_t>(natural(start_bit, 0, 8 * max_message_bytes - 1, "a start bit" + of));
  read_coding(signal, of);
  read_range(signal, of);
  const std::string_view unit = cursor_.need_quoted("the unit" + of + " in quotes", longest_name);
  if (unit.find_first_of("\r\n") != std::string_view::npos)
    throw ParseError{unit.data() - 1, "a text over several lines", "the unit" + of + " in one line"};
  signal.unit = unescaped(unit);
  skip_receivers();
  if (!in_left_out_) add_signal(std::move(signal), name, start_bit);
}

/// Parses the multiplexing mark of a signal: `M`, `m3` or `m3M`. Some tools write `m` instead of `M`.
Multiplexing Reader::simple_multiplexing(std::string_view word, const std::string& of) {
  Multiplexing result;
  const bool small = word == "m" || (word.ends_with('m') && word.size() > 2);
  result.is_switch = small || word.ends_with('M');
  if (small) note_of_signal(word, "the multiplexing mark" + of + " ends in m: it is read as M, a switch");
  const std::string_view mark = word.substr(0, word.size() - (result.is_switch ? 1 : 0));
  if (mark.empty()) return result;
  const auto value = mark.starts_with('m') ? to_natural(mark.substr(1)) : std::nullopt;
  if (!value || *value > 0xFFFF'FFFF)
    throw ParseError{word.data(), cited(word), "M, or m with a number, or ':' after the name" + of};
  result.present_at = static_cast<std::uint32_t>(*value);
  return result;
}

/// Reads length, byte order, sign, scale and offset of a signal: `|16@1+ (0.1,0)`.
void Reader::read_coding(Signal& signal, const std::string& of) {
  cursor_.need('|', "'|' in the bit position" + of);
  const std::string_view length = cursor_.need_number("the length" + of + " in bits");
  signal.length = static_cast<std::uint16_t>(natural(length, 0, max_length, "a length" + of));
  if (signal.length < 1 || signal.length > max_signal_bits)
    note_of_signal(length, "a length of " + std::to_string(signal.length) + " bits" + of +
                               ": the signal is not decoded");
  cursor_.need('@', "'@' before the byte order" + of);
  const char order = one_of("01", "0 (big-endian) or 1 (little-endian) as the byte order" + of);
  signal.byte_order = order == '1' ? ByteOrder::little_endian : ByteOrder::big_endian;
  signal.is_signed = one_of("+-", "'+' (unsigned) or '-' (signed) as the value type" + of) == '-';
  cursor_.need('(', "'(' before the scale" + of);
  const std::string_view scale = cursor_.need_number("the scale" + of + ", a number");
  signal.scale = finite(scale, "a scale" + of);
  if (signal.scale == 0.0) note_of_signal(scale, "a scale of 0" + of + ": the signal can't be encoded");
  cursor_.need(',', "',' between scale and offset" + of);
  signal.offset = finite(cursor_.need_number("the offset" + of + ", a number"), "an offset" + of);
  cursor_.need(')', "')' after the offset" + of);
}

void Reader::read_range(Signal& signal, const std::string& of) {
  cursor_.need('[', "'[' before the range" + of);
  const std::string_view low = cursor_.need_number("the minimum" + of + ", a number");
  const double minimum = real(low, "a minimum" + of);
  cursor_.need('|', "'|' in the range" + of);
  const std::string_view high = cursor_.need_number("the maximum" + of + ", a number");
  const double maximum = real(high, "a maximum" + of);
  cursor_.need(']', "']' after the range" + of);
  if (minimum <= maximum) {
    signal.minimum = minimum;
    signal.maximum = maximum;
    return;
  }
  note_of_signal(low, "minimum " + std::string(low) + " and maximum " + std::string(high) + of +
                          " are not a valid range: the range is ignored");
}

char Reader::one_of(std::string_view marks, const std::string& words) {
  const char mark = cursor_.next();
  if (marks.find(mark) == std::string_view::npos) cursor_.refuse(words);
  cursor_.take(mark);
  return mark;
}

/// Skips the names of the receiving nodes on the signal's line and, after a comma, on the next line.
void Reader::skip_receivers() {
  bool more = false;
  for (std::size_t count = 0; more || cursor_.next_is_on_this_line(); ++count) {
    const std::string_view name = cursor_.peek_word();
    if (name.empty() || is_section(name)) break;
    need_room(count, most_items, name, "receivers of a signal");
    cursor_.need_word("a receiver");
    more = cursor_.take(',');
  }
  cursor_.take(';');
}

void Reader::note_of_signal(std::string_view at, std::string what) {
  if (!in_left_out_) note(at, std::move(what));
}

void Reader::add_signal(Signal signal, std::string_view name, std::string_view start_bit) {
  Message& message = database_.messages.back();
  MessageText& text = texts_.back();
  need_room(message.signals.size(), most_signals, name, "signals of a message");
  if (text.signal_by_name.contains(name) && !signal.multiplexing.present_at)
    note(name,
         "signal " + signal.name + " occurs a second time in message " + message.name + ": both are kept");
  if (bytes_needed(signal) > message.length)
    note(start_bit, "signal " + signal.name + " reaches beyond the " + std::to_string(message.length) +
                        " bytes of message " + message.name);
  text.signal_by_name.emplace(name, message.signals.size());
  text.signals.push_back(name);
  message.signals.push_back(std::move(signal));
}

/// Resolves simple multiplexing: every signal with a mark such as `m3` depends on the signal with the mark
/// `M`. If the message has no signal with `M`, all its signals are always present.
void Reader::find_switch(Message& message) {
  auto& all = message.signals;
  const auto is_first = [](const Signal& signal) {
    return signal.multiplexing.is_switch && !signal.multiplexing.present_at;
  };
  const auto found = std::find_if(all.begin(), all.end(), is_first);
  if (found == all.end()) return;
  const auto index = static_cast<std::size_t>(found - all.begin());
  for (Signal& signal : all) {
    Multiplexing& multiplexing = signal.multiplexing;
    if (!multiplexing.present_at) continue;
    multiplexing.switched_by = index;
    multiplexing.ranges = {{*multiplexing.present_at, *multiplexing.present_at}};
  }
}

/// Warns if signals overlap. Checks only signals of at most 64 bits that are present in every frame.
void Reader::note_overlaps(const Message& message, const MessageText& text) {
  if (message.signals.size() < 2) return;
  std::vector<bool> taken(8U * std::size_t{message.length});
  for (std::size_t i = 0; i < message.signals.size(); ++i) {
    const Signal& signal = message.signals[i];
    if (signal.length > max_signal_bits || signal.multiplexing.present_at) continue;
    if (bytes_needed(signal) > message.length) continue;
    const bool little = signal.byte_order == ByteOrder::little_endian;
    // Index of the first bit. In a big-endian signal, each byte is counted from its highest bit.
    const std::size_t first = little ? signal.start_bit : signal.start_bit ^ 7U;
    bool overlaps = false;
    for (std::size_t bit = first; bit < first + signal.length; ++bit) {
      const std::size_t place = little ? bit : bit ^ 7U;
      overlaps = overlaps || taken[place];
      taken[place] = true;
    }
    if (overlaps)
      note(text.signals[i], "signal " + signal.name + " overlaps another signal of message " + message.name);
  }
}

}  // namespace hystcan::can::dbc
