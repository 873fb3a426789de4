#include "app/identification_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/gnuplot.h"
#include "app/output_file.h"
#include "identification/excerpt.h"

namespace hystcan::app {
namespace {

using identification::Comparison;
using identification::Identified;
using identification::Landscape;
using identification::Record;

constexpr const char* loops_script = R"(set key top left
set xlabel input_label
set ylabel output_label
plot for [k = 1:records] 'record.csv' using (of(k, 'input')):(of(k, 'output')) with lines lw 4 lc rgb '#f4b183' \
       title (k == 1 ? 'measured' : ''), \
     for [k = 1:records] 'record.csv' using (of(k, 'input')):(of(k, 'predicted')) with lines lw 1 lc rgb '#0060ad' \
       title (k == 1 ? 'model' : '')
)";

constexpr const char* residual_time_script = R"(set xlabel 'time [s]'
set ylabel 'measured - model [% of output span]'
set xzeroaxis lt 1 lw 1.5 lc rgb '#404040'
set multiplot layout records,1
do for [k = 1:records] {
  if (records > 1) { set title sprintf('record %d', k) }
  plot 'record.csv' using (of(k, 'time_s')):(100 * column('residual') / span) with lines lc rgb '#0060ad' notitle
}
unset multiplot
)";

constexpr const char* residual_input_script = R"(set xlabel input_label
set ylabel 'measured - model [% of output span]'
set xzeroaxis lt 1 lw 1.5 lc rgb '#404040'
set key top left
# the way that the input goes, at rest the way it went last
before = way = NaN
way_of(v) = (way = (v > before ? 1 : v < before ? -1 : way), before = v, way)
plot 'record.csv' using (way_of(column('input')) > 0 ? column('input') : NaN):(100 * column('residual') / span) \
       with points pt 7 ps 0.25 lc rgb '#c05020' title 'rising', \
     'record.csv' using (way_of(column('input')) < 0 ? column('input') : NaN):(100 * column('residual') / span) \
       with points pt 7 ps 0.25 lc rgb '#0060ad' title 'falling'
)";

constexpr const char* curves_script = R"(set key top left
set lmargin at screen 0.13
set arrow 1 from first observed_lo, graph 0 to first observed_lo, graph 1 nohead dt 3 lw 1.5 lc rgb '#404040'
set arrow 2 from first observed_hi, graph 0 to first observed_hi, graph 1 nohead dt 3 lw 1.5 lc rgb '#404040'
set xrange [thresholds_lo:thresholds_hi]
set xlabel input_label
set multiplot layout 2,1
set ylabel output_label
plot for [k = 1:records] 'record.csv' using (of(k, 'input')):(of(k, 'output')) with lines lw 1 lc rgb '#d0d0d0' \
       title (k == 1 ? 'measured' : ''), \
     'curves.csv' using (column('input')):(column('ascending')) with lines lw 2 lc rgb '#c05020' title 'ascending', \
     '' using (column('input')):(column('descending')) with lines lw 2 lc rgb '#0060ad' title 'descending', \
     NaN with lines dt 3 lw 1.5 lc rgb '#404040' title 'ends of the inputs observed'
set ylabel 'descending - ascending [% of output span]'
set yrange [0:*]
plot 'curves.csv' using (column('input')):(100 * (column('descending') - column('ascending')) / span) \
       with lines lw 2 lc rgb '#404040' title 'distance of the curves'
unset multiplot
)";

constexpr const char* landscape_script = R"(set view map
set key outside top center horizontal
set xlabel 'k ascending, times the span of the thresholds'
set ylabel 'k descending, times the span of the thresholds'
set cblabel 'RMS [% of output span]; dearer ones in the last colour'
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
set contour base
set cntrparam levels discrete 105 * least / span, 150 * least / span
set cntrlabel onecolor
set label 1 '' at first x_best, first y_best, first 0 point pt 2 ps 1.5 lw 3 lc rgb 'white' front
splot 'landscape.csv' using (place(column('k_ascending'))):(place(column('k_descending'))):(100 * column('rms') / span) \
        with pm3d nocontour notitle, \
      '' using (place(column('k_ascending'))):(place(column('k_descending'))):(100 * column('rms') / span) \
        with lines nosurface lw 2 lc rgb 'white' title 'lines: 1.05 and 1.5 times the least; cross: the model'
)";

std::string labelled(const std::string& what, const std::string& unit) {
  return gnuplot_text(unit.empty() ? what : fmt::format("{} [{}]", what, unit));
}

std::string setting(const char* name, double value) { return fmt::format("{} = {:.9g}\n", name, value); }

// Terminal, names and numbers that the scripts use.
std::string preamble(const std::string& name, int height, std::size_t records, const Identified& identified) {
  const model::HysteresisParameters& p = identified.parameters;
  return fmt::format("# gnuplot {0}.gp: draws {0}.svg\n", name) +
         fmt::format("set terminal svg size 1000,{} noenhanced font 'sans,16' background 'white'\n", height) +
         fmt::format("set output '{}.svg'\n", name) +
         "set datafile separator ','\nset datafile missing NaN\nset grid lc rgb '#c0c0c0'\n" +
         fmt::format("records = {}\ninput_label = {}\noutput_label = {}\n", records,
                     labelled("input", p.input_unit), labelled("output", p.output_unit)) +
         setting("span", identified.output_span) + setting("thresholds_lo", p.input_range().lo) +
         setting("thresholds_hi", p.input_range().hi) + setting("observed_lo", identified.observed.lo) +
         setting("observed_hi", identified.observed.hi) +
         "of(k, name) = (column('record') == k ? column(name) : NaN)\n";
}

