#include "can/log/candump.h"

#include <fmt/format.h>

#include <linux/can.h>
#include <linux/can/error.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <limits>
#include <utility>

#include "base/text.h"

namespace hystcan::can {
namespace {

constexpr std::size_t longest_line = 512;  // characters; a line with an FD frame needs at most 260
constexpr std::size_t longest_interface = 64;
constexpr std::size_t classical_bytes = 8;
constexpr std::uint8_t drop_mark = 'L';
constexpr std::uint32_t most_drops = 0xFF'FFFF;
constexpr std::int64_t latest_s = std::numeric_limits<std::int64_t>::max() / 1'000'000 - 1;

int hex_value(char digit) {
  if (digit >= '0' && digit <= '9') return digit - '0';
  if (digit >= 'A' && digit <= 'F') return digit - 'A' + 10;
  if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
  return -1;
}

bool is_hex(char c) { return hex_value(c) >= 0; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
/// Returns true for a printable ASCII character except a blank. The result does not depend on whether `char`
/// is signed.
bool is_word(char c) { return c > ' ' && c < '\x7F'; }

/// The first error in a line. `at`: position of the wrong character in the line, counted from 0.
struct LineError {
  std::size_t at;
  std::string expected;
};

/// Parses one line of a log from left to right.
class Line {
 public:
  explicit Line(std::string_view text) : text_(text) {}

  LoggedFrame parse() {
    LoggedFrame logged;
    expect('(', "'(' and the time of a frame, as `candump -L` writes it");
    logged.time = time();
    expect(')', "')' after the time");
    blanks("a blank after the time");
    logged.interface = interface();
    blanks("a blank after the interface");
    identifier(logged.frame);
    expect('#', "'#' after an identifier of three or eight digits");
    content(logged);
    logged.direction = direction();
    skip_blanks();
    if (at_ < text_.size()) refuse(at_, "the end of the line");
    return logged;
  }

 private:
  [[noreturn]] static void refuse(std::size_t at, std::string expected) {
    throw LineError{at, std::move(expected)};
  }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  bool take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c, const char* expected) {
    if (!take(c)) refuse(at_, expected);
  }
  void skip_blanks() {
    while (peek() == ' ' || peek() == '\t') ++at_;
  }
  void blanks(const char* expected) {
    if (peek() != ' ' && peek() != '\t') refuse(at_, expected);
    skip_blanks();
  }
  template <class Predicate>
  std::string_view run(Predicate belongs) {
    const std::size_t from = at_;
    while (at_ < text_.size() && belongs(text_[at_])) ++at_;
    return text_.substr(from, at_ - from);
  }

  std::chrono::microseconds time() {
    const std::size_t from = at_;
    std::int64_t seconds = 0;
    const std::string_view whole = run(is_digit);
    const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), seconds);
    if (whole.empty() || error != std::errc{} || end != whole.data() + whole.size() || seconds > latest_s)
      refuse(from, "the time in seconds since 1970");
    expect('.', "'.' and the microseconds of the time");
    const std::size_t fraction_from = at_;
    const std::string_view fraction = run(is_digit);
    if (fraction.size() != 6 && fraction.size() != 9)
      refuse(fraction_from, "six digits of microseconds (or nine of nanoseconds)");
    std::int64_t microseconds = 0;
    std::from_chars(fraction.data(), fraction.data() + 6, microseconds);
    return std::chrono::seconds{seconds} + std::chrono::microseconds{microseconds};
  }

  std::string interface() {
    const std::size_t from = at_;
    const std::string_view name = run(is_word);
    if (name.empty() || name.size() > longest_interface) refuse(from, "the name of an interface");
    return std::string(name);
  }

  void identifier(Frame& frame) {
    const std::size_t from = at_;
    const std::string_view digits = run(is_hex);
    std::from_chars(digits.data(), digits.data() + digits.size(), frame.id, 16);
    if (digits.size() == 3) {
      if (frame.id > CAN_SFF_MASK) refuse(from, "an identifier of 11 bits, at most 7FF");
    } else if (digits.size() != 8) {
      refuse(from, "an identifier of three or eight hexadecimal digits");
    } else if (frame.id > (CAN_ERR_FLAG | CAN_ERR_MASK)) {
      refuse(from, "an identifier of 29 bits, or an error frame (20000000 to 3FFFFFFF)");
    } else if ((frame.id & CAN_ERR_FLAG) != 0) {
      frame.kind = FrameKind::error;
      frame.id &= CAN_ERR_MASK;
    } else {
      frame.extended = true;
    }
  }

