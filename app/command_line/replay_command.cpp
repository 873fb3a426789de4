#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <time.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "app/command_line/bus_source.h"
#include "app/command_line/commands.h"
#include "app/live/stop_signal.h"
#include "app/stage/option_check.h"
#include "base/input_file.h"
#include "base/standard_streams.h"
#include "base/text.h"
#include "can/log/candump.h"
#include "can/socketcan/raw_socket.h"
#include "can/socketcan/socketcan_bus.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

using can::Duration;
using can::LoggedFrame;
using can::Time;
using Clock = std::chrono::steady_clock;

// A frame may be late by this without a warning. The log has microseconds; the shortest frame takes 47 us.
constexpr std::chrono::milliseconds tolerated_lateness{1};
constexpr std::chrono::milliseconds longest_sleep{100};  // between checks for a signal
constexpr std::chrono::microseconds retry_after{200};    // a full queue: about the time of two frames

constexpr std::size_t most_interfaces = 64;
constexpr std::uint64_t waits_until_said = 5000;
constexpr std::chrono::duration<double, std::micro> longest_replay = std::chrono::years{1};
constexpr std::uint64_t most_passes = 1'000'000'000;

struct ReplayArguments {
  std::filesystem::path log;
  std::string interface;
  double speed = 1.0;
  std::uint64_t loop = 1;
  std::vector<std::string> ids;
  bool force_interface = false;
};

using Ids = std::set<std::pair<bool, std::uint32_t>>;  ///< extended, identifier

/// Identifiers as candump writes them: three digits, or eight if extended.
Ids parsed_ids(const std::vector<std::string>& texts) {
  Ids ids;
  for (const std::string& text : texts) {
    std::uint32_t id = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id, 16);
    const bool extended = text.size() == 8;
    if (error != std::errc{} || end != text.data() + text.size() || (text.size() != 3 && !extended) ||
        !can::is_identifier(id, extended))
      throw Error("--filter: found '" + text +
                  "', expected an identifier of three hexadecimal digits, or eight (29 bits)");
    ids.emplace(extended, id);
  }
  return ids;
}

/// The sockets of one replay. Each opens only if the replay may write to its interface.
class Outlets {
 public:
  explicit Outlets(bool force) : force_(force) {}

  int open(const std::string& interface) {
    const auto found = sockets_.find(interface);
    if (found != sockets_.end()) return found->second.get();
    if (!force_ && !can::is_virtual_interface(interface))
      throw RunError(
          fmt::format("{} is a real CAN interface: a replay on it moves real devices; "
                      "use --force-interface if you want that",
                      interface));
    return sockets_.emplace(interface, can::open_raw_socket(interface, {})).first->second.get();
  }

  /// Waits while the queue is full, so that no frame is lost. Returns the number of waits.
  std::uint64_t send(const LoggedFrame& logged, const std::string& interface) {
    const int socket = open(interface);
    for (std::uint64_t waits = 0;; ++waits) {
      const int error = can::write_frame(socket, logged.frame);
      if (error == 0) return waits;
      if (error != ENOBUFS && error != EAGAIN && error != EINTR)
        throw RunError(fmt::format("{}: {} cannot be sent: {}", interface, can::candump_frame(logged.frame),
                                   std::strerror(error)));
      if (stop_signalled != 0) return waits;
      if (waits == waits_until_said)
        spdlog::warn("{}: its queue has been full for {} s: is there a node that acknowledges?", interface,
                     waits_until_said * retry_after / std::chrono::seconds{1});
      const timespec pause{0, std::chrono::nanoseconds(retry_after).count()};
      ::clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
    }
  }

 private:
  bool force_;
  std::map<std::string, Descriptor> sockets_;
};

/// Returns false if a signal came first.
bool sleep_until(Time deadline) {
  for (Time now = Clock::now(); now < deadline && stop_signalled == 0; now = Clock::now()) {
    const Duration until = std::min<Time>(deadline, now + longest_sleep).time_since_epoch();
    const timespec at{until.count() / 1'000'000'000, until.count() % 1'000'000'000};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
  }
  return stop_signalled == 0;
}

/// Refuses a log whose time runs backwards: two logs in one file, or a clock that was set. The frames of
/// several interfaces stand a little out of order, which counts as no step.
class TimeOrder {
 public:
  explicit TimeOrder(std::string name) : name_(std::move(name)) {}

  void check(const LoggedFrame& logged, std::size_t line) {
    if (frames_++ > 0 && logged.time < latest_ - tolerated)
      throw Error(fmt::format("{}:{}:1: the time steps back by {:.6f} s, expected at most {} s", name_, line,
                              can::seconds(latest_ - logged.time), can::seconds(tolerated)));
    latest_ = frames_ == 1 ? logged.time : std::max(latest_, logged.time);
  }
  std::uint64_t frames() const { return frames_; }

 private:
  static constexpr std::chrono::microseconds tolerated{1'000'000};

  std::string name_;
  std::uint64_t frames_ = 0;
  std::chrono::microseconds latest_{0};
};

class Replay {
 public:
  explicit Replay(const ReplayArguments& options)
      : options_(options), ids_(parsed_ids(options.ids)), outlets_(options.force_interface) {}

  /// Reads the whole log and then opens every interface before the first frame is sent, so that a damaged log
  /// or a missing interface moves nothing.
  void prepare(std::istream& stream) {
    const std::string name = options_.log.string();
    can::CandumpReader reader(stream, name);
    TimeOrder order(name);
    std::optional<std::chrono::microseconds> first;
    std::set<std::string> interfaces;
    if (!options_.interface.empty()) interfaces.insert(options_.interface);
    while (const auto logged = reader.next()) {
      order.check(*logged, reader.line());
      if (!is_sent(*logged)) continue;
      if (!first) first = logged->time;
      offset_of(*logged, *first, reader.line());
      interfaces.insert(interface_of(*logged));
      if (interfaces.size() > most_interfaces)
        throw Error(fmt::format("{}:{}:1: one more interface, expected at most {}", name, reader.line(),
                                most_interfaces));
    }
    require_frames(name, order.frames());
    for (const std::string& interface : interfaces) outlets_.open(interface);
  }

