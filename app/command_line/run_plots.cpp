#include "app/command_line/run_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>

#include "app/stage/gnuplot.h"
#include "base/output_file.h"
#include "base/text.h"

namespace hystcan::app {
namespace {

/// A picture: its data goes to a file, which the script's body names.
struct Picture {
  std::string data;
  std::string body;
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

Picture loops(const RunFigures& run, const std::string& data_file) {
  return {csv(row_header, run.rows.rows()),
          fmt::format("set xlabel {}\nset ylabel 'position (um)'\n"
                      "plot {} using 'drive':'position_um' with lines ls 1 title {}\n",
                      gnuplot_text(fmt::format("drive ({})", run.drive_unit)), data_file,
                      gnuplot_text(fmt::format("measured, against the drive of {:.2g} ms before",
                                               1e3 * run.drive_delay_s)))};
}

Picture tracking(const RunFigures& run, const std::string& data_file) {
  return {csv(row_header, run.rows.rows()),
          fmt::format(
              "set multiplot\nset lmargin 10\nset rmargin 3\nset format x ''\nset ylabel 'position (um)'\n"
              "set origin 0,0.45\nset size 1,0.55\nset bmargin 0.5\n"
              "plot {0} using 'time_s':'reference_um' with lines ls 6 title 'reference', \\\n"
              "  '' using 'time_s':'position_um' with lines ls 1 title 'measured'\n"
              "unset key\nset format x\nset xlabel 'time (s)'\nset ylabel 'error (um)'\n"
              "set origin 0,0\nset size 1,0.45\nset bmargin 3.5\nset tmargin 0.5\n"
              "plot {0} using 'time_s':'error_um' with lines ls 2\nunset multiplot\nreset session\n{1}",
              data_file, plot_look())};
}

Picture error(const RunFigures& run, const std::string& data_file) {
  return {csv(row_header, run.rows.rows()),
          fmt::format("set xlabel 'time (s)'\nset ylabel 'error (um)'\n"
                      "plot {} using 'time_s':'error_um' with lines ls 1 title {}\n",
                      data_file,
                      gnuplot_text(fmt::format("reference - measured: RMS {:.4f} um, at most {:.4f} um",
                                               run.error.rms_um(), run.error.max_um)))};
}

Picture spectrum(const RunFigures& run, const std::string& data_file) {
  std::string data = "frequency_Hz,error_um_per_sqrtHz\n";
  const std::vector<double> frequencies = run.spectrum.frequencies_Hz(), densities = run.spectrum.densities();
  for (std::size_t i = 0; i < densities.size(); ++i)
    data += fmt::format("{},{}\n", frequencies[i], densities[i]);
  return {std::move(data),
          fmt::format("set logscale xy\nset format y '10^{{%T}}'\nset xlabel 'frequency (Hz)'\n"
                      "set ylabel 'error (um/√Hz)'\n"
                      "plot {} using 'frequency_Hz':'error_um_per_sqrtHz' with lines ls 1 title {}\n"
                      "unset logscale\nset format y\n",
                      data_file, gnuplot_text(fmt::format("{} segments", run.spectrum.segments())))};
}

Picture step(const RunFigures& run, const std::string& data_file) {
  const metrics::Step& response = *run.step;
  std::string figures = fmt::format("measured: overshoot {:.1f} %", 100.0 * response.overshoot());
  if (const auto rise_s = response.rise_s()) figures += fmt::format(", rise {:.1f} ms", 1e3 * *rise_s);
  if (const auto settling_s = response.settling_s())
    figures += fmt::format(", within {:.3g} um after {:.1f} ms", response.band_um, 1e3 * *settling_s);
  return {csv(row_header, run.step_rows),
          fmt::format(
              "set xlabel 'time after the step (ms)'\nset ylabel 'position (um)'\n"
              "plot {0} using (1e3*column('time_s')):'reference_um' with steps ls 6 title 'reference', \\\n"
              "  '' using (1e3*column('time_s')):'position_um' with lines ls 1 title {1}\n",
              data_file, gnuplot_text(figures))};
}

/// Up to the last class that has a count.
Picture timing(const RunFigures& run, const std::string& data_file) {
  std::string data = "upper_us,share_percent,what\n";
  std::string body =
      "set logscale y\nset yrange [1e-4:150]\nset xrange [0:*]\nset xlabel 'time (us)'\nset ylabel 'cycles "
      "(%)'\nset style fill solid 0.4\nplot ";
  const char* between = "";
  int style = 1;
  for (const auto& [what, histogram] :
       {std::pair("sample to command", &run.turnaround_us), std::pair("SYNC late", &run.lateness_us)}) {
    const auto total = static_cast<double>(histogram->samples());
    const double width = histogram->upper_edges().front();
    for (std::size_t i = 0; i < histogram->counts().size(); ++i)
      if (const std::uint64_t count = histogram->counts()[i]; count > 0)
        data += fmt::format("{},{},{}\n", width * static_cast<double>(i + 1),
                            100.0 * static_cast<double>(count) / total, what);
    body += fmt::format(
        "{0}{1} using 'upper_us':(strcol('what') eq {2} ? column('share_percent') : NaN) "
        "with impulses ls {3} dt 1 lw 3 title {2}",
        between, data_file, gnuplot_text(what), style++);
    between = ", \\\n  ";
  }
  return {std::move(data), body + "\nunset logscale\nset xrange [*:*]\nset yrange [*:*]\n"};
}

using Maker = std::function<Picture(const RunFigures& run, const std::string& data_file)>;

const std::vector<std::pair<std::string, Maker>>& makers() {
  static const std::vector<std::pair<std::string, Maker>> all{{"loops", loops}, {"tracking", tracking},
                                                              {"error", error}, {"spectrum", spectrum},
                                                              {"step", step},   {"timing", timing}};
  return all;
}

/// Why this picture cannot be made of the run.
std::optional<std::string> lack_of(const std::string& kind, const RunFigures& run) {
  if (kind == "step" && !run.step) return "no step in its reference";
  if (kind == "spectrum" && run.spectrum.segments() == 0)
    return "too short for a spectrum: 1024 cycles are needed";
  if (kind == "timing" && run.turnaround_us.samples() == 0) return "no times of cycles";
  return std::nullopt;
}

class Drawing {
 public:
  explicit Drawing(const RunPlots& plots) : plots_(plots) {}