  void content(LoggedFrame& logged) {
    Frame& frame = logged.frame;
    const std::size_t mark = at_;
    if (take('#')) {
      if (!is_hex(peek())) refuse(at_, "the flags of an FD frame, one hexadecimal digit");
      const auto flags = static_cast<std::uint8_t>(hex_value(text_[at_++]));
      if (frame.kind == FrameKind::error)
        return bytes(frame, classical_bytes);  // python-can writes an error frame of a CAN FD bus with flags
      frame.kind = FrameKind::fd;
      frame.fd_flags = flags;
      bytes(frame, frame.data.size());
    } else if (take('R')) {
      if (frame.kind == FrameKind::error) refuse(mark, "the data of an error frame");
      frame.kind = FrameKind::remote;
      remote_length(frame);
    } else {
      bytes(frame, classical_bytes);
    }
    if (frame.kind != FrameKind::fd) raw_dlc(frame);
  }

  void remote_length(Frame& frame) {
    if (!is_digit(peek())) return;
    if (peek() > '8') refuse(at_, "the length of a remote frame, 0 to 8");
    frame.length = static_cast<std::uint8_t>(text_[at_++] - '0');
  }

  void raw_dlc(const Frame& frame) {
    if (peek() != '_') return;
    if (frame.length != classical_bytes) refuse(at_, "8 bytes of data before the DLC");
    ++at_;
    if (hex_value(peek()) < 9) refuse(at_, "a DLC from 9 to F");
    ++at_;
  }

  void bytes(Frame& frame, std::size_t most) {
    while (is_hex(peek())) {
      if (frame.length == most) refuse(at_, "at most " + std::to_string(most) + " bytes");
      const int high = hex_value(text_[at_++]);
      if (!is_hex(peek())) refuse(at_, "two hexadecimal digits for each byte");
      const int low = hex_value(text_[at_++]);
      frame.data[frame.length++] = static_cast<std::uint8_t>(16 * high + low);
      if (peek() == '.') ++at_;
    }
  }

  Direction direction() {
    if (at_ == text_.size()) return Direction::unstated;
    blanks("hexadecimal digits, or the direction R or T after a blank");
    if (take('R')) return Direction::received;
    if (take('T')) return Direction::transmitted;
    return Direction::unstated;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

std::string quoted(std::string_view line, std::size_t at) {
  if (at >= line.size()) return "the end of the line";
  const char c = line[at];
  if (is_word(c)) return std::string("'") + c + "'";
  if (c == ' ') return "a blank";
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "byte 0x%02X", static_cast<unsigned char>(c));
  return text.data();
}

/// Returns the number of lost frames in a line of `candump -d`: 12 for `DROPCOUNT: dropped 12 CAN frames on
/// 'can0' socket (total drops 34)`. Returns nullopt for any other line.
std::optional<std::uint64_t> drops_counted_by(std::string_view line) {
  constexpr std::string_view before = "DROPCOUNT: dropped ";
  if (!line.starts_with(before)) return std::nullopt;
  line.remove_prefix(before.size());
  std::uint32_t drops = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), drops);
  if (error != std::errc{} ||
      !line.substr(static_cast<std::size_t>(end - line.data())).starts_with(" CAN frame"))
    return std::nullopt;
  return drops;
}

/// A log format of another program: the text at its beginning, its name, and the command that converts it.
struct OtherLog {
  std::string_view begin, kind, converter;
};
constexpr std::string_view of_vector = "`asc2log -I FILE -O LOG`",
                           of_python = "`can_logconvert FILE LOG.log` of python-can";
constexpr OtherLog other_logs[] = {
    {"date ", "Vector (ASC)", of_vector},       {"base hex", "Vector (ASC)", of_vector},
    {"base dec", "Vector (ASC)", of_vector},    {"LOGG", "Vector (BLF)", of_python},
    {";$FILEVERSION", "PEAK (TRC)", of_python}, {"MDF     ", "ASAM (MF4)", of_python}};

/// Checks the first line of a file. Returns an error text if the file is not a candump log, else an empty
/// text.
std::string refusal_of_file(std::string_view text) {
  if (const std::string_view other = refusal_of_encoding(text); !other.empty()) return std::string(other);
  for (const OtherLog& log : other_logs)
    if (text.starts_with(log.begin))
      return fmt::format("found a log of {}, expected a log of candump -L: {} converts it", log.kind,
                         log.converter);
  return {};
}

/// Returns true if zero bytes fill the end of `line` and the rest of the stream. A file system may leave such
/// bytes at the end of a file after a power failure.
bool ends_in_zeros(std::istream& stream, std::string_view line) {
  const std::size_t zero = line.find('\0');
  if (zero == std::string_view::npos || line.find_first_not_of('\0', zero) != std::string_view::npos)
    return false;
  if (stream.eof()) return true;
  constexpr std::size_t most = 1 << 20;  // limits the search: /dev/zero has no end
  stream.clear();
  for (std::size_t n = 0; n < most; ++n) {
    const int c = stream.get();
    if (c != '\0') return c == std::istream::traits_type::eof();
  }
  return false;
}

