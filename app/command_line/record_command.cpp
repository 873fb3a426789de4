#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "app/command_line/bus_source.h"
#include "app/command_line/commands.h"
#include "app/command_line/frame_text.h"
#include "app/live/stop_signal.h"
#include "app/stage/option_check.h"
#include "base/append_file.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "can/log/error_frame.h"
#include "can/socketcan/bus_monitor.h"
#include "can/socketcan/socketcan_bus.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

using Clock = std::chrono::steady_clock;

// At most this much is lost if the machine loses power.
constexpr std::chrono::milliseconds flush_every{200};

struct RecordArguments {
  BusOptions bus;
  std::filesystem::path output;
  double duration_s = 0.0;
  bool decode = false;
  bool overwrite = false;
};

/// Counts the recorded frames.
class Summary {
 public:
  void add(const can::LoggedFrame& logged) {
    if (logged.frame.kind == can::FrameKind::error) return add_error(logged.frame);
    ++frames_;
    first_ = std::min(first_.value_or(logged.time), logged.time);
    last_ = std::max(last_.value_or(logged.time), logged.time);
    const auto second = std::chrono::floor<std::chrono::seconds>(logged.time);
    if (second != second_) frames_of_second_ = 0;
    second_ = second;
    busiest_ = std::max(busiest_, ++frames_of_second_);
  }

  std::string text(const std::string& interface, const std::string& output, std::uint64_t lost) const {
    const double span_s = frames_ > 0 ? std::chrono::duration<double>(*last_ - *first_).count() : 0.0;
    std::string result =
        fmt::format("{}: {} of {} in {:.3f} s", output, counted(frames_, "frame"), interface, span_s);
    if (frames_ > 1 && span_s > 0.0)
      result += fmt::format(", {:.1f} per second, {} in the busiest",
                            static_cast<double>(frames_ - 1) / span_s, busiest_);
    result += fmt::format("\n{}", counted(error_frames_, "error frame"));
    for (const auto& [cause, count] : causes_) result += fmt::format("\n  {}: {}", cause, count);
    return result + fmt::format("\n{} lost\n", counted(lost, "frame"));
  }

 private:
  void add_error(const can::Frame& frame) {
    if (can::drops_reported_by(frame)) return;
    ++error_frames_;
    for (const std::string& cause : can::error_causes(frame)) ++causes_[cause];
  }

  std::uint64_t frames_ = 0;
  std::uint64_t error_frames_ = 0;
  std::map<std::string, std::uint64_t> causes_;
  std::optional<std::chrono::microseconds> first_;
  std::optional<std::chrono::microseconds> last_;
  std::chrono::seconds second_{-1};
  std::uint64_t frames_of_second_ = 0;
  std::uint64_t busiest_ = 0;
};

/// Throws Error if the file exists and is to be kept.
std::unique_ptr<AppendFile> create_log(const RecordArguments& options) {
  using Existing = AppendFile::Existing;
  if (options.output.empty()) throw Error("output file is \"\", expected a name");
  try {
    return std::make_unique<AppendFile>(options.output,
                                        options.overwrite ? Existing::replace : Existing::refuse);
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::file_exists) throw RunError(error.what());
    throw Error(
        fmt::format("{}: exists already, expected another name, or --overwrite", options.output.string()));
  }
}

void require_written(const AppendFile& log) {
  if (log.error()) throw RunError(log.error_text());
}

int run_record(const RecordArguments& options) {
  const BusSource source = find_bus(options.bus);
  if (options.decode && !source.database)
    throw Error("--decode has no database, expected a configuration or --dbc");
  stop_at_a_signal();
  can::BusMonitor tap(source.interface);
  const auto log = create_log(options);
  std::optional<FrameText> text;
  std::optional<DecodeFindings> findings;
  if (options.decode) text.emplace(*source.database, FrameFormat::text);
  if (options.decode) findings.emplace(*source.database);

  Summary summary;
  bool was_up = true;
  const can::BusMonitor::Handler record = [&](const can::LoggedFrame& logged) {
    log->add(can::candump_line(logged) + "\n");
    require_written(*log);
    summary.add(logged);
    if (!text) return;
    for (const std::string& finding : findings->add(logged)) spdlog::warn(finding);
    print((*text)(logged));
  };
  spdlog::info("recording {} to {}; Ctrl-C ends it", source.interface, options.output.string());
  const auto start = Clock::now();
  auto flushed = start;
  const auto is_over = [&](Clock::time_point now) {
    return options.duration_s > 0.0 &&
           std::chrono::duration<double>(now - start).count() >= options.duration_s;
  };
  const auto conclude = [&] {
    note("{}", summary.text(source.interface, options.output.string(), tap.lost()));
  };
  try {
    for (auto now = start; stop_signalled == 0 && !is_over(now); now = Clock::now()) {
      tap.listen(flush_every / 4, record);
      if (tap.up() && !was_up) spdlog::info("{}: up again", source.interface);
      if (!tap.up() && was_up) spdlog::warn("{}: down; waiting for it", source.interface);
      was_up = tap.up();
      if (now - flushed < flush_every) continue;
      flushed = now;
      log->flush();
      require_written(*log);
      flush_output();
    }
    tap.finish(record);
    log->close();
    require_written(*log);
    flush_output();
  } catch (const std::exception&) {  // the disk is full, or the reader has closed standard output
    conclude();
    throw;
  }
  conclude();
  return done;
}

}  // namespace

void add_record(CLI::App& cli, int& status) {
  auto options = std::make_shared<RecordArguments>();
  CLI::App* command = cli.add_subcommand("record", "Write all traffic on the bus to a bus log");
  add_bus_options(*command, options->bus);
  command->add_option("--output", options->output, "log to write, in the format of `candump -L`")->required();
  command->add_flag("--overwrite", options->overwrite, "replace the file if it exists");
  command->add_flag("--decode", options->decode, "show messages and signals on standard output too");
  command->add_option("--duration", options->duration_s, "stop after this many seconds")
      ->check(positive_seconds());
  command->callback([options, &status] { status = run_record(*options); });
}

}  // namespace hystcan::app
