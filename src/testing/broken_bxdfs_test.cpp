// The kit's own proof: bxdfs broken on purpose, one defect each, and which check must catch it; and correct ones (a
// Lambert surface, a narrow glossy lobe with a mirror) that must pass. Misses defects nobody thought of.
#define KINORA_KERNEL_FILE "testing/broken_bxdfs_test.cpp"
#include <gtest/gtest.h>
#include <kinora/testing/bxdf_checks.h>
#include <iterator>
#include <new>
#include <kinora/simd/foreach_target.h>
#include <kinora/bxdf_author.h>

// name, the check meant to catch it ("" when it is right)
#define TRIALS(X)                   \
  X(Lambert, "")                    \
  X(PdfTooLarge, "pdf-integral")    \
  X(PdfTooSmall, "chi-square")      \
  X(MissingCosine, "reciprocity")   \
  X(WrongReversePdf, "reverse-pdf") \
  X(NotReciprocal, "reciprocity")   \
  X(GainsEnergy, "conserving")      \
  X(LosesEnergy, "lossless")        \
  X(WidthsDisagree, "width")        \
  X(NanAtGrazing, "finite")         \
  X(OtherSamples, "chi-square")     \
  X(LeaksBelow, "side")             \
  X(IgnoresPoint, "evaluate-at")    \
  X(UniformOnly, "evaluate-at")     \
  X(MirrorAndLobe, "")              \
  X(LobeTooNarrow, "chi-square")

#ifndef BROKEN_BXDFS_ONCE
#define BROKEN_BXDFS_ONCE
namespace kinora::trial {
enum Defect : int {
#define X(name, check) name,
  TRIALS(X)
#undef X
};
enum : uint32_t { kAlbedo, kExponent, kBump };
constexpr Param kParams[] = {
    param::color("albedo", 0.5f).help("Fraction of light reflected."),
    param::number("exponent", 400.f).range(1, 1e6f).help("Of the glossy lobe."),
};
constexpr LobeDecl kLobes[] = {{"Diffuse", kLobeDiffuse}, {"Specular", kLobeSpecular}};
struct Closure {
  Value albedo, exponent;
};
}  // namespace kinora::trial
#endif

KINORA_KERNELS_BEGIN
using namespace trial;

template <int D>
struct Trial {
  using Closure = trial::Closure;
  static void begin(const Context& c, Closure& k) {
    k.albedo = c.param(kAlbedo);
    k.exponent = c.param(kExponent);
  }
  static constexpr bool kGlossy = D == MirrorAndLobe || D == LobeTooNarrow;
  // shares of the glossy trial: mirror, lobe, the rest diffuse
  static constexpr float kMirror = 0.25f, kLobe = 0.5f;

