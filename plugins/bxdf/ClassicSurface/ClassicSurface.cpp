// ClassicSurface: the standard surfaces of the RenderMan Interface by their formulas (RISpec 3.2, appendix A.1), for
// files of the shading-language age: surfaceColor times Kd times the diffuse light, plus the highlight Ks
// (N.H)^(8 / roughness), which has no cosine of its own: it is not reciprocal, and paths traced from the lights make
// other highlights than those from the camera. The specification writes the exponent as 1 / roughness; the renderers of
// its time drew highlights eight times narrower in it, and files were lit by what these showed. Lights bring pi times what a shader
// called Cl (a light of intensity 1 that faces a white matte surface makes it 1), hence the 1 / pi here. What shaders
// made of light without direction is unlitColor: it is seen by the camera and in mirrors, and lights nothing.
#define KINORA_KERNEL_FILE "plugins/bxdf/ClassicSurface/ClassicSurface.cpp"
#include <kinora/bxdf_author.h>
#include <kinora/math/elementary.h>

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kSurfaceColor,
  kKd,
  kSpecularColor,
  kKs,
  kRoughness,
  kKr,
  kMetallic,
  kUnlitColor,
  kFacingGain,
  kFogColor,
  kFogDistance,
  kCueStart,
  kCueEnd,
  kPresence,
  kBumpNormal
};
constexpr float kLeastRoughness = 8e-3f;  // narrower highlights are beyond single precision
constexpr Param kParams[] = {
    param::color("surfaceColor", 1.f).help("Colour of the surface, which multiplies what is diffuse and unlit."),
    param::number("Kd", 0.5f).help("Diffuse coefficient."),
    param::color("specularColor", 1.f).help("Colour of highlights."),
    param::number("Ks", 0.5f).help("Coefficient of highlights."),
    param::number("roughness", 0.1f)
        .range(0.02f, 1)
        .help("Highlights are the cosine of normal and half-way vector to the power 8 / roughness, as renderers of "
              "that time drew them; at least 0.008."),
    param::number("Kr", 0.f).help("Fraction reflected as by a mirror."),
    param::flag("metallic", false)
        .help("1: highlights and reflections are multiplied by surfaceColor, as those of metals."),
    param::color("unlitColor", 0.f)
        .help("Radiance by no direction, before surfaceColor: Ka times ambient light; 1 for a constant surface. "
              "Camera and mirrors see it; it lights nothing else."),
    param::number("facingGain", 0.f)
        .help("Radiance that falls with the square of the cosine between normal and viewer, before surfaceColor."),
    param::color("fogColor", 0.f).help("Colour that fog and depth cueing mix in; camera and mirrors see it."),
    param::number("fogDistance", 0.f)
        .range(0, 10)
        .help("Fog: over this length of the ray that meets it the surface fades to 1 / e; 0: none."),
    param::number("cueStart", 0.f).range(0, 10).help("Depth cueing: length of the ray where it begins."),
    param::number("cueEnd", 0.f).range(0, 10).help("Depth cueing: where only fogColor is left; 0: none."),
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
    param::normal("bumpNormal").help("Shading normal from a bump pattern."),
};
constexpr LobeDecl kLobes[] = {{"Diffuse", kLobeDiffuse}, {"Specular", kLobeSpecular}, {"Specular", kLobeSpecular}};
constexpr const char* kLossless[] = {"Kd=1; Ks=0", "Kd=0; Ks=0; Kr=1", nullptr};
constexpr const char* kConserving[] = {"", "Kd=0.5; Ks=0.5; roughness=0.02", "Kd=0.3; Ks=0; Kr=0.7", nullptr};

