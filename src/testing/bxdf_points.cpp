// The exact half of the bxdf checks: comparisons at single points, cheap enough for every setting.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "testing/bxdf_case.h"

namespace kinora::testing {

namespace {

bool sameBits(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool usable(float x) { return std::isfinite(x) && x >= 0; }

// Points with all kinds of normals and directions; the first ones of a set do not depend on its size.
TestPoints wildPoints(uint32_t n, uint64_t seed, std::vector<Vec3>* wi) {
  TestPoints p;
  p.N.clear();
  p.wo.clear();
  p.P.clear();
  p.outerIor.clear();
  p.entering.clear();
  p.uv.clear();
  Random r(seed);
  for (uint32_t i = 0; i < n; ++i) {
    const Vec3 normal = uniformDirection(r);
    const Vec3 wo = directionAbout(normal, 0.02 + 0.98 * r.uniform(), 6.283185307179586 * r.uniform());
    // the geometric normal within some 20 degrees of the shading normal, on wo's side
    Vec3 ng = normalized(normal + uniformDirection(r) * 0.35f);
    if (dot(ng, wo) < 0.01f || r.below(2)) ng = normal;
    p.N.push_back(normal);
    p.Ng.push_back(ng);
    p.wo.push_back(wo);
    p.P.push_back({float(r.uniform()), float(r.uniform()), float(r.uniform())});
    p.uv.push_back({float(r.uniform()), float(r.uniform()), 0});
    p.outerIor.push_back(r.below(4) ? 1.f : 1.33f);
    p.entering.push_back(uint8_t(r.below(3) != 0));
    const Vec3 mirror = normalized(normal * (2 * dot(normal, wo)) + -wo);
    if (wi) wi->push_back(r.below(3) ? uniformDirection(r) : normalized(mirror + uniformDirection(r) * 0.1f));
  }
  return p;
}

void fillRandom(Generation& g, uint32_t n, uint64_t seed) {
  Random r(seed);
  for (uint32_t i = 0; i < n; ++i)
    for (int k = 0; k < 4; ++k) {
      const uint32_t edge = r.below(12);  // the ends of the interval now and then
      const float u = r.uniformFloat();
      g.u(k)[i] = edge == 0 ? 0.f : edge == 1 ? 0x1.fffffep-1f : u;
    }
}

std::string at(const Context& c, uint32_t i, Vec3 wi) {
  return "wo " + text(Vec3{c.wo[0][i], c.wo[1][i], c.wo[2][i]}) + " N " +
         text(Vec3{c.N[0][i], c.N[1][i], c.N[2][i]}) + " wi " + text(wi) + ": ";
}

// True when all of an evaluation is finite and not negative.
bool checkFinite(Judge& judge, const BoundBxdf& b, const Evaluation& e) {
  bool good = true;
  judge.count(e.count());
  for (uint32_t i = 0; i < e.count() && good; ++i) {
    if (!usable(e.pdf(i)) || !usable(e.pdfReverse(i))) {
      judge.fail("finite", at(b.context(), i, e.wi(i)) +
                               text("evaluate gives pdf %g, pdfReverse %g", e.pdf(i), e.pdfReverse(i)));
      good = false;
    }
    for (uint32_t s = 0; s < b.slots() && good; ++s)
      for (int k = 0; k < 3 && good; ++k)
        if (!usable(e.weight(s, k, i))) {
          judge.fail("finite", at(b.context(), i, e.wi(i)) +
                                   text("evaluate gives weight %g (slot %u, channel %d)", e.weight(s, k, i), s, k));
          good = false;
        }
  }
  return good;
}

bool checkFinite(Judge& judge, const BoundBxdf& b, Generation& g, uint32_t n) {
  judge.count(n);
  for (uint32_t i = 0; i < n; ++i) {
    const std::string where =
        at(b.context(), i, g.wi(i)) + text("u %.9g %.9g %.9g %.9g: ", g.u(0)[i], g.u(1)[i], g.u(2)[i], g.u(3)[i]);
    const bool allUsable = usable(g.pdf(i)) && usable(g.pdfReverse(i)) && usable(g.weight(0, i)) &&
                           usable(g.weight(1, i)) && usable(g.weight(2, i));
    if (!allUsable) {
      judge.fail("finite", where + text("generate gives weight (%g %g %g), pdf %g, pdfReverse %g", g.weight(0, i),
                                        g.weight(1, i), g.weight(2, i), g.pdf(i), g.pdfReverse(i)));
      return false;
    }
    if (!g.valid(i)) continue;
    const float length2 = dot(g.wi(i), g.wi(i));
    if (!(std::abs(length2 - 1) < 2e-5f)) {
      judge.fail("finite", where + text("generate gives a direction of squared length %.9g", length2));
      return false;
    }
    if (!(g.pdf(i) > 0) || (g.discrete(i) && g.pdf(i) > 1.0001f) || g.slot(i) >= b.slots()) {
      judge.fail("finite", where + text("generate gives pdf %g, slot %u of %u", g.pdf(i), g.slot(i), b.slots()));
      return false;
    }
  }
  return true;
}

// Colours over whole contexts: emission, albedo, presence, interior.
std::vector<float> wholeContext(const BoundBxdf& b, uint32_t n) {
  const BxdfFunctions& f = b.functions();
  const Context& c = b.context();
  std::vector<float> all;
  const auto call = [&](int components, auto&& run) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::vector<float> data(size_t(c.padded) * components, nan);
    float* rows[6] = {};
    for (int k = 0; k < components; ++k) rows[k] = data.data() + size_t(k) * c.padded;
    run(rows);
    for (int k = 0; k < components; ++k) all.insert(all.end(), rows[k], rows[k] + n);
  };
  if (f.emission) call(3, [&](float* const* r) { f.emission(&c, c.closure, r); });
  if (f.albedo) call(3, [&](float* const* r) { f.albedo(&c, c.closure, r); });
  if (f.presence) call(1, [&](float* const* r) { f.presence(&c, r[0]); });
  if (f.interior)
    call(4, [&](float* const* r) {
      const InteriorArgs a{r[0], {r[1], r[2], r[3]}};
      f.interior(&c, &a);
    });
  for (const bool emits : {false, true})
    if (f.medium)
      call(emits ? 6 : 3, [&](float* const* r) {
        MediumArgs a{{r[0], r[1], r[2]}, {nullptr, nullptr, nullptr}};
        for (int k = 0; emits && k < 3; ++k) a.emission[k] = r[3 + k];
        f.medium(&c, &a);
      });
  return all;
}

// What a bxdf says of n points and directions, and of those directions at the middle one.
struct Answers {
  Evaluation e, a;
  Generation g;
  Answers(const BoundBxdf& b, uint32_t n, const std::vector<Vec3>& wi, uint64_t seed) : e(n), a(n), g(n) {
    for (uint32_t i = 0; i < n; ++i) {
      e.set(i, wi[i]);
      a.set(i, wi[i]);
    }
    b.evaluate(e);
    b.evaluateAt(n / 2, a);
    fillRandom(g, n, seed + n);
    b.generate(g);
  }
};

void checkWidths(Judge& judge, const BxdfCase& c, uint64_t seed) {
  for (const uint32_t n : {1u, 7u, 16u, 33u}) {
    std::vector<Vec3> wi;
    const TestPoints points = wildPoints(n, seed, &wi);
    const WidthTable& first = *c.tables.front();
    const BoundBxdf reference(c.bxdf, first, c.setting, points);
    Answers answers(reference, n, wi, seed);
    const Evaluation &e0 = answers.e, &a0 = answers.a;
    Generation& g0 = answers.g;
    const std::vector<float> whole0 = wholeContext(reference, n);
    if (!checkFinite(judge, reference, e0) || !checkFinite(judge, reference, g0, n)) return;
    for (const float x : whole0)
      if (!usable(x)) {
        judge.fail("finite", text("emission, albedo, presence or interior gives %g", x));
        return;
      }

    const auto compare = [&](const BoundBxdf& other, const char* check, const std::string& who) {
      const Answers found(other, n, wi, seed);
      const Evaluation &e = found.e, &a = found.a;
      const Generation& g = found.g;
      judge.count(n);
      for (uint32_t i = 0; i < n; ++i) {
        const char* what = nullptr;
        float expected = 0, got = 0;
        const auto same = [&](const char* name, float x, float y) {
          if (what || sameBits(x, y)) return;
          what = name;
          expected = x;
          got = y;
        };
        for (int way = 0; way < 2; ++way) {
          const Evaluation &x = way ? a0 : e0, &y = way ? a : e;
          same(way ? "evaluateAt's pdf" : "evaluate's pdf", x.pdf(i), y.pdf(i));
          same(way ? "evaluateAt's pdfReverse" : "evaluate's pdfReverse", x.pdfReverse(i), y.pdfReverse(i));
          for (uint32_t s = 0; s < reference.slots(); ++s)
            for (int k = 0; k < 3; ++k)
              same(way ? "evaluateAt's weight" : "evaluate's weight", x.weight(s, k, i), y.weight(s, k, i));
        }
        for (int k = 0; k < 3; ++k) same("generate's weight", g0.weight(k, i), g.weight(k, i));
        same("generate's pdf", g0.pdf(i), g.pdf(i));
        same("generate's pdfReverse", g0.pdfReverse(i), g.pdfReverse(i));
        same("generate's slot", float(g0.slot(i)), float(g.slot(i)));
        if (g0.valid(i)) {
          same("generate's flags", float(g0.flags(i)), float(g.flags(i)));
          same("generate's wi", g0.wi(i).x, g.wi(i).x);
          same("generate's wi", g0.wi(i).y, g.wi(i).y);
          same("generate's wi", g0.wi(i).z, g.wi(i).z);
        }
        if (what) {
          judge.fail(check, at(reference.context(), i, wi[i]) + who +
                                text(", %u points: %s: expected %.9g, got %.9g", n, what, expected, got));
          return false;
        }
      }
      const std::vector<float> whole = wholeContext(other, n);
      if (whole.size() != whole0.size() || std::memcmp(whole.data(), whole0.data(), whole.size() * sizeof(float))) {
        judge.fail(check, who + text(", %u points: emission, albedo, presence or interior differ", n));
        return false;
      }
      return true;
    };
    for (size_t t = 1; t < c.tables.size(); ++t) {
      const BoundBxdf other(c.bxdf, *c.tables[t], c.setting, points);
      if (!compare(other, "width", text("width %u against %u", c.tables[t]->width, first.width))) return;
    }
    TestContextOptions varying;
    varying.varying = true;
    const BoundBxdf other(c.bxdf, c.widest(), c.setting, points, varying);
    if (!compare(other, "evaluate-at", "varying parameters against uniform ones")) return;

    // one direction at one point, for each point
    const BoundBxdf wide(c.bxdf, c.widest(), c.setting, points);
    for (uint32_t i = 0; i < n; ++i) {
      Evaluation one(1);
      one.set(0, wi[i]);
      wide.evaluateAt(i, one);
      bool equal = sameBits(one.pdf(0), e0.pdf(i)) && sameBits(one.pdfReverse(0), e0.pdfReverse(i));
      for (uint32_t s = 0; s < wide.slots(); ++s)
        for (int k = 0; k < 3; ++k) equal = equal && sameBits(one.weight(s, k, 0), e0.weight(s, k, i));
      judge.count(1);
      if (!equal) {
        judge.fail("evaluate-at",
                   at(wide.context(), i, wi[i]) +
                       text("evaluate gives pdf %.9g, evaluateAt %.9g (or a weight differs)", e0.pdf(i), one.pdf(0)));
        return;
      }
    }
  }
}

// wo on the horizon, wi wherever formulas divide by zero, random numbers at their ends.
void checkDegenerate(Judge& judge, const BxdfCase& c) {
  const Vec3 n = kTestNormal;
  const Vec3 t = directionAbout(n, 0, 0.3), b = cross(n, t);
  std::vector<Vec3> outgoing{n};
  for (const float cosine : {1e-3f, 1e-5f, 1e-7f, 0.f}) outgoing.push_back(normalized(t + n * cosine));
  TestPoints p;
  p.wo.clear();
  p.N = {n};
  p.entering.clear();
  std::vector<Vec3> wi;
  for (const Vec3& wo : outgoing) {
    const Vec3 mirror = normalized(n * (2 * dot(n, wo)) + -wo);
    for (const Vec3& w : {n, -n, wo, -wo, mirror, -mirror, t, -t, b, normalized(b + n * 1e-6f),
                          normalized(b + n * -1e-6f), normalized(-t + n * 1e-4f), normalized(-t + n * -1e-4f)})
      for (const uint8_t entering : {1, 0}) {
        p.wo.push_back(wo);
        p.entering.push_back(entering);
        wi.push_back(w);
      }
  }
  const BoundBxdf bxdf(c.bxdf, c.widest(), c.setting, p);
  Evaluation e(uint32_t(wi.size()));
  for (uint32_t i = 0; i < wi.size(); ++i) e.set(i, wi[i]);
  bxdf.evaluate(e);
  if (!checkFinite(judge, bxdf, e)) return;
  Generation g(uint32_t(wi.size()));
  const float ends[4] = {0.f, 0x1p-24f, 0.5f, 0x1.fffffep-1f};
  for (uint32_t round = 0; round < 8; ++round) {
    Random r(round + 1);
    for (uint32_t i = 0; i < wi.size(); ++i)
      for (int k = 0; k < 4; ++k) g.u(k)[i] = ends[r.below(4)];
    bxdf.generate(g);
    if (!checkFinite(judge, bxdf, g, uint32_t(wi.size()))) return;
  }
}

// How much single precision may move what is evaluated: differences to directions a few rounding errors away.
struct Tolerant {
  Evaluation e, p, q;
  explicit Tolerant(uint32_t n) : e(n), p(n), q(n) {}
  void evaluate(const BoundBxdf& b, const std::vector<Vec3>& wi) {
    for (uint32_t i = 0; i < wi.size(); ++i) {
      const Vec3 t = normalized(cross(std::abs(wi[i].x) < 0.7f ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, wi[i]));
      e.set(i, wi[i]);
      p.set(i, wi[i] + t * 3e-7f);
      q.set(i, wi[i] + cross(wi[i], t) * 3e-7f);
    }
    b.evaluate(e);
    b.evaluate(p);
    b.evaluate(q);
  }
  double slack(double value, double a, double b) const {
    return 4 * std::max(std::abs(a - value), std::abs(b - value)) + 3e-4 * std::abs(value) + 1e-6;
  }
  double pdfSlack(uint32_t i) const { return slack(e.pdf(i), p.pdf(i), q.pdf(i)); }
  double reverseSlack(uint32_t i) const { return slack(e.pdfReverse(i), p.pdfReverse(i), q.pdfReverse(i)); }
  double weightSlack(uint32_t slots, int k, uint32_t i) const {
    return slack(e.total(slots, k, i), p.total(slots, k, i), q.total(slots, k, i));
  }
};

// Directions along a fibre are at no offset.
bool isAlong(Vec3 fibre, Vec3 w) {
  const Vec3 across = cross(normalized(fibre), w);
  return dot(across, across) < 1e-6f;
}
// The normal where a path that comes back along wi goes into a fibre: at the offset of the test's normal as seen from wo,
// to the other side. See kBxdfFiber.
Vec3 mirroredAcross(Vec3 fibre, Vec3 wo, Vec3 wi) {
  const Vec3 t = normalized(fibre);
  if (isAlong(t, wi)) return kTestNormal;
  const auto across = [&](Vec3 w) { return normalized(w + t * -dot(t, w)); };
  const Vec3 from = across(wo), back = across(wi);
  const float side = dot(kTestNormal, cross(t, from));
  return normalized(back * dot(kTestNormal, from) + cross(t, back) * -side);
}

// Generate against evaluate; lobes against sides; both against the exchanged directions.
void checkPairs(Judge& judge, const BxdfCase& c, uint64_t seed, bool outside) {
  constexpr uint32_t n = 96;
  Random r(seed);
  TestPoints p;
  p.N = {kTestNormal};
  p.tangent = {directionAbout(kTestNormal, 0, 0.7)};
  p.entering = {uint8_t(outside)};
  p.wo.clear();
  for (uint32_t i = 0; i < n; ++i)
    p.wo.push_back(directionAbout(kTestNormal, 0.02 + 0.98 * r.uniform(), 6.283185307179586 * r.uniform()));
  const BoundBxdf bxdf(c.bxdf, c.widest(), c.setting, p);
  const uint32_t slots = bxdf.slots();
  Generation g(n);
  fillRandom(g, n, seed + 1);
  bxdf.generate(g);
  std::vector<Vec3> wi(n);
  for (uint32_t i = 0; i < n; ++i) wi[i] = g.valid(i) && !g.discrete(i) ? g.wi(i) : uniformDirection(r);
  Tolerant own(n);
  own.evaluate(bxdf, wi);
  if (!checkFinite(judge, bxdf, own.e)) return;
  judge.count(n);

  for (uint32_t i = 0; i < n; ++i) {
    if (!g.valid(i)) continue;
    const std::string where = at(bxdf.context(), i, g.wi(i));
    const bool below = dot(kTestNormal, g.wi(i)) < 0;
    if (std::abs(dot(kTestNormal, g.wi(i))) > 1e-5f && below != bool(g.flags(i) & kSampleTransmit)) {
      judge.fail("side", where + text("the transmit flag is %d", g.flags(i) & kSampleTransmit ? 1 : 0));
      return;
    }
    if (g.discrete(i)) continue;
    if (!(std::abs(g.pdf(i) - own.e.pdf(i)) <= own.pdfSlack(i))) {
      judge.fail("consistent", where + text("evaluate's pdf is %.7g, generate's %.7g", own.e.pdf(i), g.pdf(i)));
      return;
    }
    if (!(std::abs(g.pdfReverse(i) - own.e.pdfReverse(i)) <= own.reverseSlack(i))) {
      judge.fail("consistent", where + text("evaluate's pdfReverse is %.7g, generate's %.7g", own.e.pdfReverse(i),
                                            g.pdfReverse(i)));
      return;
    }
    // the weight is that of its slot, divided by the probability with which the slot was chosen
    double weight = 0, own3 = 0;
    for (int k = 0; k < 3; ++k) {
      weight += g.weight(k, i);
      own3 += own.e.weight(g.slot(i), k, i);
    }
    const double ratio = own3 > 0 ? weight / own3 : 0;
    for (int k = 0; k < 3; ++k) {
      const double expected = ratio * own.e.weight(g.slot(i), k, i);
      const double slack = own.weightSlack(slots, k, i) * std::max(1.0, ratio);
      if (ratio < 0.999 - 2 * slack / std::max(own3, 1e-9) ||
          (slots == 1 && std::abs(ratio - 1) * own3 > 3 * slack) || !(std::abs(g.weight(k, i) - expected) <= slack)) {
        judge.fail(
            "consistent",
            where + text("slot %u, channel %d: evaluate's weight is %.7g, generate's %.7g (ratio of sums %.7g)",
                         g.slot(i), k, own.e.weight(g.slot(i), k, i), g.weight(k, i), ratio));
        return;
      }
    }
  }

  // lobes declared reflecting or transmitting, slot by slot
  bool reflects[kMaxSlots] = {}, transmits[kMaxSlots] = {};
  for (uint32_t l = 0; l < bxdf.context().lobeCount; ++l) {
    const uint32_t flags = c.traits.lobes[l].flags, slot = bxdf.context().slotOfLobe[l];
    if ((flags & kLobeTransmit) || c.fillsSpace) transmits[slot] = true;
    if (!(flags & kLobeTransmit)) reflects[slot] = true;
  }
  Evaluation all(n);
  for (uint32_t i = 0; i < n; ++i) all.set(i, i & 1 ? uniformDirection(r) : wi[i]);
  bxdf.evaluate(all);
  for (uint32_t i = 0; i < n; ++i) {
    const float side = dot(kTestNormal, all.wi(i));
    if (std::abs(side) < 1e-4f) continue;
    for (uint32_t s = 0; s < slots; ++s) {
      if (side > 0 ? reflects[s] : transmits[s]) continue;
      for (int k = 0; k < 3; ++k)
        if (all.weight(s, k, i) != 0) {
          judge.fail("side",
                     at(bxdf.context(), i, all.wi(i)) + text("%s the surface: slot %u: expected 0, got %g",
                                                             side > 0 ? "above" : "below", s, all.weight(s, k, i)));
          return;
        }
    }
  }
  if (c.bumped) return;

  // the exchanged situation: seen from wi; below the surface both normals turn and the sides swap
  TestPoints swapped;
  swapped.N.clear();
  swapped.wo = wi;
  swapped.tangent = p.tangent;
  swapped.bitangent = {cross(kTestNormal, p.tangent[0])};  // the parameters of the surface do not turn
  swapped.entering.clear();
  for (uint32_t i = 0; i < n; ++i) {
    const bool below = dot(kTestNormal, wi[i]) < 0;
    swapped.N.push_back(c.isFiber ? mirroredAcross(swapped.bitangent[0], p.wo[i], wi[i])
                        : below   ? -kTestNormal
                                  : kTestNormal);
    swapped.entering.push_back(uint8_t(below ? !outside : outside));
  }
  const BoundBxdf exchanged(c.bxdf, c.widest(), c.setting, swapped);
  Tolerant other(n);
  other.evaluate(exchanged, p.wo);
  if (!checkFinite(judge, exchanged, other.e)) return;

  std::vector<float> ior(bxdf.context().padded * 4, 1.f);
  if (c.encloses && bxdf.functions().interior) {
    const size_t m = bxdf.context().padded;
    const InteriorArgs a{ior.data(), {ior.data() + m, ior.data() + 2 * m, ior.data() + 3 * m}};
    bxdf.functions().interior(&bxdf.context(), &a);
  }
  TestContextOptions importance;
  importance.traits = kTraitLightPath;
  const BoundBxdf adjoint(c.bxdf, c.widest(), c.setting, p, importance);
  Tolerant light(n);
  light.evaluate(adjoint, wi);
  judge.count(3 * n);
  bool reverseGood = true, reciprocityGood = true, transportGood = true;
  for (uint32_t i = 0; i < n; ++i) {
    const double cosI = c.fillsSpace ? 1 : std::abs(dot(kTestNormal, wi[i])),
                 cosO = c.fillsSpace ? 1 : std::abs(dot(kTestNormal, p.wo[i]));
    if (cosI < 1e-3 || cosO < 1e-3 || (c.isFiber && isAlong(swapped.bitangent[0], wi[i]))) continue;
    const std::string where = at(bxdf.context(), i, wi[i]);
    const double reverseSlack = own.reverseSlack(i) + other.pdfSlack(i);
    if (reverseGood && !(std::abs(own.e.pdfReverse(i) - other.e.pdf(i)) <= reverseSlack)) {
      judge.fail("reverse-pdf", where + text("pdf with the directions exchanged is %.7g, pdfReverse %.7g",
                                             other.e.pdf(i), own.e.pdfReverse(i)));
      reverseGood = false;
    }
    const bool across = dot(kTestNormal, wi[i]) < 0;
    const double inner = c.encloses ? ior[i] : 1, here = outside ? 1 : inner,
                 there = across ? (outside ? inner : 1) : here;
    for (int k = 0; k < 3; ++k) {
      const double f = own.e.total(slots, k, i) / cosI / (here * here);
      const double back = other.e.total(slots, k, i) / cosO / (there * there);
      const double slack = own.weightSlack(slots, k, i) / cosI / (here * here) +
                           other.weightSlack(slots, k, i) / cosO / (there * there);
      if (c.reciprocal && reciprocityGood && !(std::abs(f - back) <= slack)) {
        judge.fail("reciprocity",
                   where + text("channel %d: f is %.7g, with the directions exchanged %.7g", k, f, back));
        reciprocityGood = false;
      }
      const double factor = (here * here) / (there * there);
      const double expected = light.e.total(slots, k, i) * factor, got = own.e.total(slots, k, i);
      if (!c.isFiber && transportGood &&
          !(std::abs(got - expected) <= own.weightSlack(slots, k, i) + factor * light.weightSlack(slots, k, i))) {
        judge.fail("transport", where + text("channel %d: weight of importance times %.5g is %.7g, of radiance %.7g",
                                             k, factor, expected, got));
        transportGood = false;
      }
    }
  }
}

}  // namespace

void checkBxdfPoints(Judge& judge, const BxdfCase& c, uint64_t seed) {
  checkWidths(judge, c, seed);
  checkDegenerate(judge, c);
  checkPairs(judge, c, seed + 101, true);
  if (c.encloses) checkPairs(judge, c, seed + 202, false);
}

}  // namespace kinora::testing