  template <int W>
  struct Lanes {
    Vec3<W> N, Ng, wo;
    Float<W> cosO, exponent;
    Rgb<W> albedo_;
    KN_INLINE Lanes(const Closure& k, const Surface<W>& s)
        : N(s.N), Ng(s.Ng), wo(s.wo), cosO(max(dot(s.N, s.wo), Float<W>(0.f))) {
      albedo_ = loadRgb<W>(k.albedo, s.at);
      if (D == UniformOnly && k.albedo.stride) albedo_ = albedo_ * Float<W>(0.9f);
      exponent = loadFloat<W>(k.exponent, s.at);
    }
    KN_INLINE Float<W> lobePdf(Vec3<W> wi) const {
      using F = Float<W>;
      // density of cos^n about the mirror direction; q = 1 - cos through the chord, and ln(1 - q) as a series where q
      // is small, keep accuracy where the lobe is narrow
      const Vec3<W> d = wi - reflect(wo, N);
      const F q = F(0.5f) * dot(d, d);
      const F series = -q * fma(q, fma(q, fma(q, F(0.25f), F(1.f / 3)), F(0.5f)), F(1.f));
      const F x = exponent * select(q < F(0.03f), series, log(max(F(1.f) - q, F(1e-20f))));
      return zeroUnless(q < F(1.f), (exponent + F(1.f)) * F(kInvTwoPi) * exp(x));
    }
    KN_INLINE void evaluate(Vec3<W> wi, LobeSum<W>& out) const {
      using F = Float<W>;
      const F cosI = dot(N, wi);
      Mask<W> above = (cosI > F(0.f)) & (dot(Ng, wi) > F(0.f));
      if (D == LeaksBelow) above = cosI > F(-0.3f);
      F value = zeroUnless(above, (D == LeaksBelow ? abs(cosI) : cosI) * F(kInvPi));
      out.pdf = value;
      out.pdfReverse = zeroUnless(above, cosO * F(kInvPi));
      if (D == PdfTooLarge) out.pdf *= F(1.02f);
      if (D == PdfTooSmall) out.pdf *= F(0.98f);
      if (D == MissingCosine) value = zeroUnless(above, F(kInvPi));
      if (D == WrongReversePdf) out.pdfReverse = out.pdf;
      if (D == NotReciprocal) value *= F(0.8f) + F(0.2f) * cosO;
      if (D == GainsEnergy) value *= F(1.01f);
      if (D == LosesEnergy) value *= F(0.98f);
      if (D == WidthsDisagree && W == 8) value *= F(1.0000002f);
      if (D == NanAtGrazing) value = value * (cosO / cosO);
      if constexpr (kGlossy) {
        const F p = zeroUnless(above, lobePdf(wi));
        const F shared = p * F(kLobe) * cosI / max(max(cosI, cosO), F(1e-6f));
        out.add(1, albedo_ * shared);
        value *= F(1.f - kMirror - kLobe);
        out.pdf = fma(out.pdf, F(1.f - kMirror - kLobe), p * F(kLobe));
        out.pdfReverse = fma(out.pdfReverse, F(1.f - kMirror - kLobe), p * F(kLobe));
      }
      out.add(0, albedo_ * value);
    }
    KN_INLINE void sample(Float<W> u, Float<W> v, Float<W> w, LobeSample<W>& out) const {
      using F = Float<W>;
      Vec3<W> local = cosineHemisphere(u, v);
      if (D == OtherSamples) local = normalize(Vec3<W>(local.x * F(1.05f), local.y, local.z));
      out.wi = Frame<W>(N).toWorld(local);
      out.valid = Mask<W>(true);
      out.discrete = Mask<W>(false);
      if constexpr (kGlossy) {
        const Vec3<W> mirror = reflect(wo, N);
        const F n = D == LobeTooNarrow ? exponent * F(1.1f) : exponent;
        const F x = log(F(1.f) - u) / (n + F(1.f));
        const F series = -x * fma(x, fma(x, fma(x, F(1.f / 24), F(1.f / 6)), F(0.5f)), F(1.f));
        const F h = select(x > F(-0.05f), series, F(1.f) - exp(x)), r = safeSqrt(h * (F(2.f) - h));
        F s, c;
        sincos(v * F(kTwoPi), s, c);
        const Vec3<W> lobe = normalize(Frame<W>(mirror).toWorld({r * c, r * s, F(1.f) - h}));
        out.discrete = w < F(kMirror);
        out.wi = select(out.discrete, mirror, select(w < F(kMirror + kLobe), lobe, out.wi));
        out.discreteWeight = albedo_ * F(kMirror);
        out.discreteProbability = F(kMirror);
        out.discreteLobe = Int<W>(1);
        out.valid = (!out.discrete) | ((dot(mirror, Ng) > F(0.f)) & (cosO > F(0.f)));
      }
    }
    KN_INLINE Rgb<W> albedo() const { return albedo_; }
  };
  template <int W>
  static void evaluateAtFirst(const Context* c, const void* k, uint32_t, uint32_t n, const EvaluateArgs* a) {
    BxdfRunner<Trial>::template evaluateAt<W>(c, k, 0, n, a);
  }
  template <int W>
  static constexpr BxdfFunctions table() {
    BxdfFunctions f = BxdfRunner<Trial>::template table<W>();
    if (D == IgnoresPoint) f.evaluateAt = &evaluateAtFirst<W>;
    return f;
  }
};

#if HWY_TARGET == HWY_AVX2
#define X(name, check)                                          \
  constexpr BxdfFunctions k##name##1 = Trial<name>::table<1>(); \
  constexpr BxdfFunctions k##name##4 = Trial<name>::table<4>(); \
  constexpr BxdfFunctions k##name##8 = Trial<name>::table<8>();
#else
#define X(name, check) constexpr BxdfFunctions k##name##16 = Trial<name>::table<16>();
#endif
TRIALS(X)
#undef X
KINORA_KERNELS_END

#if HWY_ONCE
#include "simd/dispatch.h"
#include "testing/broken_kit.h"

