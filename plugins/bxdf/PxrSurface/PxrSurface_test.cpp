// Statistics of PxrSurface at fixed settings: densities, albedos, reciprocity, equal bits at all widths, and its
// speed. It proves agreement of generate, evaluate and pdfs with each other, and energy where it should be kept; it
// does not prove that the lobes look like anything measured. The registry-wide kit covers parameter combinations more
// widely.
#include <gtest/gtest.h>
#include <kinora/bxdf.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "simd/dispatch.h"

namespace kinora {
const Descriptor* kinoraStock_PxrSurface();
const Descriptor* kinoraStock_LamaIridescence();
const Descriptor* kinoraStock_PxrConstant();
const Descriptor* kinoraStock_PxrBlack();

namespace {

struct Vec {
  float x, y, z;
};
Vec unit(double cosine, double phi) {
  const double s = std::sqrt(std::max(0., 1 - cosine * cosine));
  return {float(s * std::cos(phi)), float(s * std::sin(phi)), float(cosine)};
}
uint32_t hash(uint32_t x) {
  x ^= x >> 16, x *= 0x7feb352du, x ^= x >> 15, x *= 0x846ca68bu;
  return x ^ x >> 16;
}

const bool kFloatMode = (setThreadFloatMode(), true);  // as in a render

// A context of n points on the plane z = 0 with arrays to fill in, and a bxdf bound to it at one width.
class Bound {
 public:
  Bound(const Descriptor* d, uint32_t width, uint32_t n, const std::string& settings) : descriptor_(d) {
    c.count = n;
    c.padded = padded(n);
    c.width = width;
    c.traits = kTraitLightPath;  // shares of power: no eta^2
    for (auto* v : {&N[0], &N[1], &Ng[0], &Ng[1], &wo[0], &wo[1], &zero}) v->assign(c.padded, 0.f);
    for (auto* v : {&N[2], &Ng[2], &wo[2], &one}) v->assign(c.padded, 1.f);
    entering.assign(c.padded, ~0u);
    for (int i = 0; i < 3; ++i)
      c.P[i] = zero.data(), c.N[i] = N[i].data(), c.Ng[i] = Ng[i].data(), c.wo[i] = wo[i].data();
    c.entering = entering.data();
    c.radius = zero.data();
    c.outerIor = one.data();
    const auto* t = static_cast<const BxdfTraits*>(d->traits);
    c.lobeCount = t->lobeCount;
    slots(1);
    static const ContextFunctions functions = [] {
      ContextFunctions f{};
      f.alloc = [](const Context* x, size_t bytes) { return self(x)->alloc(bytes); };
      f.param = [](const Context* x, uint32_t i) { return self(x)->param(i); };
      f.builtin = [](const Context* x, Builtin) { return self(x)->tangent(); };
      f.text = [](const Context*, uint32_t) { return ""; };
      return f;
    }();
    c.fn = &functions;
    c.host = this;
    for (uint32_t i = 0; i < d->tableCount; ++i)
      if (d->tables[i].width == width) fn = static_cast<const BxdfFunctions*>(d->tables[i].functions);
    set(settings);
  }
  // every lobe its own slot as far as they go, what is left in the last: all in one, or both of glass
  void slots(uint32_t n) {
    c.slotCount = n;
    slotOfLobe.assign(std::max(1u, c.lobeCount), 0);
    for (uint32_t i = 0; i < c.lobeCount; ++i) slotOfLobe[i] = uint8_t(std::min(i, n - 1));
    c.slotOfLobe = slotOfLobe.data();
  }
  // "name=v v v; name=v"
  void set(const std::string& settings) {
    std::istringstream list(settings);
    for (std::string one; std::getline(list, one, ';');) {
      const size_t eq = one.find('=');
      if (eq == std::string::npos) continue;
      const size_t start = one.find_first_not_of(' ');
      std::istringstream numbers(one.substr(eq + 1));
      std::vector<float> values;
      for (float v; numbers >> v;) values.push_back(v);
      bool known = false;
      for (uint32_t i = 0; i < descriptor_->paramCount; ++i)
        if (one.substr(start, eq - start) == descriptor_->params[i].name) values_[i] = values, known = true;
      EXPECT_TRUE(known) << one;
    }
  }
  void vary(const char* name, std::function<float(uint32_t point, int channel)> f) {
    for (uint32_t i = 0; i < descriptor_->paramCount; ++i)
      if (std::string(name) == descriptor_->params[i].name)
        for (int k = 0; k < 3; ++k) {
          varying_[i][k].resize(c.padded);
          for (uint32_t p = 0; p < c.padded; ++p) varying_[i][k][p] = f(p, k);
        }
  }
  void setOut(Vec w) {
    for (uint32_t i = 0; i < c.padded; ++i) setOut(i, w);
  }
  // The surface's outward side is +z; normals follow wo.
  void setOut(uint32_t i, Vec w) {
    const float s = w.z < 0 ? -1.f : 1.f;
    wo[0][i] = w.x, wo[1][i] = w.y, wo[2][i] = w.z;
    N[2][i] = Ng[2][i] = s;
    entering[i] = w.z < 0 ? 0 : ~0u;
  }
  void bind() { c.closure = closure = fn->begin(&c); }

