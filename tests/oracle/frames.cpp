// oracle_frames SEED SECONDS FILE: writes every frame of a run in virtual time, for oracle.py. The settings,
// the reference, the troubles (tests/support/fault_rig.h) and the damage are drawn from the seed.
//
// FILE contains records of 24 bytes, little-endian: time in ns (i64), identifier (u32), kind (u8: 0 data, 1
// remote, 2 FD; + 16: 29 bits; 128: a remark), length (u8), two bytes 0, the payload's first eight bytes. A
// remark has a value of `Remark` in place of the identifier. FILE.json contains the settings and the frames
// that the controller has rejected.
//
// With an odd seed, a tester adds damaged samples and statuses, and the bus has no errors: the counts can
// therefore be predicted.

#include <algorithm>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "can/protocol/protocol.h"
#include "tests/support/fault_rig.h"

namespace hystcan::support {
namespace {

using controller::AxisState;
using Kind = controller::Request::Kind;

constexpr std::uint32_t sample_id = 0x182, status_id = 0x181;

enum class Remark : std::uint32_t { clear = 1, foreign_sync = 2, bus_is_gone = 3 };

struct Record {
  std::int64_t time_ns = 0;
  std::uint32_t id = 0;
  std::uint8_t kind = 0;
  std::uint8_t length = 0;
  std::array<std::uint8_t, 2> unused{};
  std::array<std::uint8_t, 8> data{};
};
static_assert(sizeof(Record) == 24);

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return static_cast<double>(engine_() >> 11U) * 0x1p-53; }
  double between(double low, double high) { return low + uniform() * (high - low); }
  std::size_t below(std::size_t end) {
    return static_cast<std::size_t>(uniform() * static_cast<double>(end));
  }

 private:
  std::mt19937_64 engine_;
};

std::vector<controller::Segment> drawn_reference(Random& random) {
  const double low_um = random.between(3.0, 10.0), high_um = random.between(15.0, 26.0);
  const double frequency_Hz = random.between(0.5, 8.0);
  controller::Staircase stairs{.levels_um = {}, .rise_s = 0.03, .dwell_s = random.between(0.02, 0.1)};
  for (int i = 0; i < 8; ++i) stairs.levels_um.push_back(random.between(low_um, high_um));
  return {{.shape = controller::Sine{low_um, high_um, frequency_Hz, 4.0}, .transition_s = 0.1},
          {.shape = controller::Triangle{low_um, high_um, frequency_Hz, 3.0}, .transition_s = 0.1},
          {.shape = stairs, .transition_s = 0.1}};
}

