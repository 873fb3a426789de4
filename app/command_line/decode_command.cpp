#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "app/command_line/bus_source.h"
#include "app/command_line/commands.h"
#include "app/command_line/frame_text.h"
#include "base/input_file.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "can/log/candump.h"

namespace hystcan::app {
namespace {

struct DecodeArguments {
  std::filesystem::path log;
  std::filesystem::path dbc;
  bool csv = false;
  bool json = false;
};

/// Computes the mean frame rate of a log from the intervals between the time stamps of successive frames. If
/// the time stamp C of a frame is earlier than the time stamp B of the previous frame, the time stamp A
/// before B decides. If C is not earlier than A, then B is treated as wrong, and the interval from A to C
/// counts. If C is earlier than A, the clock was set back, and no interval counts. An interval that is longer
/// than both a second and a thousand mean intervals is a gap in the log and does not count.
class LogRate {
 public:
  void add(std::chrono::microseconds time) {
    if (!last_) before_ = time;
    if (last_ && time >= *last_)
      take(time - *last_, *last_);
    else if (last_ && time >= before_)
      take(time - before_ - std::exchange(taken_, {}), before_);
    last_ = time;
  }
  /// Returns frames per second; nullopt if all time stamps are equal.
  std::optional<double> rate_Hz() const {
    return span_ > Span(0) ? std::optional(static_cast<double>(intervals_) / span_.count()) : std::nullopt;
  }

 private:
  using Span = std::chrono::duration<double>;

  void take(Span span, std::chrono::microseconds before) {
    const bool is_gap =
        span > Span(1) && intervals_ > 10 && span > 1000.0 / static_cast<double>(intervals_) * span_;
    before_ = before;
    taken_ = is_gap ? Span(0) : span;
    span_ += taken_;
    intervals_ += is_gap ? 0 : 1;
  }

  std::optional<std::chrono::microseconds> last_;
  std::chrono::microseconds before_{};  ///< time stamp of the frame before the last frame
  Span span_{0}, taken_{0};             ///< span_: sum of the intervals between frames that count, in s;
                                        ///< taken_: last interval in this sum, 0 if it was too long to count
  std::uint64_t intervals_ = 0;
};

/// Decodes a log. `at_once`: prints each frame as soon as it arrives, because the input may be a pipe
/// (`candump -L can0 | hystcan decode - --dbc FILE`). If `at_once` is false, the output is buffered.
void decode(std::istream& stream, const std::string& name, const DecodeArguments& options, bool at_once,
            FrameText& text, DecodeFindings& findings) {
  can::CandumpReader reader(stream, name);
  LogRate rate;
  if (options.csv) print(csv_header);
  while (const auto logged = reader.next()) {
    for (const std::string& finding : findings.add(*logged)) note("{}: {}\n", options.dbc.string(), finding);
    print(text(*logged));
    if (logged->frame.kind != can::FrameKind::error) rate.add(logged->time);
    if (at_once) flush_output();
  }
  flush_output();
  if (reader.is_cut()) note("{}: {}\n", name, last_line_left_out);
  require_frames(name, text.frames() + text.error_frames());
  const std::uint64_t lost = text.lost() + reader.dropped();
  note("{}: {}, {} of them not defined in {}; {}", name, counted(text.frames(), "frame"), text.unknown(),
       options.dbc.string(), counted(text.error_frames(), "error frame"));
  if (const auto rate_Hz = rate.rate_Hz()) note("; {:.4g} frames/s", *rate_Hz);
  if (lost > 0) note("; {} lost by the recorder", counted(lost, "frame"));
  note("\n");
}

int run_decode(const DecodeArguments& options) {
  const can::Database database = can::load_dbc(options.dbc);
  print_parse_warnings(database);
  FrameText text(database, options.csv    ? FrameFormat::csv
                           : options.json ? FrameFormat::json
                                          : FrameFormat::text);
  DecodeFindings findings(database);
  if (options.log == "-") {
    decode(std::cin, "standard input", options, true, text, findings);
    return done;
  }
  const auto stream = open_input(options.log, a_candump_log);
  decode(*stream, options.log.string(), options, false, text, findings);
  return done;
}

}  // namespace

void add_decode(CLI::App& cli, int& status) {
  auto options = std::make_shared<DecodeArguments>();
  CLI::App* command = cli.add_subcommand("decode", "Decode a bus log (candump or recorded) with a DBC");
  command->add_option("LOG", options->log, "log in the format of `candump -L`; - is standard input")
      ->required();
  command->add_option("--dbc", options->dbc, "CAN database (DBC)")->required();
  CLI::Option* csv =
      command->add_flag("--csv", options->csv,
                        "print one row per signal: time_s,interface,id,message,signal,raw,value,unit,name");
  command->add_flag("--json", options->json, "print one JSON object per frame, each in one line")
      ->excludes(csv);
  command->callback([options, &status] { status = print_for_reader([&] { return run_decode(*options); }); });
}

}  // namespace hystcan::app
