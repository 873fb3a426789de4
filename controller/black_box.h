// The last cycles of each axis, kept in memory, and written as CSV when it faults: what led to it, and what
// came of it.
//
// Lives on the telemetry thread, is filled from the records, and costs the control thread nothing. One file
// for each fault, blackbox_20261121T221923.456Z_x.csv, with the time of day (UTC) and the axis. Nothing is
// ever overwritten or removed: where there are as many files as allowed the next one is not written, for
// the first fault tells the most. That, a full disk and a missing folder are warnings, not the run's end.
//
// A row is a cycle n: SYNC, sample, command. next_position_um is the sample of cycle n+1, the first that
// can have felt command n; empty where cycle n+1 has no sample or is not there.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "can/bus_health_log.h"
#include "controller/cycle_record.h"

namespace hystcan::controller {

/// Records in a ring: the newest `capacity` of them.
class RecordRing {
 public:
  explicit RecordRing(std::size_t capacity) : capacity_(capacity) { records_.reserve(capacity); }

  void add(const CycleRecord& record);
  std::size_t size() const { return records_.size(); }
  /// 0: the oldest.
  const CycleRecord& operator[](std::size_t age) const;

 private:
  std::size_t capacity_;
  std::size_t oldest_ = 0;
  std::vector<CycleRecord> records_;
};

class BlackBox {
 public:
  struct Config {
    std::filesystem::path folder;    ///< empty: the working directory
    unsigned files = 50;             ///< at most so many in the folder, of whatever run; 0: none are written
    std::size_t cycles = 10'000;     ///< kept of each axis
    std::size_t cycles_after = 100;  ///< of these, after the fault
  };
  using Sink = can::BusHealthLog::Sink;
  using UtcNow = std::function<std::chrono::system_clock::time_point()>;

  /// Warns at once where no file could be written.
  BlackBox(const Config& config, std::vector<std::string> axis_names, Sink sink,
           UtcNow utc_now = std::chrono::system_clock::now);

  void add(const CycleRecord& record);
  /// What waits for cycles after a fault is written as it is: no more come.
  void finish();
  /// From any thread: every axis as it is, with the next record.
  void request() { requested_ = true; }

 private:
  struct Box {
    std::string name;
    RecordRing ring;
    bool faulted = false;
    std::size_t cycles_to_go = 0;  ///< until a fault is written; 0: there is none to write
    std::string reason;
    std::chrono::system_clock::time_point faulted_at;
  };

  void note_fault(Box& box, const CycleRecord& record);
  void write(Box& box, std::string_view reason, std::chrono::system_clock::time_point when);
  /// Why no file may be added to the folder; empty where one may.
  std::string find_refusal() const;
  std::filesystem::path file_for(const Box& box, std::chrono::system_clock::time_point when) const;

  Config config_;
  Sink sink_;
  UtcNow utc_now_;
  std::vector<Box> boxes_;
  std::atomic<bool> requested_{false};
};

}  // namespace hystcan::controller
