#include "app/live/control_service.h"

#include <spdlog/spdlog.h>
#include <sys/inotify.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <cstring>
#include <utility>

#include "app/live/samples.h"
#include "base/error.h"
#include "base/threads.h"
#include "controller/telemetry.h"

namespace hystcan::app {
namespace {

void ignore_answer(const nlohmann::json&) {}  // the handler logs it

void log_failure(const std::exception* error) noexcept {
  try {
    spdlog::error("the control socket goes on after a failed command: {}",
                  error != nullptr ? error_text(*error) : "an unknown exception");
  } catch (...) {  // the log needs memory too
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
                               const std::filesystem::path& socket, CycleOutlets& outlets)
    : live_(config_file, config),
      handler_(context_, requests_, outlets, live_),
      watch_(context_, {config_file}, [this] { handler_.reload({ignore_answer}); }) {
  if (!socket.empty()) {
    socket_.emplace(context_, socket, handler_);
    open_stream(stream_beside(socket), stream_greeting(config).dump(), outlets.samples);
    spdlog::info("control socket {}: hystcan ctl --socket {} status", socket.string(), socket.string());
  }
  if (!watch_.is_watching())
    spdlog::warn("{} cannot be watched: send SIGHUP after a change", config_file.string());
  thread_ = std::thread([this] {
    yield_to_the_control_thread();
    const auto work = boost::asio::make_work_guard(context_);
    run_despite_exceptions(context_);
  });
}

/// A controller runs without a stream rather than not at all.
void ControlService::open_stream(const std::filesystem::path& file, const std::string& greeting,
                                 SampleBoard& samples) {
  try {
    stream_.emplace(context_, file, greeting, samples);
  } catch (const RunError& error) {
    spdlog::warn("{}; no stream of cycles, the page shows none", error.what());
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

FileWatch::FileWatch(boost::asio::io_context& context, const std::vector<std::filesystem::path>& files,
                     std::function<void()> on_change)
    : files_(files), on_change_(std::move(on_change)), events_(context), settle_(context) {
  const int descriptor = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (descriptor < 0) return;
  events_.assign(descriptor);
  watch_folders();
  read();
}

void FileWatch::watch_folders() {
  watching_ = true;
  for (const std::filesystem::path& file : files_) watch(std::filesystem::absolute(file));
}

void FileWatch::watch(std::filesystem::path place) {
  constexpr int most_links = 40;  // as the kernel follows
  for (int links = 0; links <= most_links; ++links) {
    names_.insert(place.filename().string());
    const std::filesystem::path folder = place.parent_path();
    watching_ = watching_ &&
                inotify_add_watch(events_.native_handle(), folder.c_str(), IN_CLOSE_WRITE | IN_MOVED_TO) >= 0;
    std::error_code is_no_link;
    const std::filesystem::path target = std::filesystem::read_symlink(place, is_no_link);
    if (is_no_link) return;
    place = folder / target;
  }
}

void FileWatch::read() {
  events_.async_read_some(boost::asio::buffer(buffer_),
                          [this](const boost::system::error_code& error, std::size_t bytes) {
                            if (error) return;
                            if (has_watched_name(bytes)) {
                              settle_.expires_after(std::chrono::milliseconds(100));
                              settle_.async_wait([this](const boost::system::error_code& cancelled) {
                                if (cancelled) return;
                                watch_folders();  // a link may lead to another folder now
                                on_change_();
                              });
                            }
                            read();
                          });
}

/// The kernel delivers whole events; `len` of each includes the padding of its name.
bool FileWatch::has_watched_name(std::size_t bytes) const {
  for (std::size_t at = 0; at + sizeof(inotify_event) <= bytes;) {
    inotify_event event{};
    std::memcpy(&event, buffer_.data() + at, sizeof(event));
    const char* name = buffer_.data() + at + sizeof(event);
    if (event.len != 0 && names_.contains(name)) return true;
    at += sizeof(event) + event.len;
  }
  return false;
}

}  // namespace hystcan::app
