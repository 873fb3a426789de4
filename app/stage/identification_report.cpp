#include "app/stage/identification_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <system_error>

#include "app/stage/identification_numbers.h"
#include "app/stage/identification_page.h"
#include "app/stage/identification_plots.h"
#include "base/error.h"
#include "base/output_file.h"
#include "config/schema/config.h"

namespace hystcan::app {
namespace {

constexpr int landscape_points = 21;

void remove_files(const std::filesystem::path& directory) {
  for (const std::string& name : report_files()) {
    std::error_code error;
    std::filesystem::remove(directory / name, error);
    if (error)
      throw RunError(fmt::format("{}: cannot be removed: {}", (directory / name).string(), error.message()));
  }
}

}  // namespace

const std::vector<std::string>& report_files() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all{"report.html", "record.csv", "curves.csv", "landscape.csv",
                                 "comparison.csv"};
    for (const Picture& picture : pictures())
      for (const char* ending : {".gp", ".svg"}) all.push_back(picture.name + ending);
    return all;
  }();
  return names;
}

WrittenReport write_report(const std::filesystem::path& directory, const IdentificationReport& report,
                           const std::function<bool()>& go_on) {
  create_folder(directory);
  WrittenReport written{identification::compare(report.datasets, report.identified, go_on), {}};
  std::optional<identification::Landscape> map;
  if (go_on()) map = identification::landscape(report.datasets, report.identified, landscape_points);
  remove_files(directory);  // of an earlier report
  try {
    write_numbers(directory, report.datasets, report.identified, written.comparison, map);
    written.undrawn = draw_pictures(directory, report.datasets.size(), report.identified, map);
    OutputFile page(directory / "report.html");
    page.write(page_of(directory, report, written));
    page.commit();
  } catch (const RunError&) {
    remove_files(directory);  // no part of a report remains
    throw;
  }
  return written;
}

}  // namespace hystcan::app