config::Config drawn_config(Random& random) {
  config::Config config = one_axis();
  controller::AxisConfig& control = config.axes[0].control;
  control.setpoint = drawn_reference(random);
  control.gate.slew_per_s = random.between(4'000.0, 20'000.0);
  control.gate.safe_drive = random.uniform() < 0.5 ? 0.0 : random.between(0.0, 5.0);
  control.wipe_slew_per_s = random.between(1'000.0, 2'500.0);
  control.supervision.missing_samples = static_cast<unsigned>(1 + random.below(5));
  control.fault_ramp_per_s = random.uniform() < 0.3 ? random.between(500.0, 4'000.0) : 0.0;
  return config;
}

class Run {
 public:
  Run(std::uint64_t seed, const std::string& file)
      : random_(seed),
        is_damaging_(seed % 2 == 1),
        file_(file, std::ios::binary),
        rig_(drawn_config(random_)),
        ear_(rig_.listen([this](const can::Frame& frame) { hear(frame); })) {}

  void run(double seconds) {
    rig_.start();
    rig_.tracks();
    while (now_s() < seconds) episode();
    damages_now_ = false;
    rig_.run_for(std::chrono::milliseconds(20));
  }

  nlohmann::json facts() {
    const controller::AxisConfig& control = rig_.config().axes[0].control;
    nlohmann::json rejected;
    for (const can::RejectedFrames& each : rig_.controller().rejected())
      rejected[each.message] = each.by_cause;
    rejected["XSensorSample"] =
        can::rejected_frames("", rig_.controller().wired_axis(0).sensor.samples().checker()).by_cause;
    return {{"rate_Hz", rig_.config().controller.rate_Hz},
            {"drive_min", control.gate.drive_min},
            {"drive_max", control.gate.drive_max},
            {"safe_drive", control.gate.safe_drive},
            {"slew_per_s", control.gate.slew_per_s},
            {"fault_ramp_per_s", control.fault_ramp_per_s},
            {"missing_samples", control.supervision.missing_samples},
            {"position_min_um", control.supervision.position_min_um},
            {"position_max_um", control.supervision.position_max_um},
            {"is_damaging", is_damaging_},
            {"cycles", rig_.controller().counters().cycles},
            {"faults", rig_.faults()},
            {"accepted_samples", rig_.controller().wired_axis(0).sensor.samples().checker().accepted()},
            {"rejected", rejected}};
  }

 private:
  double now_s() { return can::seconds(rig_.clock().now().time_since_epoch()); }

  void write(std::uint32_t id, std::uint8_t kind, std::uint8_t length, std::span<const std::uint8_t> data) {
    Record record{
        .time_ns = rig_.clock().now().time_since_epoch().count(), .id = id, .kind = kind, .length = length};
    std::copy_n(data.begin(), std::min(data.size(), record.data.size()), record.data.begin());
    file_.write(reinterpret_cast<const char*>(&record), sizeof record);
  }
  void remark(Remark what) { write(static_cast<std::uint32_t>(what), 128, 0, {}); }

  void hear(const can::Frame& frame) {
    const auto kind =
        static_cast<std::uint8_t>(static_cast<unsigned>(frame.kind) + (frame.extended ? 16U : 0U));
    write(frame.id, kind, frame.length, frame.payload());
    const bool is_ours = frame.kind == can::FrameKind::data && !frame.extended &&
                         (frame.id == sample_id || frame.id == status_id) && frame.length == 8;
    if (is_ours && damages_now_ && random_.uniform() < 0.01) rig_.send(damaged(frame));
  }

  /// Usually no longer intact; sometimes a frame that repeats its counter, rarely a valid one.
  can::Frame damaged(can::Frame frame) {
    const double how = random_.uniform();
    if (how < 0.1) frame.kind = can::FrameKind::remote;
    if (how >= 0.1 && how < 0.2) frame.extended = true;
    if (how >= 0.2 && how < 0.35) frame.length = static_cast<std::uint8_t>(random_.below(8));
    if (how >= 0.35 && how < 0.8) {
      for (std::size_t flips = 1 + random_.below(12); flips > 0; --flips)
        frame.data[random_.below(8)] ^= static_cast<std::uint8_t>(1U << random_.below(8));
    }
    return frame;  // otherwise the same frame again
  }

  Trouble drawn_trouble() {
    while (true) {
      const auto trouble = static_cast<Trouble>(random_.below(trouble_count));
      const bool is_of_the_bus = trouble == Trouble::bus_off || trouble == Trouble::interface_down;
      if (!is_damaging_ || !is_of_the_bus) return trouble;
    }
  }

  void episode() {
    damages_now_ = is_damaging_;
    rig_.run_for(can::Duration(std::llround(1e9 * random_.between(1.0, 4.0))));
    const Trouble trouble = drawn_trouble();
    if (trouble == Trouble::foreign_sync) remark(Remark::foreign_sync);
    if (trouble == Trouble::bus_off || trouble == Trouble::interface_down) remark(Remark::bus_is_gone);
    rig_.begin(trouble);
    rig_.run_for(can::Duration(std::llround(1e6 * std::pow(2000.0, random_.uniform()))));
    rig_.end(trouble);
    rig_.run_for(std::chrono::milliseconds(80));
    damages_now_ = false;  // otherwise it would not return
    for (int attempt = 0; attempt < 4 && rig_.axis().state() != AxisState::tracking; ++attempt) {
      if (rig_.axis().state() == AxisState::faulted) {
        remark(Remark::clear);
        rig_.ask(Kind::clear);
      }
      if (rig_.axis().state() == AxisState::offline) rig_.ask(Kind::enable);
      rig_.tracks();
    }
  }

  Random random_;
  bool is_damaging_;
  bool damages_now_ = false;
  std::ofstream file_;
  FaultRig rig_;
  std::unique_ptr<can::Bus> ear_;
};

}  // namespace
}  // namespace hystcan::support

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const std::string file = argv[3];
  hystcan::support::Run run(std::stoull(argv[1]), file);
  run.run(std::stod(argv[2]));
  std::ofstream(file + ".json") << run.facts().dump(2) << "\n";
}
