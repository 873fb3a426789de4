#include "controller/black_box.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "base/append_file.h"
#include "controller/cycle_record.h"

namespace hystcan::controller {
namespace {

using Level = can::BusHealthLog::Level;
constexpr std::string_view prefix = "blackbox_";

std::string words_of(int error) { return std::generic_category().message(error); }

/// Returns the name of an axis as a part of a file name: every special character becomes '_'.
std::string plain(std::string name) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  std::ranges::replace_if(
      name, [&](char c) { return !is_plain(c); }, '_');
  return name;
}

/// Appends the last column of a row: the sample in `next`, if this is the cycle after `record` and has a
/// sample.
void append_next_position(std::string& row, const CycleRecord& record, const CycleRecord* next) {
  row += ',';
  if (next != nullptr && next->cycle == record.cycle + 1 && !next->report.sample_missing)
    append_fixed(row, next->report.position_um, find_cycle_column("position_um")->decimals);
}

}  // namespace

BlackBox::BlackBox(const Config& config, std::vector<std::string> axis_names, Sink sink, UtcNow utc_now)
    : config_(config),
      makes_folder_(config.folder.empty()),
      names_(std::move(axis_names)),
      sink_(std::move(sink)),
      utc_now_(std::move(utc_now)) {
  if (makes_folder_) config_.folder = std::filesystem::absolute("hystcan-blackbox");
  boxes_.reserve(names_.size());
  for (const std::string& name : names_)
    boxes_.push_back({.name = name,
                      .ring = boost::circular_buffer<CycleRecord>(config_.cycles),
                      .faulted = false,
                      .cycles_to_go = 0,
                      .reason = {},
                      .faulted_at = {}});
  if (config_.files == 0) return;
  if (const auto refusal = reason_against_writing())
    sink_(Level::warning, fmt::format("no black box will be written at a fault: {}", *refusal));
}

void BlackBox::add(const CycleRecord& record) {
  Box& box = boxes_[record.axis];
  const bool fault_is_new = record.report.state == AxisState::faulted && !box.faulted;
  if (fault_is_new && box.cycles_to_go != 0) write(box, box.reason, box.faulted_at);
  box.ring.push_back(record);
  if (fault_is_new)
    note_fault(box, record);
  else if (box.cycles_to_go != 0 && --box.cycles_to_go == 0)
    write(box, box.reason, box.faulted_at);
  box.faulted = record.report.state == AxisState::faulted;
  if (!requested_.exchange(false)) return;
  const auto now = utc_now_();
  for (Box& each : boxes_) write(each, "requested", now);
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

std::optional<std::string> BlackBox::reason_against_writing() const {
  std::error_code ignored;
  if (makes_folder_ && !std::filesystem::exists(config_.folder, ignored)) {
    const std::filesystem::path parent = config_.folder.parent_path();
    if (access(parent.c_str(), W_OK | X_OK) == 0) return std::nullopt;
    return fmt::format("{}: {}", parent.string(), words_of(errno));
  }
  return reason_against_the_folder();
}

std::optional<std::string> BlackBox::reason_against_the_folder() const {
  const std::string folder = config_.folder.string();
  std::error_code error;
  std::size_t files = 0;
  auto entry = std::filesystem::directory_iterator(config_.folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error))
    files += entry->path().filename().string().starts_with(prefix) ? 1 : 0;
  if (error) return fmt::format("{}: {}", folder, error.message());
  if (access(folder.c_str(), W_OK | X_OK) != 0) return fmt::format("{}: {}", folder, words_of(errno));
  if (files >= config_.files)
    return fmt::format("{} contains {} black boxes, the maximum is {}: move them away", folder, files,
                       config_.files);
  return std::nullopt;
}

std::filesystem::path BlackBox::file_for(const Box& box, std::chrono::system_clock::time_point when) const {
  const auto since_epoch = std::chrono::floor<std::chrono::milliseconds>(when.time_since_epoch());
  const auto whole_s = std::chrono::floor<std::chrono::seconds>(since_epoch);
  return config_.folder / fmt::format("{}{:%Y%m%dT%H%M%S}.{:03}Z_{}.csv", prefix,
                                      fmt::gmtime(static_cast<std::time_t>(whole_s.count())),
                                      (since_epoch - whole_s).count(), plain(box.name));
}

void BlackBox::write(Box& box, std::string_view reason, std::chrono::system_clock::time_point when) {
  if (config_.files == 0 || box.ring.empty()) return;
  if (const auto refusal = reason_against_writing()) {
    sink_(Level::warning, fmt::format("{}: no black box was written: {}", box.name, *refusal));
    return;
  }
  const std::filesystem::path path = file_for(box, when);
  std::error_code error;
  try {
    if (makes_folder_) std::filesystem::create_directory(config_.folder);
    AppendFile file(path, AppendFile::Existing::refuse);
    std::string row = fmt::format(
        "# axis {}: {}\n# next_position_um: the sample of the next cycle; sample_heard_us and "
        "command_sent_us: time since the SYNC of the cycle\n{}",
        box.name, reason, cycle_units);
    append_cycle_header(row);
    file.add(row += ",next_position_um\n");
    for (std::size_t i = 0; i < box.ring.size(); ++i) {
      row.clear();
      append_cycle_row(row, box.ring[i], names_);
      append_next_position(row, box.ring[i], i + 1 < box.ring.size() ? &box.ring[i + 1] : nullptr);
      file.add(row += '\n');
    }
    error = file.close();
    if (error) std::filesystem::remove(path);
  } catch (const std::system_error& refused) {
    error = refused.code();
  }
  if (error) {
    sink_(Level::warning, fmt::format("{}: no black box: {}: {}", box.name, path.string(), error.message()));
  } else {
    sink_(Level::info,
          fmt::format("{}: the last {} cycles are in {}", box.name, box.ring.size(), path.string()));
  }
}

}  // namespace hystcan::controller
