#include <kinora/testing/light_checks.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "testing/judge.h"
#include "testing/made_light.h"
#include "testing/sphere_quadrature.h"

namespace kinora::testing {

namespace {

constexpr double kPi = 3.14159265358979323846;

struct LightCase {
  const Descriptor& descriptor;
  const MadeLight& light;
  std::vector<const WidthTable*> tables;
  std::string where;
  const LightFunctions& widest() const { return *static_cast<const LightFunctions*>(tables.back()->functions); }
  const LightDescription& says() const { return light.description(); }
  bool finite() const { return !says().isInfinite && !says().isDelta && widest().intersect; }
};

double mean3(const Rows& a, uint32_t r, uint32_t i) { return (double(a[r][i]) + a[r + 1][i] + a[r + 2][i]) / 3; }
bool sameBits(const float* a, const float* b, uint32_t n) { return std::memcmp(a, b, n * sizeof *a) == 0; }

Vec3 randomDirection(Random& r) {
  const double z = 2 * r.uniform() - 1, phi = 2 * kPi * r.uniform(), s = std::sqrt(std::max(0.0, 1 - z * z));
  return {float(s * std::cos(phi)), float(s * std::sin(phi)), float(z)};
}

// Points about a finite light from near to far, or anywhere in the world of an infinite one.
Vec3 pointAbout(const LightDescription& d, Random& r) {
  const Vec3 w = randomDirection(r);
  if (d.isInfinite || !(d.radius >= 0)) return w * float(kWorldRadius * r.uniform());
  const float distance = std::max(d.radius, 1e-3f) * float(1.05 + 8 * r.uniform() * r.uniform());
  return Vec3{d.center[0], d.center[1], d.center[2]} + w * distance;
}

void checkLightWidths(Judge& judge, const LightCase& c, uint64_t seed) {
  for (const uint32_t n : {1u, 7u, 16u, 33u}) {
    std::vector<LightSamples> samples;
    std::vector<LightRays> rays;
    std::vector<LightEmissions> emissions;
    for (const WidthTable* table : c.tables) {
      const LightFunctions& f = *static_cast<const LightFunctions*>(table->functions);
      Random r(seed);
      LightSamples& s = samples.emplace_back(n);
      LightRays& y = rays.emplace_back(n);
      LightEmissions& e = emissions.emplace_back(n);
      for (uint32_t i = 0; i < n; ++i) {
        s.a.set(LightSamples::kP, i, pointAbout(c.says(), r));
        for (uint32_t k = 0; k < 2; ++k) s.a[LightSamples::kU + k][i] = r.uniformFloat();
        for (uint32_t k = 0; k < 4; ++k) e.a[LightEmissions::kU + k][i] = r.uniformFloat();
      }
      s.run(f, c.light.data());
      for (uint32_t i = 0; i < n; ++i) {
        y.a.set(LightRays::kO, i, s.a.get(LightSamples::kP, i));
        const Vec3 wi = s.a.get(LightSamples::kWi, i);
        y.a.set(LightRays::kD, i, s.valid(i) && (i & 1) ? wi : randomDirection(r));
      }
      y.run(f, c.light.data(), c.finite());
      if (f.emit) e.run(f, c.light.data());
      judge.count(3 * n);
      const auto differ = [&](const char* what) {
        judge.fail("width", c.where + text("width %u against %u, %u points: %s differs", table->width,
                                           c.tables[0]->width, n, what));
      };
      for (uint32_t row = LightSamples::kWi; row < LightSamples::kRows; ++row)
        if (!sameBits(s.a[row], samples[0].a[row], n)) return differ("sample");
      if (!std::equal(s.flags.begin(), s.flags.begin() + n, samples[0].flags.begin()))
        return differ("sample's flags");
      for (uint32_t row = LightRays::kT; row < LightRays::kRows; ++row)
        if (!sameBits(y.a[row], rays[0].a[row], n)) return differ("intersect or evaluate");
      for (uint32_t row = LightEmissions::kO; f.emit && row < LightEmissions::kRows; ++row)
        if (!sameBits(e.a[row], emissions[0].a[row], n)) return differ("emit");
    }
  }
}

// sample() from many points against the rays it makes. False when nothing more can be asked of this light.
bool checkLightSamples(Judge& judge, const LightCase& c, uint64_t seed) {
  constexpr uint32_t n = 1024;
  Random r(seed);
  LightSamples s(n);
  std::vector<bool> onRim(n, false);  // made with random numbers at their ends
  for (uint32_t i = 0; i < n; ++i) {
    s.a.set(LightSamples::kP, i, pointAbout(c.says(), r));
    for (uint32_t k = 0; k < 2; ++k) {
      const bool end = r.below(16) == 0;
      onRim[i] = onRim[i] || end;
      s.a[LightSamples::kU + k][i] = !end ? r.uniformFloat() : r.below(2) ? 0.f : 0x1.fffffep-1f;
    }
  }
  s.run(c.widest(), c.light.data());
  LightRays y(n);
  judge.count(n);
  uint32_t valid = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const Vec3 wi = s.a.get(LightSamples::kWi, i);
    const float pdf = s.a[LightSamples::kPdf][i], distance = s.a[LightSamples::kDistance][i];
    const std::string where = c.where + "P " + text(s.a.get(LightSamples::kP, i)) +
                              text(" u %.9g %.9g: ", s.a[LightSamples::kU][i], s.a[LightSamples::kU + 1][i]);
    if (!std::isfinite(pdf) || pdf < 0) {
      judge.fail("finite", where + text("sample gives pdf %g", pdf));
      return false;
    }
    if (!s.valid(i)) {
      y.a.set(LightRays::kO, i, s.a.get(LightSamples::kP, i));
      y.a.set(LightRays::kD, i, {0, 0, 1});
      continue;
    }
    ++valid;
    bool good = std::abs(dot(wi, wi) - 1) < 2e-5f && distance > 0 &&
                (c.says().isInfinite ? std::isinf(distance) : std::isfinite(distance));
    for (uint32_t k = 0; k < 3; ++k) good = good && std::isfinite(s.a[LightSamples::kRadiance + k][i]);
    if (!good) {
      judge.fail("finite", where + "sample gives wi " + text(wi) +
                               text(", distance %g, radiance %g %g %g", distance, s.a[LightSamples::kRadiance][i],
                                    s.a[LightSamples::kRadiance + 1][i], s.a[LightSamples::kRadiance + 2][i]));
      return false;
    }
    if (bool(s.flags[i] & kSampleDelta) != bool(c.says().isDelta)) {
      judge.fail("consistent", where + text("a light described as %s samples with delta flag %u",
                                            c.says().isDelta ? "delta" : "not delta", s.flags[i] & kSampleDelta));
      return false;
    }
    y.a.set(LightRays::kO, i, s.a.get(LightSamples::kP, i));
    y.a.set(LightRays::kD, i, wi);
  }
  if (c.says().isDelta) return true;
  y.run(c.widest(), c.light.data(), c.finite());
  // directions on the rim may fall off it by rounding, and so may those on the edges of a map's texels
  uint32_t off = 0;
  std::string first;
  for (uint32_t i = 0; i < n; ++i) {
    if (!s.valid(i) || onRim[i]) continue;
    const auto near = [](double a, double b) {
      return std::abs(a - b) <= 3e-3 * std::max(std::abs(a), std::abs(b)) + 1e-12;
    };
    const double l = mean3(s.a, LightSamples::kRadiance, i), back = mean3(y.a, LightRays::kRadiance, i);
    const bool same = near(s.a[LightSamples::kPdf][i], y.a[LightRays::kPdf][i]) && near(l, back) &&
                      (!c.finite() || near(s.a[LightSamples::kDistance][i], y.a[LightRays::kT][i]));
    if (same) continue;
    if (!off++)
      first =
          c.where + "P " + text(s.a.get(LightSamples::kP, i)) + " wi " + text(s.a.get(LightSamples::kWi, i)) +
          text(": sample: pdf %.7g, radiance %.7g, distance %.7g; ray: %s, pdf %.7g, radiance %.7g, distance %.7g",
               s.a[LightSamples::kPdf][i], l, s.a[LightSamples::kDistance][i], y.hit[i] ? "hits" : "misses",
               y.a[LightRays::kPdf][i], back, y.a[LightRays::kT][i]);
  }
  if (off > 2 + valid / 50) judge.fail("consistent", first + text(" (%u of %u samples)", off, valid));
  return true;
}

// Distribution, integrals and irradiance as seen from one point.
void checkLightFrom(Judge& judge, const LightCase& c, Vec3 P, Vec3 N, uint32_t samples, uint64_t seed) {
  constexpr uint32_t kPoints = 2048;
  const LightFunctions& f = c.widest();
  const std::string where = c.where + "P " + text(P) + " N " + text(N) + ": ";
  Random random(seed);
  LightSamples s(kPoints);
  for (uint32_t i = 0; i < kPoints; ++i) s.a.set(LightSamples::kP, i, P);
  const auto draw = [&] {
    for (uint32_t k = 0; k < 2; ++k)
      for (uint32_t i = 0; i < kPoints; ++i) s.a[LightSamples::kU + k][i] = random.uniformFloat();
    s.run(f, c.light.data());
  };
  std::vector<Vec3> pilot;
  Moments rough;
  for (uint32_t round = 0; round < 8; ++round) {
    draw();
    for (uint32_t i = 0; i < kPoints; ++i) {
      if (!s.valid(i)) continue;
      pilot.push_back(s.a.get(LightSamples::kWi, i));
      rough.add(mean3(s.a, LightSamples::kRadiance, i) / s.a[LightSamples::kPdf][i]);
    }
  }
  SphereCells cells(N, 2);
  cells.refine(pilot, 192);
  // irradiances are in units of what the pilot saw, so that one tolerance serves all
  const double unit = rough.mean() > 0 ? rough.mean() : 1;
  const auto evaluate = [&](uint32_t n, const float* const wi[3], double* out) {
    LightRays y(n);
    for (uint32_t i = 0; i < n; ++i) {
      y.a.set(LightRays::kO, i, P);
      y.a.set(LightRays::kD, i, {wi[0][i], wi[1][i], wi[2][i]});
    }
    y.run(f, c.light.data(), c.finite());
    for (uint32_t i = 0; i < n; ++i) {
      out[i] = y.a[LightRays::kPdf][i];
      const double cosine = std::max(0.f, dot(N, {wi[0][i], wi[1][i], wi[2][i]}));
      for (uint32_t k = 0; k < 3; ++k) out[size_t(2 + k) * n + i] = cosine * y.a[LightRays::kRadiance + k][i] / unit;
      out[size_t(n) + i] = (out[2 * size_t(n) + i] + out[3 * size_t(n) + i] + out[4 * size_t(n) + i]) / 3;
    }
  };
  const SphereIntegral integral = integrateSphere(cells, evaluate, 5, 2, 2e-5, 250000, pilot);
  if (!std::isfinite(integral.total[0]) || !std::isfinite(integral.total[1])) {
    judge.fail("finite", where + "evaluate gives values that cannot be integrated");
    return;
  }
  const double quadrature = integral.totalError;

  std::vector<double> counts(cells.count() + 1, 0), expected(cells.count() + 1, 0), deviation(cells.count() + 1, 0);
  Moments irradiance[3], mean;
  double n = 0, valid = 0;
  while (n < samples) {
    draw();
    n += kPoints;
    for (uint32_t i = 0; i < kPoints; ++i) {
      double value[3] = {0, 0, 0};
      if (s.valid(i)) {
        const Vec3 wi = s.a.get(LightSamples::kWi, i);
        valid += 1;
        counts[cells.find(wi)] += 1;
        const double scale = std::max(0.f, dot(N, wi)) / (double(s.a[LightSamples::kPdf][i]) * unit);
        for (uint32_t k = 0; k < 3; ++k) value[k] = s.a[LightSamples::kRadiance + k][i] * scale;
      } else {
        counts.back() += 1;
      }
      for (int k = 0; k < 3; ++k) irradiance[k].add(value[k]);
      mean.add((value[0] + value[1] + value[2]) / 3);
    }
  }
  for (uint32_t i = 0; i < cells.count(); ++i) {
    expected[i] = n * std::max(0.0, integral.cell[size_t(i) * 5]);
    const double blur =
        4e-7 * double(1u << cells.cells()[i].level);  // rounding of positions moves directions across cells
    deviation[i] = n * integral.error[i] + expected[i] * (1e-3 + blur);
  }
  expected.back() = n * std::max(0.0, 1 - integral.total[0]);
  deviation.back() = n * (integral.totalError + 1e-3);
  const ChiSquare chi = chiSquareTest(counts, expected, deviation, 20);
  judge.test("chi-square", chi.p,
             where + text("%.0f samples, statistic %.5g, expected %.5g", n, chi.statistic, chi.freedom));
  const double fraction = valid / n;
  judge.compare("pdf-integral", fraction, std::sqrt(std::max(fraction * (1 - fraction), 1 / n) / n),
                integral.total[0], quadrature + 1e-3, where + "fraction of samples against the integral of pdf");
  judge.count(1);
  if (integral.total[0] > 1 + quadrature + 2e-3)
    judge.fail("pdf-integral", where + text("expected at most 1, got %.6g +- %.2g", integral.total[0], quadrature));
  // far off the axis of a focused light next to nothing arrives, of a distribution without usable moments
  const double nothing = 1e-9 * c.says().power;
  for (int k = 0; k < 3; ++k)
    judge.compare("irradiance", irradiance[k].mean() * unit, irradiance[k].standardError() * unit,
                  integral.total[2 + k] * unit, (quadrature + 2e-3 * integral.total[2 + k]) * unit + nothing,
                  where + text("channel %d, sampling against integration", k));
  const LightTraits& traits = *static_cast<const LightTraits*>(c.descriptor.traits);
  if (traits.irradiance) {
    const double p[3] = {P.x, P.y, P.z}, normal[3] = {N.x, N.y, N.z};
    const double closed = traits.irradiance(c.light.data(), p, normal);
    if (closed >= 0)
      judge.compare("irradiance", mean.mean() * unit, mean.standardError() * unit, closed,
                    2e-3 * closed + 1e-12 * unit, where + "sampling against the declared closed form");
  }
}

// Of rays that look back along emitted ones: the densities that emit() told.
void checkLightDensities(Judge& judge, const LightCase& c, const LightEmissions& e, LightRays& back) {
  const uint32_t n = back.a.count();
  Rows out(n, 5);
  const void* light = c.light.data();
  LightDensityArgs a{};
  a.light = &light;
  a.count = n;
  for (uint32_t k = 0; k < 3; ++k) {
    a.o[k] = back.a[LightRays::kO + k];
    a.d[k] = back.a[LightRays::kD + k];
    a.N[k] = out[k];
  }
  a.t = back.a[LightRays::kT];
  a.time = back.a[LightRays::kTime];
  a.worldRadius = kWorldRadius;
  a.pdfPosition = out[3];
  a.pdfDirection = out[4];
  c.widest().densities(&a);
  uint32_t off = 0, all = 0;
  std::string first;
  for (uint32_t i = 0; i < n; ++i) {
    const float pp = e.a[LightEmissions::kPdfPosition][i], pd = e.a[LightEmissions::kPdfDirection][i];
    if (!(pp > 0) || !(pd > 0)) continue;
    ++all;
    const auto near = [](double x, double y) { return std::abs(x - y) <= 0.02 * std::max(std::abs(x), std::abs(y)); };
    const bool same =
        near(pp, out[3][i]) && near(pd, out[4][i]) && dot(e.a.get(LightEmissions::kN, i), out.get(0, i)) > 0.999f;
    if (!same && !off++)
      first = c.where + "o " + text(e.a.get(LightEmissions::kO, i)) + " d " + text(e.a.get(LightEmissions::kD, i)) +
              text(": emit has densities %.7g %.7g, densities() %.7g %.7g", pp, pd, out[3][i], out[4][i]);
  }
  judge.count(all);
  // grazing rays lose digits of position and cosine
  if (off > 2 + all / 50) judge.fail("emission", first + text(" (%u of %u rays)", off, all));
}

// Lanes that ask for different lights get what each gives alone.
void checkLightLanes(Judge& judge, const LightCase& c, const MadeLight& other, uint64_t seed) {
  constexpr uint32_t n = 33;
  for (const WidthTable* table : c.tables) {
    const LightFunctions& f = *static_cast<const LightFunctions*>(table->functions);
    Random r(seed);
    LightSamples samples[3] = {LightSamples(n), LightSamples(n), LightSamples(n)};
    LightRays rays[3] = {LightRays(n), LightRays(n), LightRays(n)};
    std::vector<const void*> lanes(padded(n));
    for (uint32_t i = 0; i < padded(n); ++i) lanes[i] = r.below(2) ? c.light.data() : other.data();
    const void* const alone[2] = {c.light.data(), other.data()};
    for (uint32_t i = 0; i < n; ++i) {
      const Vec3 P = pointAbout(c.says(), r), d = randomDirection(r);
      const float u[2] = {r.uniformFloat(), r.uniformFloat()};
      for (int k = 0; k < 3; ++k) {
        samples[k].a.set(LightSamples::kP, i, P);
        samples[k].a[LightSamples::kU][i] = u[0];
        samples[k].a[LightSamples::kU + 1][i] = u[1];
        rays[k].a.set(LightRays::kO, i, P);
        rays[k].a.set(LightRays::kD, i, d);
      }
    }
    for (int k = 0; k < 3; ++k) {
      samples[k].run(f, k < 2 ? &alone[k] : lanes.data(), k == 2);
      for (uint32_t i = 0; i < n; ++i)
        if (samples[0].valid(i)) rays[k].a.set(LightRays::kD, i, samples[0].a.get(LightSamples::kWi, i));
      rays[k].run(f, k < 2 ? &alone[k] : lanes.data(), k == 2, c.finite());
    }
    judge.count(n);
    for (uint32_t i = 0; i < n; ++i) {
      const int k = lanes[i] == alone[0] ? 0 : 1;
      bool same = true;
      for (uint32_t row = LightSamples::kWi; row < LightSamples::kRows; ++row)
        same = same && sameBits(&samples[2].a[row][i], &samples[k].a[row][i], 1);
      for (uint32_t row = LightRays::kT; row < LightRays::kRows; ++row)
        same = same && sameBits(&rays[2].a[row][i], &rays[k].a[row][i], 1);
      if (same) continue;
      judge.fail("width",
                 c.where + text("width %u: beside another light's points a point gets other numbers", table->width));
      return;
    }
  }
}

// Power by emitted rays, against what arrives on a sphere about the light (or a disk of the world, for infinite
// ones).
void checkLightPower(Judge& judge, const LightCase& c, uint32_t samples, uint64_t seed) {
  const LightFunctions& f = c.widest();
  if (!f.emit) return;
  constexpr uint32_t kPoints = 2048;
  Random r(seed);
  const LightDescription& d = c.says();
  const bool infinite = d.isInfinite;
  const Vec3 center{d.center[0], d.center[1], d.center[2]};
  const float reach = infinite ? kWorldRadius : std::max(1.5f * d.radius, 1e-3f);
  Moments emitted, arriving;
  LightEmissions e(kPoints);
  LightSamples s(kPoints);
  LightRays back(kPoints);
  bool positionsGood = true;
  for (uint32_t done = 0; done < samples; done += kPoints) {
    for (uint32_t i = 0; i < kPoints; ++i) {
      for (uint32_t k = 0; k < 4; ++k) e.a[LightEmissions::kU + k][i] = r.uniformFloat();
      for (uint32_t k = 0; k < 2; ++k) s.a[LightSamples::kU + k][i] = r.uniformFloat();
      s.a.set(LightSamples::kP, i, infinite ? Vec3{0, 0, 0} : center + randomDirection(r) * reach);
    }
    e.run(f, c.light.data());
    s.run(f, c.light.data());
    for (uint32_t i = 0; i < kPoints; ++i) {
      const float pp = e.a[LightEmissions::kPdfPosition][i], pd = e.a[LightEmissions::kPdfDirection][i];
      const Vec3 o = e.a.get(LightEmissions::kO, i), w = e.a.get(LightEmissions::kD, i),
                 normal = e.a.get(LightEmissions::kN, i);
      const double l = mean3(e.a, LightEmissions::kRadiance, i);
      if (!std::isfinite(pp) || !std::isfinite(pd) || pp < 0 || pd < 0 || !std::isfinite(l)) {
        judge.fail("finite", c.where + text("emit gives pdfs %g %g, radiance %g", pp, pd, l));
        return;
      }
      const bool some = pp > 0 && pd > 0;
      emitted.add(some ? l * std::abs(double(dot(normal, w))) / (double(pp) * pd) : 0);
      const Vec3 P = s.a.get(LightSamples::kP, i), wi = s.a.get(LightSamples::kWi, i);
      const double cosine = infinite ? 1 : std::max(0.f, dot(wi, normalized(center + -P)));
      const double area = infinite ? kPi * reach * reach : 4 * kPi * double(reach) * reach;
      arriving.add(s.valid(i) ? mean3(s.a, LightSamples::kRadiance, i) * cosine / s.a[LightSamples::kPdf][i] * area
                              : 0);
      if (some && done == 0) {
        const bool unitVectors = std::abs(dot(w, w) - 1) < 2e-5f && std::abs(dot(normal, normal) - 1) < 2e-5f;
        const Vec3 from = o + -center;
        const bool onLight = infinite || std::sqrt(dot(from, from)) <= d.radius * 1.001f + 1e-6f;
        if (positionsGood && (!unitVectors || !onLight)) {
          judge.fail("emission", c.where + "emit gives o " + text(o) + " d " + text(w) + " N " + text(normal) +
                                     text(", light of radius %g at ", d.radius) + text(center));
          positionsGood = false;
        }
      }
      // looking back from along the ray
      back.a.set(LightRays::kO, i, some ? o + w * reach : center + Vec3{0, 0, reach});
      back.a.set(LightRays::kD, i, some ? -w : Vec3{0, 0, 1});
    }
    if (done == 0 && !d.isDelta) {
      back.run(f, c.light.data(), c.finite());
      uint32_t off = 0, all = 0;
      std::string first;
      for (uint32_t i = 0; i < kPoints; ++i) {
        if (!(e.a[LightEmissions::kPdfPosition][i] > 0) || !(e.a[LightEmissions::kPdfDirection][i] > 0)) continue;
        ++all;
        const double l = mean3(e.a, LightEmissions::kRadiance, i), seen = mean3(back.a, LightRays::kRadiance, i);
        const double t = back.a[LightRays::kT][i];
        // grazing rays lose digits of position and cosine
        const bool same = std::abs(l - seen) <= 0.01 * std::max(std::abs(l), std::abs(seen)) + 1e-12 &&
                          (!c.finite() || std::abs(t - reach) <= 0.01 * reach);
        if (!same && !off++)
          first = c.where + "o " + text(e.a.get(LightEmissions::kO, i)) + " d " +
                  text(e.a.get(LightEmissions::kD, i)) +
                  text(": emitted radiance %.7g, seen %.7g; distance %.6g, seen %.6g", l, seen, reach, t);
      }
      judge.count(all);
      if (off > 2 + all / 50) judge.fail("emission", first + text(" (%u of %u rays)", off, all));
      if (f.densities) checkLightDensities(judge, c, e, back);
    }
  }
  const double error = std::hypot(emitted.standardError(), arriving.standardError());
  judge.compare("power", emitted.mean(), error, arriving.mean(), 3e-3 * std::abs(arriving.mean()) + 1e-20,
                c.where + "power by emit against power by sample");
  if (arriving.mean() > 10 * error && !(d.power > 0))
    judge.fail("power", c.where + text("the light emits %g and describes its power as %g", arriving.mean(), d.power));
}

std::vector<Placement> placements() {
  const auto make = [](double sx, double sy, double sz, double angle, double x, double y, double z) {
    // row vectors: scale, then turn about (1, 2, 2) / 3 (Rodrigues' formula), then move
    Placement p{};
    const double a[3] = {1.0 / 3, 2.0 / 3, 2.0 / 3}, c = std::cos(angle), s = std::sin(angle),
                 scale[3] = {sx, sy, sz};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        const int third = 3 - i - k;
        const double turned =
            c * (i == k) + (1 - c) * a[i] * a[k] + (i == k ? 0 : s * a[third] * ((k - i + 3) % 3 == 1 ? 1 : -1));
        p.localToRender[4 * i + k] = scale[i] * turned;
      }
    p.localToRender[12] = x;
    p.localToRender[13] = y;
    p.localToRender[14] = z;
    p.localToRender[15] = 1;
    p.isStatic = 1;
    return p;
  };
  return {make(1, 1, 1, 0, 0, 0, 0), make(1, 1, 1, 0.9, 0.5, -1.5, 2), make(2, 0.5, 1.5, -2.2, -1, 0.3, 0.2)};
}