  /// `make` is given the file of the data as the script names it.
  template <class Make>
  void draw(const std::string& title, const Make& make) {
    const std::string name = distinct(file_name_of(title));
    const Picture picture = make(gnuplot_file(name + ".csv"));
    write_file(plots_.folder / (name + ".csv"), picture.data);
    drawn_.names.push_back(name);
    const auto failure = draw_with_gnuplot(plots_.folder, name + ".gp", plots_.formats,
                                           drawn_as(name, plots_.formats, plots_.size, picture.body));
    if (failure) drawn_.undrawn = failure;
  }
  void lack(const std::string& what) { drawn_.lacking.push_back(what); }
  DrawnPlots drawn() const { return drawn_; }

 private:
  /// Names that differ may have the same file name.
  std::string distinct(const std::string& name) const {
    std::string candidate = name;
    for (int number = 2; std::ranges::find(drawn_.names, candidate) != drawn_.names.end(); ++number)
      candidate = fmt::format("{}-{}", name, number);
    return candidate;
  }

  const RunPlots& plots_;
  DrawnPlots drawn_;
};

std::string label_of(const RunFigures& run) { return fmt::format("{}-{}", run.run, run.axis); }

/// The errors of all runs from the beginning of each.
Picture comparison(const std::vector<RunFigures>& runs, const std::string& data_file) {
  std::string data = "time_s,error_um,which\n";
  std::string body =
      "set xlabel 'time since the first cycle (s)'\nset ylabel 'error (um)'\nset key vertical maxrows "
      "4\nplot ";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::vector<PlotRow> rows = runs[i].rows.rows();
    for (const PlotRow& row : rows)
      data += fmt::format("{},{},{}\n", row.time_s - rows.front().time_s, row.error_um, i);
    body += fmt::format(
        "{}{} using 'time_s':(column('which') == {} ? column('error_um') : NaN) with lines "
        "ls {} dt 1 title {}",
        i == 0 ? "" : ", \\\n  ", data_file, i, i % 6 + 1,
        gnuplot_text(fmt::format("{}: RMS {:.4f} um", label_of(runs[i]), runs[i].error.rms_um())));
  }
  return {std::move(data), body + "\n"};
}

constexpr PictureSize demo_size{.width_mm = 240.0, .height_mm = 190.0};

/// Rows of this axis while tracking; acting(drive): the drive whose effect the sample of this row shows, of
/// some cycles before.
constexpr const char* demo_functions = R"(axis = {axis}
stroke = {stroke}
of(v) = (strcol('axis') eq axis && strcol('state') eq 'tracking' ? v : NaN)
lag = {lag}
size = int(lag) + 2
array D[size]
past(k) = D[1 + (n - 1 - k + size) % size]
acting(drive) = (strcol('axis') eq axis ? \
  (D[1 + n % size] = drive, n = n + 1, past(int(lag)) + (lag - int(lag)) * (past(int(lag) + 1) - past(int(lag)))) : NaN)
)";

constexpr const char* demo_panels = R"(n = 0
do for [k = 1:size] {{ D[k] = NaN }}
set multiplot layout 2,2 title {title}
set title 'The actuator: hysteresis'
set xlabel {drive}
set ylabel 'position (um)'
plot 'inverse+pi.csv' using (of(acting(column('drive')))):'position_um' with lines ls 2 dt 1 title 'measured'

set title 'Wanted against measured: before and after'
set xlabel 'reference (um)'
plot 'average.csv' using (of(column('reference_um'))):'position_um' with lines ls 5 title 'average (open loop)', \
     'inverse+pi.csv' using (of(column('reference_um'))):'position_um' with lines ls 1 title 'inverse+pi'

set title 'Tracking'
set xlabel 'time (s)'
set ylabel 'position (um)'
set xrange [{from}:{to}]
plot 'inverse+pi.csv' using (of(column('time_s'))):'reference_um' with lines ls 6 lw 2 title 'reference', \
     'pi.csv' using (of(column('time_s'))):'position_um' with lines ls 2 title 'pi', \
     'average+pi.csv' using (of(column('time_s'))):'position_um' with lines ls 3 title 'average+pi', \
     'inverse+pi.csv' using (of(column('time_s'))):'position_um' with lines ls 1 title 'inverse+pi'
set xrange [*:*]

set title 'Error'
set ylabel 'error (% of stroke)'
plot 'pi.csv' using (of(column('time_s'))):(100*column('error_um')/stroke) with lines ls 2 dt 1 title 'pi', \
     'average+pi.csv' using (of(column('time_s'))):(100*column('error_um')/stroke) with lines ls 3 dt 1 title 'average+pi', \
     'inverse+pi.csv' using (of(column('time_s'))):(100*column('error_um')/stroke) with lines ls 1 title 'inverse+pi'
unset multiplot
)";

