// One connection to a bus, shared by several nodes of a process.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "can/bus.h"

namespace hystcan::node {

// Passes each frame to the nodes in the order in which they were attached. Frames that the nodes then send
// wait until all nodes have received the frame: at a SYNC, amplifiers set their outputs and sensors
// read their inputs before any frame is sent. Then the frames of the node that was attached last are sent
// first: samples before statuses.
//
// Nodes do not receive each other's frames, because a SocketCAN connection does not receive its own frames.
// The first node's counters are those of the connection; the counters of the other nodes stay zero.

class SharedConnection {
 public:
  SharedConnection();
  ~SharedConnection();
  SharedConnection(const SharedConnection&) = delete;
  SharedConnection& operator=(const SharedConnection&) = delete;

  /// Returns the connection of one node. The connection must not outlive this object.
  std::unique_ptr<can::Bus> attach(std::span<const can::Filter> filters);
  /// Opens the connection for all attached nodes, before any node sends.
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
