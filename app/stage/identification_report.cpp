#include "app/stage/identification_report.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <system_error>

#include "app/stage/gnuplot.h"
#include "app/stage/new_folder.h"
#include "base/error.h"
#include "base/output_file.h"
#include "config/schema/config.h"
#include "identification/determination.h"

namespace hystcan::app {
namespace {

using identification::Comparison;
using identification::Dataset;
using identification::Identified;
using identification::Landscape;

std::string unit_lines(const Identified& identified) {
  std::string lines;
  const auto add = [&](const char* key, const std::string& unit) {
    if (!unit.empty()) lines += fmt::format("# {} = {}\n", key, unit);
  };
  add("input_unit", identified.parameters.input_unit);
  add("output_unit", identified.parameters.output_unit);
  return lines;
}

std::string record_rows(const std::vector<Dataset>& datasets, const Identified& identified) {
  const std::size_t stride = samples_per_row(datasets);
  std::string rows = unit_lines(identified) + "time_s,input,output,predicted,residual,record\n";
  for (std::size_t r = 0; r < datasets.size(); ++r) {
    const Dataset& dataset = datasets[r];
    const auto predicted = identification::predict(identified, datasets, r);
    const auto miss = [&](std::size_t i) { return std::abs(dataset.output[i] - predicted[i]); };
    for (std::size_t begin = 0; begin < dataset.size(); begin += stride) {
      std::size_t i = begin;
      for (std::size_t j = begin; j < std::min(begin + stride, dataset.size()); ++j)
        if (miss(j) > miss(i)) i = j;
      rows += fmt::format("{:.12g},{:.9g},{:.9g},{:.9g},{:.6g},{}\n", dataset.time_s[i], dataset.input[i],
                          dataset.output[i], predicted[i], dataset.output[i] - predicted[i], r + 1);
    }
  }
  return rows;
}

std::string curve_rows(const Identified& identified) {
  constexpr int points = 400;
  const model::HysteresisParameters& p = identified.parameters;
  std::string rows = unit_lines(identified) + "input,ascending,descending\n";
  for (int i = 0; i <= points; ++i) {
    const double v = p.input_range().lo + p.input_range().span() * i / points;
    rows += fmt::format("{:.9g},{:.9g},{:.9g}\n", v, p.output(p.ascending.value(v)),
                        p.output(p.descending.value(v)));
  }
  return rows;
}

// An empty line between the rows of the map, as gnuplot wants it.
std::string landscape_rows(const Landscape& map, const Identified& identified) {
  std::string rows = unit_lines(identified) + "k_ascending,k_descending,rms\n";
  for (std::size_t i = 0; i < map.k_descending.size(); ++i) {
    for (std::size_t j = 0; j < map.k_ascending.size(); ++j)
      rows += fmt::format("{:.9g},{:.9g},{:.6g}\n", map.k_ascending[j], map.k_descending[i], map.rms[i][j]);
    if (i + 1 < map.k_descending.size()) rows += "\n";
  }
  return rows;
}

std::string comparison_rows(const Comparison& comparison) {
  std::string rows =
      "model,parameters,fit_rms_percent,fit_max_percent,held_out_rms_percent,held_out_max_percent\n";
  const auto percent = [&](double error) { return 100.0 * error / comparison.output_span; };
  for (const auto& row : comparison.rows) {
    rows += fmt::format("\"{}\",{},{:.6g},{:.6g},", row.name, row.parameters, percent(row.fit.rms),
                        percent(row.fit.max));
    rows += row.held_out
                ? fmt::format("{:.6g},{:.6g}\n", percent(row.held_out->rms), percent(row.held_out->max))
                : ",\n";
  }
  return rows;
}

void write_numbers(const std::filesystem::path& directory, const std::vector<Dataset>& datasets,
                   const Identified& identified, const Comparison& comparison,
                   const std::optional<Landscape>& landscape) {
  write_file(directory / "record.csv", record_rows(datasets, identified));
  write_file(directory / "curves.csv", curve_rows(identified));
  write_file(directory / "comparison.csv", comparison_rows(comparison));
  if (landscape) write_file(directory / "landscape.csv", landscape_rows(*landscape, identified));
}

constexpr const char* loops_script = R"(set xlabel input_label
set ylabel output_label
plot for [k = 1:datasets] 'record.csv' using (of(k, 'input')):(of(k, 'output')) with lines lw 4 lc rgb '#e69f00' \
       title (k == 1 ? 'measured' : ''), \
     for [k = 1:datasets] 'record.csv' using (of(k, 'input')):(of(k, 'predicted')) with lines lw 1.5 lc rgb '#0072b2' \
       title (k == 1 ? 'model' : '')
)";

constexpr const char* residual_time_script = R"(set xlabel 'time [s]'
set ylabel 'measured - model [% of span]'
set xzeroaxis lt 1 lw 1.5 lc rgb '#404040'
set autoscale xfix
set lmargin at screen 0.12
set multiplot layout datasets,1
do for [k = 1:datasets] {
  if (datasets > 1) { set title sprintf('dataset %d', k) }
  plot 'record.csv' using (of(k, 'time_s')):(100 * column('residual') / span) with lines lc rgb '#0072b2' notitle
}
unset multiplot
)";