/// acting() remembers the drives of the last cycles in a ring.
std::string demo_functions_of(const DemoPlot& plot) {
  return fmt::format(demo_functions, fmt::arg("axis", gnuplot_string(plot.axis)),
                     fmt::arg("stroke", plot.stroke_um),
                     fmt::arg("lag", fmt::format("{:.6f}", plot.delay_cycles)));
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
        drawing.draw(name,
                     [&run, &make = make](const std::string& data_file) { return make(run, data_file); });
    }
  if (is_wanted("comparison") && runs.size() > 1)
    drawing.draw("comparison", [&](const std::string& data_file) { return comparison(runs, data_file); });
  return drawing.drawn();
}

std::optional<std::string> draw(const DemoPlot& plot) {
  const std::string body =
      fmt::format(demo_panels, fmt::arg("title", gnuplot_text(plot.title)),
                  fmt::arg("drive", gnuplot_text(fmt::format("drive ({})", plot.drive_unit))),
                  fmt::arg("from", plot.from_s), fmt::arg("to", plot.to_s));
  const std::vector<std::string> formats{"svg", "png"};
  return draw_with_gnuplot(plot.directory, "demo.gp", formats,
                           "# gnuplot demo.gp: draws demo.svg and demo.png\n" + demo_functions_of(plot) +
                               drawn_as("demo", formats, demo_size, body));
}

}  // namespace hystcan::app
