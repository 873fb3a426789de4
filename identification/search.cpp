#include "identification/search.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "base/text.h"
#include "identification/numerics/nonlinear_fit.h"
#include "identification/search_criteria.h"
#include "identification/shape_choice.h"
#include "identification/trial_cost.h"
#include "identification/unknowns.h"

namespace hystcan::identification {
namespace {

using MemoryKind = InitialMemory::Kind;

// The state of the search. Each step of the search returns a new state. To undo a step, the search continues
// with the former state.
struct SearchState {
  SearchResult found;  // the result so far; `rms` and `held_out` are set at the end of the search
  // The unknowns that are varied; they start at the values in found.trial.
  std::vector<Unknown> unknowns;
  double cost = infinite_cost;  // cost of the trial in `found`

  const Trial& trial() const { return found.trial; }
  Trial at_start() const { return moved_to(numbers_of(unknowns, &Unknown::start), unknowns, found.trial); }
  void set_steps(double step) {
    for (Unknown& unknown : unknowns) unknown.step = step;
  }
};

// Returns the first state of a new search. It keeps only the convergence rates and the list of tried shapes
// from `former`, the result of the previous search.
SearchState begin_anew(const SearchState& former, const IdentifyOptions& options) {
  SearchState state;
  state.found.shapes = former.found.shapes;
  Trial& trial = state.found.trial;
  trial.k_span_ascending = former.trial().k_span_ascending;
  trial.k_span_descending = former.trial().k_span_descending;
  trial.delay_s = options.delay_s.value_or(0.0);
  trial.creep_per_decade = options.creep_per_decade.value_or(0.0);
  state.unknowns = both_k(trial);
  return state;
}

// Returns true if the search was stopped, but has already found a trial with a finite error.
bool has_enough(double least, const TrialCost& cost) { return std::isfinite(least) && !cost.go_on(); }

// Selects the kind of initial memory with the smallest error, for each dataset separately. The choice is
// coarse: only a few convergence rates are tried with each kind.
SearchState with_memories(SearchState state, TrialCost& cost) {
  const Problem& problem = cost.problem();
  std::vector<InitialMemory>& memories = state.found.trial.memories;
  memories.assign(problem.excerpts.size(), {MemoryKind::from_lower, 0.0});
  for (std::size_t i = 0; i < memories.size(); ++i) {
    const double first = problem.excerpts[i].first_input();
    const bool mid_range = first > problem.observed.lo && first < problem.observed.hi;
    double least = infinite_cost;
    InitialMemory chosen;
    for (const MemoryKind kind :
         {MemoryKind::from_lower, MemoryKind::virgin, MemoryKind::from_upper, MemoryKind::nested}) {
      if (!mid_range && (kind == MemoryKind::from_upper || kind == MemoryKind::nested)) continue;
      Trial trial = state.trial();
      trial.memories[i] = {kind, 0.0};
      for (const double k : cost.paces({0.3, 2.0, 6.0})) {
        if (has_enough(least, cost)) break;
        trial.k_span_ascending = trial.k_span_descending = k;
        const double limit = least * (kind == MemoryKind::from_lower ? 1.0 : criteria.added);
        if (const double c = cost(trial, limit); c < limit) {
          least = c;
          chosen = trial.memories[i];
        }
      }
    }
    memories[i] = chosen;
  }
  for (std::size_t i = 0; i < memories.size(); ++i)
    if (memories[i].kind == MemoryKind::nested) state.unknowns.push_back(bias_of(i, 0.0));
  return state;
}

SearchState with_k(SearchState state, TrialCost& cost) {
  double least = infinite_cost;
  const std::vector<double> tried = cost.paces({-1.0, 0.3, 1.0, 3.0, 10.0, 30.0});
  for (const double ascending : tried)
    for (const double descending : tried) {
      if (has_enough(least, cost)) break;
      Trial trial = state.trial();
      trial.k_span_ascending = ascending;
      trial.k_span_descending = descending;
      if (const double c = cost(trial, least); c < least) {
        least = c;
        state.unknowns[0].start = std::asinh(ascending);
        state.unknowns[1].start = std::asinh(descending);
      }
    }
  state.found.trial = state.at_start();
  state.cost = cost(state.trial());
  return state;
}

// Varies all unknowns to lower the cost. The next call starts from the result, with half the step lengths.
// Ends after two fifths of `evaluations` if the cost is still above `promising_cost`.
SearchState descended(SearchState state, TrialCost& cost, int evaluations,
                      double promising_cost = infinite_cost) {
  int done = 0;
  double least = infinite_cost;
  const auto function = [&](const Eigen::VectorXd& x, double limit) {
    const double c = cost(moved_to(x, state.unknowns, state.trial()), limit);
    ++done;
    least = std::min(least, c);
    return c;
  };
  const auto go_on = [&] { return cost.go_on() && (done < 2 * evaluations / 5 || least <= promising_cost); };
  const Minimum minimum = minimise(function, numbers_of(state.unknowns, &Unknown::start),
                                   numbers_of(state.unknowns, &Unknown::step), 1e-4, evaluations, go_on);
  for (std::size_t i = 0; i < state.unknowns.size(); ++i) {
    state.unknowns[i].start = minimum.x[static_cast<Eigen::Index>(i)];
    state.unknowns[i].step *= 0.5;
  }
  state.found.trial = state.at_start();
  state.cost = minimum.value;
  return state;
}

SearchState refined(const SearchState& state, TrialCost& cost, int evaluations) {
  SearchState moved = descended(state, cost, evaluations);
  if (!(moved.cost <= state.cost)) return state;
  for (std::size_t i = 0; i < moved.unknowns.size(); ++i) moved.unknowns[i].step = state.unknowns[i].step;
  return moved;
}

// Compares two states; `tried` has one more unknown than `state`. Returns `tried`, refined, if the unknown
// also lowers the held-out error. Otherwise returns `state`, and adds the unknown to the refused steps.
SearchState with_unknown(SearchState state, SearchState tried, TrialCost& cost) {
  SeparableFit& fit = cost.fit();
  const Step taken{tried.unknowns.back().quantity, fit.fit(state.trial()).rms, fit.fit(tried.trial()).rms,
                   fit.held_out(state.trial()), fit.held_out(tried.trial())};
  if (taken.held_out_before && *taken.held_out_after > criteria.added_held_out * *taken.held_out_before) {
    state.found.refused.push_back(taken);
    return state;
  }
  tried.found.steps.push_back(taken);
  tried.found.refused = state.found.refused;
  tried.set_steps(0.3);
  return refined(tried, cost, 150);
}

// Adds the unknown that lowers the error most, again and again, until no other unknown lowers the error
// enough.
SearchState with_useful_unknowns(SearchState state, TrialCost& cost) {
  for (std::size_t known = 0; known < state.unknowns.size() && cost.go_on();) {
    known = state.unknowns.size();
    state.found.refused.clear();  // an unknown that was refused may be useful together with the added one
    std::vector<SearchState> tried;
    for (const Unknown& candidate :
         candidates(state.trial(), state.unknowns, cost.problem(), cost.options())) {
      SearchState with = state;
      with.set_steps(0.2);
      with.unknowns.push_back(candidate);
      with = descended(with, cost, 25 + 15 * static_cast<int>(with.unknowns.size()),
                       criteria.promising * state.cost);
      if (with.cost < criteria.added * state.cost) tried.push_back(std::move(with));
    }
    std::ranges::sort(tried, {}, &SearchState::cost);
    for (auto one = tried.begin(); one != tried.end() && state.unknowns.size() == known; ++one)
      state = with_unknown(std::move(state), std::move(*one), cost);
  }
  return state;
}

SearchState with_curves(SearchState state, TrialCost& cost, const CurveShape& shape) {
  state.found.shape = shape;
  cost.use(shape);
  state = with_k(with_memories(std::move(state), cost), cost);
  return with_useful_unknowns(refined(state, cost, 150), cost);
}

// Tries one convergence rate k for both directions. Only few datasets have enough turning points in both
// directions to distinguish k_ascending from k_descending. Returns the state with the common k if its error
// is nearly as small as with two rates; otherwise returns `state`.
SearchState with_one_k(const SearchState& state, TrialCost& cost) {
  SearchState common = state;
  std::vector<Unknown>& unknowns = common.unknowns;
  unknowns.erase(unknowns.begin());
  unknowns[0] = {{Quantity::Kind::common_k}, unknowns[0].start, 0.2, [](Trial& trial, double x) {
                   trial.k_span_ascending = trial.k_span_descending = std::sinh(x);
                 }};
  common.set_steps(0.2);
  common = descended(std::move(common), cost, 100);
  const double first = common.cost;
  common = descended(std::move(common), cost, 100);
  common.cost = std::min(first, common.cost);
  const auto with = cost.fit().held_out(state.trial()), without = cost.fit().held_out(common.trial());
  if (common.cost > criteria.one_k * state.cost || (with && *without > criteria.one_k * *with)) return state;
  common.found.one_k = true;
  return common;
}

SearchState with_both_k(SearchState state) {
  std::vector<Unknown> unknowns = both_k(state.trial());
  unknowns.insert(unknowns.end(), state.unknowns.begin() + (state.found.one_k ? 1 : 2), state.unknowns.end());
  state.unknowns = std::move(unknowns);
  state.found.one_k = false;
  return state;
}

// Refines all unknowns. With many unknowns, a simplex search can stop too early. It is therefore repeated
// until a repetition hardly lowers the cost.
SearchState finished(SearchState state, TrialCost& cost) {
  state = refined(state, cost, 300);
  for (double before = infinite_cost; state.cost < criteria.restart * before && cost.go_on();) {
    before = state.cost;
    state.set_steps(0.3);
    state = refined(state, cost, 150);
  }
  return with_one_k(state, cost);
}

ShapeScore scored(const SearchState& state, TrialCost& cost) {
  return {state.found.shape, cost.fit().fit(state.trial()).rms, cost.fit().held_out(state.trial())};
}

// Tries the shapes in `shapes` one after the other. Only the coefficients of the curves are fitted to each
// shape; convergence rates, delay and the other searched parameters stay constant. Selects the first shape
// whose error is near the smallest one.
SearchState with_best_shape(SearchState state, TrialCost& cost, const std::vector<CurveShape>& shapes) {
  double least = infinite_cost;
  int worse = 0;  // number of consecutive shapes that were not better
  std::vector<ShapeScore>& all = state.found.shapes;
  const std::size_t first = all.size();
  for (const CurveShape& shape : shapes) {
    if (!cost.go_on()) break;
    state.found.shape = shape;
    cost.use(shape);
    all.push_back(scored(state, cost));
    const double now = all.back().score();
    worse = now < criteria.better_shape * least ? 0 : worse + 1;
    least = std::min(least, now);
    if (worse == criteria.most_worse_shapes) break;
  }
  const double enough = criteria.low_enough * least + criteria.exact * cost.problem().output_span;
  const auto tried = std::span(all).subspan(first);
  const auto chosen =
      std::ranges::find_if(tried, [&](const ShapeScore& now) { return now.score() <= enough; });
  state.found.shape = chosen == tried.end() ? CurveShape::polynomial(criteria.first_order) : chosen->shape;
  cost.use(state.found.shape);
  state.cost = cost(state.trial());
  state.set_steps(0.3);
  return state;
}

SearchState with_best_order(SearchState state, TrialCost& cost) {
  std::vector<CurveShape> polynomials;
  for (const int order : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 18, 20})
    if (order <= cost.problem().highest_order) polynomials.push_back(CurveShape::polynomial(order));
  return with_best_shape(std::move(state), cost, polynomials);
}

// Tries an input map. If the output is steep in a small part of the inputs, loops close quickly there. An
// input map makes the convergence rate follow the slope of the output.
SearchState with_input_map(const SearchState& plain, TrialCost& cost, std::vector<CurveShape> splines) {
  const Problem& problem = cost.problem();
  const ShapeScore before = scored(plain, cost);
  if (before.score() < criteria.poor * problem.output_span) return plain;
  const std::size_t rich = std::min(splines.size() - 1, criteria.usual_spline);
  const auto course = mean_course(problem, plain.trial(), cost.fit().fit(plain.trial()).offsets);
  double least = criteria.input_map * before.score();
  std::optional<double> share;
  for (const double tried : {0.5, 0.8, 0.95}) {
    SearchState state = with_both_k(plain);
    state.found.shape = splines[rich].mapped(course, problem.observed, tried);
    cost.use(state.found.shape);
    state = refined(with_k(std::move(state), cost), cost, 150);
    if (const double now = scored(state, cost).score(); now < least && cost.go_on()) {
      least = now;
      share = tried;
    }
  }
  if (share) {
    for (CurveShape& spline : splines) spline = spline.mapped(course, problem.observed, *share);
    SearchState mapped = with_curves(begin_anew(plain, cost.options()), cost, splines[rich]);
    mapped = finished(with_best_shape(std::move(mapped), cost, splines), cost);
    const ShapeScore after = scored(mapped, cost);
    mapped.found.steps.push_back(
        {{Quantity::Kind::input_map}, before.rms, after.rms, before.held_out, after.held_out});
    if (!(after.score() > criteria.input_map * before.score())) return mapped;
  }
  cost.use(plain.found.shape);
  return plain;
}

// Tries splines instead of polynomials. If the polynomials fit badly, the convergence rates, thresholds and
// memories that were found with them compensate the wrong shape. In this case, the splines do not start from
// these values, but from a new search.
SearchState with_splines(const SearchState& polynomial, TrialCost& cost) {
  const Problem& problem = cost.problem();
  const bool is_asked = cost.options().curves == CurveChoice::spline;
  const double before = scored(polynomial, cost).score();
  if (before < criteria.exact * problem.output_span && !is_asked) return polynomial;
  std::vector<CurveShape> splines;
  for (const int pieces : {2, 3, 4, 5, 6, 8, 10, 12, 15, 18, 22})
    if (pieces <= problem.most_pieces) splines.push_back(CurveShape::spline(problem.knots(pieces)));
  SearchState state = with_both_k(polynomial);
  if (before > criteria.poor * problem.output_span)
    state = with_curves(begin_anew(state, cost.options()), cost,
                        splines[std::min(splines.size() - 1, criteria.usual_spline)]);
  state = with_best_shape(std::move(state), cost, splines);
  if (is_asked || scored(state, cost).score() < criteria.hopeless_spline * before)
    state = with_input_map(finished(std::move(state), cost), cost, splines);
  if (is_asked || scored(state, cost).score() < criteria.spline * before) return state;
  cost.use(polynomial.found.shape);
  SearchState back = polynomial;
  back.found.shapes = state.found.shapes;
  return back;
}

// Refines all unknowns with more samples than in the search. This is useful above all for the delay.
SearchResult polished(SearchState state, TrialCost& cost) {
  cost.use(state.found.shape);
  state.cost = cost(state.trial());
  state.set_steps(0.05);
  state = refined(state, cost, 100);
  state.found.rms = cost.fit().fit(state.trial()).rms;
  return state.found;
}

}  // namespace

SearchResult search(const Problem& problem, const Problem& finer, const IdentifyOptions& options) {
  TrialCost cost(problem, options);
  const auto first = CurveShape::polynomial(std::min(criteria.first_order, problem.highest_order));
  const bool is_rich =
      options.shape && !options.shape->is_spline() && options.shape->order > criteria.first_order;
  SearchState state =
      with_curves(begin_anew({}, options), cost, is_rich ? first : options.shape.value_or(first));
  if (!std::isfinite(state.cost))
    refuse("no model fits with a finite error; expected a dataset that a model can describe");
  if (is_rich) {
    state.found.shape = *options.shape;
    cost.use(*options.shape);
    state.cost = cost(state.trial());
  }
  if (!options.shape) state = with_best_order(std::move(state), cost);
  state = finished(std::move(state), cost);
  if (problem.most_pieces > 1 && !options.shape && options.curves != CurveChoice::polynomial)
    state = with_splines(state, cost);
  state.found.held_out = cost.fit().held_out(state.trial());
  if (options.go_on()) {
    TrialCost fine(finer, options);
    return polished(std::move(state), fine);
  }
  state.found.rms = cost.fit().fit(state.trial()).rms;
  return state.found;
}

}  // namespace hystcan::identification
