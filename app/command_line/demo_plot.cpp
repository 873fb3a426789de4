#include "app/command_line/demo_plot.h"

#include <fmt/format.h>

#include "app/stage/gnuplot.h"

namespace hystcan::app {
namespace {

constexpr PictureSize demo_size{.width_mm = 240.0, .height_mm = 190.0};

/// Rows of this axis while tracking; acting(drive): the drive whose effect the sample of this row shows, of some cycles before.
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
std::string functions(const DemoPlot& plot) {
  return fmt::format(demo_functions, fmt::arg("axis", gnuplot_string(plot.axis)),
                     fmt::arg("stroke", plot.stroke_um),
                     fmt::arg("lag", fmt::format("{:.6f}", plot.delay_cycles)));
}

}  // namespace

std::string draw(const DemoPlot& plot) {
  const std::string body =
      fmt::format(demo_panels, fmt::arg("title", gnuplot_text(plot.title)),
                  fmt::arg("drive", gnuplot_text(fmt::format("drive ({})", plot.drive_unit))),
                  fmt::arg("from", plot.from_s), fmt::arg("to", plot.to_s));
  const std::vector<std::string> formats{"svg", "png"};
  return draw_with_gnuplot(plot.directory, "demo.gp", formats,
                           "# gnuplot demo.gp: draws demo.svg and demo.png\n" + functions(plot) +
                               drawn_as("demo", formats, demo_size, body));
}

}  // namespace hystcan::app
