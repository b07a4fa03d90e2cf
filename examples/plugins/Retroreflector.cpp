// Retroreflector: an example bxdf. Diffuse reflection plus a lobe about the direction the light came from, as on road
// signs.
//
// The lobe is (n + 1) / (2 pi) cos^n(angle between wi and wo) times retroColor. It is the same when wi and wo change
// places, so it is reciprocal, and it reflects at most retroColor, because the power cosine integrates to 1 before
// the cosine at the surface takes its part.
#define KINORA_KERNEL_FILE "Retroreflector.cpp"
#include <kinora/bxdf_author.h>

// Plain declarations stand once; what is below is compiled for each instruction set.

KINORA_KERNELS_BEGIN

enum : uint32_t { kDiffuseColor, kRetroColor, kSharpness };
constexpr Param kParams[] = {
    param::color("diffuseColor", 0.1f).help("Fraction of light reflected diffusely."),
    param::color("retroColor", 0.8f).help("Most of the light that goes back to where it came from."),
    param::number("sharpness", 40.f).range(1, 400).help("Exponent of the lobe; larger is narrower."),
};
constexpr LobeDecl kLobes[] = {{"Diffuse", kLobeDiffuse}, {"Specular", kLobeSpecular}};
// settings of which a test may demand that they never reflect more than they receive
constexpr const char* kConserving[] = {"diffuseColor=0.5 0.5 0.5; retroColor=0.5 0.5 0.5", nullptr};

struct Retroreflector {
  struct Closure {
    Value diffuse, retro, sharpness;
  };
  static void begin(const Context& c, Closure& k) {
    k.diffuse = c.param(kDiffuseColor);
    k.retro = c.param(kRetroColor);
    k.sharpness = c.param(kSharpness);
  }

  template <int W>
  struct Lanes {
    Vec3<W> N, Ng, wo;
    Rgb<W> diffuse, retro;
    Float<W> exponent, cosO, pDiffuse;

    KN_INLINE Lanes(const Closure& k, const Surface<W>& s) : N(s.N), Ng(s.Ng), wo(s.wo), cosO(s.cosO) {
      diffuse = loadRgb<W>(k.diffuse, s.at);
      retro = loadRgb<W>(k.retro, s.at);
      exponent = max(loadFloat<W>(k.sharpness, s.at), Float<W>(1.f));
      const Float<W> d = max(average(diffuse), Float<W>(0.f)), r = max(average(retro), Float<W>(0.f));
      pDiffuse = select(d + r > Float<W>(0.f), d / max(d + r, Float<W>(1e-20f)), Float<W>(1.f));
    }
    KN_INLINE void evaluate(Vec3<W> wi, LobeSum<W>& out) const {
      using F = Float<W>;
      const F cosI = dot(N, wi);
      const Mask<W> above = (cosI > F(0.f)) & (dot(Ng, wi) > F(0.f));
      const F back = max(dot(wi, wo), F(0.f));
      const F power = select(back > F(0.f), pow(max(back, F(1e-20f)), exponent), F(0.f));
      const F lobe = zeroUnless(above, (exponent + F(1.f)) * F(kInvTwoPi) * power);
      const F cosine = zeroUnless(above, cosI) * F(kInvPi);
      out.add(0, diffuse * cosine);
      out.add(1, retro * (lobe * max(cosI, F(0.f))));
      out.pdf = fma(cosine, pDiffuse, lobe * (F(1.f) - pDiffuse));
      out.pdfReverse = fma(zeroUnless(above, cosO * F(kInvPi)), pDiffuse, lobe * (F(1.f) - pDiffuse));
    }
    KN_INLINE void sample(Float<W> u, Float<W> v, Float<W> w, LobeSample<W>& out) const {
      using F = Float<W>;
      const F z = pow(max(u, F(1e-20f)), F(1.f) / (exponent + F(1.f)));
      const F r = safeSqrt(fnma(z, z, F(1.f)));
      F sine, cosine;
      sincos(v * F(kTwoPi), sine, cosine);
      const Vec3<W> about = Frame<W>(wo).toWorld({r * cosine, r * sine, z});
      out.wi = select(w < pDiffuse, Frame<W>(N).toWorld(cosineHemisphere(u, v)), about);
      out.valid = Mask<W>(true);  // directions below the surface get no weight in evaluate()
      out.discrete = Mask<W>(false);
    }
    KN_INLINE Rgb<W> albedo() const { return diffuse + retro; }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(Retroreflector, .help = "Sends light back to where it came from, over a diffuse ground.",
            .params = kParams, .lobes = kLobes, .conserving = kConserving)
