// surface_width_gain and width1_vs_scalar: PxrSurface alone, on a context of hand-made points.
#include <kinora/testing/test_context.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include "core.h"
#include "energy_table.h"
#include "plugin/registry.h"
#include "scalar_surface.h"
#include "scenes.h"
#include "simd/dispatch.h"

namespace kinora::bench {

namespace {

using testing::TestContext;
using testing::Vec3;

constexpr uint32_t kPoints = 1024;

// A low-discrepancy number in [0, 1): fixed inputs, the same in every run.
double spread(uint32_t i, double step) {
  const double x = 0.5 + i * step;
  return x - std::floor(x);
}
Vec3 direction(uint32_t i, double a, double b, double least) {
  const double z = least + (1 - least) * spread(i, a), r = std::sqrt(1 - z * z), phi = 6.283185307 * spread(i, b);
  return {float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)};
}

// A context with the arrays that evaluate() and generate() write, at one width.
struct Bound {
  const BxdfFunctions* functions;
  std::unique_ptr<TestContext> context;
  EvaluateArgs evaluate{};
  GenerateArgs generate{};

  Bound(const Descriptor& plugin, uint32_t width, const char* setting, bool connected) {
    testing::Setting s;
    std::string error;
    if (!testing::parseSetting(plugin, setting, s, error)) throw std::runtime_error(error);
    testing::TestPoints points;
    points.N.clear();
    points.wo.clear();
    for (uint32_t i = 0; i < kPoints; ++i) {
      points.N.push_back({0, 0, 1});
      points.wo.push_back(direction(i, 0.754877666, 0.569840291, 0.05));
    }
    testing::TestContextOptions options;
    options.width = width;
    options.slots = testing::Slots::One;
    functions = static_cast<const BxdfFunctions*>(functionsFor(plugin, width));
    context = std::make_unique<TestContext>(plugin, s, points, options);
    if (connected) {
      // as patterns feed them: a colour and a roughness by point
      std::vector<float> colour, roughness;
      for (uint32_t i = 0; i < kPoints; ++i) {
        for (double step : {0.61803398875, 0.32471795724, 0.22074408461})
          colour.push_back(float(0.1 + 0.8 * spread(i, step)));
        roughness.push_back(float(0.1 + 0.5 * spread(i, 0.41421356237)));
      }
      context->setParameter("diffuseColor", colour);
      context->setParameter("specularRoughness", roughness);
    }
    context->bind(*functions);
    float* wi[3];
    for (float*& x : wi) x = context->floats(kPoints);
    for (uint32_t i = 0; i < kPoints; ++i) {
      const Vec3 w = direction(i, 0.819172513, 0.671043607, 0.02);
      wi[0][i] = w.x;
      wi[1][i] = w.y;
      wi[2][i] = w.z;
    }
    for (int k = 0; k < 3; ++k) {
      evaluate.wi[k] = wi[k];
      evaluate.weight[0][k] = context->floats(kPoints);
      generate.wi[k] = context->floats(kPoints);
      generate.weight[k] = context->floats(kPoints);
    }
    evaluate.pdf = context->floats(kPoints);
    generate.pdf = context->floats(kPoints);
    generate.slot = context->words(kPoints);
    generate.flags = context->words(kPoints);
    for (int k = 0; k < 4; ++k) {
      float* u = context->floats(kPoints);
      const double step[4] = {0.88067, 0.77559, 0.68303, 0.60152};
      for (uint32_t i = 0; i < kPoints; ++i) u[i] = float(0.999999 * spread(i, step[k]));
      generate.u[k] = u;
    }
  }
  void runEvaluate() const { functions->evaluate(&context->context(), context->context().closure, &evaluate); }
  void runAll() const {
    const void* closure = functions->begin(&context->context());
    functions->evaluate(&context->context(), closure, &evaluate);
    functions->generate(&context->context(), closure, &generate);
  }
};

// Nanoseconds a point of f, which does kPoints of them; about `target` seconds.
template <class F>
double time(const F& f, double target) {
  f();
  int rounds = 1;
  for (;;) {
    const double start = threadSeconds();
    for (int i = 0; i < rounds; ++i) f();
    const double t = threadSeconds() - start;
    if (t >= 0.5 * target) return 1e9 * t / rounds / kPoints;
    rounds *= 2;
  }
}

// The setting kAllButGlass as the scalar code takes it, read from the same text.
ScalarSurface scalarSurface(const scene::ParameterList& p) {
  ScalarSurface s;
  const auto colour = [&](const char* name, float out[3]) {
    const std::vector<float> v = p.getFloats(name);
    for (size_t k = 0; k < 3 && k < v.size(); ++k) out[k] = v[k];
  };
  colour("diffuseColor", s.diffuseColor);
  s.diffuseGain = p.getFloat("diffuseGain", 1);
  s.diffuseRoughness = p.getFloat("diffuseRoughness", 0);
  s.diffuseDoubleSided = p.getFloat("diffuseDoubleSided", 0) != 0;
  const char* const prefix[3] = {"specular", "roughSpecular", "clearcoat"};
  for (int i = 0; i < 3; ++i) {
    ScalarSpecular& l = s.specular[i];
    const std::string n = prefix[i];
    l.on = true;
    l.physical = p.getFloat(n + "FresnelMode", 0) != 0;
    l.doubleSided = p.getFloat(n + "DoubleSided", 0) != 0;
    colour((n + "FaceColor").c_str(), l.face);
    colour((n + "EdgeColor").c_str(), l.edge);
    colour((n + "Ior").c_str(), l.ior);
    colour((n + "ExtinctionCoeff").c_str(), l.extinction);
    l.roughness = p.getFloat(n + "Roughness", 0);
  }
  s.coatThickness = p.getFloat("clearcoatThickness", 0);
  colour("clearcoatAbsorptionTint", s.coatTint);
  s.coatCompensation = p.getFloat("clearcoatEnergyCompensation", 0);
  s.specularCompensation = p.getFloat("specularEnergyCompensation", 0);
  s.fuzzGain = p.getFloat("fuzzGain", 0);
  colour("fuzzColor", s.fuzzColor);
  s.fuzzConeAngle = p.getFloat("fuzzConeAngle", 8);
  s.fuzzDoubleSided = p.getFloat("fuzzDoubleSided", 0) != 0;
  energyTable(s.energy, s.energyMean);
  return s;
}

}  // namespace