void checkCase(Judge& judge, const Descriptor& d, const Setting& s, size_t placement, uint64_t seed,
               const LightCheckOptions& o) {
  const std::vector<Placement> all = placements();
  const size_t which = placement % all.size();
  const MadeLight light(d, s, all[which]);
  if (!light.error().empty()) {
    judge.fail("declaration", light.error());
    return;
  }
  LightCase c{d, light, runnableTables(d), text("placement %zu: ", which)};
  std::sort(c.tables.begin(), c.tables.end(), [](auto* a, auto* b) { return a->width < b->width; });
  const LightDescription& says = light.description();
  bool described = std::isfinite(says.power) && says.power >= 0 && std::isfinite(says.radius) &&
                   (says.isInfinite || says.isDelta || says.radius >= 0);
  for (const float x : says.center) described = described && std::isfinite(x);
  if (!described) {
    judge.fail("finite", c.where + text("describe gives power %g, radius %g", says.power, says.radius));
    return;
  }
  if (!says.isInfinite && !says.isDelta && !c.widest().intersect) {
    judge.fail("declaration", "a finite light needs intersect");
    return;
  }
  checkLightWidths(judge, c, seed);
  const MadeLight other(d, s, all[(which + 1) % all.size()]);
  // black lights are never asked, least of all beside others
  if (other.error().empty() && says.power > 0 && other.description().power > 0)
    checkLightLanes(judge, c, other, seed);
  if (!checkLightSamples(judge, c, seed + 1)) return;
  checkLightPower(judge, c, o.samples, seed + 2);
  if (says.isDelta) return;
  Random r(seed + 3);
  for (uint32_t look = 0; look < 2; ++look) {
    // a point that the light reaches, if one is soon found; N faces the light or stands askew
    Vec3 P{}, N{0, 0, 1};
    for (int attempt = 0; attempt < 24; ++attempt) {
      constexpr uint32_t kLooks = 64;
      P = pointAbout(says, r);
      LightSamples s(kLooks);
      for (uint32_t i = 0; i < kLooks; ++i) {
        s.a.set(LightSamples::kP, i, P);
        for (uint32_t k = 0; k < 2; ++k) s.a[LightSamples::kU + k][i] = r.uniformFloat();
      }
      s.run(c.widest(), light.data());
      Vec3 first{};
      double solidAngle = 0, width2 = 0, valid = 0;
      for (uint32_t i = 0; i < kLooks; ++i) {
        if (!s.valid(i)) continue;
        const Vec3 wi = s.a.get(LightSamples::kWi, i);
        if (!valid++) first = wi;
        const Vec3 across = wi + -first;
        width2 = std::max(width2, double(dot(across, across)));
        solidAngle += 1.0 / s.a[LightSamples::kPdf][i];
      }
      // seen edge-on a light is a sliver that cells of directions resolve badly; single points are compared there too
      if (!valid || solidAngle / valid < 0.1 * width2) continue;
      N = normalized(first + randomDirection(r) * (look ? 0.8f : 0.1f));
      break;
    }
    checkLightFrom(judge, c, P, N, o.samples, seed + 10 + look);
  }
}

