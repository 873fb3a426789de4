// Reports the parts of a message that decoding leaves out, once for each message.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "can/dbc/database.h"
#include "can/log/candump.h"

namespace hystcan::app {

/// Each frame is decoded by itself. Decoding leaves out
///   - signals that cannot be decoded,
///   - a message longer than a frame: a frame with the message's own identifier shows only its first bytes,
///   - a message that J1939 announces (connection management, PGN 0xEC00: request to send, or broadcast) and
///     carries in frames of its transport protocol: nothing of it is decoded.
class DecodeFindings {
 public:
  /// The database must outlive this object.
  explicit DecodeFindings(const can::Database& database) : database_(database) {}

  /// Returns one sentence for each new finding; usually none.
  std::vector<std::string> add(const can::LoggedFrame& logged);

 private:
  void examine_transport(const can::Frame& frame, std::vector<std::string>& findings);

  const can::Database& database_;
  std::set<const can::Message*> decoded_;
  std::set<std::uint32_t> transported_;  ///< parameter groups
};

}  // namespace hystcan::app
