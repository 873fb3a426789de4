// A node that fills the bus delays the controller's queued commands. Afterwards an amplifier never applies a
// command that is older than two cycles. Controller and twin on the simulated bus, with a babbling node of
// any priority.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "app/live/rehearsal_setup.h"
#include "config/schema/config.h"
#include "tests/support/hooked_connection.h"
#include "tests/support/many_axes.h"
#include "tests/support/oversleeper.h"
#include "tests/support/shows.h"

namespace hystcan::old_command_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// The reference moves, so that all commands are different.
rehearsal::Setup setup_of(std::size_t axes, bool in_shared_frames) {
  const std::string file = in_shared_frames ? "fd_eight.toml" : "piezo.toml";
  config::Config config = config::load(HYSTCAN_SOURCE_DIR "/config/" + file);
  config.axes.resize(in_shared_frames ? axes : 1);
  for (config::AxisConfig& axis : config.axes) {
    axis.control.setpoint = {
        {.shape = controller::Sine{.low_um = 5.0, .high_um = 25.0, .frequency_Hz = 2.0, .cycles = 1000.0},
         .transition_s = 0.1}};
    axis.control.wipe_slew_per_s = 2000.0;
    axis.control.wipe_dwell_s = 0.01;
  }
  return in_shared_frames ? app::rehearsal_setup(config) : support::many_axes(config, axes);
}

/// Statistics of the commands with Enable.
struct Found {
  std::size_t applied = 0;
  std::size_t not_applied = 0;
  std::size_t refused = 0;    ///< refused because too old
  can::Duration oldest{};     ///< age of the oldest applied command, since the SYNC that it names
  int most_in_the_queue = 0;  ///< maximum number of queued frames of one message
};

class Loop {
 public:
  explicit Loop(const rehearsal::Setup& setup)
      : bus_(clock_, setup.rates),
        twin_(setup.twin, setup.database, clock_,
              [this](std::span<const can::Filter> filters) {
                return bus_.attach(can::TransmitOrder::by_priority, filters);
              }),
        controller_(
            setup.controller, setup.database, sleeper_,
            [this](std::span<const can::Filter> filters) {
              return std::make_unique<support::HookedConnection>(
                  bus_.attach(can::TransmitOrder::as_sent, filters),
                  [this](can::Frame& frame) { return note_queued(frame); },
                  [this](can::Frame& frame) { return !loses_ || !loses_(frame.id); });
            },
            [this](const controller::CycleRecord&) {
              sleeper_.by = lateness_ ? lateness_() : can::Duration{};
            }),
        cycle_(setup.twin.cycle),
        babbler_(bus_.attach()),
        listener_(bus_.attach()) {
    for (const auto& axis : twin_.axes())
      amplifiers_.push_back(
          {*can::find_layout<can::AmpCommand>(setup.database, wire_of(setup, axis->name)), axis->amplifier});
    babbler_->on_sent([this](const can::Frame& frame, can::Time) {
      if (babbles_) babbler_->send(frame);
    });
    listener_->on_frame([this](const can::Frame& frame, can::Time when) { note(frame, when); });
    twin_.start();
    controller_.start();
  }

  /// From now on, each SYNC is late by the result of `lateness`, and the controller does not receive frames
  /// for which `loses` returns true.
  void disturb(std::function<can::Duration()> lateness, std::function<bool(std::uint32_t id)> loses) {
    lateness_ = std::move(lateness);
    loses_ = std::move(loses);
  }
  void run_for(can::Duration time) { clock_.run_until(clock_.now() + time); }
  void babble_for(can::Duration time, const can::Frame& frame) {
    babbles_ = true;
    for (int i = 0; i < 2; ++i) babbler_->send(frame);
    run_for(time);
    babbles_ = false;
  }
  std::string causes() const {
    std::string text;
    for (std::size_t i = 0; i < controller_.axis_count(); ++i)
      text += std::string(to_string(controller_.axis(i).fault().cause)) + "; ";
    return text;
  }
  bool tracks() const {
    for (std::size_t i = 0; i < controller_.axis_count(); ++i)
      if (controller_.axis(i).state() != controller::AxisState::tracking) return false;
    return true;
  }
  const Found& found() const { return found_; }

 private:
  struct Amplifier {
    can::Layout<can::AmpCommand> layout;
    const node::AmplifierChannel& channel;
    double setpoint = 0.0;  ///< setpoint before the command
  };

