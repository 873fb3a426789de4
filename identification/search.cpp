#include "identification/search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "base/text.h"
#include "identification/numerics/nonlinear_fit.h"
#include "identification/shape_choice.h"
#include "identification/unknowns.h"

namespace hystcan::identification {
namespace {

constexpr int first_order = 5;
constexpr double worth_it = 0.97;           // an added parameter must lower the error to this share
constexpr double promising = 0.995;         // where it is searched to the end
constexpr double worth_held_out = 0.985;    // and the held-out error to this share
constexpr double as_good = 1.05;            // a removed parameter may raise the error to this share
constexpr double low_enough = 1.01;         // times the smallest held-out error of all orders is low enough
constexpr double exact = 1e-6;              // of the output span: smaller errors do not count
constexpr double worth_a_spline = 0.9;      // of the held-out error with polynomials
constexpr double hopeless_spline = 1.25;    // of the error with polynomials, before its k are searched
constexpr double worth_an_input_map = 0.9;  // of the held-out error without it
constexpr double poor = 0.01;               // of the output span: with a polynomial that misses so much, the
                                            // other choices may be wrong, too
constexpr std::size_t usual_spline = 7;     // of those that are tried: 12 pieces
constexpr double worth_a_restart = 0.99;    // of the error before it
constexpr double widest_k_span = 200.0;     // with steep parts this is of them, not of the thresholds

using Kind = InitialMemory::Kind;

class Searcher {
 public:
  Searcher(const Problem& problem, const IdentifyOptions& options) : problem_(&problem), options_(options) {
    unknowns_ = both_k(best_);
    best_.delay_s = options_.delay_s.value_or(0.0);
    best_.creep_per_decade = options_.creep_per_decade.value_or(0.0);
  }

  SearchResult run(const Problem& finer) {
    const CurveShape first = CurveShape::polynomial(std::min(first_order, problem_->highest_order));
    const bool is_rich =
        options_.shape && !options_.shape->is_spline() && options_.shape->order > first_order;
    begin_with(is_rich ? first : options_.shape.value_or(first));
    if (!std::isfinite(best_cost_))
      refuse("no model fits with a finite error; expected a dataset that a model can describe");
    if (is_rich) {
      use(*options_.shape);
      best_cost_ = cost(best_);
    }
    if (!options_.shape) choose_order();
    finish();
    if (problem_->most_pieces > 1 && !options_.shape && options_.curves != CurveChoice::polynomial)
      try_splines();
    const std::optional<double> held_out = fit_->held_out(best_);
    polish(finer);
    SearchResult found = result_;
    found.trial = best_;
    found.shape = shape_;
    found.rms = fit_->fit(best_).rms;
    found.held_out = held_out;
    return found;
  }

 private:
  void begin_with(CurveShape shape) {
    use(std::move(shape));
    choose_memories();
    choose_k();
    refine(150);
    add_useful_unknowns();
  }

  void begin_again(const CurveShape& shape) {
    unknowns_ = both_k(best_);
    result_.steps.clear();
    result_.refused.clear();
    result_.one_k = false;
    best_.below = best_.above = 0.0;
    best_.gains.clear();
    best_.delay_s = options_.delay_s.value_or(0.0);
    best_.creep_per_decade = options_.creep_per_decade.value_or(0.0);
    begin_with(shape);
  }

  // A simplex can stop early in many dimensions: it begins again while that pays.
  void finish() {
    refine(300);
    for (double before = std::numeric_limits<double>::infinity();
         best_cost_ < worth_a_restart * before && options_.go_on();) {
      before = best_cost_;
      for (Unknown& unknown : unknowns_) unknown.step = 0.3;
      refine(150);
    }
    try_one_k();
  }

  // More samples make all unknowns more exact, the delay above all.
  void polish(const Problem& finer) {
    if (!options_.go_on()) return;
    problem_ = &finer;
    use(shape_);
    best_cost_ = cost(best_);
    for (Unknown& unknown : unknowns_) unknown.step = 0.05;
    refine(100);
  }

  void use(CurveShape shape) {
    shape_ = std::move(shape);
    fit_.emplace(*problem_, shape_, SeparableFit::coarse_scan);
  }