// The colours end at four times the least: where the best is would not be seen otherwise.
std::string of_landscape(const Landscape& map, const Identified& identified) {
  const double span = identified.parameters.input_range().span();
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const auto& row : map.rms)
    for (const double rms : row) {
      least = std::min(least, rms);
      most = std::max(most, rms);
    }
  const auto place = [&](double k) { return std::asinh(k * span); };
  return "place(k) = asinh(k * (thresholds_hi - thresholds_lo))\n" + setting("least", least) +
         setting("top", std::min(most, 4.0 * least)) + setting("x_lo", place(map.k_ascending.front())) +
         setting("x_hi", place(map.k_ascending.back())) + setting("y_lo", place(map.k_descending.front())) +
         setting("y_hi", place(map.k_descending.back())) +
         setting("x_best", place(identified.parameters.k_ascending)) +
         setting("y_best", place(identified.parameters.k_descending));
}

std::string unit_lines(const Identified& identified) {
  std::string lines;
  const auto add = [&](const char* key, const std::string& unit) {
    if (!unit.empty()) lines += fmt::format("# {} = {}\n", key, unit);
  };
  add("input_unit", identified.parameters.input_unit);
  add("output_unit", identified.parameters.output_unit);
  return lines;
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

std::string record_rows(const std::vector<Record>& records, const Identified& identified) {
  const model::Hysteresis hysteresis(identified.parameters);
  const bool even = identified.parameters.symmetry == model::Symmetry::even;
  const std::size_t stride = samples_per_row(records);
  std::string rows = unit_lines(identified) + "time_s,input,output,predicted,residual,record\n";
  for (std::size_t r = 0; r < records.size(); ++r) {
    const Record& record = records[r];
    const auto predicted = identification::predict(hysteresis, even ? folded(record) : record,
                                                   identified.delay_s, identified.memories[r]);
    const auto miss = [&](std::size_t i) { return std::abs(record.output[i] - predicted[i]); };
    for (std::size_t begin = 0; begin < record.size(); begin += stride) {
      std::size_t i = begin;
      for (std::size_t j = begin; j < std::min(begin + stride, record.size()); ++j)
        if (miss(j) > miss(i)) i = j;
      rows += fmt::format("{:.12g},{:.9g},{:.9g},{:.9g},{:.6g},{}\n", record.time_s[i], record.input[i],
                          record.output[i], predicted[i], record.output[i] - predicted[i], r + 1);
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
    rows += fmt::format("{:.9g},{:.9g},{:.9g}\n", v, p.ascending.value(v), p.descending.value(v));
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

}  // namespace

const std::vector<Picture>& pictures() {
  static const std::vector<Picture> all{
      {"loops", "Loops",
       "Measured and modelled output over the input. Where the model is right, its line lies within the "
       "measured one."},
      {"residual_time", "Residual over time",
       "What the model leaves unexplained. A slope is drift or creep; a residual that grows or shrinks at "
       "the "
       "beginning is an initial memory that was not met."},
      {"residual_input", "Residual over input",
       "Rising and falling apart: a wave that both have is the order of the curves; a loop between the two "
       "is "
       "a delay or a dependence on the rate; a fan at one end is a threshold."},
      {"curves", "Reference curves",
       "The two curves that all branches are made from, between the thresholds, and how far they are apart. "
       "Beyond the inputs observed they are extrapolated."},
      {"landscape", "Landscape of k",
       "RMS of the best curves at each pair of k, all else as identified. A long valley is a k that the "
       "record "
       "does not tell."}};
  return all;
}

std::size_t samples_per_row(const std::vector<Record>& records) {
  std::size_t samples = 0;
  for (const Record& record : records) samples += record.size();
  return std::max<std::size_t>(1, (samples + most_plotted - 1) / most_plotted);
}

void write_numbers(const std::filesystem::path& directory, const std::vector<Record>& records,
                   const Identified& identified, const Comparison& comparison,
                   const std::optional<Landscape>& landscape) {
  write_file(directory / "record.csv", record_rows(records, identified));
  write_file(directory / "curves.csv", curve_rows(identified));
  write_file(directory / "comparison.csv", comparison_rows(comparison));
  if (landscape) write_file(directory / "landscape.csv", landscape_rows(*landscape, identified));
}

std::string draw_pictures(const std::filesystem::path& directory, std::size_t records,
                          const Identified& identified, const std::optional<Landscape>& landscape) {
  std::string undrawn;
  const auto draw = [&](const std::string& name, int height, const std::string& script) {
    const std::string why =
        draw_with_gnuplot(directory, name + ".gp", preamble(name, height, records, identified) + script);
    if (undrawn.empty()) undrawn = why;
  };
  draw("loops", 700, loops_script);
  draw("residual_time", static_cast<int>(std::max<std::size_t>(400, 300 * records)), residual_time_script);
  draw("residual_input", 500, residual_input_script);
  draw("curves", 900, curves_script);
  if (landscape) draw("landscape", 750, of_landscape(*landscape, identified) + landscape_script);
  return undrawn;
}

}  // namespace hystcan::app
