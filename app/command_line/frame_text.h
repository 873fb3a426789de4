// Formats CAN frames as text, with the names, values and units of a DBC.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "can/dbc/database.h"
#include "can/dbc/message_decoder.h"
#include "can/log/candump.h"

namespace hystcan::app {

enum class FrameFormat : std::uint8_t {
  text,  ///< one line per frame, for people to read
  csv,   ///< one row per signal: time_s,interface,id,message,signal,raw,value,unit,name
  json,  ///< one JSON object per frame, in one line
};

inline constexpr std::string_view csv_header = "time_s,interface,id,message,signal,raw,value,unit,name\n";

/// Formats frames in one of the three formats. Physical values in csv and json have 17 significant digits.
/// Raw values are exact: an integer up to 2^64 - 1, or the bits of a float signal. A value that is not finite
/// is `nan` or `inf` in csv and null in json.
class FrameText {
 public:
  /// `database` must outlive this object.
  FrameText(const can::Database& database, FrameFormat format) : database_(database), format_(format) {}

  /// Returns the text for a frame, with line ends. For csv, the text is empty if the frame has no signals.
  /// The reference is valid until the next call.
  const std::string& operator()(const can::LoggedFrame& logged);

  /// Return the number of formatted frames (without error frames), and how many of them are not in the DBC.
  std::uint64_t frames() const { return frames_; }
  std::uint64_t unknown() const { return unknown_; }
  std::uint64_t error_frames() const { return error_frames_; }
  /// Returns the number of frames that the recorder lost, according to its drop notices in the log.
  std::uint64_t lost() const { return lost_; }

 private:
  void write_text(const can::LoggedFrame& logged, const can::Message* message);
  void write_csv(const can::LoggedFrame& logged, const can::Message& message);
  void write_json(const can::LoggedFrame& logged, const can::Message* message);

  const can::Database& database_;
  FrameFormat format_;
  std::string line_;
  std::uint64_t frames_ = 0;
  std::uint64_t unknown_ = 0;
  std::uint64_t error_frames_ = 0;
  std::uint64_t lost_ = 0;
};

/// Formats decoded signals as UTF-8 text such as `Position=12.5 um, State=2 (enabled)`. Values have twelve
/// significant digits.
std::string signals_text(const std::vector<can::DecodedSignal>& signals);

/// Returns a JSON object with one member for each signal. The member contains the raw value, the physical
/// value, the unit and the name of the value.
std::string signals_json(const std::vector<can::DecodedSignal>& signals);

/// Returns the JSON members for the flags of a CAN FD frame, `,"brs":true,"esi":false`. Returns an empty text
/// for a classical frame.
std::string fd_flags_json(const can::Frame& frame);

/// Formats a CAN identifier in hexadecimal like candump: three digits, or eight digits if it is extended.
std::string id_text(std::uint32_t id, bool extended);
/// Returns the text as a JSON string, with quotes and escapes. If `text` is not UTF-8, it is converted from
/// Windows-1252.
std::string json_string(std::string_view text);

/// Formats a number for JSON with 17 significant digits; returns "null" if the value is not finite.
std::string json_number(double value);

/// Returns the raw value of a signal in decimal.
std::string raw_text(const can::DecodedSignal& signal);

/// Finds the parts of a log that decoding omits, and reports each one once per message.
///
/// Each frame is decoded alone. The decoder therefore omits
///   - the end of a message that is longer than a frame,
///   - every signal of a message that J1939 sends in several frames of its transport protocol. A frame of PGN
///     0xEC00 (connection management: request to send, or broadcast) announces such a message.
/// It also omits signals that it cannot decode, for example a float of unusual length.
class DecodeFindings {
 public:
  /// `database` must outlive this object.
  explicit DecodeFindings(const can::Database& database) : database_(database) {}

  /// Returns one sentence for each part of this frame's message that decoding omits, if add() has not
  /// reported the message before. Usually the result is empty.
  std::vector<std::string> add(const can::LoggedFrame& logged);

 private:
  void examine_transport(const can::Frame& frame, std::vector<std::string>& findings);

  const can::Database& database_;
  std::set<const can::Message*> decoded_;
  std::set<std::uint32_t> transported_;  ///< J1939 parameter groups that were announced and are already
                                         ///< reported
};

}  // namespace hystcan::app