  // Perhaps infinite if it is not below the limit.
  double cost(const Trial& trial, double limit = std::numeric_limits<double>::infinity()) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const double longest_delay_s = options_.longest_delay_s.value_or(infinity);
    if (trial.below < 0.0 || trial.above < 0.0 || trial.below > 3.0 || trial.above > 3.0 ||
        trial.delay_s < 0.0 || trial.delay_s > longest_delay_s || trial.creep_per_decade < 0.0 ||
        trial.creep_per_decade > most_creep_per_decade ||
        std::min(trial.k_span_ascending, trial.k_span_descending) < -widest_k_span ||
        std::max(trial.k_span_ascending, trial.k_span_descending) > widest_k_span * steepness())
      return infinity;
    const Fitted fitted = fit_->fit(trial, limit);
    if (fitted.valid || !std::isfinite(fitted.rms)) return fitted.rms;
    return fitted.rms * (1.01 + 2.0 * fitted.violation) +
           1e-4 * problem_->output_span * (1.0 + fitted.violation);
  }

  // Where nearly all of the output happens in a small part of the inputs, loops are as small as that part.
  double steepness() const {
    double narrowest = problem_->observed.span();
    for (std::size_t i = 1; i < shape_.knots.size(); ++i)
      narrowest = std::min(narrowest, shape_.knots[i] - shape_.knots[i - 1]);
    return std::max(1.0, 0.05 * problem_->observed.span() / narrowest);
  }
  // k times the span that are worth a try: these, and larger ones on steep curves.
  std::vector<double> paces(std::vector<double> k_spans) const {
    const double largest = k_spans.back() * steepness();
    while (3.0 * k_spans.back() <= largest) k_spans.push_back(3.0 * k_spans.back());
    return k_spans;
  }

  // Stopped, with something found.
  bool has_enough(double least) const { return std::isfinite(least) && !options_.go_on(); }

  // Chooses roughly the initial memory that fits best, for each dataset separately.
  void choose_memories() {
    best_.memories.assign(problem_->excerpts.size(), {Kind::from_lower, 0.0});
    for (std::size_t i = 0; i < best_.memories.size(); ++i) {
      const double first = problem_->excerpts[i].first_input();
      const bool mid_range = first > problem_->observed.lo && first < problem_->observed.hi;
      double least = std::numeric_limits<double>::infinity();
      InitialMemory chosen;
      for (const Kind kind : {Kind::from_lower, Kind::virgin, Kind::from_upper, Kind::nested}) {
        if (!mid_range && (kind == Kind::from_upper || kind == Kind::nested)) continue;
        Trial trial = best_;
        trial.memories[i] = {kind, 0.0};
        for (const double k : paces({0.3, 2.0, 6.0})) {
          if (has_enough(least)) break;
          trial.k_span_ascending = trial.k_span_descending = k;
          const double limit = least * (kind == Kind::from_lower ? 1.0 : worth_it);
          if (const double c = cost(trial, limit); c < limit) {
            least = c;
            chosen = trial.memories[i];
          }
        }
      }
      best_.memories[i] = chosen;
    }
    for (std::size_t i = 0; i < best_.memories.size(); ++i)
      if (best_.memories[i].kind == Kind::nested) unknowns_.push_back(bias_of(i, 0.0));
  }

  void choose_k() {
    double least = std::numeric_limits<double>::infinity();
    const std::vector<double> tried = paces({-1.0, 0.3, 1.0, 3.0, 10.0, 30.0});
    for (const double ascending : tried)
      for (const double descending : tried) {
        if (has_enough(least)) break;
        Trial trial = best_;
        trial.k_span_ascending = ascending;
        trial.k_span_descending = descending;
        if (const double c = cost(trial, least); c < least) {
          least = c;
          unknowns_[0].start = std::asinh(ascending);
          unknowns_[1].start = std::asinh(descending);
        }
      }
    best_ = at_start(unknowns_);
    best_cost_ = cost(best_);
  }

  // At the start values.
  Trial at_start(const std::vector<Unknown>& unknowns) const {
    return moved_to(numbers_of(unknowns, &Unknown::start), unknowns, best_);
  }

