#include "runs/recorder.h"

#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace hystcan::runs {

Recorder::Recorder(const config::Config& config, RunInfo info, RunWriter::Sink sink, UtcNow utc_now)
    : config_(config), info_(std::move(info)), sink_(std::move(sink)), utc_now_(std::move(utc_now)) {}

std::shared_ptr<RunWriter> Recorder::writer() const {
  const std::scoped_lock lock(mutex_);
  return writer_;
}

std::filesystem::path Recorder::start() {
  if (const auto present = writer(); present && !present->is_closed())
    throw std::runtime_error("a run is already being recorded: " + present->run().string());
  auto next = std::make_shared<RunWriter>(config_, info_, sink_, utc_now_);
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

}  // namespace hystcan::runs
