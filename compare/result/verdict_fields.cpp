// SPDX-License-Identifier: Apache-2.0
// The fields of the rows that judge: indicators, the budget and its verdicts, causes, refinement, limits.
#include "compare/result/fields.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

namespace {
using Style = Column::Style;
}

std::vector<Field> describe(const Indicator*) {
  using Row = Indicator;
  Fields<Row> f;
  f.add("name", "", "which indicator it is", &Row::name)
      .named()
      .one_of({"sphere_form", "sphere_form_95", "sphere_size", "plane_flatness", "plane_flatness_95",
               "sphere_spacing"});
  f.add("objects", "", "objects it is taken from", &Row::objects).named().items(1, 2);
  f.add("unit", "", "unit of the values", [](const Row&) { return std::string("mm"); }).one_of({"mm"});
  f.add("simulated", "mm", "value of the simulated side", [](const Row& r) { return r.simulated.mm; })
      .with_sigma("simulated_sigma_mm")
      .without_images();
  f.add_positive("simulated_sigma_mm", "mm", "its standard error", [](const Row& r) {
     return r.simulated.sigma_mm;
   }).error();
  f.add("real", "mm", "value of the real side", [](const Row& r) {
     return r.real.mm;
   }).with_sigma("real_sigma_mm");
  f.add_positive("real_sigma_mm", "mm", "its standard error", [](const Row& r) {
     return r.real.sigma_mm;
   }).error();
  f.add("difference", "mm", "simulated less real", &Row::difference_mm);
  f.add("z", "", "the difference over its standard error", &Row::z);
  return f.take();
}

std::vector<Field> describe(const BudgetVerdict*) {
  Fields<BudgetVerdict> f;
  for (const auto& [key, verdict] :
       {std::pair{"gray", &BudgetVerdict::gray}, std::pair{"phase", &BudgetVerdict::phase},
        std::pair{"geometry", &BudgetVerdict::geometry}})
    f.add(key, "", "whether the budget explains all differences of this quantity", verdict)
        .one_of({"explained", "not explained"})
        .or_null();
  return f.take();
}

std::vector<Field> describe(const BudgetShare*) {
  Fields<BudgetShare> f;
  f.add("name", "", "source of uncertainty", &BudgetShare::name).named();
  f.add_positive("variance", "", "square of its standard uncertainty, in the row's unit squared",
                 &BudgetShare::variance);
  f.add_positive("share", "", "of the expected mean square", &BudgetShare::share);
  return f.take();
}

std::vector<Field> describe(const ExplainedRow*) {
  using Row = ExplainedRow;
  Fields<Row> f;
  f.add("quantity", "", "what is judged", &Row::quantity).named().one_of({"gray", "phase", "geometry"});
  f.add("region", "", "camera, camera and direction, or object", &Row::region).named();
  f.add("unit", "", "unit of the difference", &Row::unit);
  f.add_positive("observed", "", "mean square of the difference, in the row's unit squared", &Row::observed);
  f.add_positive("expected", "", "sum of the budget", &Row::expected);
  f.add("budget", "", "sources of uncertainty that make the expected mean square", &Row::shares);
  f.add_positive("chi2", "", "mean over single values of the square over what the budget allows", &Row::chi2);
  f.add_positive("chi2_limit", "", "largest chi2 that counts as explained", &Row::chi2_limit);
  f.add_positive("regional_chi2", "", "the same over means of regions", &Row::regional_chi2);
  f.add_positive("regional_limit", "", "largest regional chi2 that counts as explained",
                 &Row::regional_limit);
  f.add("n", "", "values judged", &Row::n);
  f.add("n_regions", "", "regions judged", &Row::n_regions);
  f.add("explained", "", "whether both are within their limits", &Row::explained);
  f.add("worst", "", "geometry: the number of the fit with the largest |z|", &Row::worst).or_absent();
  return f.take();
}

std::vector<Field> describe(const CauseParameter*) {
  using Row = CauseParameter;
  Fields<Row> f;
  f.add("name", "", "parameter of the twin", &Row::name).named();
  f.add("unit", "", "its unit", &Row::unit);
  f.add("twin", "", "value in the twin", &Row::twin).without_images();
  f.add("estimate", "", "value that would fit the real images", &Row::estimate).with_sigma("estimate_sigma");
  f.add_positive("estimate_sigma", "", "its standard error", &Row::sigma).error();
  return f.take();
}

std::vector<Field> describe(const CauseRow*) {
  using Row = CauseRow;
  Fields<Row> f;
  f.add("group", "", "group of parameters that were fitted", &Row::group).named();
  f.add("cause", "", "what the twin may be wrong about", &Row::cause);
  f.add("alone", "", "share of the excess that it takes away by itself", &Row::alone);
  f.add("order", "", "1 for the first one taken, 0 for one that was not taken", &Row::order);
  f.add("in_order", "", "share of the excess that it takes away after those before it", &Row::in_order);
  f.add("parameters", "", "what the group would have to be", &Row::parameters);
  return f.take();
}

std::vector<Field> describe(const Causes*) {
  Fields<Causes> f;
  f.add("named", "", "the group that explains half of the excess or more", &Causes::named).or_null();
  f.add_positive("chi2", "", "of a gray value, with the best gain and black level only", &Causes::chi2);
  f.add("rest", "", "share of the excess that all taken ones leave", &Causes::rest);
  f.add("n", "", "gray values used", &Causes::n);
  f.add("tested", "", "every group that was fitted", &Causes::rows);
  return f.take();
}

std::vector<Field> describe(const RefinedRow*) {
  using Row = RefinedRow;
  Fields<Row> f;
  f.add("name", "", "parameter of the twin", &Row::name).named().shown({"parameter", ""});
  f.add("unit", "", "its unit", &Row::unit).shown({"unit", ""});
  f.add("before", "", "value in the twin as written", &Row::before)
      .without_images()
      .shown({"twin as written", "", Style::significant, 7});
  f.add("after", "", "fitted value", &Row::after)
      .with_sigma("after_sigma")
      .shown({"refined", "", Style::with_sigma});
  f.add_positive("after_sigma", "", "its standard error", &Row::sigma).error();
  return f.take();
}

std::vector<Field> describe(const Refinement*) {
  using Row = Refinement;
  Fields<Row> f;
  f.add("asked", "", "what --refine was given", &Row::asked);
  f.add("parameters", "", "fitted parameters", &Row::rows);
  f.add("covariance", "", "of the parameters as fitted", &Row::covariance_rows);
  f.add_positive("chi2_before", "", "of a gray value, before the fit", &Row::chi2_before);
  f.add_positive("chi2_after", "", "of a gray value, after the fit", &Row::chi2_after);
  f.add("iterations", "", "steps of the fit", &Row::iterations);
  f.add("converged", "", "whether the fit came to rest", &Row::converged);
  f.add("n", "", "gray values used", &Row::n);
  f.add("notes", "", "what a reader must know of the fit", &Row::notes);
  return f.take();
}

std::vector<Field> describe(const LimitRow*) {
  using Row = LimitRow;
  Fields<Row> f;
  f.add("name", "", "key of [limits] in the twin", &Row::name).named();
  f.add("value", "", "worst value over all rows", &Row::value);
  f.add("limit", "", "what the twin allows", &Row::limit).known();
  f.add("pass", "", "whether the value is within the limit", &Row::pass);
  return f.take();
}

}  // namespace fringetwin::compare
