#include "app/command_line/demo_page.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "app/live/answer_json.h"
#include "app/live/control_service.h"
#include "app/live/cycle_outlets.h"
#include "app/live/rehearsal_setup.h"
#include "app/live/samples.h"
#include "app/live/state_log.h"
#include "app/live/twin_command_handler.h"
#include "app/page/page_host.h"
#include "app/stage/shipped.h"
#include "base/error.h"
#include "base/standard_streams.h"
#include "config/schema/settings.h"
#include "runs/run_folder.h"

namespace hystcan::app {
namespace {

constexpr auto pace = std::chrono::milliseconds(5);
/// Maximum time that the rehearsal simulates in one step. Between two steps the thread sleeps for the time
/// `pace`. If the machine is busy for longer than this maximum, the rehearsal becomes slower than real time.
constexpr auto longest_catch_up = std::chrono::milliseconds(100);

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "hystcan-demo-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw RunError(name, "cannot be created");
    folder_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::filesystem::path& name) const { return folder_ / name; }

 private:
  std::filesystem::path folder_;
};

std::filesystem::path copy_of(const std::filesystem::path& shipped, const TemporaryFolder& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(shipped.parent_path()))
    if (entry.is_regular_file() &&
        (entry.path().extension() == ".toml" || entry.path().extension() == ".dbc"))
      std::filesystem::copy_file(entry.path(), folder / entry.path().filename());
  return folder / shipped.filename();
}

/// Runs controller and twin in virtual time on a separate thread, slowed down to real time, and serves the
/// control sockets of both.
class PacedRehearsal {
 public:
  /// `files`: cache of the files that were read when `config` was loaded, so that unchanged files are not
  /// read again. `folder`: folder in which the sockets of controller and twin are created.
  PacedRehearsal(const std::filesystem::path& file, const config::Config& config, config::ReadFiles files,
                 const TemporaryFolder& folder)
      : outlets_(config, runs::describe(config, config::settings(config.file), "demo"), bus_log_sink()),
        truths_(truth_columns.size(), 20'000),
        rehearsal_(rehearsal_setup(config),
                   [this](const controller::CycleRecord& record) { outlets_.put(record); }),
        service_(std::in_place, file, config, std::move(files), folder / "control.sock", outlets_),
        twin_handler_(rehearsal_.twin(), rehearsal_.clock(), [this] { ending_ = true; }),
        twin_socket_(std::in_place, context_, folder / "twin.sock", twin_handler_),
        twin_stream_(std::in_place, context_, stream_beside(folder / "twin.sock"),
                     as_json(stream_greeting(config, twin_config(config))).dump(), truths_) {
    rehearsal_.controller().listen_to(service_->requests());
    rehearsal_.twin().on_truth([this](const twin::Truth& truth) {
      if (truths_.is_listening()) truths_.put(sample_of(truth, can::Time()));
    });
    thread_ = std::thread([this] { run(); });
  }
  ~PacedRehearsal() {
    ending_ = true;
    thread_.join();
  }
  PacedRehearsal(const PacedRehearsal&) = delete;
  PacedRehearsal& operator=(const PacedRehearsal&) = delete;

  /// Returns true after the rehearsal ended. The sockets may still be open; the destructor waits until they
  /// are closed.
  bool has_ended() const { return has_ended_; }

 private:
  void run() {
    rehearsal_.start();
    auto last = std::chrono::steady_clock::now();
    bool is_stopping = false;
    while (!ending_ && !(is_stopping && rehearsal_.controller().stopped())) {
      std::this_thread::sleep_for(pace);
      const auto now = std::chrono::steady_clock::now();
      rehearsal_.run_for(std::min<can::Duration>(now - last, longest_catch_up));
      last = now;
      if (!is_stopping && rehearsal_.controller().asked_to_stop()) {
        is_stopping = true;
        rehearsal_.controller().request_stop();
      }
      context_.restart();
      context_.poll();
    }
    has_ended_ = true;
    twin_stream_.reset();
    twin_socket_.reset();
    context_.restart();
    context_.poll();
    service_.reset();
    if (!ending_) spdlog::info("the rehearsal has ended; the page can start it again, Ctrl-C ends the page");
  }

  CycleOutlets outlets_;
  SampleBoard truths_;
  rehearsal::Rehearsal rehearsal_;
  std::optional<ControlService> service_;
  boost::asio::io_context context_{1};
  TwinCommandHandler twin_handler_;
  std::optional<ControlSocket> twin_socket_;
  std::optional<SampleStream> twin_stream_;
  std::atomic<bool> ending_{false}, has_ended_{false};
  std::thread thread_;
};

}  // namespace

int run_demo_page(const std::filesystem::path& given, const std::string& listen) {
  const TemporaryFolder folder;
  const std::filesystem::path file =
      given.empty() ? copy_of(shipped_file("piezo.toml"), folder) : std::filesystem::absolute(given);
  // Runs one rehearsal at a time, always with the same socket paths. Each start reads the configuration
  // again.
  std::optional<PacedRehearsal> running;
  const auto start = [&] {
    if (running && !running->has_ended()) throw RunError("the rehearsal runs", {.remedy = "stop it first"});
    config::ReadFiles files;
    config::Config config = config::load(file, {}, files);
    for (config::AxisConfig& axis : config.axes) axis.control.repeat = true;
    running.reset();
    running.emplace(file, config, std::move(files), folder);
  };
  const std::string token = new_token();
  PageHost host({.config = file,
                 .source = "demo",
                 .start_command = "hystcan demo --page",
                 .controller_socket = [&] { return folder / "control.sock"; },
                 .twin_socket = [&] { return folder / "twin.sock"; },
                 .start_again = start},
                PageListening::at(listen), token);
  start();
  print(fmt::format("page: {}\ntoken: {}\ncontrol socket: {}\ntwin socket: {}\n", host.url(), token,
                    (folder / "control.sock").string(), (folder / "twin.sock").string()));
  flush_output();
  host.run();
  return done;
}

}  // namespace hystcan::app
