// One connection to a bus that several nodes of a process share.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "can/bus.h"

namespace hystcan::node {

// A SharedConnection passes each received frame to its nodes in the order in which they were attached. The
// answers of the nodes wait until all nodes have received the frame: at a SYNC, amplifiers set their outputs
// and sensors read their inputs before any answer is sent. Then the connection sends the answers of the node
// that was attached last, and so on up to the first node. If sensors are attached after amplifiers, samples
// are therefore sent before statuses.
//
// The nodes do not receive each other's frames, because a SocketCAN connection does not receive its own
// frames. counters() of the first node returns the counters of the connection; counters() of every other node
// returns zeros.

class SharedConnection {
 public:
  SharedConnection();
  ~SharedConnection();
  SharedConnection(const SharedConnection&) = delete;
  SharedConnection& operator=(const SharedConnection&) = delete;

  /// Attaches a node. Returns the node's part of the connection, which must not outlive this object.
  std::unique_ptr<can::Bus> attach(std::span<const can::Filter> filters);
  /// Opens the connection for all attached nodes. Call before any node sends a frame.
  void open(const can::Attach& attach);

 private:
  class Part;
  void deliver(const can::Frame& frame, can::Time received);

  std::vector<can::Filter> filters_;
  std::vector<Part*> parts_;
  std::unique_ptr<can::Bus> bus_;  ///< connection to the bus; null before open()
  bool is_delivering_ = false;
};

}  // namespace hystcan::node
