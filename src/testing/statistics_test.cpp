// The kit's statistics against known values and against their own definition: p-values of true hypotheses are
// uniform.
#include <gtest/gtest.h>
#include <kinora/testing/statistics.h>

#include <cmath>
#include <vector>

#include "testing/sphere_quadrature.h"

namespace kinora::testing {
namespace {

TEST(Statistics, GammaAgreesWithClosedForms) {
  for (const double x : {0.01, 0.3, 1.0, 2.5, 7.0, 30.0}) {
    EXPECT_NEAR(gammaQ(1, x), std::exp(-x), 1e-12 * std::exp(-x) + 1e-15);
    EXPECT_NEAR(gammaQ(0.5, x), std::erfc(std::sqrt(x)), 1e-12);
    EXPECT_NEAR(gammaQ(3, x), std::exp(-x) * (1 + x + 0.5 * x * x), 1e-12);
  }
  // median of chi-square with many degrees lies near k (1 - 2 / 9k)^3
  for (const double k : {10.0, 100.0, 1000.0})
    EXPECT_NEAR(chiSquareTail(k * std::pow(1 - 2 / (9 * k), 3), k), 0.5, 2e-3);
  EXPECT_EQ(gammaQ(2, 0), 1);
  EXPECT_NEAR(normalTail(1.959963984540054), 0.05, 1e-12);
  EXPECT_NEAR(sidakLevel(0.01, 1000), 1.0050e-5, 1e-8);
}

TEST(Statistics, TrueHypothesesGiveUniformP) {
  Random r(5);
  std::vector<double> deciles(10, 0), expected(10, 40.0), probability(20);
  for (size_t i = 0; i < probability.size(); ++i) probability[i] = (1.0 + double(i)) / 210;
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<double> o(20, 0), e(20);
    for (size_t i = 0; i < 20; ++i) e[i] = 4000 * probability[i];
    for (int n = 0; n < 4000; ++n) {
      double u = r.uniform();
      size_t i = 0;
      while (i < 19 && u >= probability[i]) u -= probability[i++];
      ++o[i];
    }
    const double p = chiSquareTest(o, e).p;
    ++deciles[std::min<size_t>(9, size_t(p * 10))];
  }
  EXPECT_GT(chiSquareTest(deciles, expected).p, 1e-3);
}

TEST(Statistics, RefusesWrongCounts) {
  const std::vector<double> expected(16, 1000.0);
  std::vector<double> observed = expected;
  observed[3] += 250;
  observed[4] -= 250;
  EXPECT_LT(chiSquareTest(observed, expected).p, 1e-12);
}

// A known integral with a peak a thousandth of a radian wide, and one with an edge that no cell follows.
TEST(SphereQuadrature, FindsPeaksAndEdges) {
  const Vec3 axis{0.6f, 0.0f, 0.8f};
  SphereCells cells({0.f, 0.6f, 0.8f}, 2);
  const double k = 1e6;  // von Mises-Fisher lobe
  Random r(3);
  std::vector<Vec3> pilot;
  for (int i = 0; i < 2000; ++i) {
    const double a = 1e-3 * std::sqrt(-2 * std::log(1 - r.uniform())), b = 6.283185307179586 * r.uniform();
    // about the axis, in the plane of (0.8, 0, -0.6) and (0, 1, 0)
    const double x = a * std::cos(b), y = a * std::sin(b);
    pilot.push_back({float(0.6 + 0.8 * x), float(y), float(0.8 - 0.6 * x)});
  }
  cells.refine(pilot, 24);
  EXPECT_GT(cells.count(), 150u);
  const auto f = [&](uint32_t n, const float* const wi[3], double* out) {
    for (uint32_t i = 0; i < n; ++i) {
      const double dx = wi[0][i] - double(axis.x), dy = wi[1][i] - double(axis.y), dz = wi[2][i] - double(axis.z);
      out[i] = k / (2 * M_PI) * std::exp(-0.5 * k * (dx * dx + dy * dy + dz * dz));
      out[n + i] = wi[0][i] + 0.3 * wi[1][i] > 0 ? 1 / (2 * M_PI) : 0;
    }
  };
  const SphereIntegral s = integrateSphere(cells, f, 2, 2, 2e-6, 1000000);
  EXPECT_NEAR(s.total[0], 1, 1e-3);  // directions are single precision: 6e-8 of a lobe 1e-3 wide
  EXPECT_NEAR(s.total[1], 1, 1e-3);
  EXPECT_LT(s.totalError, 3e-3);
  // every direction has its cell
  for (int i = 0; i < 1000; ++i) {
    double jacobian;
    const uint32_t face = r.below(6);
    const double u = 2 * r.uniform() - 1, v = 2 * r.uniform() - 1;
    const uint32_t cell = cells.find(cells.direction(face, u, v, jacobian));
    const SphereCells::Cell& c = cells.cells()[cell];
    const double size = 2.0 / double(1u << c.level);
    EXPECT_TRUE(c.face == face && u > -1 + c.x * size - 1e-5 && u < -1 + (c.x + 1) * size + 1e-5);
  }
}

}  // namespace
}  // namespace kinora::testing
