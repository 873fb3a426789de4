#include "app/command_line/run_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/output_file.h"
#include "base/text.h"

namespace hystcan::app {
namespace {

/// The input of plot.py for one plot: the text of the CSV file, and the values that are not in the CSV.
struct RunPicture {
  std::string data;
  nlohmann::json facts;
};

std::string csv(const char* header, const std::vector<PlotRow>& rows) {
  std::string text = header;
  for (const PlotRow& row : rows) {
    for (const double value : {row.time_s, row.reference_um, row.position_um, row.error_um, row.drive}) {
      append_shortest(text, value);
      text += ',';
    }
    text.back() = '\n';
  }
  return text;
}

constexpr const char* row_header = "time_s,reference_um,position_um,error_um,drive\n";

nlohmann::json legend(std::string text) { return {{"legend", std::move(text)}}; }

RunPicture loops(const RunFigures& run) {
  return {csv(row_header, run.rows.rows()),
          {{"drive_unit", run.drive_unit},
           {"legend", fmt::format("measured position against the drive that caused it, {:.2g} ms earlier",
                                  1e3 * run.drive_delay_s)}}};
}

RunPicture tracking(const RunFigures& run) { return {csv(row_header, run.rows.rows()), {}}; }

RunPicture error(const RunFigures& run) {
  return {csv(row_header, run.rows.rows()),
          legend(fmt::format("reference - measured: RMS {:.4f} um, at most {:.4f} um", run.error.rms_um(),
                             run.error.max_um))};
}

RunPicture spectrum(const RunFigures& run) {
  std::string data = "frequency_Hz,error_um_per_sqrtHz\n";
  const std::vector<double> frequencies = run.spectrum.frequencies_Hz(), densities = run.spectrum.densities();
  for (std::size_t i = 0; i < densities.size(); ++i)
    data += fmt::format("{},{}\n", frequencies[i], densities[i]);
  return {std::move(data), legend(fmt::format("{} segments", run.spectrum.segments()))};
}

RunPicture step(const RunFigures& run) {
  const metrics::Step& response = *run.step;
  std::string figures = fmt::format("measured: overshoot {:.1f} %", 100.0 * response.overshoot());
  if (const auto rise_s = response.rise_s()) figures += fmt::format(", rise {:.1f} ms", 1e3 * *rise_s);
  if (const auto settling_s = response.settling_s())
    figures += fmt::format(", within {:.3g} um after {:.1f} ms", response.band_um, 1e3 * *settling_s);
  return {csv(row_header, run.step_rows), legend(std::move(figures))};
}

/// Returns the plot of the two timing histograms (sample to command, lateness of SYNC). Empty bins are
/// omitted.
RunPicture timing(const RunFigures& run) {
  std::string data = "upper_us,share_percent,what\n";
  for (const auto& [what, histogram] :
       {std::pair("sample to command", &run.turnaround_us), std::pair("SYNC late", &run.lateness_us)}) {
    const auto total = static_cast<double>(histogram->samples());
    const double width = histogram->upper_edges().front();
    for (std::size_t i = 0; i < histogram->counts().size(); ++i)
      if (const std::uint64_t count = histogram->counts()[i]; count > 0)
        data += fmt::format("{},{},{}\n", width * static_cast<double>(i + 1),
                            100.0 * static_cast<double>(count) / total, what);
  }
  return {std::move(data), {}};
}

using Maker = RunPicture (*)(const RunFigures& run);

const std::vector<std::pair<std::string, Maker>>& makers() {
  static const std::vector<std::pair<std::string, Maker>> all{{"loops", loops}, {"tracking", tracking},
                                                              {"error", error}, {"spectrum", spectrum},
                                                              {"step", step},   {"timing", timing}};
  return all;
}

/// Returns the reason why a plot of this kind cannot be made for the run; nullopt if it can.
std::optional<std::string> lack_of(const std::string& kind, const RunFigures& run) {
  if (kind == "step" && !run.step) return "the reference of the run has no step";
  if (kind == "spectrum" && run.spectrum.segments() == 0)
    return "too short for a spectrum: 1024 cycles are needed";
  if (kind == "timing" && run.turnaround_us.samples() == 0) return "no cycle times";
  return std::nullopt;
}

class Drawing {
 public:
  explicit Drawing(const RunPlots& plots) : plots_(plots) {}

  void add(const std::string& title, const std::string& kind, RunPicture picture) {
    const std::string name = distinct(file_name_of(title));
    write_file(plots_.folder / (name + ".csv"), picture.data);
    drawn_.names.push_back(name);
    pictures_.push_back({.kind = kind,
                         .data = {name + ".csv"},
                         .to = {},
                         .size = plots_.size,
                         .facts = std::move(picture.facts)});
    for (const std::string& format : plots_.formats)
      pictures_.back().to.push_back(fmt::format("{}.{}", name, format));
  }
  void lack(const std::string& what) { drawn_.lacking.push_back(what); }
  DrawnPlots drawn() {
    drawn_.undrawn = draw_pictures(plots_.folder / "pictures.json", pictures_);
    return drawn_;
  }

 private:
  /// Appends a number to the file name if an earlier plot already has this name.
  std::string distinct(const std::string& name) const {
    std::string candidate = name;
    for (int number = 2; std::ranges::find(drawn_.names, candidate) != drawn_.names.end(); ++number)
      candidate = fmt::format("{}-{}", name, number);
    return candidate;
  }

  const RunPlots& plots_;
  DrawnPlots drawn_;
  std::vector<Picture> pictures_;
};

std::string label_of(const RunFigures& run) { return fmt::format("{}-{}", run.run, run.axis); }

/// Returns the plot that compares the errors of all runs. The time of each run counts from its first plotted
/// row.
RunPicture comparison(const std::vector<RunFigures>& runs) {
  std::string data = "time_s,error_um,which\n";
  std::vector<std::string> legends;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::vector<PlotRow> rows = runs[i].rows.rows();
    for (const PlotRow& row : rows)
      data += fmt::format("{},{},{}\n", row.time_s - rows.front().time_s, row.error_um, i);
    legends.push_back(fmt::format("{}: RMS {:.4f} um", label_of(runs[i]), runs[i].error.rms_um()));
  }
  return {std::move(data), {{"legends", legends}}};
}

}  // namespace

const std::vector<std::string>& plot_kinds() {
  static const std::vector<std::string> kinds = [] {
    std::vector<std::string> names;
    for (const auto& [name, make] : makers()) names.push_back(name);
    names.emplace_back("comparison");
    return names;
  }();
  return kinds;
}

DrawnPlots draw_runs(const std::vector<RunFigures>& runs, const RunPlots& plots) {
  Drawing drawing(plots);
  const auto is_wanted = [&](const std::string& kind) {
    return std::ranges::find(plots.kinds, kind) != plots.kinds.end();
  };
  for (const RunFigures& run : runs)
    for (const auto& [kind, make] : makers()) {
      if (!is_wanted(kind)) continue;
      const std::string name = fmt::format("{}-{}", label_of(run), kind);
      if (const auto lack = lack_of(kind, run))
        drawing.lack(fmt::format("{}: {}", name, *lack));
      else
        drawing.add(name, kind, make(run));
    }
  if (is_wanted("comparison") && runs.size() > 1) drawing.add("comparison", "comparison", comparison(runs));
  return drawing.drawn();
}

}  // namespace hystcan::app
