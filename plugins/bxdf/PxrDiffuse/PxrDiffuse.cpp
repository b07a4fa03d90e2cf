// PxrDiffuse: Lambertian reflection and transmission. Albedo is diffuseColor (front and back alike) plus
// transmissionColor. Paper: Lambert; importance: cosine-weighted (Shirley and Chiu's concentric map).
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrDiffuse/PxrDiffuse.cpp"
#include <kinora/bxdf_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kDiffuseColor, kTransmissionBehavior, kTransmissionColor, kPresence, kBumpNormal };
constexpr Param kParams[] = {
    param::color("diffuseColor", 0.5f).help("Fraction of light reflected."),
    param::integer("transmissionBehavior", 2)
        .range(0, 2)
        .options("0 as diffuseColor, 1 as transmissionColor, 2 none")
        .help("Light let through: the colour of reflection, transmissionColor, or none."),
    param::color("transmissionColor", 0.f)
        .help("Fraction of light transmitted diffusely where transmissionBehavior is 1."),
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
    param::normal("bumpNormal").help("Shading normal from a bump pattern."),
};
constexpr LobeDecl kLobes[] = {{"Diffuse", kLobeDiffuse}, {"Diffuse", kLobeDiffuse | kLobeTransmit}};
constexpr const char* kLossless[] = {"diffuseColor=1 1 1", nullptr};

struct PxrDiffuse {
  struct Closure {
    Value reflect, transmit, bump;
    bool transmits = false, bumped = false;
  };
  static void begin(const Context& c, Closure& k) {
    k.reflect = c.param(kDiffuseColor);
    const int behavior = int(c.param(kTransmissionBehavior).data[0][0]);
    k.transmits = behavior != 2;
    if (k.transmits) k.transmit = c.param(behavior == 0 ? kDiffuseColor : kTransmissionColor);
    k.bump = c.param(kBumpNormal);
    k.bumped = isBumped(k.bump);
  }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }

  template <int W>
  struct Lanes {
    Vec3<W> N, Ng;
    Float<W> cosO, pReflect;
    Rgb<W> reflectance, transmittance;
    bool transmits;
    KN_INLINE Lanes(const Closure& k, const Surface<W>& s) : Ng(s.Ng), transmits(k.transmits) {
      N = k.bumped ? bumpedNormal<W>(k.bump, s) : s.N;
      cosO = dot(N, s.wo);
      reflectance = loadRgb<W>(k.reflect, s.at);
      pReflect = Float<W>(1.f);
      if (transmits) {
        transmittance = loadRgb<W>(k.transmit, s.at);
        const Float<W> r = max(average(reflectance), Float<W>(0.f)), t = max(average(transmittance), Float<W>(0.f));
        pReflect = select(r + t > Float<W>(0.f), r / max(r + t, Float<W>(1e-20f)), Float<W>(1.f));
      }
    }
    KN_INLINE void evaluate(Vec3<W> wi, LobeSum<W>& out) const {
      using F = Float<W>;
      const F cosI = dot(N, wi), side = dot(Ng, wi);
      const Mask<W> above = (cosI > F(0.f)) & (side > F(0.f));
      const F cosine = zeroUnless(above, cosI) * F(kInvPi);
      out.add(0, reflectance * cosine);
      out.pdf = cosine * pReflect;
      out.pdfReverse = zeroUnless(above, max(cosO, F(0.f)) * F(kInvPi) * pReflect);
      if (transmits) {
        const Mask<W> below = (cosI < F(0.f)) & (side < F(0.f));
        const F through = zeroUnless(below, -cosI) * F(kInvPi);
        out.add(1, transmittance * through);
        out.pdf += through * (F(1.f) - pReflect);
        out.pdfReverse += zeroUnless(below, max(cosO, F(0.f)) * F(kInvPi) * (F(1.f) - pReflect));
      }
    }
    KN_INLINE void sample(Float<W> u, Float<W> v, Float<W> w, LobeSample<W>& out) const {
      const Vec3<W> local = cosineHemisphere(u, v);
      const Mask<W> up = w < pReflect;
      out.wi = Frame<W>(N).toWorld({local.x, local.y, select(up, local.z, -local.z)});
      out.valid = Mask<W>(true);
      out.discrete = Mask<W>(false);
    }
    KN_INLINE Rgb<W> albedo() const { return transmits ? reflectance + transmittance : reflectance; }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(PxrDiffuse, .help = "Ideal diffuse reflection and transmission.", .params = kParams, .lobes = kLobes,
            .presenceParam = kPresence, .lossless = kLossless, .conserving = kLossless)
