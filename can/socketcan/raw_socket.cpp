#include "can/socketcan/raw_socket.h"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <vector>

#include "base/input_file.h"
#include "can/socketcan/interface.h"

namespace hystcan::can {
namespace {

// The size of the socket's send buffer. The kernel doubles it: the buffer then has space for seven or eight
// classical frames, depending on the kernel. This is about one cycle: two axes send eight frames in their
// busiest cycle. The kernel refuses any further frame, which would be outdated when it is sent.
constexpr int send_buffer_bytes = 3072;

constexpr std::chrono::seconds oldest_credible_stamp{1};

template <class Value>
bool set_option(int socket, int level, int option, const Value& value) {
  return ::setsockopt(socket, level, option, &value, sizeof value) == 0;
}

/// Returns filters for both identifier types; the E2eChecker of a message rejects frames of the wrong type.
/// The kernel finds a filter for exactly one data identifier in a table, which is fast. But it compares every
/// frame on the bus with each of the other filters, for example filters for remote frames. Therefore remote
/// frames have only one filter, which passes all of them.
std::vector<can_filter> kernel_filters(std::span<const Filter> filters) {
  constexpr canid_t kinds = CAN_EFF_FLAG | CAN_RTR_FLAG;
  std::vector<can_filter> result;
  for (const Filter& filter : filters) {
    if (filter.id <= CAN_SFF_MASK) result.push_back({filter.id, CAN_SFF_MASK | kinds});
    result.push_back({filter.id | CAN_EFF_FLAG, CAN_EFF_MASK | kinds});
  }
  if (!filters.empty()) result.push_back({CAN_RTR_FLAG, CAN_RTR_FLAG});
  return result;
}

void set_options(int socket, const std::string& interface, std::span<const Filter> filters) {
  const std::vector<can_filter> accepted = kernel_filters(filters);
  const auto bytes = static_cast<socklen_t>(accepted.size() * sizeof(can_filter));
  if (::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FILTER, accepted.data(), bytes) != 0)
    fail_at_interface(interface, "cannot set filters");
  if (!set_option(socket, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_MASK}))
    fail_at_interface(interface, "cannot receive error frames");
  set_option(socket, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1);  // an old kernel without FD may refuse this
  set_option(socket, SOL_SOCKET, SO_RXQ_OVFL, 1);
  set_option(socket, SOL_SOCKET, SO_TIMESTAMPNS, 1);
  set_option(socket, SOL_SOCKET, SO_SNDBUF, send_buffer_bytes);
}

Duration realtime_now() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return std::chrono::seconds{now.tv_sec} + Duration{now.tv_nsec};
}

}  // namespace

int open_raw_socket(const std::string& interface, std::span<const Filter> filters) {
  const Interface found = require_can_interface(interface);
  Descriptor socket(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (socket.get() < 0) fail_at_interface(interface, "cannot open a CAN socket");
  set_options(socket.get(), interface, filters);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = found.index;
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    fail_at_interface(interface, "cannot bind");
  return socket.release();
}

void receive_own_frames(int socket) { set_option(socket, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 1); }

int write_frame(int socket, const Frame& frame) {
  const bool fd = frame.kind == FrameKind::fd;
  const bool remote = frame.kind == FrameKind::remote;
  if (frame.kind == FrameKind::error || frame.length > (fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN)) return EINVAL;
  if (frame.id > (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK)) return EINVAL;
  canfd_frame raw{};
  raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (remote ? CAN_RTR_FLAG : 0U);
  raw.len = frame.length;
  if (fd) raw.flags = frame.fd_flags;
  if (!remote) std::copy_n(frame.data.begin(), frame.length, raw.data);
  return ::send(socket, &raw, fd ? CANFD_MTU : CAN_MTU, MSG_DONTWAIT) < 0 ? errno : 0;
}

ReceiveBatch::ReceiveBatch() {
  for (std::size_t i = 0; i < capacity; ++i) {
    vectors_[i] = {&frames_[i], sizeof frames_[i]};
    headers_[i].msg_hdr.msg_iov = &vectors_[i];
    headers_[i].msg_hdr.msg_iovlen = 1;
    headers_[i].msg_hdr.msg_control = control_[i].data();
  }
}

int ReceiveBatch::read(int socket, std::size_t room) {
  for (std::size_t i = 0; i < room; ++i) headers_[i].msg_hdr.msg_controllen = control_bytes;
  const int count =
      room == 1 ? read_one(socket)
                : ::recvmmsg(socket, headers_.data(), static_cast<unsigned>(room), MSG_DONTWAIT, nullptr);
  if (count <= 0) return count;
  const Time steady = std::chrono::steady_clock::now();
  const Duration realtime = realtime_now();
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) read_control(i, steady, realtime);
  return count;
}

/// Reads one frame with recvmsg(). For one frame, recvmmsg() would take 0.3 us longer.
int ReceiveBatch::read_one(int socket) {
  const ssize_t bytes = ::recvmsg(socket, &headers_[0].msg_hdr, 0);
  if (bytes < 0) return -1;
  headers_[0].msg_len = static_cast<unsigned>(bytes);
  return 1;
}

void ReceiveBatch::read_control(std::size_t index, Time steady_now, Duration realtime) {
  received_[index] = steady_now;
  stamped_[index] = realtime;
  msghdr& header = headers_[index].msg_hdr;
  for (cmsghdr* item = CMSG_FIRSTHDR(&header); item != nullptr; item = CMSG_NXTHDR(&header, item)) {
    if (item->cmsg_level != SOL_SOCKET) continue;
    if (item->cmsg_type == SO_RXQ_OVFL) std::memcpy(&lost_, CMSG_DATA(item), sizeof lost_);
    if (item->cmsg_type == SCM_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(item), sizeof stamp);
      stamped_[index] = std::chrono::seconds{stamp.tv_sec} + Duration{stamp.tv_nsec};
      const Duration age = realtime - stamped_[index];
      if (age >= Duration::zero() && age < oldest_credible_stamp) received_[index] = steady_now - age;
    }
  }
}

Frame ReceiveBatch::frame(std::size_t index) const {
  const canfd_frame& raw = frames_[index];
  Frame frame;
  frame.length = static_cast<std::uint8_t>(std::min<std::size_t>(raw.len, frame.data.size()));
  std::copy_n(raw.data, frame.length, frame.data.begin());
  if ((raw.can_id & CAN_ERR_FLAG) != 0) {
    frame.id = raw.can_id & CAN_ERR_MASK;
    frame.kind = FrameKind::error;
    return frame;
  }
  frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.id = raw.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  if (headers_[index].msg_len == CANFD_MTU) {
    frame.kind = FrameKind::fd;
    frame.fd_flags = raw.flags & 0xFU;
  } else if ((raw.can_id & CAN_RTR_FLAG) != 0) {
    frame.kind = FrameKind::remote;
  }
  return frame;
}

}  // namespace hystcan::can
