#include "stylet/needle/advance_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace stylet {

namespace {

using Verdict = AdvanceSearch::Verdict;
constexpr double tolerance = 1e-9;

struct Result {
  Verdict verdict;
  double b;
  std::vector<double> tried;
};

/// From the base to the first verdict that is not another try.
Result search(const std::function<double(double)>& g, double end, double first = 0) {
  AdvanceSearch search;
  Result result{Verdict::move, first, {}};
  for (int i = 0; i < 100; ++i) {
    result.tried.push_back(result.b);
    const auto next = search.next(result.b, g(result.b), end, tolerance);
    result.verdict = next.verdict;
    result.b = next.b;
    if (next.verdict != Verdict::move) break;
  }
  return result;
}

TEST(AdvanceSearch, FindsTheRootFromBelowAndFromAbove) {
  for (const double slope : {0.1, 0.5, 1.0, 2.0, 20.0}) {
    for (const double first : {0.0, 0.29, 0.31, 0.9}) {
      const auto found = search([&](double b) { return slope * (0.3 - b); }, 1, first);
      EXPECT_EQ(found.verdict, Verdict::found);
      EXPECT_NEAR(found.b, 0.3, 2 * tolerance / slope);
      EXPECT_LT(found.tried.size(), 12U);
    }
  }
}

TEST(AdvanceSearch, NeverLooksBehindAnEndWhoseGapItHasNotSeen) {
  // However far the needle is ahead: one end at a time.
  const auto passed = search([](double b) { return 1e3 - b; }, 1);
  EXPECT_EQ(passed.verdict, Verdict::pass);
  EXPECT_EQ(passed.b, 1);
  EXPECT_EQ(passed.tried, (std::vector<double>{0, 1}));
  // The root is just before the end: it is not passed.
  const auto found = search([](double b) { return b < 0.999 ? 0.5 * (0.999 - b) : 0.999 - b; }, 1);
  EXPECT_EQ(found.verdict, Verdict::found);
  EXPECT_NEAR(found.b, 0.999, 3 * tolerance);
}

TEST(AdvanceSearch, ATipThatCannotCutHolds) {
  const auto held = search([](double b) { return -0.1 - b; }, 1);
  EXPECT_EQ(held.verdict, Verdict::stick);
  EXPECT_EQ(held.b, 0);
  // Also if a first guess went ahead.
  EXPECT_EQ(search([](double b) { return -0.1 - b; }, 1, 0.5).b, 0);
}

TEST(AdvanceSearch, HoldsBeyondAJump) {
  const auto held = search([](double b) { return b < 0.37 ? 0.2 : -0.4; }, 1);
  EXPECT_EQ(held.verdict, Verdict::stick);
  EXPECT_NEAR(held.b, 0.37, 1e-13);
  EXPECT_GE(held.b, 0.37);
}

TEST(AdvanceSearch, SqueezedTissueTakesLongerAndLongerAdvances) {
  const auto passed = search([](double b) { return 1 - 1e-6 * b; }, 1e4);
  EXPECT_EQ(passed.verdict, Verdict::pass);
  EXPECT_LT(passed.tried.size(), 30U);
}

TEST(AdvanceSearch, TheFirstOfTwoRoots) {
  // Soft tissue behind stiff: the gap opens again behind its first root.
  const auto g = [](double b) { return 0.1 - b + (b > 0.3 ? 5 * (b - 0.3) : 0); };
  const auto found = search(g, 1);
  EXPECT_EQ(found.verdict, Verdict::found);
  EXPECT_NEAR(found.b, 0.1, 2 * tolerance);
}

}  // namespace

}  // namespace stylet