  /// Sends the log once; the first frame is due at `start`. Returns the time at which the last frame was due.
  Time pass(std::istream& stream, const std::string& name, Time start) {
    can::CandumpReader reader(stream, name);
    TimeOrder order(name);
    std::optional<std::chrono::microseconds> first;
    Time due = start;
    while (const auto logged = reader.next()) {
      order.check(*logged, reader.line());
      if (!is_sent(*logged)) {
        ++(logged->frame.kind == can::FrameKind::error ? error_frames_ : filtered_);
        continue;
      }
      if (!first) first = logged->time;
      const Duration offset = offset_of(*logged, *first, reader.line());
      // Where the time steps back, a frame is due with its predecessor.
      due = std::max(due, start + offset);
      if (!sleep_until(due)) break;
      waits_ += outlets_.send(*logged, interface_of(*logged));
      if (stop_signalled != 0) break;
      account(Clock::now() - due);
    }
    if (stop_signalled == 0) require_frames(name, order.frames());
    return due;
  }

  void report() const {
    note("{} sent", counted(sent_, "frame"));
    if (error_frames_ > 0) note(", {} cannot be sent", counted(error_frames_, "error frame"));
    if (filtered_ > 0) note(", {} left out by --filter", filtered_);
    if (waits_ > 0) note("; waited {} for a full queue", counted(waits_, "time"));
    note("; at most {:.3f} ms late\n", 1e3 * can::seconds(latest_));
    if (late_ > 0)
      note("the timing of the log was not kept: {} sent more than {} ms late\n", counted(late_, "frame"),
           tolerated_lateness.count());
  }

 private:
  bool is_sent(const LoggedFrame& logged) const {
    return logged.frame.kind != can::FrameKind::error &&
           (ids_.empty() || ids_.contains({logged.frame.extended, logged.frame.id}));
  }
  /// The time from the first frame to this one; negative if the log steps back.
  Duration offset_of(const LoggedFrame& logged, std::chrono::microseconds first, std::size_t line) const {
    const std::chrono::duration<double, std::micro> offset = (logged.time - first) / options_.speed;
    if (offset > longest_replay)
      throw Error(
          fmt::format("{}:{}:1: the frame is due {:.3g} s after the first one, expected at most a year",
                      options_.log.string(), line, offset.count() / 1e6));
    return std::chrono::duration_cast<Duration>(std::max(offset, -longest_replay));
  }
  const std::string& interface_of(const LoggedFrame& logged) const {
    return options_.interface.empty() ? logged.interface : options_.interface;
  }
  void account(Duration lateness) {
    ++sent_;
    latest_ = std::max(latest_, lateness);
    if (lateness > tolerated_lateness) ++late_;
  }

  const ReplayArguments& options_;
  Ids ids_;  ///< empty: all
  Outlets outlets_;
  std::uint64_t sent_ = 0;
  std::uint64_t error_frames_ = 0;
  std::uint64_t filtered_ = 0;
  std::uint64_t waits_ = 0;
  std::uint64_t late_ = 0;
  Duration latest_{0};
};

/// The log is read twice, so that a damaged log moves nothing.
void require_rereadable(const std::filesystem::path& log) {
  std::error_code unknown;
  const auto type = std::filesystem::status(log, unknown).type();
  if (type == std::filesystem::file_type::fifo || type == std::filesystem::file_type::character)
    throw Error(log.string() + ": it is a pipe or a device, expected a file, or - for standard input");
}

int run_replay(const ReplayArguments& options) {
  Replay replay(options);
  if (options.log == "-") {
    end_at_a_signal();  // also while it waits for a line
    if (options.loop != 1) throw Error("--loop: standard input can be read only once, expected a file");
    replay.pass(std::cin, "standard input", Clock::now());
  } else {
    stop_at_a_signal();
    require_rereadable(options.log);
    replay.prepare(*open_can_log(options.log));
    Time start = Clock::now();
    for (std::uint64_t i = 0; (options.loop == 0 || i < options.loop) && stop_signalled == 0; ++i) {
      start = replay.pass(*open_can_log(options.log), options.log.string(), start);
    }
  }
  replay.report();
  if (stop_signalled != 0) throw RunError("stopped before the end of the log");
  return done;
}

}  // namespace

void add_replay(CLI::App& cli, int& status) {
  auto options = std::make_shared<ReplayArguments>();
  CLI::App* command =
      cli.add_subcommand("replay", "Send a bus log of candump or record again with its timing");
  command->add_option("LOG", options->log, "log as `candump -L` writes it; - is standard input")->required();
  command
      ->add_option("--interface", options->interface,
                   "send all frames on this interface instead of the log's own")
      ->check(interface_name());
  command->add_option("--speed", options->speed, "speed relative to the log; 1 by default")
      ->check(number_between(1e-3, 1e6));
  command->add_option("--loop", options->loop, "number of passes; 0: until a signal")
      ->check(whole_number(0, most_passes));
  command->add_option("--filter", options->ids,
                      "send only these identifiers, as candump writes them (201, 00000201)");
  command->add_flag("--force-interface", options->force_interface, "allow an interface that is not virtual");
  command->callback([options, &status] { status = run_replay(*options); });
}

}  // namespace hystcan::app
