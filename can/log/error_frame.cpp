#include "can/log/error_frame.h"

#include <linux/can/error.h>
#include <cstdint>
#include <span>

#include "can/log/candump.h"

namespace hystcan::can {
namespace {

std::optional<BusState> state_in(const Frame& frame) {
  if ((frame.id & CAN_ERR_BUSOFF) != 0) return BusState::bus_off;
  if ((frame.id & CAN_ERR_RESTARTED) != 0) return BusState::active;
  if ((frame.id & CAN_ERR_CRTL) == 0) return std::nullopt;
  const std::uint8_t controller = frame.data[1];
  if ((controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) return BusState::passive;
  if ((controller & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) return BusState::warning;
  if ((controller & CAN_ERR_CRTL_ACTIVE) != 0) return BusState::active;
  return std::nullopt;
}

std::optional<ErrorCounters> counters_in(const Frame& frame) {
  const ErrorCounters counters{.transmit = frame.data[6], .receive = frame.data[7]};
  if ((frame.id & CAN_ERR_CNT) != 0) return counters;
  const bool are_given = counters.transmit != 0 || counters.receive != 0;
  if ((frame.id & CAN_ERR_CRTL) != 0 && are_given) return counters;
  return std::nullopt;
}

using Word = std::pair<std::uint32_t, const char*>;  ///< a bit of linux/can/error.h and its text

constexpr Word classes[] = {{CAN_ERR_TX_TIMEOUT, "transmission timed out"},
                            {CAN_ERR_LOSTARB, "arbitration lost"},
                            {CAN_ERR_TRX, "transceiver error"},
                            {CAN_ERR_ACK, "not acknowledged"},
                            {CAN_ERR_BUSOFF, "bus-off"},
                            {CAN_ERR_BUSERROR, "bus error"},
                            {CAN_ERR_RESTARTED, "restarted after bus-off"}};

constexpr Word controller_details[] = {
    {CAN_ERR_CRTL_RX_OVERFLOW, "receive buffer of the controller overflowed"},
    {CAN_ERR_CRTL_TX_OVERFLOW, "transmit buffer of the controller overflowed"},
    {CAN_ERR_CRTL_RX_WARNING, "receive errors: warning"},
    {CAN_ERR_CRTL_TX_WARNING, "transmit errors: warning"},
    {CAN_ERR_CRTL_RX_PASSIVE, "receive errors: error-passive"},
    {CAN_ERR_CRTL_TX_PASSIVE, "transmit errors: error-passive"},
    {CAN_ERR_CRTL_ACTIVE, "error-active again"}};

constexpr Word protocol_details[] = {{CAN_ERR_PROT_BIT, "bit error"},
                                     {CAN_ERR_PROT_FORM, "form error"},
                                     {CAN_ERR_PROT_STUFF, "stuff error"},
                                     {CAN_ERR_PROT_BIT0, "could not send a dominant bit"},
                                     {CAN_ERR_PROT_BIT1, "could not send a recessive bit"},
                                     {CAN_ERR_PROT_OVERLOAD, "overload"},
                                     {CAN_ERR_PROT_ACTIVE, "active error announcement"},
                                     {CAN_ERR_PROT_TX, "while sending"}};

void add(std::vector<std::string>& causes, std::span<const Word> words, std::uint32_t bits,
         const char* none) {
  const std::size_t before = causes.size();
  for (const auto& [bit, text] : words)
    if ((bits & bit) != 0) causes.emplace_back(text);
  if (causes.size() == before && none != nullptr) causes.emplace_back(none);
}

}  // namespace

ErrorReport interpret(const Frame& frame) {
  const bool protocol = (frame.id & CAN_ERR_PROT) != 0;
  const bool in_ack_slot = protocol && frame.data[3] == CAN_ERR_PROT_LOC_ACK;
  return {.state = state_in(frame),
          .error_counters = counters_in(frame),
          .restarted = (frame.id & CAN_ERR_RESTARTED) != 0,
          .not_acknowledged = (frame.id & CAN_ERR_ACK) != 0 || in_ack_slot,
          .arbitration_lost = (frame.id & CAN_ERR_LOSTARB) != 0,
          .protocol_error = protocol && !in_ack_slot,
          .controller_overflow = (frame.id & CAN_ERR_CRTL) != 0 &&
                                 (frame.data[1] & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) != 0,
          .transceiver_error = (frame.id & CAN_ERR_TRX) != 0};
}

void count(const ErrorReport& report, BusCounters& counters) {
  ++counters.error_frames;
  if (report.restarted) ++counters.restarts;
  if (report.not_acknowledged) ++counters.not_acknowledged;
  if (report.arbitration_lost) ++counters.arbitration_lost;
  if (report.protocol_error) ++counters.protocol_errors;
  if (report.controller_overflow) ++counters.controller_overflows;
  if (report.transceiver_error) ++counters.transceiver_errors;
}

std::vector<std::string> error_causes(const Frame& frame) {
  std::vector<std::string> causes;
  if (drops_reported_by(frame)) return {"frames lost by the recorder"};
  add(causes, classes, frame.id, nullptr);
  if ((frame.id & CAN_ERR_CRTL) != 0) add(causes, controller_details, frame.data[1], "controller error");
  if ((frame.id & CAN_ERR_PROT) != 0) add(causes, protocol_details, frame.data[2], "protocol error");
  if (causes.empty() && (frame.id & CAN_ERR_CNT) != 0) causes.emplace_back("error counters");
  if (causes.empty()) causes.emplace_back("error of an unknown class");
  return causes;
}

std::string describe_error(const Frame& frame) {
  std::string text;
  for (const std::string& cause : error_causes(frame)) text += (text.empty() ? "" : ", ") + cause;
  if (const auto drops = drops_reported_by(frame)) return text + ": " + std::to_string(*drops);
  if ((frame.id & CAN_ERR_LOSTARB) != 0 && frame.data[0] != CAN_ERR_LOSTARB_UNSPEC)
    text += ", arbitration lost in bit " + std::to_string(frame.data[0]);
  if ((frame.id & CAN_ERR_PROT) != 0 && frame.data[3] != CAN_ERR_PROT_LOC_UNSPEC)
    text += ", at place " + std::to_string(frame.data[3]);
  // Older drivers, such as the SJA1000 driver, send error counters without the error class CAN_ERR_CNT.
  if ((frame.id & CAN_ERR_CNT) != 0 || frame.data[6] != 0 || frame.data[7] != 0)
    text += ", error counters: transmit " + std::to_string(frame.data[6]) + ", receive " +
            std::to_string(frame.data[7]);
  return text;
}

}  // namespace hystcan::can