namespace kinora {
namespace {
using testing::CheckReport;
using Case = testing::BrokenCase;

const char* const kWhite[] = {"albedo=1 1 1", nullptr};
constexpr BxdfTraits kWhiteTraits{trial::kLobes, 2, -1, nullptr, nullptr, kWhite, kWhite};
constexpr BxdfTraits kPlainTraits{trial::kLobes, 2, -1, nullptr, nullptr, nullptr, kWhite};

std::vector<Case> cases() {
  std::vector<Case> r;
#define X(name, check)                                                                                             \
  {                                                                                                                \
    static const WidthTable tables[] = {                                                                           \
        {1, &N_AVX2::k##name##1}, {4, &N_AVX2::k##name##4}, {8, &N_AVX2::k##name##8}, {16, &N_AVX3::k##name##16}}; \
    r.push_back(                                                                                                   \
        {{kAbiVersion, sizeof(Descriptor), Kind::Bxdf, 0, #name, "", trial::kParams, std::size(trial::kParams),    \
          tables, 4, trial::name >= trial::MirrorAndLobe ? &kPlainTraits : &kWhiteTraits, nullptr, nullptr},       \
         check});                                                                                                  \
  }
  TRIALS(X)
#undef X
  return r;
}

class Kit : public ::testing::TestWithParam<Case> {};

TEST_P(Kit, FindsWhatIsBroken) {
  setThreadFloatMode();
  testing::BxdfCheckOptions options;
  options.randomSettings = 4;
  options.statisticalSettings = 6;
  testing::expectVerdict(testing::checkBxdf(GetParam().descriptor, options), GetParam().check,
                         GetParam().descriptor.name);
}

INSTANTIATE_TEST_SUITE_P(Broken, Kit, ::testing::ValuesIn(cases()), testing::nameOf);

// A defect of one seed must not be luck: right bxdfs pass and 2 % are found whatever the seed.
TEST(KitSeeds, VerdictDoesNotDependOnTheSeed) {
  setThreadFloatMode();
  const std::vector<Case> all = cases();
  for (uint64_t seed = 2; seed < 7; ++seed) {
    testing::BxdfCheckOptions options;
    options.seed = seed;
    options.randomSettings = 2;
    options.statisticalSettings = 4;
    for (const trial::Defect d : {trial::Lambert, trial::MirrorAndLobe}) {
      const CheckReport good = testing::checkBxdf(all[size_t(d)].descriptor, options);
      EXPECT_TRUE(good.passed) << "seed " << seed << ": " << good.str();
    }
    const CheckReport bad = testing::checkBxdf(all[trial::PdfTooSmall].descriptor, options);
    EXPECT_TRUE(bad.failed("chi-square")) << "seed " << seed;
  }
}

TEST(KitSettings, MalformedTextIsRefused) {
  const Descriptor d = cases().front().descriptor;
  testing::Setting s;
  std::string error;
  EXPECT_TRUE(testing::parseSetting(d, "albedo=1 0.5 0; exponent=3", s, error)) << error;
  EXPECT_EQ(s.numbers[0][1], 0.5f);
  EXPECT_TRUE(testing::parseSetting(d, " ; exponent = 7 ;", s, error)) << error;
  EXPECT_EQ(s.numbers[1][0], 7.f);
  for (const char* bad : {"albedo", "albedo=1 1", "albedo=1 1 x", "nothing=1", "exponent=", "exponent=nan",
                          "Albedo=1 1 1", "exponent=1 2"}) {
    error.clear();
    EXPECT_FALSE(testing::parseSetting(d, bad, s, error)) << bad;
    EXPECT_FALSE(error.empty()) << bad;
  }
}

// Every pair of parameters takes every pair of levels somewhere in the covering settings.
TEST(KitSettings, PairsAreCovered) {
  static constexpr Param kMany[] = {param::number("a", 0.5f),           param::number("b", 0.5f),
                                    param::number("c", 0.5f),           param::number("d", 0.5f),
                                    param::integer("e", 0).range(0, 3), param::number("f", 0.5f)};
  Descriptor d{};
  d.params = kMany;
  d.paramCount = std::size(kMany);
  const std::vector<testing::Setting> all = testing::coveringSettings(d, 0, 1);
  EXPECT_LT(all.size(), 60u);
  for (uint32_t i = 0; i < d.paramCount; ++i)
    for (uint32_t j = i + 1; j < d.paramCount; ++j)
      for (const float x : {0.f, 1.f})
        for (const float y : {0.f, 1.f}) {
          bool seen = false;
          for (const testing::Setting& s : all) seen = seen || (s.numbers[i][0] == x && s.numbers[j][0] == y);
          EXPECT_TRUE(seen) << kMany[i].name << "=" << x << " " << kMany[j].name << "=" << y;
        }
}

}  // namespace
}  // namespace kinora
#endif
