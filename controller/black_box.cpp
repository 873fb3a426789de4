#include "controller/black_box.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <iterator>
#include <memory>
#include <system_error>
#include <utility>

namespace hystcan::controller {
namespace {

using Level = can::BusHealthLog::Level;
constexpr std::string_view prefix = "blackbox_";

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::string words_of(int error) { return std::generic_category().message(error); }

/// The name of an axis as a part of a file name.
std::string plain(std::string name) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  std::ranges::replace_if(
      name, [&](char c) { return !is_plain(c); }, '_');
  return name;
}

double us(can::Duration duration) { return std::chrono::duration<double, std::micro>(duration).count(); }

constexpr std::string_view header =
    "cycle,time_s,state,fault,segment,reference_um,position_um,error_um,demand_um,drive,limits,"
    "amplifier_output,next_position_um,period_us,sync_late_us,sample_heard_us,command_sent_us,execution_us,"
    "overruns,missing_samples,late_samples,learnt_um\n";

/// `next`: the record after this one, or null.
void format_row(fmt::memory_buffer& text, const CycleRecord& record, const CycleRecord* next) {
  const auto out = std::back_inserter(text);
  const AxisReport& report = record.report;
  fmt::format_to(out, "{},{:.9f},{},{},", record.cycle, record.time_s, to_string(report.state),
                 to_string(report.cause));
  if (report.state == AxisState::tracking)
    fmt::format_to(out, "{},{:.6f},{:.6f},{:.6f},{:.6f},", report.point.segment, report.reference_um,
                   report.position_um, report.reference_um - report.position_um, report.demand_um);
  else
    fmt::format_to(out, ",,{:.6f},,,", report.position_um);
  fmt::format_to(out, "{:.6f},{},{:.6f},", report.drive, limits_to_string(report.limits),
                 record.amplifier_output);
  if (next != nullptr && next->cycle == record.cycle + 1 && !next->report.sample_missing)
    fmt::format_to(out, "{:.6f}", next->report.position_um);
  fmt::format_to(out, ",{:.3f},{:.3f},", us(record.phases.period), us(record.phases.lateness));
  if (!report.sample_missing) fmt::format_to(out, "{:.3f}", us(record.phases.sample_heard));
  fmt::format_to(out, ",{:.3f},{:.3f},{},{},{},", us(record.phases.command_sent), us(record.phases.execution),
                 record.counters.overruns, record.counters.missing_samples, record.counters.late_samples);
  if (report.learning.state != LearningState::off)
    fmt::format_to(out, "{:.6f}", report.learning.correction_um);
  fmt::format_to(out, "\n");
}

}  // namespace

void RecordRing::add(const CycleRecord& record) {
  if (records_.size() < capacity_) {
    records_.push_back(record);
    return;
  }
  records_[oldest_] = record;
  oldest_ = (oldest_ + 1) % capacity_;
}

const CycleRecord& RecordRing::operator[](std::size_t age) const {
  return records_[(oldest_ + age) % records_.size()];
}

BlackBox::BlackBox(const Config& config, std::vector<std::string> axis_names, Sink sink, UtcNow utc_now)
    : config_(config), sink_(std::move(sink)), utc_now_(std::move(utc_now)) {
  if (config_.folder.empty()) config_.folder = ".";
  boxes_.reserve(axis_names.size());
  for (std::string& name : axis_names)
    boxes_.push_back({.name = std::move(name),
                      .ring = RecordRing(config_.cycles),
                      .faulted = false,
                      .cycles_to_go = 0,
                      .reason = {},
                      .faulted_at = {}});
  if (config_.files == 0) return;
  if (const std::string refusal = reason_against_writing(); !refusal.empty())
    sink_(Level::warning, fmt::format("no black box will be written at a fault: {}", refusal));
}

