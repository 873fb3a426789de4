// An amplifier and a sensor on a card: devices, nodes and guard.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>

#include "node/analogue/analogue_station.h"
#include "node/analogue/guard.h"
#include "tests/node/fake_card.h"
#include "tests/support/refusal.h"
#include "tests/twin/twin_bench.h"

namespace hystcan::node::analogue_test {
namespace {

constexpr DriveRange drives{.min = 0.0, .max = 90.0, .safe = 5.0};

struct OnACard : testing::Test {
  FakeCard card;
  AnalogueConfig config = connected_to_fake();
};

using CardInputTest = OnACard;

TEST_F(CardInputTest, ScalesVoltsToPositions) {
  config.position_zero_um = 1.0;
  CardInput input(config, card);
  card.inputs_V[0] = 2.0;
  EXPECT_DOUBLE_EQ(input.read({}).position_um, 7.0);
  EXPECT_EQ(input.read({}).status, 0);
}

TEST_F(CardInputTest, HasNoPositionAtAnEndOfItsRange) {
  CardInput input(config, card);
  for (const double rail_V : {-10.0, 10.0}) {
    card.inputs_V[0] = rail_V;
    EXPECT_EQ(input.read({}).status, sensor_status::out_of_range | sensor_status::no_position);
  }
}

TEST_F(CardInputTest, HasNoPositionWhenAConversionFails) {
  CardInput input(config, card);
  card.inputs_V[0] = 2.0;
  input.read({});
  card.fails = true;
  EXPECT_EQ(input.read({}).status, sensor_status::no_position);
  EXPECT_EQ(input.read({}).position_um, 0.0) << "an old position";
}

using CardOutputTest = OnACard;

TEST_F(CardOutputTest, WritesTheVoltsOfADrive) {
  CardOutput output(config, drives, card);
  output.go_to(80.0, {}, {});
  EXPECT_DOUBLE_EQ(card.outputs_V[0], 8.0);
}

TEST_F(CardOutputTest, ReportsItsMonitor) {
  CardOutput output(config, drives, card);
  card.inputs_V[1] = 4.0;
  EXPECT_DOUBLE_EQ(output.output({}), 40.0);
}

TEST_F(CardOutputTest, ReportsTheWrittenDriveWithoutAMonitor) {
  config.output_input.reset();
  CardOutput output(config, drives, card);
  output.go_to(80.0, {}, {});
  EXPECT_DOUBLE_EQ(output.output({}), 80.0);
}

TEST_F(CardOutputTest, RefusesADriveBeyondTheRangeOfTheCard) {
  config.volts_per_drive = 0.2;
  EXPECT_EQ(support::refusal_of([&] { CardOutput(config, drives, card); }),
            "a drive of 90 needs 18 V, but the range of the output is -10 to 10 V; choose a larger range of "
            "drive_output, or limit the drive in "
            "[axis.control]");
}

TEST_F(CardOutputTest, NamesTheKeyOfAnUnavailableChannel) {
  config.output_input->channel = 8;
  try {
    CardOutput(config, drives, card);
    FAIL();
  } catch (const ChannelError& error) {
    EXPECT_EQ(error.key, "output_input");
    EXPECT_STREQ(error.what(), "the card has 8 channels");
  }
}

TEST_F(CardOutputTest, SwitchesOffAfterTheSafeDrive) {
  CardOutput output(config, drives, card);
  output.switch_on();
  EXPECT_FALSE(card.lines[0]) << "active low";
  output.go_to(80.0, {}, {});
  card.order.clear();
  output.leave(WatchdogAction::hold, {});
  EXPECT_EQ(card.order, (std::vector<std::string>{"output", "line"}));
  EXPECT_DOUBLE_EQ(card.outputs_V[0], 0.5);
  EXPECT_TRUE(card.lines[0]);
}

TEST_F(CardOutputTest, IsDisabledAfterAFailureUntilTheSafeDriveIsWritten) {
  CardOutput output(config, drives, card);
  EXPECT_TRUE(output.works());
  card.fails = true;
  output.go_to(80.0, {}, {});
  EXPECT_FALSE(output.works());
  card.fails = false;
  EXPECT_FALSE(output.works());
  EXPECT_DOUBLE_EQ(card.outputs_V[0], 0.5);
  EXPECT_TRUE(output.works());
}

TEST_F(CardOutputTest, IsDisabledWhileTheInterlockIsActive) {
  CardOutput output(config, drives, card);
  card.lines[1] = true;
  EXPECT_FALSE(output.works());
  card.lines[1] = false;
  EXPECT_TRUE(output.works());
}

TEST_F(CardOutputTest, TogglesTheChargePumpAtEachSync) {
  CardOutput output(config, drives, card);
  for (int i = 0; i < 4; ++i) {
    output.works();
    EXPECT_EQ(card.lines[2], i % 2 == 0);
  }
}

TEST_F(CardOutputTest, IsDisabledOnceAfterATakeoverByTheGuard) {
  std::atomic<unsigned> takeovers{0};
  CardOutput output(config, drives, card);
  output.obey(takeovers);
  output.switch_on();
  EXPECT_TRUE(output.works());
  ++takeovers;
  EXPECT_FALSE(output.works());
  EXPECT_TRUE(output.works());
}

TEST_F(CardOutputTest, WorksAfterATakeoverAtRest) {
  std::atomic<unsigned> takeovers{0};
  CardOutput output(config, drives, card);
  output.obey(takeovers);
  ++takeovers;
  EXPECT_TRUE(output.works());
}

TEST_F(CardOutputTest, WritesTheSafeDriveAfterADriveDuringATakeover) {
  std::atomic<unsigned> takeovers{0};
  CardOutput output(config, drives, card);
  output.obey(takeovers);
  EXPECT_TRUE(output.works());
  ++takeovers;
  output.go_to(80.0, {}, {});
  EXPECT_DOUBLE_EQ(card.outputs_V[0], 0.5);
  EXPECT_FALSE(output.works());
}

/// One axis on the fake card, and a tester that stores the frames of its nodes.
struct StationBench : twin::NodeTester {
  explicit StationBench(can::Duration delay = {}) : enable_delay(delay) {
    tester_->on_frame([this](const can::Frame& frame, can::Time) {
      if (const auto emergency = can::parse_emergency(frame); emergency && frame.id < 0x100)
        emergencies[frame.id - 0x80].push_back(emergency->code);
      received.push_back(frame.id);
      if (frame.id == 0x181)
        if (const auto decoded = decode_status(frame)) status = *decoded;
      if (frame.id == 0x182)
        if (const auto decoded = decode_sample(frame)) sample = *decoded;
    });
    station.station().start([] {});
    run(common.heartbeat_period);
    start_nodes();
  }
  void drive(double setpoint, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      sync();
      tester_->send(*encode({.setpoint = setpoint, .enable = true, .sync_counter = counter_}));
      run(std::chrono::milliseconds(1));
    }
  }

