#include "can/log/error_words.h"

#include <linux/can/error.h>

#include <cstdint>
#include <span>

#include "can/log/candump.h"

namespace hystcan::can {
namespace {

struct Word {
  std::uint32_t bit;
  const char* text;
};

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
  for (const Word& word : words)
    if ((bits & word.bit) != 0) causes.emplace_back(word.text);
  if (causes.size() == before && none != nullptr) causes.emplace_back(none);
}

}  // namespace

std::vector<std::string> error_causes(const Frame& frame) {
  std::vector<std::string> causes;
  if (drops_reported_by(frame)) return {"frames lost by the recorder"};
  add(causes, classes, frame.id, nullptr);
  if ((frame.id & CAN_ERR_CRTL) != 0) add(causes, controller_details, frame.data[1], "controller error");
  if ((frame.id & CAN_ERR_PROT) != 0) add(causes, protocol_details, frame.data[2], "protocol error");
  if (causes.empty() && (frame.id & CAN_ERR_CNT) != 0) causes.emplace_back("error counters");
  if (causes.empty()) causes.emplace_back("error of no known class");
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
  // Older drivers, such as the one for SJA1000, give the counters without their class.
  if ((frame.id & CAN_ERR_CNT) != 0 || frame.data[6] != 0 || frame.data[7] != 0)
    text += ", error counters: transmit " + std::to_string(frame.data[6]) + ", receive " +
            std::to_string(frame.data[7]);
  return text;
}

}  // namespace hystcan::can
