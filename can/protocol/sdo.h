// Expedited SDO (CiA 301): objects of 1 to 4 bytes in another node's dictionary, written and read.
//
//   request 0x600 + node, response 0x580 + node, 8 bytes:
//
//   | byte | 0 | 1..2 | 3 | 4..7 |
//   |---|---|---|---|---|
//   | write 4, 3, 2, 1 bytes | 0x23, 0x27, 0x2B, 0x2F | index | sub-index | value, low byte first |
//   | written | 0x60 | index | sub-index | 0 |
//   | read | 0x40 | index | sub-index | 0 |
//   | read 4, 3, 2, 1 bytes | 0x43, 0x47, 0x4B, 0x4F | index | sub-index | value |
//   | abort, either way | 0x80 | index | sub-index | abort code |
//
// Nothing here waits or holds a timer: it is told frames and the time, and says what to send.
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
  std::uint8_t bytes = 4;

  friend bool operator==(const SdoValue&, const SdoValue&) = default;
};

enum class SdoService : std::uint8_t { write, written, read, value, abort };

struct SdoMessage {
  SdoService service = SdoService::abort;
  SdoObject object{};
  SdoValue content{};  ///< of write and value; of abort, the code

  friend bool operator==(const SdoMessage&, const SdoMessage&) = default;
};

/// As request or as response to or from `node`.
Frame sdo_request(std::uint8_t node, const SdoMessage& message);
Frame sdo_response(std::uint8_t node, const SdoMessage& message);
/// Empty where the frame is not a well-formed one of expedited transfer. The caller has matched the
/// identifier.
std::optional<SdoMessage> parse_sdo_request(const Frame& frame);
std::optional<SdoMessage> parse_sdo_response(const Frame& frame);

namespace sdo_abort {
inline constexpr std::uint32_t timed_out = 0x0504'0000;
inline constexpr std::uint32_t unknown_command = 0x0504'0001;
inline constexpr std::uint32_t out_of_memory = 0x0504'0005;
inline constexpr std::uint32_t no_such_object = 0x0602'0000;
inline constexpr std::uint32_t wrong_length = 0x0607'0010;
}  // namespace sdo_abort

/// An abort code in words.
std::string_view sdo_abort_text(std::uint32_t code);

/// One object to be set before a node is started.
struct SdoWrite {
  SdoObject object{};
  SdoValue content{};
};

/// Why a node could not be set up.
struct SdoFailure {
  enum class Reason : std::uint8_t { none, timed_out, aborted, read_back_differs };
  Reason reason = Reason::none;
  SdoObject object{};
  std::uint32_t abort_code = 0;
  std::uint32_t written = 0;
  std::uint32_t read_back = 0;
};
/// "object 0x2001:02: aborted by the node with 0x06010002: ...".
std::string describe(const SdoFailure& failure);

/// How long a node is waited for, and how often it is asked.
struct SdoPatience {
  Duration timeout{std::chrono::milliseconds(100)};  ///< for one response
  unsigned attempts = 3;                             ///< of each write, in all
};

/// Writes objects in order, reads each back and compares; a write that fails in any way is tried again from
/// its beginning, `attempts` times in all. Then the whole has failed.
class SdoSetup {
 public:
  struct Config {
    std::vector<SdoWrite> writes{};
    SdoPatience patience{};
  };

  SdoSetup(std::uint8_t node, Config config);

  /// From the first write on again: the node has lost what it was told.
  void restart();
  /// What to send now, if anything. To be called once a cycle while neither done nor failed.
  std::optional<Frame> poll(Time now);
  /// A response of this node; one that answers nothing that was asked is ignored.
  void handle(const Frame& frame);

  bool is_done() const { return next_ == config_.writes.size(); }
  bool has_failed() const { return failed_; }
  const SdoFailure& failure() const { return failure_; }

 private:
  enum class Step : std::uint8_t { write, await_written, read, await_value };

  void fail(SdoFailure::Reason reason, std::uint32_t abort_code, std::uint32_t read_back);
  void take_value(const SdoValue& value);
  Frame ask(SdoService service, Time now);

  std::uint8_t node_;
  Config config_;
  std::size_t next_ = 0;
  Step step_ = Step::write;
  unsigned attempt_ = 1;
  Time deadline_{};
  bool failed_ = false;
  SdoFailure failure_;
};

/// The other side, as small as a node may have it: keeps the objects 0x2000 to 0x5FFF that are written, up to
/// 64 of them; one that was never written is not there.
class SdoServer {
 public:
  explicit SdoServer(std::uint8_t node);

  /// As at power-on: no object has been written.
  void reset() { objects_.clear(); }
  /// The response to a request that is for this node; empty for every other frame.
  std::optional<Frame> answer(const Frame& frame);
  std::optional<SdoValue> object(SdoObject object) const;

 private:
  SdoMessage reply_to(const SdoMessage& request);
  SdoMessage write(const SdoMessage& request);

  std::uint8_t node_;
  std::vector<SdoWrite> objects_;
};

}  // namespace hystcan::can
