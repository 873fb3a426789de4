#include "app/stage/identification_report.h"

#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "base/text.h"

namespace hystcan::app {
namespace {

using identification::Comparison;
using identification::ComparisonRow;
using identification::Identified;
using identification::InitialMemory;
using identification::SearchResult;

std::string escaped(std::string_view text) {
  return with_replaced(text, {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}});
}

std::string number_cell(const std::string& text, bool best = false) {
  return fmt::format("<td class=\"number{}\">{}</td>", best ? " best" : "", escaped(text));
}

/// Returns the heading row of a table. The first column contains text, the other columns contain numbers.
std::string heading_row(const std::vector<std::string>& headings) {
  std::string row = "<tr>";
  for (std::size_t i = 0; i < headings.size(); ++i)
    row += fmt::format("<th{}>{}</th>", i == 0 ? "" : " class=\"number\"", escaped(headings[i]));
  return row + "</tr>\n";
}

std::string error_cell(double error, const Identified& identified) {
  return number_cell(fmt::format("{:.3g}", error * (100.0 / identified.output_span)));
}

std::string left_out_of(const IdentificationReport& report) {
  const std::vector<identification::LeftOut>& left_out = report.identified.left_out;
  if (left_out.empty()) return {};
  std::string part =
      "<table>\n" +
      heading_row({"record left out", "prediction from the other records, RMS [%]", "moves [%] more"});
  for (std::size_t i = 0; i < left_out.size(); ++i)
    if (const identification::LeftOut& of = left_out[i]; of.samples > 0.0)
      part += fmt::format("<tr><td>{}</td>", escaped(report.names[i])) +
              error_cell(of.rms(), report.identified) +
              number_cell(fmt::format("{:+.2g}", 100.0 * (of.gain - 1.0))) + "</tr>\n";
  return part +
         "</table>\n<p class=\"note\">Each record is predicted by the curves of the other records, "
         "with its own zero and the mean gain of the other records. "
         "The values of k (convergence rate), thresholds, delay, creep and initial memories "
         "come from all records. "
         "Cycles whose inputs exceed the inputs of the other records do not count.</p>\n";
}

/// Returns a table of the model structures that the search tried. It shows which parts of a model lower the
/// error of the held-out data. Empty if no data was held out.
std::string structures_of(const IdentificationReport& report) {
  const Identified& identified = report.identified;
  const SearchResult& search = identified.search;
  if (!identified.held_out_rms) return {};
  std::string part =
      "<h2>Selected structure</h2>\n<table>\n" +
      heading_row({"structure", "fit RMS [%]",
                   identified.left_out.empty() ? "held-out cycles RMS [%]" : "held-out records RMS [%]",
                   "selected"});
  const auto row = [&](const std::string& what, double rms, const std::optional<double>& held_out,
                       bool is_taken) {
    part += fmt::format("<tr><td>{}</td>", escaped(what)) + error_cell(rms, identified) +
            (held_out ? error_cell(*held_out, identified) : number_cell("")) +
            number_cell(is_taken ? "yes" : "no") + "</tr>\n";
  };
  const auto with_creep = [](const SearchResult& result) {
    const double creep = result.trial.creep_per_decade;
    return creep > 0.0
               ? fmt::format("all parameters, with a creep of {:.2g} % per decade of time", 100.0 * creep)
               : "all parameters, without creep";
  };
  for (const identification::Step& step : search.steps)
    row(to_string(step.quantity), step.rms_after, step.held_out_after, true);
  for (const identification::Step& step : search.refused)
    row(to_string(step.quantity), step.rms_after, step.held_out_after, false);
  for (const identification::ShapeScore& tried : search.shapes)
    row(tried.shape.text(), tried.rms, tried.held_out, tried.shape.text() == search.shape.text());
  if (const auto& alternative = identified.alternative) {
    row(with_creep(search), search.rms, search.held_out, true);
    row(with_creep(*alternative), alternative->rms, alternative->held_out, false);
  }
  return part + "</table>\n" + left_out_of(report);
}

constexpr const char* head = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{0}</title>
<style>
body {{ font-family: sans-serif; line-height: 1.4; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #202020; }}
table {{ border-collapse: collapse; margin: 1em 0; }}
th, td {{ padding: 0.25em 0.8em; border-bottom: 1px solid #c0c0c0; text-align: left; vertical-align: top; }}
td.number, th.number {{ text-align: right; font-variant-numeric: tabular-nums; }}
td.best {{ font-weight: bold; background: #e4eef8; }}
tr.own td {{ border-bottom: 2px solid #404040; }}
img {{ width: 100%; }}
figure {{ margin: 1em 0; break-inside: avoid; }}
h2 {{ margin-top: 1.6em; break-after: avoid; }}
.note {{ color: #505050; font-size: 0.9em; }}
</style>
</head>
<body>
<h1>{0}</h1>
)";

std::string with_unit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}

std::string title_of(const IdentificationReport& report) {
  std::string title = "Identification of ";
  for (std::size_t i = 0; i < report.names.size(); ++i) title += (i == 0 ? "" : ", ") + report.names[i];
  return title;
}

std::string findings_of(const IdentificationReport& report) {
  std::string list;
  if (report.identified.stopped || report.comparison.stopped)
    list += "<p><strong>The search was stopped early: this is the best result so far.</strong></p>\n";
  if (report.findings.empty()) return list;
  list += "<h2>Findings</h2>\n<ul>\n";
  for (const std::string& finding : report.findings) list += fmt::format("<li>{}</li>\n", escaped(finding));
  return list + "</ul>\n";
}

// The functions from here on write the table of errors.

double percent(double error, const Comparison& comparison) { return 100.0 * error / comparison.output_span; }

// Returns one error of a row in output units; `nullopt` if the row does not have this error.
using ReadError = std::optional<double> (*)(const ComparisonRow&);
constexpr ReadError error_columns[] = {
    [](const ComparisonRow& row) { return std::optional(row.fit.rms); },
    [](const ComparisonRow& row) { return std::optional(row.fit.max); },
    [](const ComparisonRow& row) { return row.held_out ? std::optional(row.held_out->rms) : std::nullopt; },
    [](const ComparisonRow& row) { return row.held_out ? std::optional(row.held_out->max) : std::nullopt; }};

double least(const Comparison& comparison, ReadError read) {
  double least = std::numeric_limits<double>::infinity();
  for (const ComparisonRow& row : comparison.rows) least = std::min(least, read(row).value_or(least));
  return least;
}

std::string table_of(const Comparison& comparison) {
  const std::size_t columns = comparison.no_hold_out ? 2 : 4;
  std::vector<std::string> headings{"model",       "parameters",       "fit RMS [%]",
                                    "fit max [%]", "held out RMS [%]", "held out max [%]"};
  headings.resize(2 + columns);
  std::string table = "<table>\n" + heading_row(headings);
  for (const ComparisonRow& row : comparison.rows) {
    table += fmt::format("<tr{}><td>{}</td>", &row == &comparison.rows.front() ? " class=\"own\"" : "",
                         escaped(row.name));
    table += number_cell(fmt::format("{}", row.parameters));
    for (std::size_t i = 0; i < columns; ++i) {
      const auto error = error_columns[i](row);
      table += error ? number_cell(fmt::format("{:.3g}", percent(*error, comparison)),
                                   *error == least(comparison, error_columns[i]))
                     : number_cell("");
    }
    table += "</tr>\n";
  }
  return table + "</table>\n";
}

/// Returns a sentence about the cross-validated error, which is the error that `hystcan identify` prints.
std::string cross_validated(const Identified& identified) {
  if (!identified.held_out_rms) return {};
  return fmt::format(
      " The cross-validated error of the identified model is {:.3g} % RMS of the output's span "
      "(hystcan identify prints it, too). "
      "One cycle after the other was left out of the fit of the curves and then predicted, "
      "with the values of k (convergence rate), delay and thresholds from all samples.",
      100.0 * *identified.held_out_rms / identified.output_span);
}

std::string hold_out_of(const Identified& identified, const Comparison& comparison) {
  if (comparison.no_hold_out) return "Nothing was held out: " + *comparison.no_hold_out + ".";
  return fmt::format(
             "Held out: {} of {}, {} of {}: "
             "every second cycle, except those that are needed to reach the ends of the input range. "
             "Every model was fitted again without the held-out cycles and then predicted them. "
             "The identified model keeps the order that was found from all samples.",
             comparison.held_out_cycles, counted(comparison.cycles, "cycle"), comparison.held_out_samples,
             counted(comparison.samples, "sample")) +
         cross_validated(identified);
}

std::string comparison_of(const IdentificationReport& report) {
  const Comparison& comparison = report.comparison;
  std::string part = "<h2>Comparison</h2>\n";
  const std::string& unit = report.identified.parameters.output_unit;
  part += fmt::format(
      "<p>Errors in percent of the output's span, {}; the smallest of each column is marked.</p>\n",
      escaped(with_unit(fmt::format("{:.4g}", comparison.output_span), unit)));
  part += table_of(comparison);
  part += fmt::format("<p>{}</p>\n", escaped(hold_out_of(report.identified, comparison)));
  for (const std::string& refused : comparison.refused)
    part += fmt::format("<p>Not fitted: {}</p>\n", escaped(refused));
  part +=
      "<p class=\"note\">All models were fitted by least squares to the same samples, "
      "with the same delay and the same thresholds. "
      "Each model with memory was tried with several initial memories, and the best fit was kept. "
      "Initial memories are not counted as parameters. Exception: with a free start, "
      "the initial values of the plays are fitted and counted.</p>\n";
  return part;
}

// The functions from here on describe the model.

std::string memory_text(const InitialMemory& memory) {
  switch (memory.kind) {
    case InitialMemory::Kind::virgin:
      return "virgin";
    case InitialMemory::Kind::from_lower:
      return "from the lower threshold";
    case InitialMemory::Kind::from_upper:
      return "from the upper threshold";
    case InitialMemory::Kind::nested:
      break;
  }
  return fmt::format("nested loops, bias {:.3g}", memory.bias);
}

std::string pace_text(double k, model::Interval range, const Identified& identified) {
  const std::string& unit = identified.parameters.input_unit;
  return fmt::format(
      "{:.5g}{}, {:.4g} per span of the thresholds; {}", k, unit.empty() ? "" : " / " + unit,
      k * identified.parameters.input_range().span(),
      identified.stopped ? "the search was stopped"
      : identification::is_determined(range)
          ? fmt::format("from {:.3g} to {:.3g} the RMS error is at most 5 % larger", range.lo, range.hi)
          : "the dataset does not determine this value");
}

std::string model_of(const Identified& identified) {
  const model::HysteresisParameters& p = identified.parameters;
  std::string part = "<h2>The model</h2>\n<table>\n";
  const auto row = [&](const char* what, const std::string& value) {
    part += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", what, escaped(value));
  };
  row("symmetry", p.symmetry == model::Symmetry::even ? "even: x(v) = x(-v)"
                  : p.output_map ? "butterfly: an output map converts the curves to the output"
                                 : "none");
  row("reference curves", identified.search.shape.text());
  const auto interval = [&](model::Interval range) {
    return with_unit(fmt::format("{:.6g} to {:.6g}", range.lo, range.hi), p.input_unit);
  };
  row("thresholds", interval(p.input_range()));
  row("inputs observed", interval(identified.observed));
  row("k ascending", pace_text(p.k_ascending, identified.pace_ascending, identified));
  row("k descending", pace_text(p.k_descending, identified.pace_descending, identified));
  row("delay", fmt::format("{:.4g} s", identified.delay_s));
  row("parameters", fmt::format("{}", identified.parameter_count()));
  part += "</table>\n<table>\n" +
          heading_row({identified.search.shape.is_spline() ? "B-spline coefficient" : "Chebyshev coefficient",
                       "ascending", "descending"});
  const auto& up = p.ascending.coefficients();
  const auto& down = p.descending.coefficients();
  const auto term = [](const std::vector<double>& c, std::size_t j) {
    return number_cell(j < c.size() ? fmt::format("{:.9g}", c[j]) : "");
  };
  for (std::size_t j = 0; j < std::max(up.size(), down.size()); ++j)
    part += fmt::format("<tr><td>{}</td>{}{}</tr>\n", j, term(up, j), term(down, j));
  return part + "</table>\n";
}

std::string dataset_name(const IdentificationReport& report, std::size_t i) {
  return report.datasets.size() == 1 ? report.names[i] : fmt::format("{}: {}", i + 1, report.names[i]);
}

std::string datasets_of(const IdentificationReport& report) {
  const Identified& identified = report.identified;
  const auto in_percent = [&](double error) {
    return fmt::format("{:.3g}", 100.0 * error / identified.output_span);
  };
  std::string part =
      "<h2>Datasets</h2>\n<table>\n" + heading_row({"dataset", "samples", "duration [s]", "cycles",
                                                    "noise [%]", "repeatability [%]", "RMS [%]", "max [%]"});
  for (std::size_t i = 0; i < report.datasets.size(); ++i) {
    const identification::Characterisation& is = identified.datasets[i];
    part += fmt::format("<tr><td>{}</td>", escaped(report.names[i])) +
            number_cell(fmt::format("{}", is.samples)) + number_cell(fmt::format("{:.5g}", is.duration_s)) +
            number_cell(fmt::format("{}", is.cycles)) + number_cell(in_percent(is.noise)) +
            number_cell(is.repeatability ? in_percent(*is.repeatability) : "no repeat") +
            number_cell(in_percent(identified.errors[i].rms)) +
            number_cell(in_percent(identified.errors[i].max)) + "</tr>\n";
  }
  part += "</table>\n<p class=\"note\">In percent of the output's span. Initial memory: ";
  for (std::size_t i = 0; i < report.datasets.size(); ++i)
    part += fmt::format("{}{}, {}", i == 0 ? "" : "; ", escaped(dataset_name(report, i)),
                        memory_text(identified.memories[i]));
  return part + ".</p>\n";
}

// The functions from here on write the end of the page: the pictures, and links to the files of the report.

std::string pictures_of(const std::filesystem::path& directory, const IdentificationReport& report) {
  std::string part;
  for (const ReportPicture& picture : report_pictures()) {
    part += fmt::format("<h2>{}</h2>\n", picture.title);
    if (std::filesystem::exists(directory / (picture.name + ".svg")))
      part +=
          fmt::format("<figure><img src=\"{0}.svg\" alt=\"{1}\">\n<figcaption>{2}</figcaption></figure>\n",
                      picture.name, picture.title, picture.explanation);
    else if (report.undrawn)
      part += fmt::format(
          "<p>No picture: {}. "
          "To draw it: <code>python3 -m hystcan.plot pictures.json</code> in this folder.</p>\n",
          escaped(*report.undrawn));
    else
      part += "<p>No picture: the command was stopped before the picture was drawn.</p>\n";
  }
  return part;
}

std::string files_of(const std::filesystem::path& directory, const IdentificationReport& report) {
  const std::size_t stride = samples_per_row(report.datasets);
  std::string part = "<h2>Files</h2>\n<p>Beside this page:";
  for (const std::string& name : report_files())
    if (std::filesystem::exists(directory / name)) part += fmt::format(" <a href=\"{0}\">{0}</a>", name);
  part += ". Residuals are measured - model. ";
  part += stride == 1 ? "record.csv and the pictures show every sample."
                      : fmt::format(
                            "record.csv and the pictures show one of every {} samples, "
                            "the one with the largest residual. Errors and fits use all samples.",
                            stride);
  return part + "</p>\n</body>\n</html>\n";
}

}  // namespace

std::string page_of(const std::filesystem::path& directory, const IdentificationReport& report) {
  return fmt::format(head, escaped(title_of(report))) + findings_of(report) + structures_of(report) +
         comparison_of(report) + model_of(report.identified) + datasets_of(report) +
         pictures_of(directory, report) + files_of(directory, report);
}

}  // namespace hystcan::app
