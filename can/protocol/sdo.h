// Expedited SDO (CiA 301): writes and reads objects of 1 to 4 bytes in the dictionary of another node.
//
//   request 0x600 + node, response 0x580 + node, 8 bytes:
//
//   | byte                   | 0                      | 1..2  | 3         | 4..7                  |
//   |------------------------|------------------------|-------|-----------|-----------------------|
//   | write 4, 3, 2, 1 bytes | 0x23, 0x27, 0x2B, 0x2F | index | sub-index | value, low byte first |
//   | written                | 0x60                   | index | sub-index | 0                     |
//   | read                   | 0x40                   | index | sub-index | 0                     |
//   | read 4, 3, 2, 1 bytes  | 0x43, 0x47, 0x4B, 0x4F | index | sub-index | value                 |
//   | read, size not stated  | 0x42                   | index | sub-index | value                 |
//   | read in segments       | 0x40, 0x41             | index | sub-index | number of bytes       |
//   | abort, either way      | 0x80                   | index | sub-index | abort code            |
//
// A response may be shorter than 8 bytes if it holds all that its first byte announces. Nodes send such
// responses, although CiA 301 asks for 8 bytes.
//
// No function here waits or holds a timer. The caller gives the received frames and the time, and sends the
// frames that are returned.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/frame.h"
#include "can/scheduler.h"

namespace hystcan::can {

struct SdoObject {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;

  friend bool operator==(const SdoObject&, const SdoObject&) = default;
};

/// A value of 1 to 4 bytes.
struct SdoValue {
  std::uint32_t value = 0;
  std::uint8_t bytes = 4;  ///< 0 in a response that does not state the size

  friend bool operator==(const SdoValue&, const SdoValue&) = default;
};

enum class SdoService : std::uint8_t { write, written, read, value, segmented, abort };

struct SdoMessage {
  SdoService service = SdoService::abort;
  SdoObject object{};
  SdoValue content{};  ///< the value of write and value, or the code of abort

  friend bool operator==(const SdoMessage&, const SdoMessage&) = default;
};

/// The message as a request to `node`, or as a response from `node`.
Frame sdo_request(std::uint8_t node, const SdoMessage& message);
Frame sdo_response(std::uint8_t node, const SdoMessage& message);
/// Empty if the frame is not a well-formed expedited transfer. The caller has checked the identifier.
std::optional<SdoMessage> parse_sdo_request(const Frame& frame);
/// The same, and also the announcement of a value in segments.
std::optional<SdoMessage> parse_sdo_response(const Frame& frame);
/// The begin of a transfer of any kind (expedited, in segments, or in blocks) as write or read of its
/// object, without the value. Empty: this request begins no transfer.
std::optional<SdoMessage> sdo_access_of(const Frame& request);

namespace sdo_abort {
inline constexpr std::uint32_t timed_out = 0x0504'0000;
inline constexpr std::uint32_t out_of_memory = 0x0504'0005;
inline constexpr std::uint32_t no_such_object = 0x0602'0000;
inline constexpr std::uint32_t wrong_length = 0x0607'0010;
}  // namespace sdo_abort

/// The text of an abort code.
std::string_view sdo_abort_text(std::uint32_t code);

/// One object that is written before a node is started.
struct SdoWrite {
  SdoObject object{};
  SdoValue content{};
};

/// Why the setup of a node failed.
struct SdoFailure {
  enum class Reason : std::uint8_t { none, timed_out, aborted, read_back_differs, segmented };
  Reason reason = Reason::none;
  SdoObject object{};
  std::uint32_t abort_code = 0;
  std::uint32_t written = 0;
  std::uint32_t read_back = 0;
};
/// "object 0x2001:02: refused by the node with 0x06010002: ...".
std::string describe(const SdoFailure& failure);

/// How long the setup waits for a response, and how often it tries.
struct SdoPatience {
  Duration timeout{std::chrono::milliseconds(100)};  ///< for one response
  unsigned attempts = 3;                             ///< for each object, the first one included
};

/// Writes objects in order, reads each one back and compares. If any of this fails, it starts again with the
/// write of the same object. The setup has failed after `attempts` tries of one object.
class SdoSetup {
 public:
  SdoSetup(std::uint8_t node, std::vector<SdoWrite> writes, SdoPatience patience = {});

  /// Starts again with the first object, because the node has lost its values.
  void restart();
  /// The frame to send now, if there is one. The caller polls once a cycle until is_done() or has_failed().
  std::optional<Frame> poll(Time now);
  /// Takes a response of this node. False: the frame does not answer the last request and is ignored.
  bool handle(const Frame& frame);

  bool is_done() const { return next_ == writes_.size(); }
  bool has_failed() const { return failed_; }
  const SdoFailure& failure() const { return failure_; }

 private:
  enum class Step : std::uint8_t { write, await_written, read, await_value };

  void fail(SdoFailure::Reason reason, std::uint32_t abort_code, std::uint32_t read_back);
  void take_value(const SdoValue& value);
  Frame ask(SdoService service, Time now);

  std::uint8_t node_;
  std::vector<SdoWrite> writes_;
  SdoPatience patience_;
  std::size_t next_ = 0;
  Step step_ = Step::write;
  unsigned attempt_ = 1;
  Time deadline_{};
  bool failed_ = false;
  SdoFailure failure_;
};

/// A minimal server for a node. It keeps up to 64 written objects from 0x2000 to 0x5FFF; an object exists
/// only after a write.
class SdoServer {
 public:
  explicit SdoServer(std::uint8_t node);

  /// Returns to the state at power-on: no object exists.
  void reset() { objects_.clear(); }
  /// The response to a request to this node; empty for every other frame.
  std::optional<Frame> answer(const Frame& frame);
  std::optional<SdoValue> object(SdoObject object) const;

 private:
  SdoMessage reply_to(const SdoMessage& request);
  SdoMessage write(const SdoMessage& request);

  std::uint8_t node_;
  std::vector<SdoWrite> objects_;
};

}  // namespace hystcan::can
