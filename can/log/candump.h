// The log format of can-utils (`candump -L`, `canplayer`), one frame to a line:
//
//   (1699876543.123456) can0 123#11223344        data, 11-bit identifier (three digits)
//   (1699876543.123456) can0 12345678#           data, 29-bit identifier (eight digits)
//   (1699876543.123456) can0 123#R5              remote, length asked for (none written where it is 0)
//   (1699876543.123456) can0 123##1AABB          FD: one digit of flags, then data
//   (1699876543.123456) can0 20000004#0001...    error frame: 0x20000000 and the classes of linux/can/error.h
//   (1699876543.123456) can0 123#11 R            with `candump -x`: received, or sent (T) by the same host
//
// Read besides: times in nanoseconds (cut to microseconds), several blanks before the interface, dots between
// bytes, a DLC above 8 of a classical frame (`_9`, dropped as canplayer does), comments (`#` in column 1,
// which canplayer skips) and the lines that `candump -d` puts between frames (`DROPCOUNT: ...`). Nothing
// else.
#pragma once

#include <chrono>
#include <cstdint>
#include <istream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "can/frame.h"

namespace hystcan::can {

enum class Direction : std::uint8_t { unstated, received, transmitted };

struct LoggedFrame {
  std::chrono::microseconds time{};  ///< since 1970-01-01 UTC; not negative
  std::string interface;
  Frame frame;
  std::uint8_t fd_flags = 0;  ///< of an FD frame, 4 bits: 1 bit rate switched, 2 error state, 4 FD
  Direction direction = Direction::unstated;

  friend bool operator==(const LoggedFrame&, const LoggedFrame&) = default;
};

/// what() is `FILE:LINE:COLUMN: found what, expected what`.
class CandumpError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The frame alone, as cansend takes it: `123#11223344`.
std::string candump_frame(const Frame& frame, std::uint8_t fd_flags = 0);

/// One line, without its end.
std::string candump_line(const LoggedFrame& logged);

/// Reads a log line by line, in constant memory.
class CandumpReader {
 public:
  /// `stream` must outlive the reader. `name` is the file in messages.
  CandumpReader(std::istream& stream, std::string name) : stream_(stream), name_(std::move(name)) {}

  /// Empty at the end of the log. Throws CandumpError.
  std::optional<LoggedFrame> next();

  /// Of the frame read last, from 1.
  std::size_t line() const { return line_; }
  /// Frames that `candump -d` says it has lost, so far.
  std::uint64_t dropped() const { return dropped_; }

 private:
  std::istream& stream_;
  std::string name_;
  std::size_t line_ = 0;
  std::uint64_t dropped_ = 0;
};

/// A frame that tells that the recorder has lost `lost` frames before it (24 bits; more count as the most).
/// No comment says so, for python-can refuses comments: it is an error frame of class CAN_ERR_CRTL, receive
/// overflow (data[1] = 1), with `L` in data[4] and the number in data[5..7], little-endian.
Frame drop_notice(std::uint32_t lost);

/// Empty where the frame is none.
std::optional<std::uint32_t> drops_told_by(const Frame& frame);

}  // namespace hystcan::can
