// For any bytes, a CSV of cycles is either refused with its place, or read with consistent axes, summary and
// columns.
#include <string>
#include <vector>

#include "runs/run.h"
#include "tests/fuzz/refusal.h"

using namespace hystcan;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::File file(data, size);
  fuzz::read_or_refuse(file, [&] {
    const runs::Run run(file.path());
    std::uint64_t rows = 0;
    for (std::size_t axis = 0; axis < run.info().axes.size(); ++axis) {
      const std::vector<std::string> names{"time_s", "position_um"};
      const runs::Columns columns = run.read(axis, names);
      fuzz::demand(columns[1].size() == columns[0].size());
      rows += columns[0].size();
    }
    fuzz::demand(rows <= run.info().rows);  // a row without a time is outside every span
  });
  return 0;
}
