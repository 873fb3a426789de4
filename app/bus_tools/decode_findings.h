// What decoding leaves out, told once for each message that comes.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "can/dbc/database.h"
#include "can/log/candump.h"

namespace hystcan::app {

/// A frame is decoded by itself. Left out are signals that are not decodable, and what a transport protocol
/// carries in several frames: in a frame of the message's own identifier only its first bytes are seen, and
/// where J1939 announces it (connection management, PGN 0xEC00: request to send, or broadcast) nothing is.
class DecodeFindings {
 public:
  /// The database must outlive this.
  explicit DecodeFindings(const can::Database& database) : database_(database) {}

  /// One sentence each; mostly none.
  std::vector<std::string> add(const can::LoggedFrame& logged);

 private:
  void look_at_transport(const can::Frame& frame, std::vector<std::string>& findings);

  const can::Database& database_;
  std::set<const can::Message*> decoded_;
  std::set<std::uint32_t> transported_;  ///< parameter groups
};

}  // namespace hystcan::app
