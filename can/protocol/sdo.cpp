#include "can/protocol/sdo.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "can/protocol/protocol.h"

namespace hystcan::can {
namespace {

constexpr std::uint8_t expedited_with_size = 0x03;  ///< bits e and s; bits 2 and 3 count the unused bytes

std::uint8_t with_size(unsigned specifier, std::uint8_t bytes) {
  return static_cast<std::uint8_t>(specifier | expedited_with_size | (4U - bytes) << 2U);
}

std::uint8_t command_of(const SdoMessage& message) {
  switch (message.service) {
    case SdoService::write:
      return with_size(0x20, message.content.bytes);
    case SdoService::written:
      return 0x60;
    case SdoService::read:
      return 0x40;
    case SdoService::value:
      return with_size(0x40, message.content.bytes);
    case SdoService::abort:
      break;
  }
  return 0x80;
}

Frame make_frame(std::uint32_t id, const SdoMessage& message) {
  Frame frame{.id = id, .length = 8};
  frame.data[0] = command_of(message);
  frame.data[1] = static_cast<std::uint8_t>(message.object.index);
  frame.data[2] = static_cast<std::uint8_t>(message.object.index >> 8U);
  frame.data[3] = message.object.subindex;
  const bool carries = message.service == SdoService::write || message.service == SdoService::value ||
                       message.service == SdoService::abort;
  const unsigned bytes = message.service == SdoService::abort ? 4 : message.content.bytes;
  for (unsigned i = 0; carries && i < bytes; ++i)
    frame.data[4 + i] = static_cast<std::uint8_t>(message.content.value >> 8 * i);
  return frame;
}

/// Parses what both directions share. `sized` is the service that carries a value, in bits 7 to 5 of
/// `specifier`.
std::optional<SdoMessage> parse(const Frame& frame, unsigned specifier, SdoService sized) {
  if (frame.kind != FrameKind::data || frame.extended || frame.length != 8) return std::nullopt;
  const unsigned command = frame.data[0];
  SdoMessage message{.object = {.index = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8),
                                .subindex = frame.data[3]}};
  if ((command & 0xF3U) == (specifier | expedited_with_size)) {
    message.service = sized;
    message.content.bytes = static_cast<std::uint8_t>(4U - (command >> 2U & 3U));
  } else if (command != 0x80) {
    return std::nullopt;
  }
  for (unsigned i = 0; i < message.content.bytes; ++i)
    message.content.value |= std::uint32_t{frame.data[4 + i]} << 8 * i;
  return message;
}

std::optional<SdoMessage> parse_without_value(const Frame& frame, unsigned command, SdoService service) {
  if (frame.kind != FrameKind::data || frame.extended || frame.length != 8) return std::nullopt;
  if (frame.data[0] != command) return std::nullopt;
  return SdoMessage{.service = service,
                    .object = {.index = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8),
                               .subindex = frame.data[3]}};
}

}  // namespace

Frame sdo_request(std::uint8_t node, const SdoMessage& message) {
  return make_frame(sdo_request_base + node, message);
}
Frame sdo_response(std::uint8_t node, const SdoMessage& message) {
  return make_frame(sdo_response_base + node, message);
}

std::optional<SdoMessage> parse_sdo_request(const Frame& frame) {
  if (const auto read = parse_without_value(frame, 0x40, SdoService::read)) return read;
  return parse(frame, 0x20, SdoService::write);
}
std::optional<SdoMessage> parse_sdo_response(const Frame& frame) {
  if (const auto written = parse_without_value(frame, 0x60, SdoService::written)) return written;
  return parse(frame, 0x40, SdoService::value);
}

SdoSetup::SdoSetup(std::uint8_t node, Config config) : node_(node), config_(std::move(config)) {}

void SdoSetup::restart() {
  next_ = 0;
  step_ = Step::write;
  attempt_ = 1;
  failed_ = false;
  failure_ = {};
}

