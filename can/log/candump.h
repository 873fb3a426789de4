// The log format of can-utils (`candump -L`, `canplayer`), one frame per line:
//
//   (1699876543.123456) can0 123#11223344        data, 11-bit identifier (three digits)
//   (1699876543.123456) can0 12345678#           data, 29-bit identifier (eight digits)
//   (1699876543.123456) can0 123#R5              remote, with the requested length (not written if it is 0)
//   (1699876543.123456) can0 123##1AABB          FD: one digit of flags, then data
//   (1699876543.123456) can0 20000004#0001...    error frame: 0x20000000 and the classes of linux/can/error.h
//   (1699876543.123456) can0 123#11 R            written by `candump -x`: R received, T sent by this host
//
// The reader also accepts the following, and nothing else:
//
//   - times in nanoseconds, truncated to microseconds
//   - several blanks before the interface, and dots between bytes
//   - a DLC above 8 of a classical frame (`_9`), which it ignores like canplayer
//   - comments (`#` in column 1), which it ignores like canplayer
//   - error frames of a CAN FD bus as python-can writes them (`20000080##0`)
//   - the lines of `candump -d` between frames (`DROPCOUNT: ...`)
#pragma once

#include <chrono>
#include <cstdint>
#include <istream>
#include <optional>
#include <string>

#include "base/error.h"
#include "can/frame.h"

namespace hystcan::can {

enum class Direction : std::uint8_t { unstated, received, transmitted };

struct LoggedFrame {
  std::chrono::microseconds time{};  ///< time since 1970-01-01 UTC; not negative
  std::string interface;
  Frame frame;
  Direction direction = Direction::unstated;

  friend bool operator==(const LoggedFrame&, const LoggedFrame&) = default;
};

/// Formats only the frame, as the program cansend expects it: `123#11223344`.
std::string candump_frame(const Frame& frame);

/// Formats one line of a log, without the line end.
std::string candump_line(const LoggedFrame& logged);

/// Reads a log line by line, in constant memory.
class CandumpReader {
 public:
  /// `stream` must outlive the reader. `name`: the name of the file in error messages.
  CandumpReader(std::istream& stream, std::string name) : stream_(stream), name_(std::move(name)) {}

  /// Returns the next frame; nullopt at the end of the log. Omits a last line without a line end (a crash may
  /// have cut it), unless it is the only line. Throws Error: `FILE:LINE:COLUMN: found ..., expected ...`.
  std::optional<LoggedFrame> next();

  /// Returns true if next() omitted the last line because it may be incomplete.
  bool is_cut() const { return is_cut_; }
  /// The line number of the last frame, counted from 1.
  std::size_t line() const { return line_; }
  /// The number of lost frames that `candump -d` reported in the lines that were read.
  std::uint64_t dropped() const { return dropped_; }

 private:
  std::istream& stream_;
  std::string name_;
  std::size_t line_ = 0;
  std::uint64_t dropped_ = 0;
  bool is_cut_ = false;
};

/// Returns the drop notice: a frame in the log that reports that the recorder lost `lost` frames before this
/// notice. The number has 24 bits; a larger number is reported as the maximum. The notice is an error frame,
/// because python-can rejects comments in a log:
///
///   class      CAN_ERR_CRTL
///   data[1]    1, receive overflow
///   data[4]    'L'
///   data[5..7] the number of lost frames, little-endian
Frame drop_notice(std::uint32_t lost);

/// Returns the number of lost frames in a drop notice; nullopt for any other frame.
std::optional<std::uint32_t> drops_reported_by(const Frame& frame);

}  // namespace hystcan::can
