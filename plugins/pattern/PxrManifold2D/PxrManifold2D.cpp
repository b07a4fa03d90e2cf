// PxrManifold2D: texture coordinates turned, scaled and shifted about the origin, in this order, then inverted. The
// footprint grows with the larger of the two scales, so that textures are never sampled too finely.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrManifold2D/PxrManifold2D.cpp"
#include <cmath>
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kAngle, kScaleS, kScaleT, kOffsetS, kOffsetT, kInvertS, kInvertT, kPrimvarS, kPrimvarT };
constexpr Param kParams[] = {
    param::number("angle", 0.f).range(-180, 180).help("Rotation about the origin, degrees."),
    param::number("scaleS", 1.f).range(-8, 8).help("Factor of s: repetitions of a texture."),
    param::number("scaleT", 1.f).range(-8, 8).help("Factor of t."),
    param::number("offsetS", 0.f).range(-1, 1).help("Added to s after scaling."),
    param::number("offsetT", 0.f).range(-1, 1).help("Added to t after scaling."),
    param::integer("invertS", 0).range(0, 1).help("1: s becomes 1 - s, last of all."),
    param::integer("invertT", 1).range(0, 1).help("1: t becomes 1 - t, last of all."),
    param::string("primvarS", "")
        .help("Primitive variable of s, or of s and t when it has two components; \"\": st."),
    param::string("primvarT", "").help("Primitive variable of t; \"\": the second component of primvarS."),
    param::output(Type::Struct, "result"),
    param::output(Type::Float, "resultS"),
    param::output(Type::Float, "resultT"),
};

// Where s or t comes from: a component of a primitive variable, or (null) of the surface's own.
struct Source {
  const char* primvar = nullptr;
  uint32_t component = 0;
};

// s, t and the footprint in their units; the surface's own where the named variables are missing.
inline void texturePlace(const Context& c, Value& s, Value& t, Value& radius, Source from[2]) {
  const char *nameS = c.fn->text(&c, kPrimvarS), *nameT = c.fn->text(&c, kPrimvarT);
  Value q = c.builtin(Builtin::St), r;
  radius = c.builtin(Builtin::StRadius);
  shareComponent(q, 0, s);
  shareComponent(q, 1, t);
  from[1].component = 1;
  if (nameS && *nameS) {
    const Value v = c.fn->primvar(&c, nameS, &r);
    if (v.components) shareComponent(v, 0, s), from[0] = {nameS, 0};
    if (v.components > 1) shareComponent(v, 1, t), from[1] = {nameS, 1};
    if (v.components && r.components) radius = r;
  }
  if (nameT && *nameT) {
    const Value v = c.fn->primvar(&c, nameT, nullptr);
    if (v.components) from[1] = {nameT, v.components > 1 ? 1u : 0u}, shareComponent(v, from[1].component, t);
  }
}

struct PxrManifold2D {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value angle = c->param(kAngle), scaleS = c->param(kScaleS), scaleT = c->param(kScaleT);
    const Value offsetS = c->param(kOffsetS), offsetT = c->param(kOffsetT);
    const bool invertS = fixedInteger(*c, kInvertS) != 0, invertT = fixedInteger(*c, kInvertT) != 0;
    Value inS, inT, r;
    Source from[2];
    texturePlace(*c, inS, inT, r, from);
    const bool one = allUniform({&angle, &scaleS, &scaleT, &offsetS, &offsetT, &inS, &inT, &r});
    Manifold& m = args->manifolds[0];
    float *st[3], *radius[3];
    m.dimensions = 2;
    makeOutput(*c, m.q, 2, one, st);
    makeOutput(*c, m.radius, 1, one, radius);
    const bool turned = !angle.uniform() || angle.data[0][0] != 0.f;
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const At at{i, false};
      F s = loadFloat<W>(inS, at), t = loadFloat<W>(inT, at);
      if (turned) {
        F sine, cosine;
        sincos(loadFloat<W>(angle, at) * F(kPi / 180.f), sine, cosine);
        const F turnedS = fms(s, cosine, t * sine);
        t = fma(s, sine, t * cosine);
        s = turnedS;
      }
      const F fs = loadFloat<W>(scaleS, at), ft = loadFloat<W>(scaleT, at);
      s = fma(s, fs, loadFloat<W>(offsetS, at));
      t = fma(t, ft, loadFloat<W>(offsetT, at));
      if (invertS) s = F(1.f) - s;
      if (invertT) t = F(1.f) - t;
      s.store(st[0] + i);
      t.store(st[1] + i);
      (loadFloat<W>(r, at) * max(abs(fs), abs(ft))).store(radius[0] + i);
    }
    args->outputs[0] = m.q;
    shareComponent(m.q, 0, args->outputs[1]);
    shareComponent(m.q, 1, args->outputs[2]);
    if (args->wanted[0] & kWantGradients) gradients<W>(*c, from, turned, m);
  }
  // The gradients of s and t, turned and scaled like them.
  template <int W>
  static void gradients(const Context& c, const Source from[2], bool turned, Manifold& m) {
    using F = Float<W>;
    const Value angle = c.param(kAngle), scaleS = c.param(kScaleS), scaleT = c.param(kScaleT);
    const float signS = fixedInteger(c, kInvertS) != 0 ? -1.f : 1.f,
                signT = fixedInteger(c, kInvertT) != 0 ? -1.f : 1.f;
    const Value ofS = c.fn->gradient(&c, from[0].primvar, from[0].component);
    const Value ofT = c.fn->gradient(&c, from[1].primvar, from[1].component);
    float *outS[3], *outT[3];
    makeOutput(c, m.gradient[0], 3, false, outS);
    makeOutput(c, m.gradient[1], 3, false, outT);
    for (uint32_t i = 0; i < c.padded; i += W) {
      const At at{i, false};
      Vec3<W> s = loadVec<W>(ofS, at), t = loadVec<W>(ofT, at);
      if (turned) {
        F sine, cosine;
        sincos(loadFloat<W>(angle, at) * F(kPi / 180.f), sine, cosine);
        const Vec3<W> turnedS = s * cosine - t * sine;
        t = s * sine + t * cosine;
        s = turnedS;
      }
      (s * (loadFloat<W>(scaleS, at) * F(signS))).store(outS, i);
      (t * (loadFloat<W>(scaleT, at) * F(signT))).store(outT, i);
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrManifold2D, .help = "Places 2D textures: rotates, scales, shifts and inverts texture coordinates.",
               .params = kParams)