Frame SdoSetup::ask(SdoService service, Time now) {
  const SdoWrite& write = config_.writes[next_];
  deadline_ = now + config_.patience.timeout;
  step_ = service == SdoService::write ? Step::await_written : Step::await_value;
  return sdo_request(node_, {.service = service, .object = write.object, .content = write.content});
}

std::optional<Frame> SdoSetup::poll(Time now) {
  if (is_done() || failed_) return std::nullopt;
  if (step_ == Step::write) return ask(SdoService::write, now);
  if (step_ == Step::read) return ask(SdoService::read, now);
  if (now < deadline_) return std::nullopt;
  const SdoObject object = config_.writes[next_].object;
  fail(SdoFailure::Reason::timed_out, 0, 0);
  return sdo_request(node_, {.service = SdoService::abort,
                             .object = object,
                             .content = {.value = sdo_abort::timed_out, .bytes = 4}});
}

void SdoSetup::handle(const Frame& frame) {
  if (is_done() || failed_) return;
  const auto message = parse_sdo_response(frame);
  if (!message || message->object != config_.writes[next_].object) return;
  const bool waiting = step_ == Step::await_written || step_ == Step::await_value;
  if (waiting && message->service == SdoService::abort)
    fail(SdoFailure::Reason::aborted, message->content.value, 0);
  else if (step_ == Step::await_written && message->service == SdoService::written)
    step_ = Step::read;
  else if (step_ == Step::await_value && message->service == SdoService::value)
    take_value(message->content);
}

void SdoSetup::take_value(const SdoValue& value) {
  if (value != config_.writes[next_].content)
    return fail(SdoFailure::Reason::read_back_differs, 0, value.value);
  ++next_;
  step_ = Step::write;
  attempt_ = 1;
}

void SdoSetup::fail(SdoFailure::Reason reason, std::uint32_t abort_code, std::uint32_t read_back) {
  const SdoWrite& write = config_.writes[next_];
  failure_ = {.reason = reason,
              .object = write.object,
              .abort_code = abort_code,
              .written = write.content.value,
              .read_back = read_back};
  step_ = Step::write;
  failed_ = ++attempt_ > config_.patience.attempts;
}

SdoServer::SdoServer(std::uint8_t node) : node_(node) { objects_.reserve(64); }

std::optional<Frame> SdoServer::answer(const Frame& frame) {
  if (frame.id != sdo_request_base + node_) return std::nullopt;
  const auto request = parse_sdo_request(frame);
  if (!request || request->service == SdoService::abort) return std::nullopt;
  return sdo_response(node_, reply_to(*request));
}

std::optional<SdoValue> SdoServer::object(SdoObject object) const {
  const auto found = std::ranges::find(objects_, object, &SdoWrite::object);
  if (found == objects_.end()) return std::nullopt;
  return found->content;
}

SdoMessage SdoServer::reply_to(const SdoMessage& request) {
  if (request.service == SdoService::write) return write(request);
  if (const auto stored = object(request.object))
    return {.service = SdoService::value, .object = request.object, .content = *stored};
  return {.service = SdoService::abort,
          .object = request.object,
          .content = {.value = sdo_abort::no_such_object}};
}

SdoMessage SdoServer::write(const SdoMessage& request) {
  const auto abort = [&](std::uint32_t code) {
    return SdoMessage{.service = SdoService::abort, .object = request.object, .content = {.value = code}};
  };
  const auto found = std::ranges::find(objects_, request.object, &SdoWrite::object);
  if (found != objects_.end() && found->content.bytes != request.content.bytes)
    return abort(sdo_abort::wrong_length);
  if (request.object.index < 0x2000 || request.object.index > 0x5FFF) return abort(sdo_abort::no_such_object);
  if (found == objects_.end() && objects_.size() == objects_.capacity())
    return abort(sdo_abort::out_of_memory);
  if (found == objects_.end())
    objects_.push_back({.object = request.object, .content = request.content});
  else
    found->content = request.content;
  return {.service = SdoService::written, .object = request.object};
}

}  // namespace hystcan::can
