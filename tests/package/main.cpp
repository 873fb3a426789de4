// Identifies a model from a measured loop, and computes the drive for a position.
#include <hystcan/identification/identify.h>

#include <cmath>
#include <cstdio>

int main() {
  using namespace hystcan;
  identification::Dataset loop{
      .input_unit = "V", .output_unit = "um", .time_s = {}, .input = {}, .output = {}};
  double play = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double drive = 50.0 - 50.0 * (1.0 - i / 8000.0) * std::cos(0.01 * i);
    play = std::fmax(drive - 5.0, std::fmin(drive + 5.0, play));
    loop.time_s.push_back(1e-3 * i);
    loop.input.push_back(drive);
    loop.output.push_back(0.4 * drive + 0.1 * play);
  }
  const model::Hysteresis model{
      identification::identify({loop}, {.shape = identification::CurveShape::polynomial(4)}).parameters};
  auto memory = model.virgin(model.input_range().lo, 64);
  const model::Prediction drive = model.inverse(memory, 20.0);
  std::printf("20 um at %.2f V\n", drive.value);
  model.advance(memory, drive.value);
  return std::fabs(memory.output - 20.0) < 1e-9 ? 0 : 1;
}
