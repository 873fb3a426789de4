#include "can/bus_health_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/lockfree/spsc_queue.hpp>
#include <utility>

#include "base/text.h"

namespace hystcan::can {
namespace {

// describe() writes all twelve counters. The log writes only the first eight. The others count changes of
// state, which have their own lines in the log, and error frames, whose causes are among the first eight.
constexpr std::array<BusTrouble, 12> troubles{{
    {"send_refused", "not sent: the queue was full or the interface was down", &BusCounters::send_refused},
    {"receive_lost", "lost in the kernel: the program read too slowly", &BusCounters::receive_lost},
    {"not_acknowledged", "not acknowledged: no other node is on the bus", &BusCounters::not_acknowledged},
    {"arbitration_lost", "arbitration lost", &BusCounters::arbitration_lost},
    {"protocol_errors", "protocol errors: check wiring, termination and bit rates",
     &BusCounters::protocol_errors},
    {"controller_overflows", "queue overflows in the adapter", &BusCounters::controller_overflows},
    {"transceiver_errors", "transceiver errors: check the wiring", &BusCounters::transceiver_errors},
    {"restarts", "restarts after bus-off", &BusCounters::restarts},
    {"warnings", "changes to error-warning", &BusCounters::warnings},
    {"passives", "changes to error-passive", &BusCounters::passives},
    {"bus_offs", "changes to bus-off", &BusCounters::bus_offs},
    {"error_frames", "error frames", &BusCounters::error_frames},
}};

BusHealthLog::Level level_of(BusState state) {
  if (state == BusState::active) return BusHealthLog::Level::info;
  const bool lost = state == BusState::bus_off || state == BusState::down;
  return lost ? BusHealthLog::Level::error : BusHealthLog::Level::warning;
}

std::string words_of(const std::optional<ErrorCounters>& counters) {
  if (!counters) return {};
  return fmt::format(", error counters {} transmit, {} receive", counters->transmit, counters->receive);
}

}  // namespace

std::optional<std::uint64_t> RateLimit::add(std::uint64_t events, double time_s) {
  pending_ += events;
  if (pending_ == 0 || (last_s_ && time_s < *last_s_ + period_s_)) return std::nullopt;
  last_s_ = time_s;
  return std::exchange(pending_, 0);
}

BusReport report_of(const Bus& bus, double time_s) {
  return {.time_s = time_s,
          .state = bus.state(),
          .refusal = bus.refusal(),
          .error_counters = bus.error_counters(),
          .counters = bus.counters()};
}

BusReport report_of(std::span<const Bus* const> connections, double time_s) {
  BusReport all;
  all.time_s = time_s;
  BusCounters& sum = all.counters;
  for (const Bus* bus : connections) {
    const BusReport one = report_of(*bus, time_s);
    all.state = std::max(all.state, one.state);
    all.refusal = std::max(all.refusal, one.refusal);
    if (one.error_counters) all.error_counters = one.error_counters;
    const std::uint64_t refused = sum.send_refused + one.counters.send_refused;
    const std::uint64_t lost = sum.receive_lost + one.counters.receive_lost;
    for (const BusTrouble& trouble : troubles)
      sum.*trouble.count = std::max(sum.*trouble.count, one.counters.*trouble.count);
    sum.send_refused = refused;
    sum.receive_lost = lost;
    sum.sent += one.counters.sent;
    sum.received += one.counters.received;
  }
  return all;
}

std::span<const BusTrouble> bus_troubles() { return troubles; }

std::string describe(const BusReport& report) {
  std::string text = fmt::format("bus {}: {} sent, {} received", to_string(report.state),
                                 counted(report.counters.sent, "frame"), report.counters.received);
  for (const BusTrouble& trouble : troubles) {
    const std::string_view name = trouble.words.substr(0, trouble.words.find(':'));
    if (const std::uint64_t count = report.counters.*trouble.count; count != 0)
      text += fmt::format(", {} {}", count, name);
  }
  return text + words_of(report.error_counters);
}

struct BusHealthLog::Ring {
  static constexpr std::size_t capacity = 256;
  boost::lockfree::spsc_queue<BusReport, boost::lockfree::capacity<capacity>> reports;
};

BusHealthLog::BusHealthLog(std::string interface, Sink sink)
    : ring_(std::make_unique<Ring>()), interface_(std::move(interface)), sink_(std::move(sink)) {}

BusHealthLog::~BusHealthLog() = default;

void BusHealthLog::sample(const BusReport& report) {
  ring_->reports.push(report);  // a full ring drops the report; the totals in the next report have its events
}

void BusHealthLog::write() {
  ring_->reports.consume_all([this](const BusReport& report) { write(report); });
}

void BusHealthLog::write(const BusReport& report) {
  RateLimit& state_limit = state_limits_[static_cast<std::size_t>(report.state)];
  if (const auto times = state_limit.add(report.state != last_.state ? 1 : 0, report.time_s))
    sink_(level_of(report.state),
          fmt::format("{}: bus {} at {:.3f} s{}{}", interface_, to_string(report.state), report.time_s,
                      *times > 1 ? fmt::format(" ({} times since the last line)", *times) : "",
                      words_of(report.error_counters)));
  if (report.refusal != last_.refusal && report.refusal != Refusal::none)
    sink_(Level::error, fmt::format("{}: the interface is up again at {:.3f} s, but is not used, because {}",
                                    interface_, report.time_s, to_string(report.refusal)));
  for (std::size_t i = 0; i < trouble_limits_.size(); ++i) {
    const std::uint64_t more = report.counters.*troubles[i].count - last_.counters.*troubles[i].count;
    if (const auto events = trouble_limits_[i].add(more, report.time_s))
      sink_(Level::warning, fmt::format("{}: {} {} (counted until {:.3f} s)", interface_, *events,
                                        troubles[i].words, report.time_s));
  }
  last_ = report;
}

}  // namespace hystcan::can
