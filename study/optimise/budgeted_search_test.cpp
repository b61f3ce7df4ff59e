// SPDX-License-Identifier: Apache-2.0
// | tolerance | unit     | origin                                                                       |
// |-----------|----------|------------------------------------------------------------------------------|
// | 0.01      | 1        | of a place: ten of the search's least steps; quadratics are flat at the least |
#include "study/optimise/budgeted_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

namespace fringetwin::study::budgeted_search_test {
namespace {

using Function = std::function<Assessment(const Place&)>;

/// With what was asked.
struct Course {
  SearchResult result;
  std::size_t asked = 0;
};
Course run(const SearchPlan& plan, const Function& function) {
  Course out;
  out.result = search(plan, [&](const std::vector<Place>& places, std::size_t first) {
    EXPECT_EQ(first, out.asked);
    out.asked += places.size();
    std::vector<Assessment> answers;
    for (const Place& place : places) answers.push_back(function(place));
    return answers;
  });
  EXPECT_EQ(out.result.tried.size(), out.asked);
  EXPECT_LE(out.asked, plan.evaluations);
  std::set<Place> places;
  for (const Tried& t : out.result.tried) EXPECT_TRUE(places.insert(t.place).second) << "no place twice";
  return out;
}

double bowl(const Place& p) { return std::pow(p[0] - 0.8, 2) + 2.0 * std::pow(p[1] - 0.3, 2); }

TEST(Search, ALeastInside) {
  const Course r = run({{0, 0}, 0, 60, 1}, [](const Place& p) { return Assessment{bowl(p), {}}; });
  ASSERT_TRUE(r.result.best);
  const Place& best = r.result.tried[*r.result.best].place;
  EXPECT_NEAR(best[0], 0.8, 0.01);
  EXPECT_NEAR(best[1], 0.3, 0.01);
}

// x + y <= 0.9: the least of the bowl on that line is at (0.8 - 2 t, 0.3 - t), t = 0.2/3.
TEST(Search, ALeastAtAConstraint) {
  const Course r = run({{0, 0}, 1, 80, 1}, [](const Place& p) {
    return Assessment{bowl(p), {100.0 * (p[0] + p[1] - 0.9)}};
  });
  ASSERT_TRUE(r.result.best);
  const Tried& best = r.result.tried[*r.result.best];
  EXPECT_TRUE(best.assessment.feasible());
  EXPECT_NEAR(best.place[0], 0.8 - 0.4 / 3.0, 0.01);
  EXPECT_NEAR(best.place[1], 0.3 - 0.2 / 3.0, 0.01);
  EXPECT_GT(best.place[0] + best.place[1], 0.9 - 0.01) << "the constraint is active";
}

TEST(Search, GoesOnBesideWhatFails) {
  const Course r = run({{0, 0}, 1, 80, 1}, [](const Place& p) {
    if (p[0] > 0.85 || p[1] < 0.15) return Assessment{std::nan(""), {std::nan("")}};
    return Assessment{bowl(p), {p[0] - 0.7}};
  });
  ASSERT_TRUE(r.result.best);
  EXPECT_NEAR(r.result.tried[*r.result.best].place[0], 0.7, 0.01);
  EXPECT_NEAR(r.result.tried[*r.result.best].place[1], 0.3, 0.01);
  EXPECT_LE(r.result.tried[*r.result.best].place[0], 0.7);
}

TEST(Search, ListsAreWalkedStepByStep) {
  // 40 values: too many for 30 evaluations; the 31st is best, whatever the place between 0 and 1.
  const Course r = run({{40, 0}, 0, 40, 3}, [](const Place& p) {
    const double i = 40.0 * p[0] - 0.5;
    EXPECT_NEAR(i, std::round(i), 1e-9) << "one of the values";
    return Assessment{std::pow(i - 30.0, 2) / 100.0 + std::pow(p[1] - 0.5, 2), {}};
  });
  ASSERT_TRUE(r.result.best);
  EXPECT_NEAR(r.result.tried[*r.result.best].place[0], 30.5 / 40.0, 1.1 / 40.0);
  EXPECT_NEAR(r.result.tried[*r.result.best].place[1], 0.5, 0.05);
}

TEST(Search, AShortListIsTriedAsAWhole) {
  const Course r = run({{3, 4}, 0, 60, 1}, [](const Place& p) { return Assessment{bowl(p), {}}; });
  EXPECT_EQ(r.asked, 12u);
  ASSERT_TRUE(r.result.best);
  EXPECT_NEAR(r.result.tried[*r.result.best].place[0], 5.0 / 6.0, 1e-12);
  EXPECT_NEAR(r.result.tried[*r.result.best].place[1], 3.0 / 8.0, 1e-12);
}

TEST(Search, NothingFeasibleIsNoBest) {
  const Course none = run({{0}, 1, 20, 1}, [](const Place& p) { return Assessment{p[0], {1.0 + p[0]}}; });
  EXPECT_FALSE(none.result.best);
  EXPECT_GT(none.asked, 10u) << "it looked for where the constraint is exceeded least";
  const Course failed = run({{0}, 0, 20, 1}, [](const Place&) { return Assessment{}; });
  EXPECT_FALSE(failed.result.best);
  EXPECT_EQ(failed.asked, 10u);
}

TEST(Search, FindsAFeasibleCornerByWhatIsExceeded) {
  const Course r = run({{0, 0}, 2, 60, 1}, [](const Place& p) {
    return Assessment{p[0] + p[1], {0.97 - p[0], 0.97 - p[1]}};
  });
  ASSERT_TRUE(r.result.best);
  EXPECT_NEAR(r.result.tried[*r.result.best].place[0], 0.97, 0.01);
}

TEST(Search, IsTheSameAgainAndKeepsToItsBudget) {
  const Function f = [](const Place& p) { return Assessment{bowl(p), {p[0] - 0.6}}; };
  const Course a = run({{0, 0, 3}, 1, 50, 9}, f), b = run({{0, 0, 3}, 1, 50, 9}, f);
  ASSERT_EQ(a.asked, b.asked);
  for (std::size_t i = 0; i < a.asked; ++i) EXPECT_EQ(a.result.tried[i].place, b.result.tried[i].place);
  for (const std::size_t n : {1, 2, 3, 7}) run({{0, 0, 3}, 1, n, 9}, f);
  EXPECT_NE(run({{0, 0}, 1, 4, 8}, f).result.tried[0].place, run({{0, 0}, 1, 4, 9}, f).result.tried[0].place);
}

TEST(Search, ExceptionsPass) {
  std::size_t n = 0;
  EXPECT_THROW(run({{0}, 0, 20, 1},
                   [&](const Place& p) {
                     if (++n == 14) throw std::out_of_range("stop");
                     return Assessment{p[0], {}};
                   }),
               std::out_of_range);
}

}  // namespace
}  // namespace fringetwin::study::budgeted_search_test
