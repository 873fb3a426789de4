#include "tests/app/live/control_bench.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "app/live/rehearsal_setup.h"
#include "config/schema/settings.h"
#include "runs/run_folder.h"

namespace hystcan::app {
namespace {

using controller::AxisState;
using std::chrono::milliseconds;

config::Config prepared(const support::ShippedCopy& files,
                        const std::function<void(const support::ShippedCopy&)>& prepare) {
  if (prepare) prepare(files);
  return config::load(files / "piezo.toml");
}

}  // namespace

int connected_to(const std::filesystem::path& file) {
  const int connection = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  file.string().copy(address.sun_path, sizeof address.sun_path - 1);
  support::limit_receive(connection);
  EXPECT_EQ(::connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return connection;
}

Client::Client(const std::filesystem::path& socket) : socket_(connected_to(socket)) {}

void Client::send(std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return;  // the other side has disconnected; the answer shows this
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

nlohmann::json Client::read() {
  std::array<char, 4096> chunk{};
  std::size_t end = 0;
  while ((end = unread_.find('\n')) == std::string::npos) {
    const ssize_t received = ::recv(socket_, chunk.data(), chunk.size(), 0);
    if (received <= 0) return {};
    unread_.append(chunk.data(), static_cast<std::size_t>(received));
  }
  const std::string line = unread_.substr(0, end);
  unread_.erase(0, end + 1);
  return nlohmann::json::parse(line, nullptr, false);
}

void Client::end_sending() { ::shutdown(socket_, SHUT_WR); }

void Client::hang_up() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

ControlBench::ControlBench(const std::function<void(const support::ShippedCopy&)>& prepare)
    : config_(prepared(files_, prepare)),
      outlets_(config_, runs::describe(config_, config::settings(config_.file), "test"),
               [](can::BusHealthLog::Level, const std::string&) {}),
      steps_(config_.axes.size()),
      rehearsal_(rehearsal_setup(config_),
                 [this](const controller::CycleRecord& record) {
                   outlets_.put(record);
                   const controller::AxisReport& report = record.report;
                   const std::scoped_lock lock(mutex_);
                   steps_[record.axis].push_back(
                       {record.cycle, report.state, report.reference_um, report.position_um, report.drive});
                 }),
      service_(std::make_unique<ControlService>(files_ / "piezo.toml", config_, config::ReadFiles{}, socket(),
                                                outlets_)) {
  rehearsal_.controller().listen_to(service_->requests());
  thread_ = std::thread([this] { run(); });
}

ControlBench::~ControlBench() { halt(); }

void ControlBench::halt() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
}

void ControlBench::end_service() {
  halt();
  service_.reset();
}

void ControlBench::run() {
  rehearsal_.start();
  while (!ending_) {
    rehearsal_.run_for(milliseconds(10));
    asked_to_stop_ = rehearsal_.controller().asked_to_stop();
    std::this_thread::sleep_for(milliseconds(1));  // other threads need the processor
  }
}

bool ControlBench::axis_is(std::size_t axis, AxisState state) const {
  return support::eventually([&] { return outlets_.board.newest()[axis].report.state == state; });
}

std::vector<Step> ControlBench::steps(std::size_t axis) const {
  const std::scoped_lock lock(mutex_);
  return steps_[axis];
}

std::size_t ControlBench::step_count(std::size_t axis) const {
  const std::scoped_lock lock(mutex_);
  return steps_[axis].size();
}

void never_rest(const support::ShippedCopy& files) {
  files.edit("piezo.toml", "cycles       = 10.0", "cycles       = 1e6");
}

double largest_drive_step(const std::vector<Step>& steps, std::size_t first) {
  double largest = 0.0;
  for (std::size_t i = std::max<std::size_t>(first, 1); i < steps.size(); ++i)
    if (steps[i].state == AxisState::tracking && steps[i - 1].state == AxisState::tracking)
      largest = std::max(largest, std::abs(steps[i].drive - steps[i - 1].drive));
  return largest;
}

bool says(const nlohmann::json& answer, std::string_view text) {
  return answer.is_object() && answer.value("error", std::string()).find(text) != std::string::npos;
}

bool is_ok(const nlohmann::json& answer) { return answer.is_object() && answer.value("ok", false); }

}  // namespace hystcan::app
