// For any bytes, CsvReader and LabCsvReader either refuse them with their place, or return rows of finite
// numbers.
#include <cmath>
#include <vector>

#include "config/files/csv.h"
#include "config/files/lab_csv.h"
#include "tests/fuzz/refusal.h"

using namespace hystcan;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::File file(data, size);
  fuzz::read_or_refuse(file, [&] {
    config::CsvReader reader(config::CsvLines(file.path()), {"input"});
    const std::size_t width = reader.add_if_present("time_s") ? 2 : 1;
    std::vector<double> row;
    while (reader.next(row)) {
      fuzz::demand(row.size() == width);
      for (const double number : row) fuzz::demand(std::isfinite(number));
    }
    fuzz::demand(reader.bytes_read() <= size + 1);
  });
  fuzz::read_or_refuse(file, [&] {
    config::LabCsvReader reader(file.path());
    fuzz::demand(!reader.columns().empty());
    reader.select({0, reader.columns().size() - 1});
    std::vector<double> row;
    while (reader.read(row)) {
      if (reader.is_damaged()) throw reader.damage_error();
      fuzz::demand(row.size() == 2);
      for (const double number : row) fuzz::demand(std::isfinite(number));
    }
  });
  return 0;
}
