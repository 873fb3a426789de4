#include "can/protocol/sdo.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "can/protocol/protocol.h"

namespace hystcan::can {
namespace {

/// Bits 1 and 0 of a frame's first byte. Bit 1: the transfer is expedited. Bit 0: the size is stated, so that
/// bits 2 and 3 contain the number of unused bytes.
constexpr std::uint8_t expedited_with_size = 0x03;

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
    case SdoService::segmented:
      return 0x41;
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

constexpr std::uint32_t mask_of(unsigned bytes) { return 0xFFFF'FFFFU >> 8U * (4U - bytes); }

SdoMessage message_of(const Frame& frame, SdoService service) {
  return {.service = service,
          .object = {.index = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8),
                     .subindex = frame.data[3]},
          .content = {.value = 0, .bytes = 4}};
}

/// Reads a value of `bytes` bytes, low byte first, which begins at byte 4 of the frame.
std::uint32_t value_of(const Frame& frame, unsigned bytes) {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < bytes; ++i) value |= std::uint32_t{frame.data[4 + i]} << 8 * i;
  return value;
}

bool is_sdo(const Frame& frame, std::uint8_t least_length) {
  return frame.kind == FrameKind::data && !frame.extended && frame.length >= least_length &&
         frame.length <= 8;
}

/// Parses an expedited transfer that states its size. `specifier`: the expected bits 7 to 5 of the first
/// byte. Returns nullopt for any other transfer.
std::optional<SdoMessage> parse_sized(const Frame& frame, unsigned specifier, SdoService service) {
  const unsigned command = frame.data[0];
  if ((command & 0xF3U) != (specifier | expedited_with_size)) return std::nullopt;
  SdoMessage message = message_of(frame, service);
  message.content.bytes = static_cast<std::uint8_t>(4U - (command >> 2U & 3U));
  if (frame.length < 4 + message.content.bytes) return std::nullopt;
  message.content.value = value_of(frame, message.content.bytes);
  return message;
}

std::optional<SdoMessage> parse_abort(const Frame& frame) {
  if (frame.data[0] != 0x80 || frame.length < 8) return std::nullopt;
  SdoMessage message = message_of(frame, SdoService::abort);
  message.content.value = value_of(frame, 4);
  return message;
}

/// Parses a response whose value has no stated size: the value is all bytes from byte 4 on.
SdoMessage unsized_value(const Frame& frame) {
  SdoMessage message = message_of(frame, SdoService::value);
  message.content = {.value = value_of(frame, frame.length - 4U), .bytes = 0};
  return message;
}

using AbortText = std::pair<std::uint32_t, std::string_view>;

// CiA 301, table of SDO abort codes.
constexpr std::array abort_texts{
    AbortText{0x0503'0000, "toggle bit not alternated"},
    AbortText{0x0504'0000, "SDO protocol timed out"},
    AbortText{0x0504'0001, "command specifier not valid or unknown"},
    AbortText{0x0504'0002, "invalid block size"},
    AbortText{0x0504'0003, "invalid sequence number"},
    AbortText{0x0504'0004, "CRC error"},
    AbortText{0x0504'0005, "out of memory"},
    AbortText{0x0601'0000, "unsupported access to an object"},
    AbortText{0x0601'0001, "attempt to read a write-only object"},
    AbortText{0x0601'0002, "attempt to write a read-only object"},
    AbortText{0x0602'0000, "object does not exist in the object dictionary"},
    AbortText{0x0604'0041, "object cannot be mapped to the PDO"},
    AbortText{0x0604'0042, "the mapped objects would exceed the PDO's length"},
    AbortText{0x0604'0043, "general parameter incompatibility"},
    AbortText{0x0604'0047, "general internal incompatibility in the device"},
    AbortText{0x0606'0000, "access failed due to a hardware error"},
    AbortText{0x0607'0010, "data type or length does not match"},
    AbortText{0x0607'0012, "data type does not match, too long"},
    AbortText{0x0607'0013, "data type does not match, too short"},
    AbortText{0x0609'0011, "sub-index does not exist"},
    AbortText{0x0609'0030, "invalid value for the parameter"},
    AbortText{0x0609'0031, "value of the parameter too high"},
    AbortText{0x0609'0032, "value of the parameter too low"},
    AbortText{0x0609'0036, "maximum value is less than minimum value"},
    AbortText{0x060A'0023, "resource not available: SDO connection"},
    AbortText{0x0800'0000, "general error"},
    AbortText{0x0800'0020, "data cannot be transferred or stored"},
    AbortText{0x0800'0021, "data cannot be transferred or stored because of local control"},
    AbortText{0x0800'0022, "data cannot be transferred or stored in the present device state"},
    AbortText{0x0800'0023, "no object dictionary present, or it could not be generated"},
    AbortText{0x0800'0024, "no data available"},
};

}  // namespace

Frame sdo_request(std::uint8_t node, const SdoMessage& message) {
  return make_frame(sdo_request_base + node, message);
}
Frame sdo_response(std::uint8_t node, const SdoMessage& message) {
  return make_frame(sdo_response_base + node, message);
}

std::optional<SdoMessage> parse_sdo_request(const Frame& frame) {
  if (!is_sdo(frame, 8)) return std::nullopt;
  if (frame.data[0] == 0x40) return message_of(frame, SdoService::read);
  if (const auto write = parse_sized(frame, 0x20, SdoService::write)) return write;
  return parse_abort(frame);
}

std::optional<SdoMessage> parse_sdo_response(const Frame& frame) {
  if (!is_sdo(frame, 4)) return std::nullopt;
  if (frame.data[0] == 0x60) return message_of(frame, SdoService::written);
  if (frame.data[0] == 0x42 && frame.length > 4) return unsized_value(frame);
  if (frame.data[0] == 0x40 || frame.data[0] == 0x41) return message_of(frame, SdoService::segmented);
  if (const auto value = parse_sized(frame, 0x40, SdoService::value)) return value;
  return parse_abort(frame);
}

std::optional<SdoMessage> sdo_access_of(const Frame& request) {
  constexpr unsigned download = 1, upload = 2, block_upload = 5, block_download = 6;
  if (!is_sdo(request, 4)) return std::nullopt;
  const unsigned specifier = request.data[0] >> 5U;
  const bool begins_a_block = (request.data[0] & 1U) == 0;
  if (specifier == download || (specifier == block_download && begins_a_block))
    return message_of(request, SdoService::write);
  if (specifier == upload || (specifier == block_upload && (request.data[0] & 3U) == 0))
    return message_of(request, SdoService::read);
  return std::nullopt;
}

SdoSetup::SdoSetup(std::uint8_t node, std::vector<SdoWrite> writes, SdoPatience patience)
    : node_(node), writes_(std::move(writes)), patience_(patience) {}

void SdoSetup::restart() {
  next_ = 0;
  step_ = Step::write;
  attempt_ = 1;
  failed_ = false;
  failure_ = {};
}

Frame SdoSetup::ask(SdoService service, Time now) {
  const SdoWrite& write = writes_[next_];
  deadline_ = now + patience_.timeout;
  step_ = service == SdoService::write ? Step::await_written : Step::await_value;
  return sdo_request(node_, {.service = service, .object = write.object, .content = write.content});
}

std::optional<Frame> SdoSetup::poll(Time now) {
  if (is_done() || failed_) return std::nullopt;
  if (step_ == Step::write) return ask(SdoService::write, now);
  if (step_ == Step::read) return ask(SdoService::read, now);
  if (now < deadline_) return std::nullopt;
  const SdoObject object = writes_[next_].object;
  fail(SdoFailure::Reason::timed_out, 0, 0);
  return sdo_request(node_, {.service = SdoService::abort,
                             .object = object,
                             .content = {.value = sdo_abort::timed_out, .bytes = 4}});
}

bool SdoSetup::handle(const Frame& frame) {
  const bool waiting = step_ == Step::await_written || step_ == Step::await_value;
  if (is_done() || failed_ || !waiting) return false;
  const auto message = parse_sdo_response(frame);
  if (!message || message->object != writes_[next_].object) return false;
  if (message->service == SdoService::abort)
    fail(SdoFailure::Reason::aborted, message->content.value, 0);
  else if (step_ == Step::await_written && message->service == SdoService::written)
    step_ = Step::read;
  else if (step_ == Step::await_value && message->service == SdoService::value)
    take_value(message->content);
  else if (step_ == Step::await_value && message->service == SdoService::segmented)
    fail(SdoFailure::Reason::segmented, 0, 0);
  else
    return false;
  return true;
}

void SdoSetup::take_value(const SdoValue& value) {
  const SdoValue& written = writes_[next_].content;
  const std::uint32_t stated = value.bytes == 0 ? value.value & mask_of(written.bytes) : value.value;
  if (stated != written.value || (value.bytes != 0 && value.bytes != written.bytes))
    return fail(SdoFailure::Reason::read_back_differs, 0, value.value);
  ++next_;
  step_ = Step::write;
  attempt_ = 1;
}

void SdoSetup::fail(SdoFailure::Reason reason, std::uint32_t abort_code, std::uint32_t read_back) {
  const SdoWrite& write = writes_[next_];
  failure_ = {.reason = reason,
              .object = write.object,
              .abort_code = abort_code,
              .written = write.content.value,
              .read_back = read_back};
  step_ = Step::write;
  failed_ = ++attempt_ > patience_.attempts;
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

std::string_view sdo_abort_text(std::uint32_t code) {
  const auto found = std::ranges::find(abort_texts, code, &AbortText::first);
  return found == abort_texts.end() ? "unknown abort code" : found->second;
}

std::string describe(const SdoFailure& failure) {
  const std::string object =
      fmt::format("object 0x{:04X}:{:02X}: ", failure.object.index, failure.object.subindex);
  switch (failure.reason) {
    case SdoFailure::Reason::timed_out:
      return object + "the node does not answer";
    case SdoFailure::Reason::aborted:
      return object + fmt::format("refused by the node with 0x{:08X}: {}", failure.abort_code,
                                  sdo_abort_text(failure.abort_code));
    case SdoFailure::Reason::read_back_differs:
      return object +
             fmt::format("0x{:X} was written, but 0x{:X} was read back", failure.written, failure.read_back);
    case SdoFailure::Reason::segmented:
      return object + "the node answers in segments, expected a value of at most 4 bytes";
    case SdoFailure::Reason::none:
      break;
  }
  return object + "no failure";
}

}  // namespace hystcan::can