void BlackBox::add(const CycleRecord& record) {
  Box& box = boxes_[record.axis];
  const bool fault_is_new = record.report.state == AxisState::faulted && !box.faulted;
  if (fault_is_new && box.cycles_to_go != 0) write(box, box.reason, box.faulted_at);
  box.ring.add(record);
  if (fault_is_new)
    note_fault(box, record);
  else if (box.cycles_to_go != 0 && --box.cycles_to_go == 0)
    write(box, box.reason, box.faulted_at);
  box.faulted = record.report.state == AxisState::faulted;
  if (!requested_.exchange(false)) return;
  const auto now = utc_now_();
  for (Box& each : boxes_) write(each, "asked for", now);
}

void BlackBox::note_fault(Box& box, const CycleRecord& record) {
  box.reason =
      fmt::format("{} at {:.6f} s, cycle {}", to_string(record.report.cause), record.time_s, record.cycle);
  box.faulted_at = utc_now_();
  box.cycles_to_go = config_.cycles_after;
  if (box.cycles_to_go == 0) write(box, box.reason, box.faulted_at);
}

void BlackBox::finish() {
  for (Box& box : boxes_)
    if (std::exchange(box.cycles_to_go, 0) != 0) write(box, box.reason, box.faulted_at);
}

std::string BlackBox::reason_against_writing() const {
  const std::string folder = config_.folder.string();
  std::error_code error;
  std::size_t files = 0;
  auto entry = std::filesystem::directory_iterator(config_.folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error))
    files += entry->path().filename().string().starts_with(prefix) ? 1 : 0;
  if (error) return fmt::format("{}: {}", folder, error.message());
  if (access(folder.c_str(), W_OK | X_OK) != 0) return fmt::format("{}: {}", folder, words_of(errno));
  if (files >= config_.files)
    return fmt::format("{} holds {} black boxes, {} are allowed: move them away", folder, files,
                       config_.files);
  return {};
}

std::filesystem::path BlackBox::file_for(const Box& box, std::chrono::system_clock::time_point when) const {
  const auto since_epoch = std::chrono::floor<std::chrono::milliseconds>(when.time_since_epoch());
  const auto whole_s = std::chrono::floor<std::chrono::seconds>(since_epoch);
  return config_.folder / fmt::format("{}{:%Y%m%dT%H%M%S}.{:03}Z_{}.csv", prefix,
                                      fmt::gmtime(static_cast<std::time_t>(whole_s.count())),
                                      (since_epoch - whole_s).count(), plain(box.name));
}

void BlackBox::write(Box& box, std::string_view reason, std::chrono::system_clock::time_point when) {
  if (config_.files == 0 || box.ring.size() == 0) return;
  if (const std::string refusal = reason_against_writing(); !refusal.empty()) {
    sink_(Level::warning, fmt::format("{}: no black box was written: {}", box.name, refusal));
    return;
  }
  const std::filesystem::path path = file_for(box, when);
  File file(std::fopen(path.c_str(), "wx"));  // "x": fails where the file exists
  int error = file ? 0 : errno;
  const bool created = error == 0;
  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text),
                 "# axis {}: {}; drive and amplifier_output in the axis's drive unit\n"
                 "# next_position_um: the sample of the next cycle; *_us from the SYNC of the cycle on\n{}",
                 box.name, reason, header);
  for (std::size_t i = 0; error == 0 && i < box.ring.size(); ++i) {
    format_row(text, box.ring[i], i + 1 < box.ring.size() ? &box.ring[i + 1] : nullptr);
    if (std::fwrite(text.data(), 1, text.size(), file.get()) != text.size()) error = errno;
    text.clear();
  }
  if (file && std::fclose(file.release()) != 0 && error == 0) error = errno;
  if (error != 0) {
    if (created) std::remove(path.c_str());
    sink_(Level::warning, fmt::format("{}: no black box: {}: {}", box.name, path.string(), words_of(error)));
  } else {
    sink_(Level::info,
          fmt::format("{}: the last {} cycles are in {}", box.name, box.ring.size(), path.string()));
  }
}

}  // namespace hystcan::controller
