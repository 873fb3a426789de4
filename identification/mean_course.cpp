#include "identification/mean_course.h"

#include <algorithm>
#include <cstddef>

namespace hystcan::identification {
namespace {

struct Sample {
  double input, output, weight;
};

// Neighbours whose mean outputs fall are pooled, until none does.
std::vector<Sample> pooled(std::vector<Sample> samples) {
  std::ranges::sort(samples, {}, &Sample::input);
  std::vector<Sample> blocks;
  for (const Sample& sample : samples) {
    blocks.push_back(sample);
    while (blocks.size() > 1 && blocks[blocks.size() - 2].output >= blocks.back().output) {
      const Sample last = blocks.back();
      blocks.pop_back();
      Sample& before = blocks.back();
      const double weight = before.weight + last.weight, share = last.weight / weight;
      before = {before.input + share * (last.input - before.input),
                before.output + share * (last.output - before.output), weight};
    }
  }
  return blocks;
}

}  // namespace

MeanCourse::MeanCourse(const Problem& problem, const Trial& trial, const std::vector<double>& offsets) {
  std::array<std::vector<Sample>, 2> samples;
  for (std::size_t i = 0; i < problem.excerpts.size(); ++i) {
    const Excerpt::Sequence sequence =
        problem.excerpts[i].delayed_by(trial.delay_s, model::OutputCreep(creep_of(trial.creep_per_decade)));
    std::size_t way = 0;
    for (std::size_t j = 0; j < sequence.input.size(); ++j) {
      if (j > 0 && sequence.input[j] != sequence.input[j - 1])
        way = sequence.input[j] > sequence.input[j - 1] ? 0 : 1;
      if (sequence.fold[j] != Regression::left_out && sequence.weight[j] > 0.0)
        samples[way].push_back({sequence.input[j], (sequence.output[j] - offsets[i]) / trial.gain(i),
                                sequence.weight[j] * sequence.weight[j]});
    }
  }
  for (std::size_t way = 0; way < samples.size(); ++way)
    for (const Sample& block : pooled(std::move(samples[way]))) {
      courses_[way].input.push_back(block.input);
      courses_[way].output.push_back(block.output);
    }
}

double MeanCourse::operator()(double input) const {
  double sum = 0.0, count = 0.0;
  for (const Course& course : courses_) {
    if (course.input.empty()) continue;
    const auto after =
        static_cast<std::size_t>(std::ranges::lower_bound(course.input, input) - course.input.begin());
    count += 1.0;
    if (after == 0 || after == course.input.size()) {
      sum += after == 0 ? course.output.front() : course.output.back();
      continue;
    }
    const double part = (input - course.input[after - 1]) / (course.input[after] - course.input[after - 1]);
    sum += course.output[after - 1] + part * (course.output[after] - course.output[after - 1]);
  }
  return sum / count;
}

}  // namespace hystcan::identification
