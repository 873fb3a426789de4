#include "runs/recorder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace hystcan::runs {

Recorder::Recorder(const config::Config& config, RunInfo info, RunWriter::Sink sink,
                   RunWriter::OnPart on_part, UtcNow utc_now)
    : config_(config),
      info_(std::move(info)),
      sink_(std::move(sink)),
      on_part_(std::move(on_part)),
      utc_now_(std::move(utc_now)) {}

std::shared_ptr<RunWriter> Recorder::writer() const {
  const std::scoped_lock lock(mutex_);
  return writer_;
}

std::filesystem::path Recorder::start() {
  if (const auto present = writer(); present && !present->is_closed())
    throw std::runtime_error("a run is recorded already: " + present->run().string());
  auto next = std::make_shared<RunWriter>(config_, info_, sink_, on_part_, utc_now_);
  std::thread([next] { next->write_until_the_end(); }).detach();
  const std::scoped_lock lock(mutex_);
  writer_ = next;
  return next->run();
}

std::filesystem::path Recorder::stop() {
  const auto present = writer();
  if (!present || present->is_closed()) return {};
  present->end();
  return present->run();
}

void Recorder::finish() {
  stop();
  if (const auto last = writer()) last->await();
}

void Recorder::add(const controller::CycleRecord& record) {
  const std::scoped_lock lock(mutex_);
  if (writer_) writer_->add(record);
}

void Recorder::add(const std::vector<config::Change>& changes) {
  const std::scoped_lock lock(mutex_);
  if (!writer_) return;
  for (const config::Change& change : changes) writer_->add(change);
}

RunWriter::Status Recorder::status() const {
  const auto present = writer();
  return present ? present->status() : RunWriter::Status{};
}

namespace {

/// A group of its own: Ctrl-C in the terminal is for the controller.
pid_t spawn(std::array<std::string, 5> words) {
  std::array<char*, 6> arguments{};
  for (std::size_t i = 0; i < words.size(); ++i) arguments.at(i) = words.at(i).data();
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_RDWR, 0);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  pid_t child = -1;
  const int error = posix_spawn(&child, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error == 0 ? child : -1;
}

}  // namespace

void PartConverter::convert(const std::filesystem::path& part) {
  std::erase_if(children_, [this](const auto& child) { return has_ended(child.first, child.second); });
  const pid_t pid = spawn({program_.string(), "export", part.string(), "--output", hdf5_of(part).string()});
  if (pid < 0) return warn(part);
  children_.emplace_back(pid, part);
}

bool PartConverter::has_ended(pid_t child, const std::filesystem::path& part) {
  int status = 0;
  if (::waitpid(child, &status, WNOHANG) == 0) return false;
  if (status != 0) warn(part);
  return true;
}

void PartConverter::warn(const std::filesystem::path& part) {
  sink_(can::BusHealthLog::Level::warning, fmt::format("{}: was not made; hystcan export {} --hdf5 makes it",
                                                       hdf5_of(part).string(), part.string()));
}

}  // namespace hystcan::runs