  static const can::AxisWire& wire_of(const rehearsal::Setup& setup, const std::string& name) {
    return std::ranges::find_if(setup.twin.axes, [&](const auto& axis) { return axis.wire.name == name; })
        ->wire;
  }
  bool enables(const can::Frame& frame) const {
    return std::ranges::any_of(amplifiers_, [&](const Amplifier& amplifier) {
      return amplifier.layout.id() == frame.id && amplifier.layout.decode(frame).enable;
    });
  }
  bool note_queued(const can::Frame& frame) {
    if (enables(frame)) ++queued_[frame.id];
    return true;
  }
  /// The amplifier has already received the frame, because it was attached earlier.
  void note(const can::Frame& frame, can::Time when) {
    if (const auto counter = can::parse_sync(frame)) syncs_[*counter] = when;
    if (enables(frame)) --queued_[frame.id];
    for (const auto& [id, count] : queued_)
      found_.most_in_the_queue = std::max(found_.most_in_the_queue, count);
    for (Amplifier& amplifier : amplifiers_)
      if (amplifier.layout.id() == frame.id) judge(amplifier, amplifier.layout.decode(frame), when);
  }
  void judge(Amplifier& amplifier, const can::AmpCommand& command, can::Time when) {
    const double before = std::exchange(amplifier.setpoint, amplifier.channel.setpoint());
    if (!command.enable || command.setpoint == before) return;
    const can::Duration age = when - syncs_[command.sync_counter];
    if (amplifier.setpoint == command.setpoint) {
      ++found_.applied;
      found_.oldest = std::max(found_.oldest, age);
    } else {
      ++found_.not_applied;
      if (age > 2 * cycle_) ++found_.refused;
    }
  }

  can::VirtualClock clock_;
  support::Oversleeper sleeper_{clock_};
  std::function<can::Duration()> lateness_;
  std::function<bool(std::uint32_t)> loses_;
  can::SimBus bus_;
  std::vector<Amplifier> amplifiers_;
  std::map<std::uint32_t, int> queued_;
  twin::Twin twin_;
  controller::Controller controller_;
  can::Duration cycle_;
  std::unique_ptr<can::Bus> babbler_;
  std::unique_ptr<can::Bus> listener_;
  std::array<can::Time, can::sync_counter_max + 1U> syncs_{};
  bool babbles_ = false;
  Found found_;
};

/// Returns a frame of any priority whose identifier is not used in a configuration: nodes 64 to 126.
can::Frame babble(int function, int node, int length) {
  return {.id = static_cast<std::uint32_t>(128 * function + node),
          .length = static_cast<std::uint8_t>(length)};
}

TEST(OldCommand, IsNotAppliedMoreThanTwoCyclesAfterItsSync) {
  shows("S-049");
  std::size_t refused = 0;
  const bool holds = rc::check([&] {
    const auto axes = *rc::gen::inRange<std::size_t>(1, 5);
    const rehearsal::Setup setup = setup_of(axes, *rc::gen::arbitrary<bool>());
    Loop loop(setup);
    for (int i = 0; i < 100 && !loop.tracks(); ++i) loop.run_for(milliseconds(20));
    RC_ASSERT(loop.tracks());
    loop.run_for(microseconds(*rc::gen::inRange(0, 20'000)));
    const int length = *rc::gen::inRange(0, 9);  // in separate statements: the same cases with each compiler
    const int node = *rc::gen::inRange(64, 127);
    const can::Frame frame = babble(*rc::gen::inRange(0, 16), node, length);
    const int length_us = 1 << *rc::gen::inRange(6, 17);
    loop.babble_for(microseconds(*rc::gen::inRange(length_us, 2 * length_us)), frame);
    loop.run_for(milliseconds(20));
    RC_ASSERT(loop.found().applied > 0U);
    RC_ASSERT(loop.found().oldest <= 2 * setup.twin.cycle);
    RC_ASSERT(loop.found().most_in_the_queue == 1);
    refused += loop.found().refused;
  });
  EXPECT_TRUE(holds);
  EXPECT_GT(refused, 10U);
}

// A SYNC that is late by up to half a cycle does not delay later ones: the distances are 0.5 to 1.5 cycles.
// If a sample is lost, the command is sent at the end of its cycle.
TEST(CommandOnABusInOrder, IsAppliedWithLateSyncsAndLostSamples) {
  for (const bool in_shared_frames : {false, true}) {
    const rehearsal::Setup setup = setup_of(2, in_shared_frames);
    const auto sample = can::find_layout<can::SensorSample>(setup.database, setup.twin.axes[0].wire);
    Loop loop(setup);
    for (int i = 0; i < 100 && !loop.tracks(); ++i) loop.run_for(milliseconds(20));
    ASSERT_TRUE(loop.tracks());
    const std::size_t not_applied_before = loop.found().not_applied;
    std::mt19937_64 random(1);
    const auto half = static_cast<std::uint64_t>(setup.twin.cycle.count() / 2);
    loop.disturb(
        [&] {
          return can::Duration(static_cast<can::Duration::rep>(random() % 2 == 0 ? half : random() % half));
        },
        [&, samples = 0](std::uint32_t id) mutable { return id == sample->id() && ++samples % 16 == 0; });
    loop.run_for(std::chrono::seconds(2));
    EXPECT_TRUE(loop.tracks()) << loop.causes();
    EXPECT_GT(loop.found().applied, 2000U);
    EXPECT_EQ(loop.found().not_applied, not_applied_before);
    EXPECT_GT(loop.found().oldest, 5 * setup.twin.cycle / 4);
  }
}

}  // namespace
}  // namespace hystcan::old_command_test
