// Frames as text, with the names, values and units of a DBC.
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
  text,  ///< one line per frame, for people
  csv,   ///< one row per signal: time_s,interface,id,message,signal,raw,value,unit,name
  json,  ///< one object per frame, in one line
};

inline constexpr std::string_view csv_header = "time_s,interface,id,message,signal,raw,value,unit,name\n";

/// Formats frames. Values in csv and json have 17 significant digits. Raw values are exact: 0 to 2^64 - 1 for
/// an unsigned signal, the bits for a float signal. A value that is not finite is `nan` or `inf` in csv, null
/// in json.
class FrameText {
 public:
  /// The database must outlive this object.
  FrameText(const can::Database& database, FrameFormat format) : database_(database), format_(format) {}

  /// Returns lines with line ends; for csv, an empty text if the frame has no signals. Valid until the next
  /// call.
  const std::string& operator()(const can::LoggedFrame& logged);

  std::uint64_t frames() const { return frames_; }    ///< number of frames, without error frames
  std::uint64_t unknown() const { return unknown_; }  ///< frames that match no message of the database
  std::uint64_t error_frames() const { return error_frames_; }
  std::uint64_t lost() const { return lost_; }  ///< frames lost according to the drop notices in the log

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

/// Returns `Position=12.5 um, State=2 (enabled)`, with twelve digits, in UTF-8.
std::string signals_text(const std::vector<can::DecodedSignal>& signals);

/// Returns an object that maps each signal name to raw, value, unit and value name.
std::string signals_json(const std::vector<can::DecodedSignal>& signals);

/// Returns the members for an FD frame, `,"brs":true,"esi":false`; empty for any other frame.
std::string fd_flags_json(const can::Frame& frame);

/// Formats an identifier like candump: three digits, or eight if it is extended.
std::string id_text(std::uint32_t id, bool extended);
/// Returns the text quoted and escaped. Text that is not UTF-8 is read as Windows-1252.
std::string json_string(std::string_view text);

/// Formats 17 significant digits; null if the value is not finite.
std::string json_number(double value);

/// Returns the raw value of a signal in decimal.
std::string raw_text(const can::DecodedSignal& signal);

/// Reports the parts of a message that can't be decoded, once for each message.
///
/// Each frame is decoded on its own. Decoding omits
///   - signals that cannot be decoded,
///   - a message longer than a frame: a frame with the message's own identifier has only its first bytes,
///   - a message that J1939 announces (connection management, PGN 0xEC00: request to send, or broadcast)
///     and sends in frames of its transport protocol: none of it is decoded.
class DecodeFindings {
 public:
  /// The database must outlive this object.
  explicit DecodeFindings(const can::Database& database) : database_(database) {}

  /// Returns one sentence for each new finding; usually none.
  std::vector<std::string> add(const can::LoggedFrame& logged);

 private:
  void examine_transport(const can::Frame& frame, std::vector<std::string>& findings);

  const can::Database& database_;
  std::set<const can::Message*> decoded_;
  std::set<std::uint32_t> transported_;  ///< reported parameter groups that J1939 announced
};

}  // namespace hystcan::app