void measureSurface(const Options& options, Figures& figures) {
  Registry registry;
  Diagnostics diagnostics;
  const Descriptor* plugin = registry.find(Kind::Bxdf, "PxrSurface", diagnostics, {});
  if (!plugin) return;
  const double target = options.quick ? 0.001 : 0.04;
  std::vector<uint32_t> widths{1, 4, 8};
  if (cpuHasAvx512()) widths.push_back(16);

  std::map<uint32_t, std::unique_ptr<Bound>> all;
  for (uint32_t w : widths) all[w] = std::make_unique<Bound>(*plugin, w, kAllLobes, true);
  std::map<uint32_t, std::vector<double>> ns;
  std::vector<double> gain;
  for (int r = 0; r < options.repeat; ++r) {
    double best = INFINITY;
    for (uint32_t w : widths) {
      ns[w].push_back(time([&] { all[w]->runAll(); }, target));
      if (w > 1) best = std::min(best, ns[w].back());
    }
    gain.push_back(ns[1].back() / best);
  }
  figures.add("surface_width_gain", gain, "PxrSurface, all lobes: time at width 1 over the best width's");
  for (uint32_t w : widths)
    figures.add("ns_surface_width_" + std::to_string(w), ns[w], "nanoseconds a point: begin, evaluate and generate");

  // the same formulas as plain scalar code
  const Bound one(*plugin, 1, kAllButGlass, false);
  const ScalarSurface surface = scalarSurface(parameters(kAllButGlass));
  const Context& c = one.context->context();
  std::vector<float> out[4];
  for (auto& v : out) v.resize(kPoints);
  const ScalarPoints points{kPoints,
                            {c.N[0], c.N[1], c.N[2]},
                            {c.Ng[0], c.Ng[1], c.Ng[2]},
                            {c.wo[0], c.wo[1], c.wo[2]},
                            {one.evaluate.wi[0], one.evaluate.wi[1], one.evaluate.wi[2]},
                            c.entering,
                            {out[0].data(), out[1].data(), out[2].data()},
                            out[3].data(),
                            nullptr};
  one.runEvaluate();
  evaluateScalar(surface, points);
  double worst = 0;
  for (uint32_t i = 0; i < kPoints; ++i)
    for (int k = 0; k < 4; ++k) {
      const double a = k < 3 ? one.evaluate.weight[0][k][i] : one.evaluate.pdf[i], b = out[k][i];
      worst = std::max(worst, std::abs(a - b) / (std::abs(a) + 1e-3));
    }
  std::vector<double> wide, scalar, ratio;
  for (int r = 0; r < options.repeat; ++r) {
    wide.push_back(time([&] { one.runEvaluate(); }, target));
    scalar.push_back(time([&] { evaluateScalar(surface, points); }, target));
    ratio.push_back(wide.back() / scalar.back());
  }
  figures.add("width1_vs_scalar", ratio,
              "evaluate() of PxrSurface at width 1 over plain scalar code of the same formulas");
  figures.add("ns_evaluate_width_1", wide, "nanoseconds a point: evaluate() at width 1, no glass");
  figures.add("ns_evaluate_scalar", scalar, "nanoseconds a point: the scalar code");
  figures.add("scalar_difference", {worst},
              "largest relative difference between the two, which must be rounding alone");
}

}  // namespace kinora::bench