struct ClassicSurface {
  struct Closure {
    const Context* context;
    Value color, kd, specularColor, ks, roughness, kr, unlit, facing, bump, seen;
    Value fogColor, fogDistance, cueStart, cueEnd;
    bool metallic = false, bumped = false, isLimited = false, hasFog = false;
  };
  template <int W>
  using HasEmission = void;
  // A bit for each lobe that may be on.
  static uint64_t programKey(const ParamValue* v, uint32_t) {
    return uint64_t(v[kKd].mayBeOn()) | uint64_t(v[kKs].mayBeOn()) << 1 | uint64_t(v[kKr].mayBeOn()) << 2;
  }
  static void begin(const Context& c, Closure& k) {
    k.context = &c;
    k.color = c.param(kSurfaceColor);
    k.kd = c.param(kKd);
    k.specularColor = c.param(kSpecularColor);
    k.ks = c.param(kKs);
    k.roughness = c.param(kRoughness);
    k.kr = c.param(kKr);
    k.metallic = c.param(kMetallic).data[0][0] != 0.f;
    k.unlit = c.param(kUnlitColor);
    k.facing = c.param(kFacingGain);
    k.bump = c.param(kBumpNormal);
    k.bumped = isBumped(k.bump);
    k.seen = c.fn->primvar(&c, "__seen", nullptr);
    k.isLimited = c.depth > 0;
    k.fogDistance = c.param(kFogDistance);
    k.cueEnd = c.param(kCueEnd);
    k.hasFog = !(isNone(k.fogDistance) && isNone(k.cueEnd));
    if (!k.hasFog) return;
    k.fogColor = c.param(kFogColor);
    k.cueStart = c.param(kCueStart);
  }
  static bool isNone(const Value& v) { return v.uniform() && v.data[0][0] == 0.f; }
  // What the way to the surface leaves of it (RISpec 3.2, appendix A.3).
  template <int W>
  static KN_INLINE Float<W> visibility(const Closure& k, At at) {
    using F = Float<W>;
    const F away = loadFloat<W>(k.context->distance, at), reach = loadFloat<W>(k.fogDistance, at);
    const F start = loadFloat<W>(k.cueStart, at), end = loadFloat<W>(k.cueEnd, at);
    const F fog = select(reach > F(0.f), exp(-away / max(reach, F(1e-12f))), F(1.f));
    const F cued = clamp((away - start) / max(end - start, F(1e-12f)), F(0.f), F(1.f));
    return select(end > F(0.f), fog * (F(1.f) - cued), fog);
  }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }

  template <int W>
  static KN_INLINE Rgb<W> emission(const Closure& k, At at) {
    const Surface<W> s(*k.context, at);
    const Float<W> facing = loadFloat<W>(k.facing, at) * s.cosO * s.cosO;
    Rgb<W> sum = (loadRgb<W>(k.unlit, at) + Rgb<W>(facing, facing, facing)) * loadRgb<W>(k.color, at);
    if (k.hasFog) {
      const Float<W> clear = visibility<W>(k, at);
      sum = sum * clear + loadRgb<W>(k.fogColor, at) * (Float<W>(1.f) - clear);
    }
    return k.seen.components ? sum * loadFloat<W>(k.seen, at) : sum;
  }

  template <int W>
  struct Lanes {
    Vec3<W> N, Ng, wo;
    Rgb<W> diffuse, highlight, mirror;
    Float<W> cosO, exponent, pDiffuse, pHighlight, pMirror;
    KN_INLINE Lanes(const Closure& k, const Surface<W>& s) : Ng(s.Ng), wo(s.wo) {
      using F = Float<W>;
      N = k.bumped ? bumpedNormal<W>(k.bump, s) : s.N;
      cosO = dot(N, wo);
      const Rgb<W> color = loadRgb<W>(k.color, s.at);
      diffuse = color * loadFloat<W>(k.kd, s.at);
      highlight = loadRgb<W>(k.specularColor, s.at) * loadFloat<W>(k.ks, s.at);
      const F kr = loadFloat<W>(k.kr, s.at);
      mirror = Rgb<W>(kr, kr, kr);
      if (k.metallic) {
        highlight = highlight * color;
        mirror = mirror * color;
      }
      if (k.hasFog) {
        const F clear = visibility<W>(k, s.at);
        diffuse = diffuse * clear;
        highlight = highlight * clear;
        mirror = mirror * clear;
      }
      exponent = F(8.f) / max(loadFloat<W>(k.roughness, s.at), F(kLeastRoughness));
      const F spread = F(8.f) / (exponent + F(2.f));  // what a highlight keeps of light from above, at most
      if (k.isLimited) {
        // between surfaces that send on more than they get, light would grow without end
        const F most = max(maxComponent(diffuse + highlight * spread + mirror), F(1.f)), less = F(1.f) / most;
        diffuse = diffuse * less;
        highlight = highlight * less;
        mirror = mirror * less;
      }
      const F d = max(average(diffuse), F(0.f)), h = max(average(highlight), F(0.f)) * spread,
              m = max(average(mirror), F(0.f)), sum = d + h + m;
      const Mask<W> any = sum > F(0.f);
      const F scale = F(1.f) / max(sum, F(1e-20f));
      pDiffuse = select(any, d * scale, F(1.f));
      pHighlight = zeroUnless(any, h * scale);
      pMirror = zeroUnless(any, m * scale);
    }
    KN_INLINE void evaluate(Vec3<W> wi, LobeSum<W>& out) const {
      using F = Float<W>;
      const F cosI = dot(N, wi);
      const Mask<W> above = (cosI > F(0.f)) & (dot(Ng, wi) > F(0.f));
      const F cosine = zeroUnless(above, cosI) * F(kInvPi);
      const Vec3<W> half = normalize(wo + wi);
      const F cosH = dot(N, half), toward = dot(wo, half);
      const Mask<W> shines = above & (cosH > F(0.f)) & (toward > F(1e-6f));
      const F power = zeroUnless(shines, pow(max(cosH, F(1e-20f)), exponent));
      out.add(0, diffuse * cosine);
      out.add(1, highlight * (power * F(kInvPi)));
      const F density = power * (exponent + F(1.f)) * F(0.25f * kInvTwoPi) / max(toward, F(1e-6f)) * pHighlight;
      out.pdf = fma(cosine, pDiffuse, density);
      out.pdfReverse = zeroUnless(above, fma(max(cosO, F(0.f)) * F(kInvPi), pDiffuse, density));
    }
    KN_INLINE void sample(Float<W> u, Float<W> v, Float<W> w, LobeSample<W>& out) const {
      using F = Float<W>;
      const Mask<W> isDiffuse = w < pDiffuse, isMirror = w >= F(1.f) - pMirror;
      const Frame<W> frame(N);
      const F cosine = pow(max(u, F(1e-20f)), F(1.f) / (exponent + F(1.f)));
      const F sine = safeSqrt(fnma(cosine, cosine, F(1.f)));
      F s, c;
      sincos(v * F(kTwoPi), s, c);
      Vec3<W> half = frame.toWorld({sine * c, sine * s, cosine});
      half = select(isMirror, N, half);
      out.wi = select(isDiffuse & !isMirror, frame.toWorld(cosineHemisphere(u, v)), reflect(wo, half));
      out.valid = (cosO > F(0.f)) | !isMirror;
      out.discrete = isMirror & (pMirror > F(0.f)) & (dot(Ng, out.wi) > F(0.f));
      out.valid = out.valid & (out.discrete | !isMirror);
      out.discreteWeight = mirror;
      out.discreteProbability = pMirror;
      out.discreteLobe = Int<W>(2u);
    }
    KN_INLINE Rgb<W> albedo() const {
      const Float<W> none(0.f), one(1.f);
      const Rgb<W> sum = diffuse + highlight + mirror;
      return {clamp(sum.x, none, one), clamp(sum.y, none, one), clamp(sum.z, none, one)};
    }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(ClassicSurface,
            .help = "The standard surfaces of the RenderMan Interface (matte, metal, plastic ...) by their formulas.",
            .params = kParams, .lobes = kLobes, .presenceParam = kPresence, .programKey = ClassicSurface::programKey,
            .lossless = kLossless, .conserving = kConserving, .flags = kBxdfNotReciprocal)