void append_hex(std::string& text, std::uint32_t value, int digits) {
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4)
    text += "0123456789ABCDEF"[value >> shift & 0xFU];
}

}  // namespace

std::optional<LoggedFrame> CandumpReader::next() {
  std::array<char, longest_line> buffer{};
  for (;;) {
    ++line_;
    stream_.getline(buffer.data(), buffer.size());
    auto size = static_cast<std::size_t>(stream_.gcount());
    if (stream_.eof() && size == 0) return std::nullopt;
    const auto refuse = [&](std::size_t at, const std::string& found, const std::string& expected) {
      throw Error({name_, line_, at + 1}, fmt::format("found {}", found), {.expected = expected});
    };
    if (stream_.bad()) throw Error(name_, "cannot be read");
    if (!stream_.eof() && !stream_.fail()) --size;  // gcount() includes the line end
    if (line_ == 1)
      if (const std::string other = refusal_of_file({buffer.data(), size}); !other.empty())
        throw Error({name_, 1, 1}, other);
    const bool is_longer = stream_.fail();
    const bool is_last_without_end = line_ > 1 && stream_.eof() && !stream_.bad();
    if (is_last_without_end || ends_in_zeros(stream_, {buffer.data(), size})) {
      is_cut_ = true;
      return std::nullopt;
    }
    if (is_longer) refuse(size, "the line is too long", "at most " + std::to_string(size) + " characters");
    std::string_view text(buffer.data(), size);
    if (line_ == 1) text = without_byte_order_mark(text);
    if (text.ends_with('\r')) text.remove_suffix(1);
    if (text.empty() || text.starts_with('#')) continue;
    if (const auto drops = drops_counted_by(text)) {
      dropped_ += *drops;
      continue;
    }
    try {
      return Line(text).parse();
    } catch (const LineError& error) {
      refuse(error.at, quoted(text, error.at), error.expected);
    }
  }
}

std::string candump_frame(const Frame& frame) {
  std::string text;
  const std::uint32_t id = frame.kind == FrameKind::error ? frame.id | CAN_ERR_FLAG : frame.id;
  append_hex(text, id, frame.extended || frame.kind == FrameKind::error ? 8 : 3);
  text += '#';
  if (frame.kind == FrameKind::remote) {
    text += 'R';
    if (frame.length > 0) text += static_cast<char>('0' + std::min<int>(frame.length, classical_bytes));
    return text;
  }
  if (frame.kind == FrameKind::fd) {
    text += '#';
    append_hex(text, frame.fd_flags, 1);
  }
  for (const std::uint8_t byte : frame.payload()) append_hex(text, byte, 2);
  return text;
}

std::string candump_line(const LoggedFrame& logged) {
  std::array<char, 40> time{};
  const std::int64_t us = std::max<std::int64_t>(logged.time.count(), 0);
  std::snprintf(time.data(), time.size(), "(%010lld.%06lld) ", static_cast<long long>(us / 1'000'000),
                static_cast<long long>(us % 1'000'000));
  std::string text = time.data() + logged.interface + ' ' + candump_frame(logged.frame);
  if (logged.direction != Direction::unstated) text += logged.direction == Direction::received ? " R" : " T";
  return text;
}

Frame drop_notice(std::uint32_t lost) {
  lost = std::min(lost, most_drops);
  Frame frame;
  frame.id = CAN_ERR_CRTL;
  frame.kind = FrameKind::error;
  frame.length = CAN_ERR_DLC;
  frame.data[1] = CAN_ERR_CRTL_RX_OVERFLOW;
  frame.data[4] = drop_mark;
  for (unsigned i = 0; i < 3; ++i) frame.data[5 + i] = static_cast<std::uint8_t>(lost >> (8 * i) & 0xFFU);
  return frame;
}

std::optional<std::uint32_t> drops_reported_by(const Frame& frame) {
  if (frame.kind != FrameKind::error || frame.id != CAN_ERR_CRTL || frame.length != CAN_ERR_DLC ||
      frame.data[1] != CAN_ERR_CRTL_RX_OVERFLOW || frame.data[4] != drop_mark)
    return std::nullopt;
  return frame.data[5] | static_cast<std::uint32_t>(frame.data[6]) << 8U |
         static_cast<std::uint32_t>(frame.data[7]) << 16U;
}

}  // namespace hystcan::can
