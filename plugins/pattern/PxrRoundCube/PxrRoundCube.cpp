// PxrRoundCube: texture coordinates by projection along the three axes, chosen by the normal ("triplanar"). Where
// faces blend, each sample takes one of them with the probability of its weight: the mean over samples is the blend,
// unbiased where what is looked up is used linearly (colours), and one lookup instead of three.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrRoundCube/PxrRoundCube.cpp"
#include <kinora/pattern_author.h>
#include <kinora/random.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kNumberOfTextures, kFrequency, kTransitionWidth, kUse, kPref, kNref, kCoordsys };
constexpr Param kParams[] = {
    param::integer("numberOfTextures", 1)
        .range(1, 6)
        .options("1 one, 3 one an axis, 6 one a face")
        .help("How many textures the faces share; the third component of the result says which."),
    param::number("frequency", 1.f).range(0.01f, 32).help("Repetitions per unit of length."),
    param::number("transitionWidth", 0.5f).help("0: faces meet in edges, 1: they blend all over."),
    param::integer("use", 0).options("0 position and normal, 1 primitive variables pref and nref").help("Of what."),
    param::string("pref", "__Pref").help("Primitive variable with the reference position."),
    param::string("nref", "__Nref").help("Primitive variable with the reference normal."),
    param::string("coordsys", "object").help("Space whose axes are meant."),
    param::output(Type::Struct, "resultMulti"),
    param::output(Type::Float, "resultMask"),
};
// Addresses of random numbers that no path uses.
constexpr uint32_t kDimension = 0x40000000u;

struct PxrRoundCube {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    using I = Int<W>;
    const char *space = c->fn->text(c, kCoordsys), *pref = c->fn->text(c, kPref), *nref = c->fn->text(c, kNref);
    if (!space || !*space) space = "object";
    const bool takesReference = fixedInteger(*c, kUse) == 1;
    const Primvar places(*c, takesReference ? pref : nullptr), normals(*c, takesReference ? nref : nullptr);
    Value p, n, r = c->builtin(Builtin::PoRadius);
    for (uint32_t k = 0; k < 3; ++k) {
      p.data[k] = c->P[k];
      n.data[k] = c->N[k];
    }
    p.stride = n.stride = 1;
    p.components = n.components = 3;
    if (std::strcmp(space, "object")) {
      r.data[0] = c->radius;
      r.stride = r.components = 1;
    }
    toSpace<W>(*c, space, Moves::Point, p);
    toSpace<W>(*c, space, Moves::Normal, n);
    p = placesOr<W>(*c, places, space, Moves::Point, p);
    n = placesOr<W>(*c, normals, space, Moves::Normal, n);
    if (places.value.components == 3) r = footprintOr(*c, places, r);
    const Value frequency = c->param(kFrequency), transition = c->param(kTransitionWidth);
    const int textures = fixedInteger(*c, kNumberOfTextures);
    Manifold& m = args->manifolds[0];
    m.dimensions = 2;
    float *q[3], *radius[3], *mask[3];
    makeOutput(*c, m.q, 3, false, q);
    makeOutput(*c, m.radius, 1, false, radius);
    makeOutput(*c, args->outputs[1], 1, false, mask);
    const bool wantGradients = args->wanted[0] & kWantGradients;
    Value of[3];
    float* slopes[2][3];
    if (wantGradients) {
      positionGradients<W>(*c, space, pref, places, of);
      for (uint32_t k = 0; k < 2; ++k) makeOutput(*c, m.gradient[k], 3, false, slopes[k]);
    }
    const F zero(0.f), one(1.f);
    for (uint32_t i = 0; i < c->padded; i += W) {
      const At at{i, false};
      const Vec3<W> N = loadVec<W>(n, at), P = loadVec<W>(p, at) * loadFloat<W>(frequency, at);
      const F ax = abs(N.x), ay = abs(N.y), az = abs(N.z), most = max(ax, max(ay, az));
      const F floor = most * (one - clamp(loadFloat<W>(transition, at), zero, one)) - most * F(1e-6f);
      const F wx = max(ax - floor, zero), wy = max(ay - floor, zero), wz = max(az - floor, zero);
      const F sum = max(wx + wy + wz, F(1e-30f));
      const F u =
          drawHashed<W>(I::load(c->sampleSeed + i), I::load(c->sampleIndex + i), kDimension, I(c->depth)) * sum;
      const Mask<W> isX = u < wx, isY = (!isX) & (u < wx + wy);
      const F along = select(isX, N.x, select(isY, N.y, N.z)), sign = select(along < zero, -one, one);
      // seen from outside, s runs to the right and t down in a right-handed space
      const F s = select(isX, -P.z * sign, select(isY, P.x, P.x * sign));
      const F t = select(isX, P.y, select(isY, -P.z * sign, P.y));
      const F axis = select(isX, zero, select(isY, one, F(2.f)));
      const F face = textures >= 6 ? fma(axis, F(2.f), select(along < zero, one, zero)) : textures >= 3 ? axis : zero;
      s.store(q[0] + i);
      (one - t).store(q[1] + i);
      face.store(q[2] + i);
      (loadFloat<W>(r, at) * abs(loadFloat<W>(frequency, at))).store(radius[0] + i);
      (select(isX, wx, select(isY, wy, wz)) / sum).store(mask[0] + i);
      if (wantGradients) {
        const Vec3<W> gx = loadVec<W>(of[0], at), gy = loadVec<W>(of[1], at), gz = loadVec<W>(of[2], at);
        const F f = loadFloat<W>(frequency, at);
        (select(isX, gz * -sign, select(isY, gx, gx * sign)) * f).store(slopes[0], i);
        (select(isX, gy, select(isY, gz * -sign, gy)) * -f).store(slopes[1], i);
      }
    }
    args->outputs[0] = m.q;
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrRoundCube, .help = "Texture coordinates by projection along three axes, chosen by the normal.",
               .params = kParams)
