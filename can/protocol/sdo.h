// Expedited SDO (CiA 301): writes and reads objects of 1 to 4 bytes in the object dictionary of another node.
//
//   A request has the identifier 0x600 + node, a response 0x580 + node. Both have 8 bytes:
//
//   | byte                             | 0                      | 1..2  | 3         | 4..7                  |
//   |----------------------------------|------------------------|-------|-----------|-----------------------|
//   | request: write 4, 3, 2, 1 bytes  | 0x23, 0x27, 0x2B, 0x2F | index | sub-index | value, low byte first |
//   | response: written                | 0x60                   | index | sub-index | 0                     |
//   | request: read                    | 0x40                   | index | sub-index | 0                     |
//   | response: value, 4, 3, 2, 1 byte | 0x43, 0x47, 0x4B, 0x4F | index | sub-index | value                 |
//   | response: value without its size | 0x42                   | index | sub-index | value                 |
//   | response: value in segments      | 0x40, 0x41             | index | sub-index | number of bytes       |
//   | request or response: abort       | 0x80                   | index | sub-index | abort code            |
//
// The parsers accept a response of less than 8 bytes if the response contains all bytes that its first byte
// announces. Real nodes send such responses, although CiA 301 requires 8 bytes.
//
// No function of this file waits or has a timer. The caller supplies the received frames and the present
// time, and sends the returned frames.
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

/// The value of an object, 1 to 4 bytes.
struct SdoValue {
  std::uint32_t value = 0;
  std::uint8_t bytes = 4;  ///< size of the value, 1 to 4; 0 in a response that does not state the size

  friend bool operator==(const SdoValue&, const SdoValue&) = default;
};

enum class SdoService : std::uint8_t { write, written, read, value, segmented, abort };

struct SdoMessage {
  SdoService service = SdoService::abort;
  SdoObject object{};
  SdoValue content{};  ///< value for the services `write` and `value`; abort code for `abort`

  friend bool operator==(const SdoMessage&, const SdoMessage&) = default;
};

/// Encodes the message: sdo_request() as a request to `node`, sdo_response() as a response from `node`.
Frame sdo_request(std::uint8_t node, const SdoMessage& message);
Frame sdo_response(std::uint8_t node, const SdoMessage& message);
/// Parses a request. Returns nullopt if the frame is not a well-formed expedited transfer. The caller must
/// have checked the identifier.
std::optional<SdoMessage> parse_sdo_request(const Frame& frame);
/// Parses a response: an expedited transfer, an abort, or the announcement of a value that follows in
/// segments. Returns nullopt for any other frame. The caller must have checked the identifier.
std::optional<SdoMessage> parse_sdo_response(const Frame& frame);
/// Returns which object a request begins to write or to read, without the value. The transfer may be
/// expedited, segmented or a block transfer. Returns nullopt if the request does not begin a transfer.
std::optional<SdoMessage> sdo_access_of(const Frame& request);

namespace sdo_abort {
inline constexpr std::uint32_t timed_out = 0x0504'0000;
inline constexpr std::uint32_t out_of_memory = 0x0504'0005;
inline constexpr std::uint32_t no_such_object = 0x0602'0000;
inline constexpr std::uint32_t wrong_length = 0x0607'0010;
}  // namespace sdo_abort

/// Returns the text that CiA 301 gives for an abort code.
std::string_view sdo_abort_text(std::uint32_t code);

/// An object of a node, and the value to write to it before the node is started.
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
/// Returns a text such as "object 0x2001:02: refused by the node with 0x06010002: ...".
std::string describe(const SdoFailure& failure);

/// How long SdoSetup waits for a response, and how often it tries to write an object.
struct SdoPatience {
  Duration timeout{std::chrono::milliseconds(100)};  ///< timeout of each response
  unsigned attempts = 3;                             ///< maximum attempts per object, including the first
};

/// Writes the objects of a node in order, reads each object back and compares the values. After any failure,
/// SdoSetup writes the same object again. The setup fails after SdoPatience::attempts attempts at one object.
class SdoSetup {
 public:
  SdoSetup(std::uint8_t node, std::vector<SdoWrite> writes, SdoPatience patience = {});

  /// Starts the setup again with the first object. Call after the node lost its values.
  void restart();
  /// Returns the frame that the caller must send now; nullopt if there is none. The caller calls poll() once
  /// per cycle until is_done() or has_failed() returns true.
  std::optional<Frame> poll(Time now);
  /// Processes a response of this node. If the frame does not answer the last request, ignores the frame and
  /// returns false.
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

/// A minimal SDO server of a node. The server stores up to 64 objects with an index from 0x2000 to 0x5FFF. An
/// object exists only after a client has written to it.
class SdoServer {
 public:
  explicit SdoServer(std::uint8_t node);

  /// Returns to the state at power-on: no object exists.
  void reset() { objects_.clear(); }
  /// Returns the response to a request to this node; nullopt for every other frame.
  std::optional<Frame> answer(const Frame& frame);
  std::optional<SdoValue> object(SdoObject object) const;

 private:
  SdoMessage reply_to(const SdoMessage& request);
  SdoMessage write(const SdoMessage& request);

  std::uint8_t node_;
  std::vector<SdoWrite> objects_;
};

}  // namespace hystcan::can
