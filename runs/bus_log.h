// The bus log of a run: a thread writes all frames on a CAN interface to the run's folder (bus_0001.log,
// ...), in candump format.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

namespace hystcan::runs {

class BusLog {
 public:
  using Warn = std::function<void(const std::string&)>;

  /// Throws RunError if the interface can't be monitored.
  BusLog(const std::string& interface, std::filesystem::path run, std::uint64_t part_bytes, Warn warn);
  ~BusLog();
  BusLog(const BusLog&) = delete;
  BusLog& operator=(const BusLog&) = delete;

 private:
  Warn warn_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace hystcan::runs