  Context c{};
  const BxdfFunctions* fn = nullptr;
  void* closure = nullptr;
  std::vector<float> N[3], Ng[3], wo[3], zero, one;
  std::vector<uint32_t> entering;
  std::vector<uint8_t> slotOfLobe;

 private:
  static Bound* self(const Context* x) { return static_cast<Bound*>(x->host); }
  void* alloc(size_t bytes) {
    void* p = std::aligned_alloc(64, (bytes + 63) / 64 * 64);
    arena_.emplace_back(p, &std::free);
    return p;
  }
  Value param(uint32_t i) {
    const Param& p = descriptor_->params[i];
    const uint32_t n = p.type == Type::Float || p.type == Type::Int ? 1 : 3;
    Value v;
    v.components = n;
    if (auto f = varying_.find(i); f != varying_.end()) {
      v.stride = 1;
      for (uint32_t k = 0; k < n; ++k) v.data[k] = f->second[k].data();
      return v;
    }
    auto& list = values_[i];
    if (list.empty()) list.assign(p.value, p.value + 3);
    for (uint32_t k = 0; k < n; ++k) v.data[k] = &list[list.size() == 1 ? 0 : k];
    return v;
  }
  Value tangent() {
    Value v;
    v.components = 3;
    for (int k = 0; k < 3; ++k) v.data[k] = k == 0 ? one.data() : zero.data();
    return v;
  }
  const Descriptor* descriptor_;
  std::map<uint32_t, std::vector<float>> values_;
  std::map<uint32_t, std::vector<float>[3]> varying_;
  std::vector<std::unique_ptr<void, void (*)(void*)>> arena_;
};

struct Sums {
  std::vector<float> weight[kMaxSlots][3], pdf, reverse, wi[3];
  EvaluateArgs args{};
  explicit Sums(uint32_t n) {
    for (auto& s : weight)
      for (auto& v : s) v.assign(padded(n), 0.f);
    pdf.assign(padded(n), 0.f), reverse = pdf;
    for (int k = 0; k < 3; ++k) wi[k].assign(padded(n), k == 2 ? 1.f : 0.f), args.wi[k] = wi[k].data();
    for (uint32_t s = 0; s < kMaxSlots; ++s)
      for (int k = 0; k < 3; ++k) args.weight[s][k] = weight[s][k].data();
    args.pdf = pdf.data(), args.pdfReverse = reverse.data();
  }
};
struct Samples {
  std::vector<float> u[4], wi[3], weight[3], pdf, reverse;
  std::vector<uint32_t> slot, flags;
  GenerateArgs args{};
  explicit Samples(uint32_t n) {
    for (int k = 0; k < 4; ++k) u[k].assign(padded(n), 0.5f), args.u[k] = u[k].data();
    for (int k = 0; k < 3; ++k) {
      wi[k].assign(padded(n), 0.f), weight[k] = wi[k];
      args.wi[k] = wi[k].data(), args.weight[k] = weight[k].data();
    }
    pdf.assign(padded(n), 0.f), reverse = pdf;
    slot.assign(padded(n), 0), flags = slot;
    args.pdf = pdf.data(), args.pdfReverse = reverse.data(), args.slot = slot.data(), args.flags = flags.data();
  }
  void randomize(uint32_t seed) {
    for (int k = 0; k < 4; ++k)
      for (size_t i = 0; i < u[k].size(); ++i)
        u[k][i] = float(hash(seed * 747796405u + uint32_t(i * 4 + k)) >> 8) / 16777216.f;
  }
};

constexpr uint32_t kPoints = 256;
const Descriptor* surface() { return kinoraStock_PxrSurface(); }
uint32_t testWidth() { return bestWidth(); }

// Mean of weight / pdf over many directions: the albedo, discrete lobes included. Stratified in direction and lobe.
struct Albedo {
  double rgb[3] = {0, 0, 0}, smooth = 0;  // smooth: the part without discrete lobes
};
Albedo sampledAlbedo(Bound& b, Vec wo, uint32_t rounds = 96) {
  b.setOut(wo);
  b.bind();
  Samples s(kPoints);
  Albedo a;
  for (uint32_t r = 0; r < rounds; ++r) {
    for (uint32_t i = 0; i < kPoints; ++i) {  // R3 sequence (Roberts), an additive low-discrepancy one
      const double n = r * kPoints + i + 1;
      s.u[0][i] = float(std::fmod(0.5 + n * 0.8191725133961645, 1.0));
      s.u[1][i] = float(std::fmod(0.5 + n * 0.6710436067037893, 1.0));
      s.u[2][i] = float(std::fmod(0.5 + n * 0.5497004779019703, 1.0));
      for (int k = 0; k < 3; ++k) s.u[k][i] = std::min(s.u[k][i], 0.99999994f);
      s.u[3][i] = float(hash(uint32_t(n)) >> 8) / 16777216.f;
    }
    b.fn->generate(&b.c, b.closure, &s.args);
    for (uint32_t i = 0; i < kPoints; ++i) {
      if (s.slot[i] == kNoLobe) continue;
      for (int k = 0; k < 3; ++k) {
        const double w = s.weight[k][i] / s.pdf[i];
        EXPECT_TRUE(std::isfinite(w));
        a.rgb[k] += w;
        if (!(s.flags[i] & kSampleDiscrete)) a.smooth += w / 3;
      }
    }
  }
  for (double& v : a.rgb) v /= double(rounds) * kPoints;
  a.smooth /= double(rounds) * kPoints;
  return a;
}
// Integrals over the sphere by a fine rule: of the value (grey mean) and of the pdf.
void integrate(Bound& b, Vec wo, double& value, double& pdf) {
  b.setOut(wo);
  b.bind();
  constexpr int kTheta = 512, kPhi = 512;
  Sums s(kPhi);
  value = pdf = 0;
  for (int t = 0; t < kTheta; ++t) {
    const double theta = M_PI * (t + 0.5) / kTheta, weight = std::sin(theta) * (M_PI / kTheta) * (2 * M_PI / kPhi);
    for (int p = 0; p < kPhi; ++p) {
      const Vec w = unit(std::cos(theta), 2 * M_PI * (p + 0.5) / kPhi);
      s.wi[0][p] = w.x, s.wi[1][p] = w.y, s.wi[2][p] = w.z;
    }
    b.fn->evaluateAt(&b.c, b.closure, 0, kPhi, &s.args);
    for (int p = 0; p < kPhi; ++p) {
      pdf += weight * s.pdf[p];
      for (uint32_t l = 0; l < b.c.slotCount; ++l)
        for (int k = 0; k < 3; ++k) value += weight * s.weight[l][k][p] / 3;
    }
  }
}

const char* const kRoughSettings[] = {
    "diffuseRoughness=0.6; diffuseColor=0.8 0.5 0.2",
    "diffuseGain=0; specularFaceColor=0.9 0.8 0.7; specularEdgeColor=1 1 1; specularRoughness=0.5; "
    "specularModelType=1",
    "diffuseGain=0; specularFaceColor=0.9 0.8 0.7; specularEdgeColor=1 1 1; specularRoughness=0.5; "
    "specularModelType=0",
    "diffuseGain=0; specularFaceColor=1 1 1; specularEdgeColor=1 1 1; specularRoughness=1; specularModelType=1",
    "diffuseGain=0; specularFaceColor=1 1 1; specularEdgeColor=1 1 1; specularRoughness=0.6; specularModelType=1; "
    "specularAnisotropy=0.7",
    "diffuseGain=0; specularFaceColor=1 1 1; specularEdgeColor=1 1 1; specularRoughness=0.6; "
    "specularAnisotropy=-0.7; specularAnisotropyDirection=1 1 0",
    "specularFresnelMode=1; specularEdgeColor=1 1 1; specularRoughness=0.4; diffuseExponent=3",
    "diffuseGain=0; fuzzGain=0.8; fuzzColor=1 0.5 0.5; fuzzConeAngle=20",
    "diffuseGain=0; reflectionGain=1; refractionGain=1; glassRoughness=0.6",
    "diffuseGain=0; reflectionGain=1; refractionGain=1; glassRoughness=0.8; glassIor=2; refractionColor=0.5 0.8 0.9",
    "diffuseGain=0; reflectionGain=0.5; refractionGain=0.7; glassRoughness=0.5; glassRefractionRoughness=0.7; "
    "glassAnisotropy=0.5",
    "diffuseGain=0; reflectionGain=1; refractionGain=1; glassRoughness=0.6; thinGlass=1",
    "diffuseDoubleSided=1; diffuseTransmitGain=0.5; diffuseTransmitColor=1 0.2 0.2; diffuseBackUseDiffuseColor=0; "
    "diffuseBackColor=0.9 0.1 0.1",
    "diffuseGain=0; iridescenceFaceGain=1 0.9 0.8; iridescenceEdgeGain=1 1 1; iridescenceRoughness=0.5; "
    "iridescenceScale=4; iridescenceCurve=0.7; iridescencePrimaryColor=0 0 0; iridescenceSecondaryColor=1 0.5 0.2",
    "diffuseGain=0; iridescenceFaceGain=1 1 1; iridescenceEdgeGain=0.5 1 1; iridescenceRoughness=0.7; "
    "iridescenceMode=1; iridescenceThickness=600; iridescenceAnisotropy=0.6; iridescenceDoubleSided=1",
    // all at once
    "iridescenceFaceGain=0.1 0.2 0.1; iridescenceEdgeGain=0.5 0.5 0.6; diffuseDoubleSided=1; "
    "diffuseTransmitGain=0.4; specularFaceColor=0.1 0.1 0.1; specularEdgeColor=1 1 1; "
    "specularRoughness=0.5; "
    "roughSpecularFaceColor=0.2 0.1 0.1; roughSpecularEdgeColor=0.5 0.5 0.5; roughSpecularModelType=1; "
    "clearcoatFresnelMode=1; "
    "clearcoatEdgeColor=1 1 1; clearcoatRoughness=0.4; clearcoatModelType=1; clearcoatThickness=0.4; "
    "clearcoatAbsorptionTint=0.1 0.5 1; "
    "clearcoatEnergyCompensation=1; specularEnergyCompensation=0.7; fuzzGain=0.3; reflectionGain=0.3; "
    "refractionGain=0.4; "
    "glassRoughness=0.5; specularDoubleSided=1; clearcoatDoubleSided=1",
};
const double kCosines[] = {0.15, 0.6, 0.95};

TEST(PxrSurface, SampledAlbedoEqualsIntegralOfEvaluate) {
  for (const char* settings : kRoughSettings)
    for (double cosine : kCosines)
      for (double side : {1., -1.}) {
        SCOPED_TRACE(std::string(settings) + " cos " + std::to_string(side * cosine));
        Bound b(surface(), testWidth(), kPoints, settings);
        b.slots(8);
        const Vec wo = unit(side * cosine, 0.7);
        double value, pdf;
        integrate(b, wo, value, pdf);
        const Albedo a = sampledAlbedo(b, wo, 192);
        EXPECT_NEAR(a.smooth, value, 0.003 + 0.004 * value);
        EXPECT_LE(pdf, 1.002);
      }
}

TEST(PxrSurface, DirectionsAreDistributedAsThePdfSays) {
  constexpr int kTheta = 20, kPhi = 20, kSub = 12;
  for (const char* settings : kRoughSettings)
    for (double cosine : {0.9, 0.3, -0.5}) {
      Bound b(surface(), testWidth(), kPoints, settings);
      b.setOut(unit(cosine, 0.3));
      b.bind();
      std::vector<double> expected(kTheta * kPhi, 0.), seen(kTheta * kPhi, 0.);
      Sums s(kPhi * kSub);
      for (int t = 0; t < kTheta * kSub; ++t) {
        const double z = 1 - 2 * (t + 0.5) / (kTheta * kSub);
        for (int p = 0; p < kPhi * kSub; ++p) {
          const Vec w = unit(z, 2 * M_PI * (p + 0.5) / (kPhi * kSub));
          s.wi[0][p] = w.x, s.wi[1][p] = w.y, s.wi[2][p] = w.z;
        }
        b.fn->evaluateAt(&b.c, b.closure, 0, kPhi * kSub, &s.args);
        for (int p = 0; p < kPhi * kSub; ++p)
          expected[t / kSub * kPhi + p / kSub] += s.pdf[p] * 4 * M_PI / (kTheta * kSub * kPhi * kSub);
      }
      Samples g(kPoints);
      const int rounds = 400;
      for (int r = 0; r < rounds; ++r) {
        g.randomize(uint32_t(r) + 1);
        b.fn->generate(&b.c, b.closure, &g.args);
        for (uint32_t i = 0; i < kPoints; ++i) {
          if (g.slot[i] == kNoLobe || g.flags[i] & kSampleDiscrete) continue;
          double phi = std::atan2(g.wi[1][i], g.wi[0][i]);
          if (phi < 0) phi += 2 * M_PI;
          const int t = std::min(kTheta - 1, int((1 - g.wi[2][i]) / 2 * kTheta)),
                    p = std::min(kPhi - 1, int(phi / (2 * M_PI) * kPhi));
          ++seen[t * kPhi + p];
        }
      }
      const double n = double(rounds) * kPoints;
      double chi2 = 0, poolSeen = 0, poolExpected = 0;
      int bins = 0;
      for (size_t i = 0; i < seen.size(); ++i) {
        const double e = expected[i] * n;
        if (e < 20) {
          poolSeen += seen[i], poolExpected += e;
          continue;
        }
        chi2 += (seen[i] - e) * (seen[i] - e) / e;
        ++bins;
      }
      if (poolExpected > 20) chi2 += (poolSeen - poolExpected) * (poolSeen - poolExpected) / poolExpected, ++bins;
      if (bins == 0) continue;
      // Wilson and Hilferty: the cube root of chi^2 / n is nearly normal. 5 sigma allows for the rule's own error in
      // steep bins.
      const double z = (std::cbrt(chi2 / bins) - (1 - 2. / (9 * bins))) / std::sqrt(2. / (9 * bins));
      EXPECT_LT(z, 5) << settings << " cos " << cosine << " bins " << bins << " chi2 " << chi2;
    }
}

TEST(PxrSurface, LosslessSettingsKeepAllLight) {
  double worst = 0;
  std::string where;
  const auto report = [&](const char* what) {
    std::printf("lossless settings, %s: albedo within %.4f of 1 (%s)\n", what, worst, where.c_str());
    worst = 0;
  };
  const auto check = [&](const std::string& settings, bool bothSides) {
    for (double cosine : {0.1, 0.5, 0.9})
      for (double side : {1., -1.}) {
        if (side < 0 && !bothSides) continue;
        Bound b(surface(), testWidth(), kPoints, settings);
        const Albedo a = sampledAlbedo(b, unit(side * cosine, 0.4));
        for (double v : a.rgb) {
          EXPECT_NEAR(v, 1, 0.01) << settings << " cos " << side * cosine;
          if (std::abs(v - 1) > worst)
            worst = std::abs(v - 1), where = settings + " cos " + std::to_string(side * cosine);
        }
      }
  };
  for (const char* lobe : {"specular", "roughSpecular", "clearcoat"})
    for (const char* model : {"0", "1"})
      for (const char* roughness : {"0", "0.05", "0.1", "0.3", "0.45", "0.6", "0.8", "1"}) {
        const std::string p(lobe);
        check("diffuseGain=0; " + p + "FaceColor=1 1 1; " + p + "EdgeColor=1 1 1; " + p + "Roughness=" + roughness +
                  "; " + p + "ModelType=" + model,
              false);
      }
  report("reflection");
  for (const char* ior : {"1", "1.1", "1.33", "1.5", "2", "2.6"})
    for (const char* thin : {"0", "1"})
      for (const char* roughness : {"0", "0.05", "0.1", "0.3", "0.45", "0.6", "0.8", "1"})
        check(std::string("diffuseGain=0; reflectionGain=1; refractionGain=1; glassRoughness=") + roughness +
                  "; glassIor=" + ior + "; thinGlass=" + thin,
              true);
  report("glass");
  const auto* traits = static_cast<const BxdfTraits*>(surface()->traits);
  for (const char* const* l = traits->lossless; *l; ++l) check(*l, true);
  report("declared");
}

TEST(PxrSurface, RadianceOfRefractionCarriesTheIndexSquared) {
  for (double side : {1., -1.})
    for (const char* roughness : {"0", "0.5"}) {
      Bound b(surface(), testWidth(), kPoints,
              std::string("diffuseGain=0; refractionGain=1; glassIor=1.5; glassRoughness=") + roughness);
      const double power = sampledAlbedo(b, unit(side * 0.8, 0)).rgb[0];
      b.c.traits = kTraitEyePath;
      const double radiance = sampledAlbedo(b, unit(side * 0.8, 0)).rgb[0];
      EXPECT_NEAR(radiance / power, side > 0 ? 1 / 2.25 : 2.25, 1e-4);
    }
}

TEST(PxrSurface, ConservingSettingsNeverGain) {
  const auto* traits = static_cast<const BxdfTraits*>(surface()->traits);
  double most = 0;
  for (const char* const* l = traits->conserving; *l; ++l)
    for (double cosine : {0.02, 0.1, 0.3, 0.6, 1.})
      for (double side : {1., -1.}) {
        Bound b(surface(), testWidth(), kPoints, *l);
        for (double v : sampledAlbedo(b, unit(side * cosine, 0)).rgb) {
          EXPECT_LE(v, 1.002) << *l << " cos " << side * cosine;
          most = std::max(most, v);
        }
      }
  std::printf("greatest albedo of conserving settings: %.4f\n", most);
}

// f(wo, wi) = f(wi, wo), of f / eta^2 where refracted, and pdfReverse is the pdf with the roles swapped.
TEST(PxrSurface, ReciprocityAndReversePdf) {
  for (const char* settings : kRoughSettings)
    for (double ior : {1.0, 1.3}) {
      std::string all = std::string(settings);
      Bound a(surface(), testWidth(), kPoints, all), b(surface(), testWidth(), kPoints, all);
      for (auto* x : {&a, &b}) {
        x->slots(8);
        x->one.assign(x->c.padded, float(ior));  // the index outside
        x->c.outerIor = x->one.data();
      }
      double inside = 1.5;
      if (const char* g = std::strstr(settings, "glassIor=")) inside = std::atof(g + 9);
      const bool thin = std::strstr(settings, "thinGlass=1") != nullptr;
      const bool medium = std::strstr(settings, "refractionGain") != nullptr;
      std::mt19937 random(7);
      std::uniform_real_distribution<double> uniform;
      Sums sa(kPoints), sb(kPoints);
      for (uint32_t i = 0; i < kPoints; ++i) {
        const Vec o = unit(2 * uniform(random) - 1, 6.28 * uniform(random)),
                  w = unit(2 * uniform(random) - 1, 6.28 * uniform(random));
        a.setOut(i, o), b.setOut(i, w);
        sa.wi[0][i] = w.x, sa.wi[1][i] = w.y, sa.wi[2][i] = w.z;
        sb.wi[0][i] = o.x, sb.wi[1][i] = o.y, sb.wi[2][i] = o.z;
      }
      for (auto* x : {&a, &b}) x->c.traits = kTraitEyePath, x->bind();
      a.fn->evaluate(&a.c, a.closure, &sa.args);
      b.fn->evaluate(&b.c, b.closure, &sb.args);
      int nonzero = 0;
      for (uint32_t i = 0; i < kPoints; ++i) {
        const float co = std::abs(a.wo[2][i]), ci = std::abs(sa.wi[2][i]);
        if (std::min(co, ci) < 0.01) continue;
        const bool through = (a.wo[2][i] > 0) != (sa.wi[2][i] > 0);
        const double no = a.wo[2][i] > 0 ? ior : inside, ni = a.wo[2][i] > 0 ? inside : ior;
        for (uint32_t l = 0; l < 8; ++l)
          for (int k = 0; k < 3; ++k) {
            const double scale = through && !thin && medium && (l == 7 || l == 1) ? no * no / (ni * ni) : 1;
            const double f = sa.weight[l][k][i] / ci, g = sb.weight[l][k][i] / co * scale;
            EXPECT_NEAR(f, g, 2e-5 + 2e-3 * std::abs(f))
                << settings << " lobe " << l << " co " << a.wo[2][i] << " ci " << sa.wi[2][i];
            nonzero += f > 0;
          }
        EXPECT_NEAR(sa.pdf[i], sb.reverse[i], 1e-5 + 2e-3 * sa.pdf[i]) << settings;
        EXPECT_NEAR(sb.pdf[i], sa.reverse[i], 1e-5 + 2e-3 * sb.pdf[i]) << settings;
      }
      EXPECT_GT(nonzero, 20) << settings;
    }
}

TEST(PxrSurface, AllWidthsGiveTheSameBits) {
  std::vector<std::string> all(std::begin(kRoughSettings), std::end(kRoughSettings));
  all.push_back(
      "specularFaceColor=0.2 0.2 0.2; specularEdgeColor=1 1 1; specularRoughness=0; reflectionGain=1; "
      "refractionGain=1; glassRoughness=0");
  for (const std::string& settings : all) {
    std::vector<float> reference;
    for (uint32_t width : {1u, 4u, 8u, 16u}) {
      if (width > bestWidth()) continue;
      const uint32_t n = 101;
      Bound b(surface(), width, n, settings);
      b.slots(8);
      b.vary("specularRoughness", [](uint32_t p, int) { return float(hash(p) >> 8) / 16777216.f; });
      b.vary("glassRoughness", [](uint32_t p, int) { return float(hash(p + 77) >> 8) / 16777216.f; });
      b.vary("specularFresnelShape", [](uint32_t p, int) { return p % 3 ? 5.f : 2.5f; });
      b.vary("diffuseRoughness", [](uint32_t p, int) { return p % 2 ? 0.f : 0.7f; });
      b.vary("bumpNormal",
             [](uint32_t p, int k) { return k == 2 ? 1.f : float(hash(p * 3 + k) >> 8) / 16777216.f - 0.5f; });
      for (uint32_t i = 0; i < b.c.padded; ++i) {
        const uint32_t j = std::min(i, n - 1);
        b.setOut(i, unit((hash(j * 2 + 5) >> 8) / 8388608. - 1, (hash(j * 2 + 6) >> 8) / 1000.));
      }
      b.bind();
      Samples g(n);
      g.randomize(3);
      b.fn->generate(&b.c, b.closure, &g.args);
      Sums s(n);
      for (int k = 0; k < 3; ++k) s.wi[k] = g.wi[k], s.args.wi[k] = s.wi[k].data();
      b.fn->evaluate(&b.c, b.closure, &s.args);
      std::vector<float> rgb[3];
      for (auto& v : rgb) v.assign(b.c.padded, 0.f);
      float* out[3] = {rgb[0].data(), rgb[1].data(), rgb[2].data()};
      b.fn->albedo(&b.c, b.closure, out);
      std::vector<float> got;
      for (uint32_t i = 0; i < n; ++i) {
        for (int k = 0; k < 3; ++k) {
          got.push_back(g.wi[k][i]), got.push_back(g.weight[k][i]), got.push_back(rgb[k][i]);
          for (int l = 0; l < 8; ++l) got.push_back(s.weight[l][k][i]);
        }
        for (float v : {g.pdf[i], g.reverse[i], float(g.slot[i]), float(g.flags[i]), s.pdf[i], s.reverse[i]})
          got.push_back(v);
      }
      for (float v : got) ASSERT_TRUE(std::isfinite(v)) << settings;
      if (reference.empty()) reference = got;
      ASSERT_EQ(0, std::memcmp(reference.data(), got.data(), got.size() * sizeof(float)))
          << settings << " width " << width;
    }
  }
}

// generate's pdf and weight are those evaluate gives for its direction.
TEST(PxrSurface, GenerateAgreesWithEvaluate) {
  for (const char* settings : kRoughSettings) {
    Bound b(surface(), testWidth(), kPoints, settings);
    for (uint32_t i = 0; i < kPoints; ++i) b.setOut(i, unit((hash(i) >> 8) / 8388608. - 1, i));
    b.bind();
    Samples g(kPoints);
    g.randomize(11);
    b.fn->generate(&b.c, b.closure, &g.args);
    Sums s(kPoints);
    for (int k = 0; k < 3; ++k) s.wi[k] = g.wi[k], s.args.wi[k] = s.wi[k].data();
    b.fn->evaluate(&b.c, b.closure, &s.args);
    int valid = 0;
    for (uint32_t i = 0; i < kPoints; ++i) {
      if (g.slot[i] == kNoLobe) continue;
      ++valid;
      EXPECT_EQ(g.pdf[i], s.pdf[i]) << settings;
      EXPECT_EQ(g.weight[0][i], s.weight[0][0][i]) << settings;
    }
    EXPECT_GT(valid, 60) << settings;
  }
}

// What a mirror lobe returns of light from one direction.
std::array<double, 3> mirrored(const Descriptor* d, const std::string& settings, double cosine) {
  Bound b(d, testWidth(), 16, settings);
  b.setOut(unit(cosine, 0.3));
  b.bind();
  Samples s(16);
  b.fn->generate(&b.c, b.closure, &s.args);
  EXPECT_TRUE(s.flags[0] & kSampleDiscrete);
  std::array<double, 3> f{};
  for (size_t k = 0; k < 3; ++k) f[k] = s.weight[k][0] / s.pdf[0];
  return f;
}

// Smooth, its reflectance is the gains' Schlick curve times the colours that alternate along the angle.
TEST(PxrSurface, IridescenceAlternatesItsColours) {
  const double face[3] = {0.9, 0.5, 0.7}, edge[3] = {0.3, 1, 0.6}, first[3] = {1, 0.2, 0}, second[3] = {0.1, 0.4, 1};
  const std::string base =
      "diffuseGain=0; iridescenceRoughness=0; iridescenceFaceGain=0.9 0.5 0.7; iridescenceEdgeGain=0.3 1 0.6; "
      "iridescencePrimaryColor=1 0.2 0; iridescenceSecondaryColor=0.1 0.4 1; ";
  for (const double shape : {5., 2.})
    for (const double scale : {0., 1., 3.5})
      for (const double curve : {0.5, 1., 3.})
        for (const bool flip : {false, true}) {
          const std::string settings = base + "iridescenceFresnelShape=" + std::to_string(shape) +
                                       "; iridescenceScale=" + std::to_string(scale) +
                                       "; iridescenceCurve=" + std::to_string(curve) +
                                       "; iridescenceFlip=" + (flip ? "1" : "0");
          for (const double cosine : {0.05, 0.2, 0.4, 0.6, 0.8, 0.97}) {
            const std::array<double, 3> got = mirrored(surface(), settings, cosine);
            double along = std::fmod(scale * std::pow(1 - cosine, curve), 2.);
            along = along > 1 ? 2 - along : along;
            if (flip) along = 1 - along;
            for (size_t k = 0; k < 3; ++k) {
              const double gain = face[k] + (edge[k] - face[k]) * std::pow(1 - cosine, shape);
              EXPECT_NEAR(got[k], gain * (first[k] + (second[k] - first[k]) * along), 2e-4)
                  << settings << ' ' << cosine;
            }
          }
        }
}

// The physical one is the film that LamaIridescence proves against Airy's sum.
TEST(PxrSurface, IridescenceOfAFilm) {
  for (const char* thickness : {"150", "400", "800", "1900"})
    for (const double cosine : {0.1, 0.5, 0.95}) {
      const std::string nm = thickness;
      const std::array<double, 3>
          film = mirrored(kinoraStock_LamaIridescence(),
                          "roughness=0; relativeFilmThickness=0; filmIOR=1.5; minFilmThickness=" + nm, cosine),
          got = mirrored(surface(),
                         "diffuseGain=0; iridescenceMode=1; iridescenceRoughness=0; iridescenceFaceGain=0.8 0.6 1; "
                         "iridescenceEdgeGain=0.8 0.6 1; iridescenceThickness=" +
                             nm,
                         cosine);
      const double gain[3] = {0.8, 0.6, 1};
      for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(got[k], gain[k] * film[k], 1e-5) << nm << ' ' << cosine;
    }
}

TEST(PxrSurface, GlowAndInterior) {
  Bound b(surface(), testWidth(), 5,
          "glowGain=2; glowColor=1 0.5 0; extinction=1 2 3; ssAlbedo=0 0.5 1; glassIor=1.7");
  b.setOut(unit(1, 0));
  b.bind();
  std::vector<float> v[4];
  for (auto& x : v) x.assign(b.c.padded, -1.f);
  float* rgb[3] = {v[0].data(), v[1].data(), v[2].data()};
  b.fn->emission(&b.c, b.closure, rgb);
  EXPECT_EQ(v[0][4], 2);
  EXPECT_EQ(v[1][4], 1);
  EXPECT_EQ(v[2][4], 0);
  InteriorArgs a{v[3].data(), {v[0].data(), v[1].data(), v[2].data()}};
  b.fn->interior(&b.c, &a);
  EXPECT_FLOAT_EQ(v[3][4], 1.7f);
  EXPECT_FLOAT_EQ(v[0][4], 1);
  EXPECT_FLOAT_EQ(v[1][4], 1);
  EXPECT_FLOAT_EQ(v[2][4], 0);
}

TEST(PxrConstantAndBlack, ScatterNothing) {
  for (const Descriptor* d : {kinoraStock_PxrConstant(), kinoraStock_PxrBlack()}) {
    Bound b(d, testWidth(), 20, "");
    b.setOut(unit(0.7, 0));
    b.bind();
    Samples g(20);
    b.fn->generate(&b.c, b.closure, &g.args);
    for (uint32_t i = 0; i < 20; ++i) EXPECT_EQ(g.slot[i], kNoLobe);
    Sums s(20);
    b.fn->evaluate(&b.c, b.closure, &s.args);
    for (uint32_t i = 0; i < 20; ++i) EXPECT_EQ(s.pdf[i] + s.weight[0][0][i], 0);
    std::vector<float> v[3];
    for (auto& x : v) x.assign(b.c.padded, -1.f);
    float* rgb[3] = {v[0].data(), v[1].data(), v[2].data()};
    if (d == kinoraStock_PxrConstant()) {
      b.fn->emission(&b.c, b.closure, rgb);
      EXPECT_EQ(v[1][19], 1);
    } else {
      EXPECT_EQ(b.fn->emission, nullptr);
    }
  }
}

// Prints nanoseconds a point (best of several runs); proves only that wide code is wide.
TEST(PxrSurface, Speed) {
  for (const char* ior : {"2.9", "2.95"}) {  // an index whose tables no other test has asked for, and again
    const auto start = std::chrono::steady_clock::now();
    Bound b(surface(), testWidth(), kPoints, std::string("refractionGain=1; glassIor=") + ior);
    b.bind();
    const std::chrono::duration<double, std::milli> t = std::chrono::steady_clock::now() - start;
    std::printf("binding glass of index %s: %.3f ms\n", ior, t.count());
  }
  const struct {
    const char* name;
    std::string settings;
  } cases[] = {
      {"diffuse", ""},
      {"metal",
       "diffuseGain=0; specularFresnelMode=1; specularEdgeColor=1 1 1; specularIor=0.2 0.9 1.1; "
       "specularExtinctionCoeff=3.9 2.5 2.3; specularModelType=1"},
      {"plastic", "specularFresnelMode=1; specularEdgeColor=1 1 1; specularModelType=1"},
      {"glass", "diffuseGain=0; reflectionGain=1; refractionGain=1; glassRoughness=0.3"},
      {"all lobes", kRoughSettings[std::size(kRoughSettings) - 1]},
  };
  for (const auto& one : cases) {
    double first[2] = {0, 0};
    for (uint32_t width : {1u, 8u, 16u}) {
      if (width > bestWidth()) continue;
      Bound b(surface(), width, kPoints, one.settings);
      for (uint32_t i = 0; i < kPoints; ++i) b.setOut(i, unit((hash(i) >> 8) / 16777216. * 0.9 + 0.1, i));
      b.bind();
      Samples g(kPoints);
      g.randomize(5);
      Sums s(kPoints);
      s.args.pdfReverse = nullptr;
      b.fn->generate(&b.c, b.closure, &g.args);
      for (int k = 0; k < 3; ++k) s.wi[k] = g.wi[k], s.args.wi[k] = s.wi[k].data();
      double best[2] = {1e30, 1e30};
      for (int run = 0; run < 15; ++run)
        for (int what = 0; what < 2; ++what) {
          const auto start = std::chrono::steady_clock::now();
          for (int r = 0; r < 8; ++r) {
            if (what == 0)
              b.fn->evaluate(&b.c, b.closure, &s.args);
            else
              b.fn->generate(&b.c, b.closure, &g.args);
          }
          const std::chrono::duration<double, std::nano> t = std::chrono::steady_clock::now() - start;
          best[what] = std::min(best[what], t.count() / (8 * kPoints));
        }
      if (width == 1) first[0] = best[0], first[1] = best[1];
      std::printf("%-10s width %2u: evaluate %7.1f ns (x %.1f), generate %7.1f ns (x %.1f)\n", one.name, width,
                  best[0], first[0] / best[0], best[1], first[1] / best[1]);
      if (width == 8) {
        EXPECT_GT(first[0] / best[0], 1.5);
      }
    }
  }
}

}  // namespace
}  // namespace kinora