  // Moves all unknowns. The next search starts from the result, with half the steps.
  // Ends after two fifths of the evaluations if the cost is not down to `promising_cost` then.
  double descend(std::vector<Unknown>& unknowns, int evaluations,
                 double promising_cost = std::numeric_limits<double>::infinity()) {
    int done = 0;
    double least = std::numeric_limits<double>::infinity();
    const auto function = [&](const Eigen::VectorXd& x, double limit) {
      const double c = cost(moved_to(x, unknowns, best_), limit);
      ++done;
      least = std::min(least, c);
      return c;
    };
    const Minimum found =
        minimise(function, numbers_of(unknowns, &Unknown::start), numbers_of(unknowns, &Unknown::step), 1e-4,
                 evaluations,
                 [&] { return options_.go_on() && (done < 2 * evaluations / 5 || least <= promising_cost); });
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      unknowns[i].start = found.x[static_cast<Eigen::Index>(i)];
      unknowns[i].step *= 0.5;
    }
    return found.value;
  }

  void refine(int evaluations) {
    std::vector<Unknown> moved = unknowns_;
    const double c = descend(moved, evaluations);
    if (!(c <= best_cost_)) return;
    for (std::size_t i = 0; i < moved.size(); ++i) unknowns_[i].start = moved[i].start;
    best_ = at_start(unknowns_);
    best_cost_ = c;
  }

  // Adds the best remaining candidate that is worth it, repeatedly, until none is.
  void add_useful_unknowns() {
    bool is_added = true;
    while (is_added && options_.go_on()) {
      result_.refused.clear();  // they are tried again beside what was added
      std::vector<std::pair<double, std::vector<Unknown>>> tried;
      for (const Unknown& candidate : candidates(best_, unknowns_, *problem_, options_)) {
        std::vector<Unknown> unknowns = unknowns_;
        for (Unknown& known : unknowns) known.step = 0.2;
        unknowns.push_back(candidate);
        const double c =
            descend(unknowns, 25 + 15 * static_cast<int>(unknowns.size()), promising * best_cost_);
        if (c < worth_it * best_cost_) tried.emplace_back(c, std::move(unknowns));
      }
      std::ranges::sort(tried, {}, [](const auto& one) { return one.first; });
      is_added =
          std::ranges::any_of(tried, [&](const auto& one) { return add_unknown(one.second, one.first); });
    }
  }

  bool add_unknown(const std::vector<Unknown>& unknowns, double c) {
    const Trial trial = at_start(unknowns);
    const Step taken{unknowns.back().quantity, fit_->fit(best_).rms, fit_->fit(trial).rms,
                     fit_->held_out(best_), fit_->held_out(trial)};
    if (taken.held_out_before && *taken.held_out_after > worth_held_out * *taken.held_out_before) {
      result_.refused.push_back(taken);
      return false;
    }
    result_.steps.push_back(taken);
    unknowns_ = unknowns;
    for (Unknown& unknown : unknowns_) unknown.step = 0.3;
    best_ = trial;
    best_cost_ = c;
    refine(150);
    return true;
  }

  static double score(const ShapeScore& tried) {
    return identification::score(tried.rms, tried.held_out, tried.shape);
  }
  ShapeScore scored() { return {shape_, fit_->fit(best_).rms, fit_->held_out(best_)}; }

  // Chooses the first shape with an error near the smallest, at the present trial.
  void choose_shape(const std::vector<CurveShape>& shapes) {
    double least = std::numeric_limits<double>::infinity();
    int worse = 0;  // consecutive shapes that were not better
    const std::size_t first = result_.shapes.size();
    for (const CurveShape& shape : shapes) {
      if (!options_.go_on()) break;
      use(shape);
      result_.shapes.push_back(scored());
      const double now = score(result_.shapes.back());
      worse = now < 0.98 * least ? 0 : worse + 1;
      least = std::min(least, now);
      if (worse == 3) break;
    }
    const auto tried = std::span(result_.shapes).subspan(first);
    const auto chosen = std::ranges::find_if(tried, [&](const ShapeScore& now) {
      return score(now) <= low_enough * least + exact * problem_->output_span;
    });
    use(chosen == tried.end() ? CurveShape::polynomial(first_order) : chosen->shape);
    best_cost_ = cost(best_);
    for (Unknown& unknown : unknowns_) unknown.step = 0.3;
  }

