// One connection to a bus for several nodes of a process.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "can/bus.h"

namespace hystcan::node {

// A frame goes to the nodes in the order in which they were attached. What they send meanwhile waits until
// all of them have received it: at a SYNC, amplifiers set their outputs and sensors read their inputs before
// any frame is sent. Then the frames of the node that was attached last go first: samples before statuses.
//
// Nodes do not receive each other's frames, because those of a SocketCAN connection do not return to it. The
// first node's counters are those of the connection; the others count nothing.

class SharedConnection {
 public:
  SharedConnection();
  ~SharedConnection();
  SharedConnection(const SharedConnection&) = delete;
  SharedConnection& operator=(const SharedConnection&) = delete;

  /// The connection of one node, which must not outlive this.
  std::unique_ptr<can::Bus> attach(std::span<const can::Filter> filters);
  /// Connects all of them, before one sends.
  void open(const can::Attach& attach);

 private:
  class Part;
  void deliver(const can::Frame& frame, can::Time received);

  std::vector<can::Filter> filters_;
  std::vector<Part*> parts_;
  std::unique_ptr<can::Bus> bus_;  ///< null before open()
  bool is_delivering_ = false;
};

}  // namespace hystcan::node
