// Two axes that are disturbed at random and recovered, like tests/hil/soak.py, in virtual time. An axis
// faults only because of disturbances that affect it, always recovers, and its reference never jumps.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "config/schema/config.h"
#include "controller/requests.h"
#include "rehearsal/rehearsal.h"
#include "tests/support/hooked_connection.h"
#include "tests/support/long_run.h"

namespace hystcan::disturbed_bench_test {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;
using twin::Fault;
using Kind = controller::Request::Kind;

/// Bound of a reference's motion per cycle: staircases move by 1.4 um, a joining axis moves by less.
constexpr double fastest_um = 2.0;

class DisturbedBench {
 public:
  explicit DisturbedBench(unsigned seed) : random_(seed) {
    controller_.listen_to(requests_);
    twin_.start();
    controller_.start(true);
    run_for(milliseconds(3000));
  }

  /// Disturbs the axes until the disturbance has ended. Returns its name.
  std::string disturb() {
    may_fault_.clear();
    const std::string name = any(4) == 0 ? link_goes_down() : twin_fault();
    run_for(milliseconds(500 + any(20)));  // the slowest detection takes 0.3 s
    return name;
  }
  std::string unexplained() const {
    std::string names;
    for (std::size_t i = 0; i < axes; ++i)
      if (state(i) == AxisState::faulted && !may_fault_.contains(i))
        names += names_[i] + ": " + std::string(to_string(controller_.axis(i).fault().cause)) + ' ';
    return names;
  }
  /// Clears and enables one axis after the other. Returns false if not all axes track within ten seconds.
  bool bring_back() {
    for (const auto& [kind, from] :
         {std::pair(Kind::clear, AxisState::faulted), {Kind::enable, AxisState::offline}})
      for (std::size_t i = 0; i < axes; ++i)
        if (state(i) == from) ask(kind, i);
    for (int i = 0; i < 100 && !all_track(); ++i) run_for(milliseconds(100));
    return all_track();
  }
  void rest() { run_for(milliseconds(300 + any(1700))); }
  double largest_step_um() const { return largest_step_um_; }

 private:
  static constexpr std::size_t axes = 2;

  std::unique_ptr<can::Bus> attach() {
    auto connection = std::make_unique<support::HookedConnection>(bus_.attach());
    connections_.push_back(connection.get());
    return connection;
  }
  int any(int count) { return std::uniform_int_distribution(0, count - 1)(random_); }
  void run_for(can::Duration duration) { clock_.run_until(clock_.now() + duration); }
  AxisState state(std::size_t i) const { return controller_.axis(i).state(); }
  bool all_track() const { return state(0) == AxisState::tracking && state(1) == AxisState::tracking; }

  void ask(Kind kind, std::size_t axis) {
    auto request = std::make_unique<controller::Request>();
    request->kind = kind;
    request->axis = axis;
    ASSERT_TRUE(requests_.ask(std::move(request)));
    run_for(milliseconds(2 + any(10)));
    requests_.take_answer();
  }

  std::string link_goes_down() {
    may_fault_ = {0, 1};
    for (support::HookedConnection* connection : connections_) connection->pretend(can::BusState::down);
    run_for(milliseconds(10 + any(1500)));
    for (support::HookedConnection* connection : connections_) connection->pretend(std::nullopt);
    return "link down";
  }

  std::string twin_fault() {
    // A babbling node blocks the wire for all nodes, and a parameter drift is permanent.
    static const std::set<Fault> others{Fault::babbling_node, Fault::parameter_drift};
    Fault kind{};
    do kind = every<Fault>()[static_cast<std::size_t>(any(twin::fault_count))];
    while (others.contains(kind));
    const auto axis = static_cast<std::size_t>(any(axes));
    twin::FaultSpec spec = twin::fault_spec(kind, names_[axis]);
    if (traits(kind).site == twin::FaultSite::either_node && any(2) == 0) spec.node = twin::Node::amplifier;
    if (!is_harmless(spec)) may_fault_ = {axis};
    twin_.faults().inject(spec);
    run_for(milliseconds(20 + any(580)));
    twin_.faults().remove(kind);
    return describe(spec);
  }
  /// Returns true if this disturbance never faults an axis.
  static bool is_harmless(const twin::FaultSpec& spec) {
    return spec.kind == Fault::duplicate || traits(spec.kind).site == twin::FaultSite::plant ||
           (spec.node == twin::Node::amplifier &&
            (spec.kind == Fault::late || spec.kind == Fault::out_of_order));
  }

  void see(const controller::CycleRecord& record) {
    std::optional<double>& last_um = last_um_[record.axis];
    if (record.report.state != AxisState::tracking) {
      last_um.reset();
      return;
    }
    if (last_um)
      largest_step_um_ = std::max(largest_step_um_, std::abs(record.report.reference_um - *last_um));
    last_um = record.report.reference_um;
  }

  std::mt19937 random_;
  const config::Config config_ = config::load(HYSTCAN_SOURCE_DIR "/config/piezo.toml");
  const std::vector<std::string> names_ = axis_names(config_);
  can::VirtualClock clock_;
  can::SimBus bus_{clock_, {1'000'000}};
  std::vector<support::HookedConnection*> connections_;
  twin::Twin twin_{twin_config(config_), config_.database, clock_, [this](auto) { return attach(); }};
  controller::RequestLink requests_;
  std::array<std::optional<double>, axes> last_um_;
  double largest_step_um_ = 0.0;
  controller::Controller controller_{controller_config(config_), config_.database, clock_,
                                     [this](auto) { return attach(); },
                                     [this](const controller::CycleRecord& record) { see(record); }};
  std::set<std::size_t> may_fault_;
};

TEST(DisturbedBench, FaultsOnlyForADisturbanceAndNeverJumps) {
  for (unsigned seed = 1; seed <= (support::long_run() ? 100 : 2); ++seed) {
    DisturbedBench bench(seed);
    for (int i = 0; i < 200; ++i) {
      const std::string name = bench.disturb();
      ASSERT_EQ(bench.unexplained(), "") << "after " << name << ", seed " << seed;
      ASSERT_TRUE(bench.bring_back()) << "after " << name << ", seed " << seed;
      bench.rest();
      ASSERT_EQ(bench.unexplained(), "") << "at rest after " << name << ", seed " << seed;
      ASSERT_LT(bench.largest_step_um(), fastest_um) << "after " << name << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace hystcan::disturbed_bench_test