  void choose_order() {
    std::vector<CurveShape> polynomials;
    for (const int order : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20})
      if (order <= problem_->highest_order) polynomials.push_back(CurveShape::polynomial(order));
    choose_shape(polynomials);
  }

  // Splines need not begin where the polynomials ended: where these miss the output, their k, thresholds and
  // memories make up for the shape.
  void try_splines() {
    const Searcher polynomial = *this;
    const double before = score(scored());
    if (before < exact * problem_->output_span && options_.curves == CurveChoice::automatic) return;
    std::vector<CurveShape> splines;
    for (const int pieces : {2, 3, 4, 5, 6, 8, 10, 12, 15, 18, 22})
      if (pieces <= problem_->most_pieces) splines.push_back(CurveShape::spline(problem_->knots(pieces)));
    part_the_k();
    if (before > poor * problem_->output_span)
      begin_again(splines[std::min(splines.size() - 1, usual_spline)]);
    choose_shape(splines);
    if (options_.curves == CurveChoice::spline || score(scored()) < hopeless_spline * before) {
      finish();
      try_input_maps(splines);
    }
    if (options_.curves == CurveChoice::spline || score(scored()) < worth_a_spline * before) return;
    const std::vector<ShapeScore> tried = result_.shapes;
    take(polynomial);
    result_.shapes = tried;
  }

  void part_the_k() {
    std::vector<Unknown> unknowns = both_k(best_);
    unknowns.insert(unknowns.end(), unknowns_.begin() + (result_.one_k ? 1 : 2), unknowns_.end());
    unknowns_ = unknowns;
    result_.one_k = false;
  }

  // Where the outputs are steep, loops close in a small part of the inputs: a rate that follows the course of
  // the outputs.
  void try_input_maps(std::vector<CurveShape> splines) {
    const ShapeScore before = scored();
    if (score(before) < poor * problem_->output_span) return;
    const Searcher plain = *this;
    const std::size_t rich = std::min(splines.size() - 1, usual_spline);
    const auto course = mean_course(*problem_, best_, fit_->fit(best_).offsets);
    double least = worth_an_input_map * score(before);
    std::optional<double> share;
    for (const double tried : {0.5, 0.8, 0.95}) {
      take(plain);
      part_the_k();
      use(splines[rich].mapped(course, problem_->observed, tried));
      choose_k();
      refine(150);
      if (const double now = score(scored()); now < least && options_.go_on()) {
        least = now;
        share = tried;
      }
    }
    take(plain);
    if (!share) return;
    for (CurveShape& spline : splines) spline = spline.mapped(course, problem_->observed, *share);
    begin_again(splines[rich]);
    choose_shape(splines);
    finish();
    const ShapeScore after = scored();
    result_.steps.push_back(
        {{Quantity::Kind::input_map}, before.rms, after.rms, before.held_out, after.held_out});
    if (score(after) > worth_an_input_map * score(before)) take(plain);
  }

  void take(const Searcher& other) {
    unknowns_ = other.unknowns_;
    best_ = other.best_;
    best_cost_ = other.best_cost_;
    result_ = other.result_;
    use(other.shape_);
  }

  // Few datasets have enough turning points in both directions to distinguish the two k. If this dataset does
  // not, one common k is used.
  void try_one_k() {
    std::vector<Unknown> unknowns(unknowns_.begin() + 1, unknowns_.end());
    unknowns[0] = {{Quantity::Kind::common_k}, unknowns_[1].start, 0.2, [](Trial& trial, double x) {
                     trial.k_span_ascending = trial.k_span_descending = std::sinh(x);
                   }};
    for (Unknown& unknown : unknowns) unknown.step = 0.2;
    double c = descend(unknowns, 100);
    c = std::min(c, descend(unknowns, 100));
    const Trial trial = at_start(unknowns);
    const auto with = fit_->held_out(best_), without = fit_->held_out(trial);
    if (c > as_good * best_cost_ || (with && *without > as_good * *with)) return;
    unknowns_ = unknowns;
    best_ = trial;
    best_cost_ = c;
    result_.one_k = true;
  }

  const Problem* problem_;
  const IdentifyOptions& options_;
  std::vector<Unknown> unknowns_;
  std::optional<SeparableFit> fit_;
  CurveShape shape_;
  Trial best_;
  double best_cost_ = std::numeric_limits<double>::infinity();
  SearchResult result_;
};

}  // namespace

SearchResult search(const Problem& problem, const Problem& finer, const IdentifyOptions& options) {
  return Searcher(problem, options).run(finer);
}

}  // namespace hystcan::identification