constexpr const char* residual_input_script = R"(set xlabel input_label
set ylabel 'measured - model [% of span]'
set xzeroaxis lt 1 lw 1.5 lc rgb '#404040'
stats 'record.csv' using (column('residual')) nooutput
size = STATS_records > 2000 ? 0.25 : 0.6
# the way that the input goes; at rest, the way it went last
before = way = NaN
way_of(v) = (way = (v > before ? 1 : v < before ? -1 : way), before = v, way)
plot 'record.csv' using (way_of(column('input')) > 0 ? column('input') : NaN):(100 * column('residual') / span) \
       with points pt 7 ps size lc rgb '#d55e00' notitle, \
     'record.csv' using (way_of(column('input')) < 0 ? column('input') : NaN):(100 * column('residual') / span) \
       with points pt 7 ps size lc rgb '#0072b2' notitle, \
     NaN with points pt 7 lc rgb '#d55e00' title 'rising', \
     NaN with points pt 7 lc rgb '#0072b2' title 'falling'
)";

constexpr const char* curves_script = R"(set lmargin at screen 0.13
set arrow 1 from first observed_lo, graph 0 to first observed_lo, graph 1 nohead dt 3 lw 1.5 lc rgb '#404040'
set arrow 2 from first observed_hi, graph 0 to first observed_hi, graph 1 nohead dt 3 lw 1.5 lc rgb '#404040'
set xrange [thresholds_lo:thresholds_hi]
set xlabel input_label
set multiplot layout 2,1
# extrapolated curves may leave far behind what was measured: cut off half a span beyond it
stats 'record.csv' using (column('output')) nooutput
set yrange [STATS_min - 0.5 * span < * : * < STATS_max + 0.5 * span]
set ylabel output_label
plot for [k = 1:datasets] 'record.csv' using (of(k, 'input')):(of(k, 'output')) with lines lw 1 lc rgb '#d0d0d0' \
       title (k == 1 ? 'measured' : ''), \
     'curves.csv' using (column('input')):(column('ascending')) with lines lw 2 lc rgb '#d55e00' title 'ascending', \
     'curves.csv' using (column('input')):(column('descending')) with lines lw 2 lc rgb '#0072b2' title 'descending', \
     NaN with lines dt 3 lw 1.5 lc rgb '#404040' title 'ends of the inputs observed'
set yrange [0:*]
set ylabel 'distance [% of span]'
plot 'curves.csv' using (column('input')):(100 * (column('descending') - column('ascending')) / span) \
       with lines lw 2 lc rgb '#404040' title 'descending - ascending'
unset multiplot
)";

