// The time to encode and seal a frame, and to check and decode it, with the layouts of the DBC. In the same
// run the same frame is packed by hand, with a CRC computed bit by bit.
//
//   bench_frames      prints ns per frame and the ratio
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "can/dbc/database.h"
#include "can/protocol/protocol.h"
#include "tests/bench/short_run.h"

namespace {

using namespace hystcan;
using Clock = std::chrono::steady_clock;

const int repetitions = bench::full_or_short(7, 1);
const int frames = bench::full_or_short(1'000'000, 100'000);

/// Nanoseconds for each of `frames` steps, the best of some repetitions.
template <class Step>
double best_ns(Step step) {
  double best = 1e99;
  for (int i = 0; i < repetitions; ++i) {
    const auto start = Clock::now();
    for (int n = 0; n < frames; ++n) step(n);
    best = std::min(best, std::chrono::duration<double, std::nano>(Clock::now() - start).count() / frames);
  }
  return best;
}

std::uint8_t sync_counter(int n) { return static_cast<std::uint8_t>(n % can::sync_counter_max + 1); }

std::uint8_t crc_by_hand(const std::array<std::uint8_t, 9>& bytes) {
  unsigned crc = 0xFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = ((crc & 0x80U) != 0 ? crc << 1U ^ 0x1DU : crc << 1U) & 0xFFU;
  }
  return static_cast<std::uint8_t>(crc ^ 0xFFU);
}

std::array<std::uint8_t, 8> command_by_hand(double setpoint, std::uint8_t sync_counter, unsigned counter) {
  const auto raw = static_cast<std::int32_t>(std::lround(setpoint * 1e6));
  std::array<std::uint8_t, 9> checked{0x01, 0x02};
  std::memcpy(&checked[2], &raw, sizeof raw);
  checked[6] = 1;
  checked[7] = sync_counter;
  checked[8] = static_cast<std::uint8_t>(counter & 0xFU);
  std::array<std::uint8_t, 8> payload{};
  std::copy_n(checked.begin() + 2, 7, payload.begin());
  payload[7] = crc_by_hand(checked);
  return payload;
}

void print(const char* what, double ns, double by_hand_ns) {
  std::printf("%-8s %6.1f ns per frame, by hand %6.1f ns: %.2f x\n", what, ns, by_hand_ns, ns / by_hand_ns);
}

}  // namespace

int main() {
  bench::announce_short_run();
  const can::Database database = can::load_dbc(HYSTCAN_SOURCE_DIR "/config/hystcan.dbc");
  const can::Message& message = *database.find("XAmpCommand");
  can::Encoder<can::AmpCommand> encode(message);
  unsigned seen = 0;
  const auto command = [](int n) {
    return can::AmpCommand{.setpoint = 1e-4 * n, .enable = true, .sync_counter = sync_counter(n)};
  };
  for (int n = 0; n < frames; ++n) encode(command(n)).value();  // throws if one is refused
  const double encode_ns = best_ns([&](int n) { seen += encode(command(n))->data[7]; });
  const double encode_by_hand_ns = best_ns(
      [&](int n) { seen += command_by_hand(1e-4 * n, sync_counter(n), static_cast<unsigned>(n))[7]; });

  std::array<can::Frame, 16> ring;
  for (int n = 0; n < 16; ++n) ring[static_cast<std::size_t>(n)] = encode(command(1000 * n)).value();
  can::Decoder<can::AmpCommand> decode(message);
  for (const can::Frame& frame : ring) decode(frame).value();
  double sum = 0.0;
  const double decode_ns =
      best_ns([&](int n) { sum += decode(ring[static_cast<unsigned>(n) % 16])->setpoint; });
  const double decode_by_hand_ns = best_ns([&](int n) {
    const can::Frame& frame = ring[static_cast<unsigned>(n) % 16];
    std::array<std::uint8_t, 9> checked{0x01, 0x02};
    std::copy_n(frame.data.begin(), 7, checked.begin() + 2);
    std::int32_t raw = 0;
    std::memcpy(&raw, frame.data.data(), sizeof raw);
    if (crc_by_hand(checked) == frame.data[7]) sum += 1e-6 * raw;
  });
  print("encode", encode_ns, encode_by_hand_ns);
  print("decode", decode_ns, decode_by_hand_ns);
  return seen == 0 && sum == 0.0 ? 1 : 0;
}
