#include "app/live/control_service.h"

#include <spdlog/spdlog.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>

#include "app/live/answer_json.h"
#include "app/live/samples.h"
#include "base/error.h"
#include "base/threads.h"
#include "controller/telemetry.h"

namespace hystcan::app {
namespace {

void ignore_answer(const nlohmann::json&) {}  // needs no answer, because the handler logs the result

void log_failure(const std::exception* error) noexcept {
  try {
    spdlog::error("a command of the control socket failed: {}",
                  error != nullptr ? error_text(*error) : "an unknown exception");
  } catch (...) {  // gives up logging: it needs memory, and memory may be exhausted
    return;
  }
}

}  // namespace

void run_despite_exceptions(boost::asio::io_context& context) {
  while (!context.stopped()) {
    try {
      context.run();
    } catch (const std::exception& error) {
      log_failure(&error);
    } catch (...) {
      log_failure(nullptr);
    }
  }
}

ControlService::ControlService(const std::filesystem::path& config_file, const config::Config& config,
                               config::ReadFiles files, const std::filesystem::path& socket,
                               CycleOutlets& outlets)
    : live_(config_file, config, std::move(files)),
      handler_(context_, requests_, outlets, live_),
      watch_(context_, {config_file}, [this] { handler_.reload({ignore_answer}); }) {
  if (!socket.empty()) {
    socket_.emplace(context_, socket, handler_);
    open_stream(stream_beside(socket), as_json(stream_greeting(config)).dump(), outlets.samples);
    spdlog::info("control socket {}; to show the status: hystcan ctl --socket {} status", socket.string(),
                 socket.string());
  }
  if (!watch_.is_watching())
    spdlog::warn("{} cannot be watched for changes; send SIGHUP to the controller after a change",
                 config_file.string());
  thread_ = std::thread([this] {
    yield_to_the_control_thread();
    const auto work = boost::asio::make_work_guard(context_);
    run_despite_exceptions(context_);
  });
}

/// Opens the socket of the sample stream. If that fails, logs a warning, and the controller runs without a
/// stream.
void ControlService::open_stream(const std::filesystem::path& file, const std::string& greeting,
                                 SampleBoard& samples) {
  try {
    stream_.emplace(context_, file, greeting, samples);
  } catch (const RunError& error) {
    spdlog::warn("{}; the operator's page cannot show the cycles", error.what());
  }
}

ControlService::~ControlService() {
  boost::asio::post(context_, [this] {
    handler_.close();
    stream_.reset();
    boost::asio::post(context_, [this] { context_.stop(); });
  });
  thread_.join();
}

void ControlService::reload() {
  boost::asio::post(context_, [this] { handler_.reload({ignore_answer}); });
}

}  // namespace hystcan::app