constexpr const char* landscape_script = R"(set view map
set title 'lines: 1.05 and 1.5 times the least; cross: the model'
set lmargin at screen 0.1
set rmargin at screen 0.83
set tmargin at screen 0.93
set bmargin at screen 0.12
set xlabel 'k ascending, times the span of the thresholds'
set ylabel 'k descending, times the span of the thresholds'
set cblabel (cut ? 'RMS [% of output span], cut off at the last colour' : 'RMS [% of output span]') offset 1
set palette defined (0 '#440154', 1 '#3b528b', 2 '#21918c', 3 '#5ec962', 4 '#fde725')
do for [axis in 'x y'] {
  eval 'set '.axis.'tics ()'
  do for [k in '-300 -100 -30 -10 -3 -1 -0.3 0 0.3 1 3 10 30 100 300'] {
    eval sprintf('set %stics add (''%s'' %g)', axis, k, asinh(real(k)))
  }
}
set xrange [x_lo:x_hi]
set yrange [y_lo:y_hi]
set cbrange [100 * least / span : 100 * top / span]
set pm3d interpolate 4,4
set contour base
set cntrparam levels discrete 105 * least / span, 150 * least / span
set cntrlabel onecolor
set label 1 '' at first x_best, first y_best, first 0 point pt 2 ps 1.5 lw 3 lc rgb 'white' front
splot 'landscape.csv' using (place(column('k_ascending'))):(place(column('k_descending'))):(100 * column('rms') / span) \
        with pm3d nocontour notitle, \
      'landscape.csv' using (place(column('k_ascending'))):(place(column('k_descending'))):(100 * column('rms') / span) \
        with lines nosurface lw 2 lc rgb 'white' notitle
)";

std::string labelled(const std::string& what, const std::string& unit) {
  return gnuplot_text(unit.empty() ? what : fmt::format("{} [{}]", what, unit));
}

std::string setting(const char* name, double value) { return fmt::format("{} = {:.9g}\n", name, value); }

// The terminal, names and numbers that the scripts use.
std::string preamble(const std::string& name, int height, std::size_t datasets,
                     const Identified& identified) {
  const model::HysteresisParameters& p = identified.parameters;
  return fmt::format("# gnuplot {0}.gp: draws {0}.svg\n", name) +
         fmt::format("set terminal svg size 1000,{} enhanced font 'sans,16' background 'white'\n", height) +
         fmt::format("set output {}\n", gnuplot_file(name + ".svg")) +
         "set datafile separator ','\nset datafile missing NaN\nset border 3 lw 0.6\nset tics nomirror out "
         "scale 0.6\nset grid lw 0.4 lc rgb '#dddddd'\nset key outside top center horizontal\n" +
         fmt::format("datasets = {}\ninput_label = {}\noutput_label = {}\n", datasets,
                     labelled("input", p.input_unit), labelled("output", p.output_unit)) +
         setting("span", identified.output_span) + setting("thresholds_lo", p.input_range().lo) +
         setting("thresholds_hi", p.input_range().hi) + setting("observed_lo", identified.observed.lo) +
         setting("observed_hi", identified.observed.hi) +
         "of(k, name) = (column('record') == k ? column(name) : NaN)\n";
}

// The colour scale ends at four times the least error; otherwise the place of the minimum would not be
// visible.
std::string of_landscape(const Landscape& map, const Identified& identified) {
  const double span = identified.parameters.input_range().span();
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const auto& row : map.rms)
    for (const double rms : row) {
      least = std::min(least, rms);
      most = std::max(most, rms);
    }
  // gnuplot refuses a map whose colours have no range: where every k fits alike, or one fits exactly.
  const double top = std::max(std::min(most, 4.0 * least), least + 1e-6 * identified.output_span);
  const auto place = [&](double k) { return std::asinh(k * span); };
  return "place(k) = asinh(k * (thresholds_hi - thresholds_lo))\n" + setting("least", least) +
         setting("top", top) + setting("cut", most > top ? 1.0 : 0.0) +
         setting("x_lo", place(map.k_ascending.front())) + setting("x_hi", place(map.k_ascending.back())) +
         setting("y_lo", place(map.k_descending.front())) + setting("y_hi", place(map.k_descending.back())) +
         setting("x_best", place(identified.parameters.k_ascending)) +
         setting("y_best", place(identified.parameters.k_descending));
}

