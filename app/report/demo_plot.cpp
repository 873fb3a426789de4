#include "app/report/demo_plot.h"

#include <fmt/format.h>

#include "app/report/gnuplot.h"

namespace hystcan::app {
namespace {

constexpr const char* script_template = R"(# gnuplot demo.gp: draws demo.svg and demo.png
set datafile separator ','
axis = '{axis}'
stroke = {stroke}
# rows of this axis while tracking
set datafile missing NaN
of(v) = (strcol('axis') eq axis && strcol('state') eq 'tracking' ? v : NaN)
# the drive that has acted when a position is measured: the command of two cycles before
d0 = d1 = d2 = NaN
acting(drive) = (strcol('axis') eq axis ? (d2 = d1, d1 = d0, d0 = drive, d2) : NaN)

do for [terminal in "svg png"] {{
  if (terminal eq 'svg') {{ set terminal svg size 1200,900 enhanced background 'white'; set output 'demo.svg' }}
  if (terminal eq 'png') {{ set terminal pngcairo size 1200,900 enhanced; set output 'demo.png' }}
  set multiplot layout 2,2 title '{title}'
  set grid
  set key default
  set key inside top left

  set title 'The actuator: hysteresis'
  set xlabel 'drive [{unit}]'
  set ylabel 'position [um]'
  plot 'inverse+pi.csv' using (of(acting(column('drive')))):(column('position_um')) with lines lc rgb '#c05020' title 'measured'

  set title 'Wanted against measured: before and after'
  set xlabel 'reference [um]'
  plot 'average.csv' using (of(column('reference_um'))):(column('position_um')) with lines \
         lc rgb '#999999' title 'average (open loop)', \
       'inverse+pi.csv' using (of(column('reference_um'))):(column('position_um')) with lines \
         lc rgb '#0060ad' title 'inverse+pi'

  set key above
  set title 'Tracking'
  set xlabel 'time [s]'
  set xrange [{from}:{to}]
  plot 'inverse+pi.csv' using (of(column('time_s'))):(column('reference_um')) with lines lw 2 lc rgb 'black' title 'reference', \
       'pi.csv' using (of(column('time_s'))):(column('position_um')) with lines lc rgb '#c05020' title 'pi', \
       'average+pi.csv' using (of(column('time_s'))):(column('position_um')) with lines lc rgb '#50a050' title 'average+pi', \
       'inverse+pi.csv' using (of(column('time_s'))):(column('position_um')) with lines lc rgb '#0060ad' title 'inverse+pi'
  set xrange [*:*]

  set title 'Error'
  set ylabel 'error [% of stroke]'
  plot 'pi.csv' using (of(column('time_s'))):(100*column('error_um')/stroke) with lines lc rgb '#c05020' title 'pi', \
       'average+pi.csv' using (of(column('time_s'))):(100*column('error_um')/stroke) with lines lc rgb '#50a050' title 'average+pi', \
       'inverse+pi.csv' using (of(column('time_s'))):(100*column('error_um')/stroke) with lines lc rgb '#0060ad' title 'inverse+pi'
  unset multiplot
  unset output
}}
)";

}  // namespace

std::string draw(const DemoPlot& plot) {
  return draw_with_gnuplot(
      plot.directory, "demo.gp",
      fmt::format(script_template, fmt::arg("axis", plot.axis), fmt::arg("stroke", plot.stroke_um),
                  fmt::arg("title", plot.title), fmt::arg("unit", plot.drive_unit),
                  fmt::arg("from", plot.from_s), fmt::arg("to", plot.to_s)));
}

}  // namespace hystcan::app