std::string unusableLight(const Descriptor& d) {
  if (d.kind != Kind::Light) return "not a light";
  if (!d.traits || !static_cast<const LightTraits*>(d.traits)->describe) return "has no LightTraits with describe";
  const auto tables = runnableTables(d);
  if (tables.empty()) return "has no function table that this CPU runs";
  for (const WidthTable* t : tables) {
    const LightFunctions& f = *static_cast<const LightFunctions*>(t->functions);
    if (!f.sample || !f.evaluate) return "lacks sample or evaluate";
  }
  return {};
}

}  // namespace

CheckReport checkLight(const Descriptor& light, const Setting& setting, const LightCheckOptions& options) {
  Judge judge(light.name);
  if (const std::string why = unusableLight(light); !why.empty()) {
    judge.fail("declaration", why);
    return judge.finish();
  }
  judge.setSetting(setting.text);
  for (size_t p = 0; p < placements().size(); ++p)
    checkCase(judge, light, setting, p, options.seed * 1000003 + 17 * p, options);
  return judge.finish();
}

CheckReport checkLight(const Descriptor& light, const LightCheckOptions& options) {
  Judge judge(light.name);
  if (const std::string why = unusableLight(light); !why.empty()) {
    judge.fail("declaration", why);
    return judge.finish();
  }
  std::vector<Setting> settings = coveringSettings(light, options.randomSettings, options.seed);
  // images: the defaults and the last settings again, with the kit's image in each parameter that names a file
  const size_t plain = settings.size();
  for (uint32_t i = 0; i < light.paramCount; ++i) {
    if (!(light.params[i].flags & kParamFile)) continue;
    for (const size_t base : {size_t(0), plain - 1, plain / 2}) {
      Setting s = settings[base];
      s.strings[i] = {kTestImage};
      s.given[i] = true;
      s.text = (base ? s.text + "; " : "") + light.params[i].name + "=" + kTestImage;
      settings.insert(settings.begin() + 1, std::move(s));
    }
  }
  uint64_t seed = options.seed * 1000003;
  for (size_t i = 0; i < settings.size(); ++i) {
    judge.setSetting(settings[i].text);
    for (size_t p = 0; p < placements().size(); ++p) {
      // the defaults stand everywhere, the others at one place each
      if (i && (i + options.seed) % placements().size() != p) continue;
      checkCase(judge, light, settings[i], p, seed += 29, options);
    }
  }
  return judge.finish();
}

}  // namespace kinora::testing