/// Draws every plot whose numbers exist. Returns why one was not drawn.
std::optional<std::string> draw_pictures(const std::filesystem::path& directory, std::size_t datasets,
                                         const Identified& identified,
                                         const std::optional<Landscape>& landscape) {
  std::optional<std::string> undrawn;
  const auto draw = [&](const std::string& name, int height, const std::string& script) {
    const auto why = draw_with_gnuplot(directory, name + ".gp", {"svg"},
                                       preamble(name, height, datasets, identified) + script);
    if (!undrawn) undrawn = why;
  };
  draw("loops", 700, loops_script);
  draw("residual_time", static_cast<int>(std::max<std::size_t>(400, 340 * datasets)), residual_time_script);
  draw("residual_input", 500, residual_input_script);
  draw("curves", 900, curves_script);
  if (landscape) draw("landscape", 750, of_landscape(*landscape, identified) + landscape_script);
  return undrawn;
}

constexpr int landscape_points = 21;

/// Files of an earlier report that this one does not have are removed.
void move_files(const std::filesystem::path& from, const std::filesystem::path& to) {
  for (const std::string& name : report_files()) {
    std::error_code error;
    if (std::filesystem::exists(from / name))
      std::filesystem::rename(from / name, to / name, error);
    else
      std::filesystem::remove(to / name, error);
    if (error)
      throw RunError(fmt::format("{}: cannot be replaced: {}", (to / name).string(), error.message()));
  }
}

}  // namespace

std::size_t samples_per_row(const std::vector<Dataset>& datasets) {
  std::size_t samples = 0;
  for (const Dataset& dataset : datasets) samples += dataset.size();
  return std::max<std::size_t>(1, (samples + most_plotted - 1) / most_plotted);
}

const std::vector<Picture>& pictures() {
  static const std::vector<Picture> all{
      {"loops", "Loops",
       "Measured and modelled output over the input. If the model is right, its line lies within the "
       "measured one."},
      {"residual_time", "Residual over time",
       "The part of the output that the model does not explain. A slope is drift or creep; a residual that "
       "grows or shrinks at the beginning comes from a wrong initial memory."},
      {"residual_input", "Residual over input",
       "Rising and falling input separately. A wave that both have shows that the order of the curves is too "
       "low; a loop between the two shows a delay or a dependence on the rate; a fan at one end shows a "
       "wrong threshold."},
      {"curves", "Reference curves",
       "The two curves from which all branches are made, between the thresholds, and their distance. Beyond "
       "the observed inputs they are extrapolated."},
      {"landscape", "Landscape of k",
       "RMS of the best curves at each pair of k, with all other parameters as identified. A long valley is "
       "a k that the dataset does not determine."}};
  return all;
}

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

std::optional<std::string> write_report(const std::filesystem::path& directory, IdentificationReport report,
                                        const std::function<bool()>& go_on) {
  create_folder(directory);
  report.comparison = identification::compare(report.datasets, report.identified, go_on);
  std::optional<identification::Landscape> map;
  if (go_on()) map = identification::landscape(report.datasets, report.identified, landscape_points);
  const NewFolder whole(directory / "report.new");  // until it is, an earlier one stays
  write_numbers(whole.path(), report.datasets, report.identified, report.comparison, map);
  report.undrawn = draw_pictures(whole.path(), report.datasets.size(), report.identified, map);
  write_file(whole.path() / "report.html", page_of(whole.path(), report));
  move_files(whole.path(), directory);
  return report.undrawn;
}

}  // namespace hystcan::app