  can::Duration enable_delay;
  FakeCard* card = nullptr;
  can::Database database = can::load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  CommonConfig common{.heartbeat_period = std::chrono::milliseconds(100)};
  Cards cards{[this](const std::string&) {
    auto made = std::make_unique<FakeCard>();
    card = made.get();
    return made;
  }};
  AllDevices devices = [this] {
    AllDevices all;
    AnalogueConfig config = connected_to_fake();
    config.amplifier.enable_delay = enable_delay;
    all.push_back(std::make_unique<AnalogueDevices>(
        WiredAnalogueAxis{
            {.name = "x", .message_prefix = "X", .amplifier_node = 1, .sensor_node = 2}, config, drives},
        cards));
    return all;
  }();
  AnalogueStation station{devices, common, database, clock_, [this](auto) { return bus_.attach(); }};
  can::Encoder<can::AmpCommand> encode{twin::without_limits(*database.find("XAmpCommand"))};
  can::Decoder<can::AmpStatus> decode_status{*database.find("XAmpStatus")};
  can::Decoder<can::SensorSample> decode_sample{*database.find("XSensorSample")};
  std::map<std::uint32_t, std::vector<int>> emergencies;  ///< per node
  std::vector<std::uint32_t> received;
  std::optional<can::SensorSample> sample;
  std::optional<can::AmpStatus> status;
};

TEST(AnalogueStation, DrivesTheCardAtTheSyncAfterTheCommand) {
  StationBench bench;
  bench.drive(40.0, 3);
  EXPECT_DOUBLE_EQ(bench.card->outputs_V[0], 4.0);
  EXPECT_EQ(bench.sample->status, 0);
}

TEST(AnalogueStation, SetsTheOutputBeforeItReadsTheInputAtASync) {
  StationBench bench;
  bench.drive(40.0, 3);
  bench.card->order.clear();
  bench.cycle();
  EXPECT_EQ(bench.card->order, (std::vector<std::string>{"line", "output", "input"})) << "charge pump first";
}

TEST(AnalogueStation, SendsTheSampleOfASyncBeforeTheStatus) {
  StationBench bench;
  for (int cycle = 0; cycle < 30; ++cycle) {
    bench.received.clear();
    bench.drive(40.0, 1);
    EXPECT_EQ(bench.received.front(), 0x182u) << cycle;
  }
}

TEST(AnalogueStation, SwitchesTheLineOffWhenCommandsStopWhileItIsEnabling) {
  StationBench bench(std::chrono::milliseconds(50));
  bench.drive(40.0, 3);
  EXPECT_FALSE(bench.card->lines[0]) << "active low";
  bench.run(std::chrono::milliseconds(100));
  EXPECT_TRUE(bench.card->lines[0]);
}

TEST(AnalogueStation, ReportsAFailedConversionOnceAndItsEnd) {
  StationBench bench;
  bench.drive(40.0, 3);
  bench.card->fails = true;
  bench.drive(40.0, 3);
  EXPECT_EQ(bench.sample->status, sensor_status::no_position);
  EXPECT_EQ(bench.emergencies[2], (std::vector<int>{0x5000}));
  EXPECT_EQ(bench.emergencies[1], (std::vector<int>{0x5000}));
  EXPECT_EQ(bench.status->state, can::AmpState::fault);
  bench.card->fails = false;
  bench.drive(40.0, 3);
  EXPECT_EQ(bench.emergencies[2], (std::vector<int>{0x5000, 0}));
  EXPECT_EQ(bench.status->state, can::AmpState::fault) << "until a command clears it";
  EXPECT_DOUBLE_EQ(bench.card->outputs_V[0], 0.5);
}

TEST(AnalogueStation, ReportsARailOfTheSensor) {
  StationBench bench;
  bench.card->inputs_V[0] = 10.0;
  bench.drive(40.0, 3);
  EXPECT_NE(bench.sample->status, 0);
  EXPECT_EQ(bench.emergencies[2], (std::vector<int>{0x5000}));
}

/// A number shared by processes.
class SharedCount {
 public:
  bool add() const { return ++*place_ != 0; }
  int value() const { return *place_; }
  bool reaches(int value) const {
    for (int i = 0; i < 10'000 && *place_ != value; ++i) usleep(1000);
    return *place_ == value;
  }

 private:
  std::atomic<int>* place_ = static_cast<std::atomic<int>*>(
      mmap(nullptr, sizeof(std::atomic<int>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
};

constexpr std::chrono::hours patient{1};

TEST(Guard, MakesTheOutputsSafeAtStartAndEnd) {
  const SharedCount safe;
  Guard guard([&] { return safe.add(); }, patient);
  EXPECT_EQ(safe.value(), 1);
  EXPECT_TRUE(guard.abandon());
  EXPECT_EQ(safe.value(), 2);
}

TEST(Guard, ReportsThatTheCardRefuses) {
  EXPECT_FALSE(Guard([] { return false; }, patient).abandon());
}

/// An emulator of another processor does not release the lock of a dead thread.
bool kernel_releases_locks_of_dead_threads() {
  void* list = nullptr;
  std::size_t length = 0;
  return syscall(SYS_get_robust_list, 0, &list, &length) == 0;
}

TEST(Guard, MakesTheOutputsSafeAfterItsNodeWasKilled) {
  if (!kernel_releases_locks_of_dead_threads()) GTEST_SKIP() << "needs a kernel with robust locks";
  const SharedCount ready, safe;
  const pid_t node = fork();
  if (node == 0) {
    Guard guard([&] { return safe.add(); }, patient);
    ready.add();
    while (true) pause();
  }
  ASSERT_TRUE(ready.reaches(1));
  kill(node, SIGKILL);
  waitpid(node, nullptr, 0);
  EXPECT_TRUE(safe.reaches(2));
}

TEST(Guard, ReportsItsDeath) {
  Guard guard([] { return true; }, patient);
  kill(guard.process(), SIGKILL);
  pollfd end{.fd = guard.descriptor(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(poll(&end, 1, 10'000), 1);
  EXPECT_FALSE(guard.abandon());
}

TEST(Guard, TakesOverFromANodeThatDoesNotRun) {
  const SharedCount safe;
  Guard guard([&] { return safe.add(); }, std::chrono::milliseconds(5));
  usleep(20'000);
  EXPECT_EQ(guard.takeovers(), 0u) << "the node has not begun to beat";
  guard.beat();
  for (int i = 0; i < 10'000 && safe.value() < 2; ++i) usleep(1000);
  EXPECT_GE(safe.value(), 2);
  EXPECT_GE(guard.takeovers(), 1u);
}

TEST(Guard, IsKilledIfItDoesNotRun) {
  Guard guard([] { return true; }, std::chrono::milliseconds(5));
  kill(guard.process(), SIGSTOP);
  pollfd end{.fd = guard.descriptor(), .events = POLLIN, .revents = 0};
  for (int i = 0; i < 1000 && poll(&end, 1, 10) == 0; ++i) guard.beat();
  EXPECT_NE(end.revents, 0);
  EXPECT_FALSE(guard.abandon());
}

TEST(OpenCard, RefusesAnUnknownKind) {
  EXPECT_EQ(
      support::refusal_of([] { open_card("nidaq:0"); }),
      "device is \"nidaq:0\", expected comedi:/dev/comedi0, iio:ad5791, simulated or simulated:BITS with "
      "2 to 24 bits");
  EXPECT_EQ(support::refusal_of([] { open_card("simulated"); }),
            "simulated: not a real card; set device to a card (example: comedi:/dev/comedi0 or iio:ad5791)");
}

TEST(OpenCard, RefusesAMissingConverter) {
  const std::string refusal = support::refusal_of([] { open_card("iio:no-such-chip"); });
  EXPECT_TRUE(refusal.starts_with("iio:no-such-chip: ")) << refusal;
}

TEST(OpenCard, RefusesAFileThatIsNotACard) {
  const std::string refusal = support::refusal_of([] { open_card("comedi:/dev/null"); });
  if (refusal.find("built without libcomedi") != std::string::npos) GTEST_SKIP() << refusal;
  EXPECT_EQ(refusal, "/dev/null: not a comedi device; set device to a comedi device file (ls /dev/comedi*)");
}

TEST(OpenCard, RefusesAMissingCard) {
  const std::string refusal = support::refusal_of([] { open_card("comedi:/dev/comedi99"); });
  if (refusal.find("built without libcomedi") != std::string::npos) GTEST_SKIP() << refusal;
  EXPECT_EQ(refusal,
            "/dev/comedi99: card not found; load the driver of the card, or set device to another file "
            "(ls /dev/comedi*)");
}

}  // namespace
}  // namespace hystcan::node::analogue_test
