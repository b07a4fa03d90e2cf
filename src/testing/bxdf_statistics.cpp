// The statistical half of the bxdf checks: samples against integrals, for one setting and outgoing direction.
#include <algorithm>
#include <cmath>

#include "testing/bxdf_case.h"
#include "testing/sphere_quadrature.h"

namespace kinora::testing {

namespace {
struct Sums {
  double sum = 0, squares = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
  }
  double mean(double n) const { return sum / n; }
  double error(double n) const { return std::sqrt(std::max(0.0, squares / n - (sum / n) * (sum / n)) / n); }
};
}  // namespace

void checkBxdfStatistics(Judge& judge, const BxdfCase& c, const StatisticsPlan& plan, uint64_t seed) {
  constexpr uint32_t kPoints = 2048, kMostSamples = 1u << 20;
  const Vec3 wo = directionAbout(kTestNormal, plan.cosine, 1.1);
  TestPoints p;
  p.N = {kTestNormal};
  p.tangent = {directionAbout(kTestNormal, 0, 0.7)};
  p.entering = {uint8_t(plan.outside)};
  p.wo.assign(kPoints, wo);
  TestContextOptions options;
  // albedos are of energy: across an interface that is what importance carries
  options.traits = c.encloses ? kTraitLightPath : kTraitEyePath;
  const BoundBxdf bxdf(c.bxdf, c.widest(), c.setting, p, options);
  const uint32_t slots = bxdf.slots();
  const std::string where =
      "wo " + text(wo) + text(" at cosine %.3g %s: ", plan.cosine, plan.outside ? "outside" : "inside");
  Random random(seed);
  Generation g(kPoints);
  const auto draw = [&] {
    for (uint32_t i = 0; i < kPoints; ++i)
      for (int k = 0; k < 4; ++k) g.u(k)[i] = random.uniformFloat();
    bxdf.generate(g);
  };

  // cells follow where samples of their own go; the tests use others
  SphereCells cells(kTestNormal, 2);
  std::vector<Vec3> pilot;
  draw();
  for (uint32_t i = 0; i < kPoints; ++i)
    if (g.valid(i) && !g.discrete(i)) pilot.push_back(g.wi(i));
  cells.refine(pilot, 24);

  // channels: pdf; pdf where there is weight (a sample without weight is no sample); sum of weights; weight by slot,
  // rgb; second moment of weight / pdf by slot, rgb, for slots chosen in proportion to their weight
  const uint32_t moments = 3 + 3 * slots, channels = 3 + 6 * slots;
  const auto evaluate = [&](uint32_t n, const float* const wi[3], double* out) {
    static thread_local Evaluation e(4096);
    if (e.count() != n) e = Evaluation(n);
    for (uint32_t i = 0; i < n; ++i) e.set(i, {wi[0][i], wi[1][i], wi[2][i]});
    bxdf.evaluateAt(0, e);
    for (uint32_t i = 0; i < n; ++i) {
      double sum = 0;
      for (uint32_t s = 0; s < slots; ++s)
        for (int k = 0; k < 3; ++k) {
          const double w = e.weight(s, k, i);
          out[size_t(3 + 3 * s + k) * n + i] = w;
          sum += w;
        }
      for (uint32_t s = 0; s < slots; ++s) {
        double own = 0;
        for (int k = 0; k < 3; ++k) own += out[size_t(3 + 3 * s + k) * n + i];
        const double scale = own > 0 && e.pdf(i) > 0 ? sum / (own * e.pdf(i)) : 0;
        for (int k = 0; k < 3; ++k) {
          const double w = out[size_t(3 + 3 * s + k) * n + i];
          out[size_t(moments + 3 * s + k) * n + i] = w * w * scale;
        }
      }
      out[i] = e.pdf(i);
      out[size_t(n) + i] = sum > 0 ? e.pdf(i) : 0;
      out[2 * size_t(n) + i] = sum * (1.0 / 3);
    }
  };
  const SphereIntegral integral = integrateSphere(cells, evaluate, channels, 3, 2e-6, 300000, pilot);
  if (!std::isfinite(integral.total[0]) || !std::isfinite(integral.total[2])) {
    judge.fail("finite", where + "evaluate gives values that cannot be integrated");
    return;
  }
  const double quadrature = integral.totalError;

  std::vector<double> counts(cells.count() + 1, 0);
  std::vector<Sums> slotSums(3 * slots), smooth(3), discrete(3);
  double n = 0, continuous = 0, mirrors = 0;
  const auto sample = [&] {
    draw();
    n += kPoints;
    for (uint32_t i = 0; i < kPoints; ++i) {
      if (!g.valid(i)) {
        counts.back() += 1;
        continue;
      }
      const double scale = 1.0 / g.pdf(i);
      if (g.discrete(i)) {
        mirrors += 1;
        counts.back() += 1;
        for (int k = 0; k < 3; ++k) discrete[k].add(g.weight(k, i) * scale);
        continue;
      }
      continuous += 1;
      counts[cells.find(g.wi(i))] += 1;
      for (int k = 0; k < 3; ++k) {
        slotSums[3 * g.slot(i) + k].add(g.weight(k, i) * scale);
        smooth[k].add(g.weight(k, i) * scale);
      }
    }
  };
  while (n < plan.samples) sample();

  // distribution
  std::vector<double> expected(cells.count() + 1, 0), deviation(cells.count() + 1, 0);
  for (uint32_t i = 0; i < cells.count(); ++i) {
    expected[i] = n * std::max(0.0, integral.cell[size_t(i) * channels + 1]);
    // single-precision directions blur cells by a few rounding errors of their size
    const double blur = 1e-7 * double(1u << cells.cells()[i].level);
    deviation[i] = n * integral.error[i] + expected[i] * (2e-4 + blur);
  }
  expected.back() = n * std::max(0.0, 1 - integral.total[1]);
  deviation.back() = n * (quadrature + 1e-4);
  const ChiSquare chi = chiSquareTest(counts, expected, deviation, 20);
  judge.test("chi-square", chi.p,
             where + text("%.0f samples, statistic %.5g, expected %.5g", n, chi.statistic, chi.freedom));

  // the pdf's integral: with the mirrors' probability never above 1, and the fraction of samples that are continuous
  const double fraction = continuous / n;
  judge.compare("pdf-integral", fraction, std::sqrt(std::max(fraction * (1 - fraction), 1 / n) / n),
                integral.total[1], quadrature + 3e-4,
                where + "fraction of continuous samples against the integral of pdf");
  const double mirrorShare = mirrors / n;
  const double mirrorError = std::sqrt(mirrorShare * (1 - mirrorShare) / n);
  if (integral.total[0] + mirrorShare > 1 + quadrature + 1e-3 + 6 * mirrorError)
    judge.fail("pdf-integral", where + text("expected at most 1, got %.6g (of it %.4g discrete)",
                                            integral.total[0] + mirrorShare, mirrorShare));
  judge.count(1);

  // weights by slot
  for (uint32_t s = 0; s < slots; ++s)
    for (int k = 0; k < 3; ++k) {
      const double whole = integral.total[3 + 3 * s + k];
      // rare bright samples may all be missing from those drawn: their variance is known from the integral
      const double variance = std::max(0.0, integral.total[moments + 3 * s + k] - whole * whole);
      const double error = std::max(slotSums[3 * s + k].error(n), std::sqrt(variance / n));
      judge.compare("weight-integral", slotSums[3 * s + k].mean(n), error, whole, quadrature + 1e-3 * whole + 1e-6,
                    where + text("slot %u, channel %d, mean of weight / pdf against the integral of evaluate", s, k));
    }

  // albedo by both roads
  double whole[3] = {0, 0, 0}, variance[3] = {0, 0, 0};
  for (uint32_t s = 0; s < slots; ++s)
    for (int k = 0; k < 3; ++k) {
      whole[k] += integral.total[3 + 3 * s + k];
      variance[k] += integral.total[moments + 3 * s + k];
    }
  if (plan.precise) {
    const auto wellKnown = [&] {
      for (int k = 0; k < 3; ++k)
        if (smooth[k].error(n) > 7e-4 * whole[k] + 1e-6 || discrete[k].error(n) > 1.5e-3) return false;
      return true;
    };
    while (n < kMostSamples && !wellKnown()) sample();
  }
  for (int k = 0; k < 3; ++k) {
    const double got = smooth[k].mean(n);
    const double error =
        std::max(smooth[k].error(n), std::sqrt(std::max(0.0, variance[k] - whole[k] * whole[k]) / n));
    judge.count(1);
    if (std::abs(got - whole[k]) >
        3e-3 * whole[k] + 2 * quadrature + 1e-6 + 5 * error * (error > 7e-4 * whole[k] ? 1 : 0.25))
      judge.fail("furnace", where + text("channel %d: albedo by quadrature %.6g, by sampling %.6g +- %.2g", k,
                                         whole[k], got, error));
    const double albedo = whole[k] + discrete[k].mean(n), spread = discrete[k].error(n);
    const double slack = 2 * quadrature + 5 * spread;
    if (plan.lossless && !(std::abs(albedo - 1) <= 0.01 + slack))
      judge.fail("lossless", where + text("channel %d: albedo: expected 1, got %.6g", k, albedo));
    if (plan.conserving && !(albedo <= 1.003 + slack))
      judge.fail("conserving", where + text("channel %d: albedo: expected at most 1, got %.6g", k, albedo));
  }
}

}  // namespace kinora::testing
