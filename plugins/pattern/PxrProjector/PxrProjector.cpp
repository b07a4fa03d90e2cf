// PxrProjector: texture coordinates by projection from a coordinate system, as a slide projector, a globe or a label
// lays a picture onto things. Cameras look along -z of their coordinate system, y up; planes face +z.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrProjector/PxrProjector.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kProjection,
  kCoordsys,
  kUse,
  kFrontOnly,
  kFrontFalloff,
  kTraceOcclusion,
  kTraceMaxDistance,
  kTraceSet,
  kResolutionX,
  kResolutionY,
  kFocalLength,
  kApertureX,
  kApertureY,
  kNearClipPlane,
  kFarClipPlane,
  kFilmFit,
  kClampTo,
  kAngle,
  kScaleS,
  kScaleT,
  kOffsetS,
  kOffsetT,
  kInvertT,
  kVerbose
};
constexpr Param kParams[] = {
    param::integer("projection", 0)
        .range(0, 4)
        .options("0 planar, 1 perspective, 2 spherical, 3 cylindrical, 4 cubic")
        .help("How positions become texture coordinates. A plane shows -1 to 1 of x and y. A perspective projector "
              "stands at the origin of its system and looks along -z, y up."),
    param::string("coordsys", "")
        .help("Coordinate system of the projector; \"\": object space. That of a RIB camera looks along +z: Scale 1 "
              "1 -1 before the CoordinateSystem turns it round for a perspective projector."),
    param::integer("use", 0).options("0 position, 1 primitive variable __Pref").help("Position that is projected."),
    param::flag("frontOnly", true).help("1: what faces away from the projector is outside resultMask."),
    param::number("frontFalloff", 0.f).help("How resultMask falls off towards the sides: power of the cosine."),
    param::flag("traceOcclusion", false).help("No effect yet. Nothing hides the picture from what lies behind."),
    param::number("traceMaxDistance", 10000.f).help("No effect: see traceOcclusion."),
    param::string("traceSet", "").help("No effect: see traceOcclusion."),
    param::integer("resolutionX", 2048).range(1, 16384).help("Width of the picture: its shape for filmFit."),
    param::integer("resolutionY", 1556).range(1, 16384).help("Height of the picture."),
    param::number("focalLength", 50.f).fixed().range(1, 500).help("Of a perspective projector, millimetres."),
    param::number("apertureX", 0.98f).fixed().range(0.1f, 5).help("Width of its film, inches."),
    param::number("apertureY", 0.735f).fixed().range(0.1f, 5).help("Height of its film, inches."),
    param::number("nearClipPlane", 0.01f).help("Nearer points are outside resultMask."),
    param::number("farClipPlane", 10000.f).help("Farther points are outside resultMask."),
    param::integer("filmFit", 0)
        .range(0, 3)
        .options("0 fill, 1 horizontal, 2 vertical, 3 overscan")
        .help("How the picture lies on a film of another shape."),
    param::flag("clampTo", true).help("1: outside 0..1 of s and t resultMask is 0."),
    param::number("angle", 0.f).range(-180, 180).help("Rotation about the middle of the picture, degrees."),
    param::number("scaleS", 1.f).range(-8, 8).help("Factor of s about the middle."),
    param::number("scaleT", 1.f).range(-8, 8).help("Factor of t about the middle."),
    param::number("offsetS", 0.f).range(-1, 1).help("Added to s after scaling."),
    param::number("offsetT", 0.f).range(-1, 1).help("Added to t after scaling."),
    param::flag("invertT", true).help("1: t becomes 1 - t, last of all."),
    param::integer("verbose", 0).range(0, 2).help("Accepted."),
    param::output(Type::Struct, "result"),
    param::output(Type::Float, "resultS"),
    param::output(Type::Float, "resultT"),
    param::output(Type::Float, "resultMask"),
};

struct PxrProjector {
  // Where a point lies in the picture, how much a unit of length is there, and whether the projector sees it.
  template <int W>
  struct Seen {
    Float<W> s, t, grow, facing;
    Mask<W> inside;
    KN_INLINE Seen() {}
  };
  // Half sizes of the picture on a plane at distance 1.
  struct Film {
    float x, y;
    explicit Film(const Context& c) {
      const auto number = [&](uint32_t i) { return c.param(i).data[0][0]; };
      const float focal = number(kFocalLength) > 1e-3f ? number(kFocalLength) : 1e-3f;
      x = number(kApertureX) * 12.7f / focal;
      y = number(kApertureY) * 12.7f / focal;
      const float height = number(kResolutionY) > 1 ? number(kResolutionY) : 1.f;
      const float shape = (number(kResolutionX) > 1 ? number(kResolutionX) : 1.f) / height;
      const int fit = fixedInteger(c, kFilmFit);
      const bool wider = shape * y > x;  // the picture, beside the film
      if (fit == 1 || (fit == 0 && wider) || (fit == 3 && !wider))
        y = x / shape;
      else
        x = y * shape;
    }
  };
  template <int W>
  static KN_INLINE Seen<W> project(int projection, const Film& film, Vec3<W> p, Vec3<W> n) {
    using F = Float<W>;
    const F half(0.5f), least(1e-6f);
    Seen<W> r;
    r.inside = Mask<W>(true);
    const F l = max(length(p), least), around = sqrt(max(fma(p.x, p.x, p.z * p.z), least * least));
    switch (projection) {
      case 1: {
        r.inside = p.z < F(0.f);
        const F d = F(1.f) / max(-p.z, least), wide = d * F(0.5f / film.x), high = d * F(0.5f / film.y);
        r.s = fma(p.x, wide, half);
        r.t = fma(p.y, high, half);
        r.grow = max(wide, high);
        r.facing = -dot(n, p) / l;
        break;
      }
      case 2:
      case 3:
        r.s = fma(atan2(p.x, p.z), F(0.5f / kPi), half);
        r.t = projection == 2 ? fma(asin(clamp(p.y / l, F(-1.f), F(1.f))), F(1.f / kPi), half) : fma(p.y, half, half);
        r.grow = projection == 2 ? F(1.f / kPi) / l : max(F(0.5f / kPi) / around, half);
        r.facing = F(1.f);
        break;
      case 4: {
        const F x = abs(n.x), y = abs(n.y), z = abs(n.z);
        const Mask<W> alongX = (x >= y) & (x >= z), alongY = (!alongX) & (y >= z);
        const F sign = select(select(alongX, n.x, select(alongY, n.y, n.z)) < F(0.f), F(-1.f), F(1.f));
        r.s = fma(select(alongX, -p.z * sign, select(alongY, p.x, p.x * sign)), half, half);
        r.t = fma(select(alongX, p.y, select(alongY, -p.z * sign, p.y)), half, half);
        r.grow = half;
        r.facing = F(1.f);
        break;
      }
      default:
        r.s = fma(p.x, half, half);
        r.t = fma(p.y, half, half);
        r.grow = half;
        r.facing = n.z;
    }
    return r;
  }
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const char* space = c->fn->text(c, kCoordsys);
    if (!space || !*space) space = "object";
    const Primvar reference(*c, fixedInteger(*c, kUse) == 1 ? "__Pref" : nullptr);
    Value p, n;
    for (uint32_t k = 0; k < 3; ++k) {
      p.data[k] = c->P[k];
      n.data[k] = c->N[k];
    }
    p.stride = n.stride = 1;
    p.components = n.components = 3;
    toSpace<W>(*c, space, Moves::Point, p);
    toSpace<W>(*c, space, Moves::Normal, n);
    p = placesOr<W>(*c, reference, space, Moves::Point, p);
    MatrixValue matrix;
    c->fn->matrix(c, "render", space, &matrix);
    const Value angle = c->param(kAngle), scaleS = c->param(kScaleS), scaleT = c->param(kScaleT),
                offsetS = c->param(kOffsetS), offsetT = c->param(kOffsetT), falloff = c->param(kFrontFalloff),
                nearest = c->param(kNearClipPlane), farthest = c->param(kFarClipPlane);
    const int projection = fixedInteger(*c, kProjection);
    const Film film(*c);
    const bool frontOnly = fixedInteger(*c, kFrontOnly) != 0, cut = fixedInteger(*c, kClampTo) != 0,
               flip = fixedInteger(*c, kInvertT) != 0;
    Manifold& m = args->manifolds[0];
    m.dimensions = 2;
    float *st[3], *radius[3], *mask[3];
    makeOutput(*c, m.q, 2, false, st);
    makeOutput(*c, m.radius, 1, false, radius);
    makeOutput(*c, args->outputs[3], 1, false, mask);
    for (uint32_t i = 0; i < c->padded; i += W) {
      const At at{i, false};
      const F zero(0.f), one(1.f), half(0.5f);
      const Vec3<W> place = loadVec<W>(p, at);
      Vec3<W> normal = loadVec<W>(n, at);
      normal = normal * (one / max(length(normal), F(1e-20f)));
      const Seen<W> seen = project<W>(projection, film, place, normal);
      // the longest image of a unit of length
      const auto axis = [&](float x, float y, float z) {
        return length(moveBy<W>(matrix, Moves::Vector, Vec3<W>(F(x), F(y), F(z)), at));
      };
      const F scale = max(axis(1, 0, 0), max(axis(0, 1, 0), axis(0, 0, 1)));
      F sine, cosine;
      sincos(loadFloat<W>(angle, at) * F(kPi / 180.f), sine, cosine);
      const F a = seen.s - half, b = seen.t - half, fs = loadFloat<W>(scaleS, at), ft = loadFloat<W>(scaleT, at);
      const F s = fma(fms(a, cosine, b * sine), fs, half) + loadFloat<W>(offsetS, at);
      const F t = fma(fma(a, sine, b * cosine), ft, half) + loadFloat<W>(offsetT, at);
      s.store(st[0] + i);
      (flip ? one - t : t).store(st[1] + i);
      (F::load(c->radius + i) * scale * seen.grow * max(abs(fs), abs(ft))).store(radius[0] + i);
      Mask<W> inside = seen.inside;
      if (projection == 1)
        inside = inside & (-place.z >= loadFloat<W>(nearest, at)) & (-place.z <= loadFloat<W>(farthest, at));
      if (cut) inside = inside & (s >= zero) & (s <= one) & (t >= zero) & (t <= one);
      if (frontOnly) inside = inside & (seen.facing > zero);
      const F power = loadFloat<W>(falloff, at), faced = clamp(abs(seen.facing), F(1e-6f), one);
      select(inside, select(power > zero, pow(faced, power), one), zero).store(mask[0] + i);
    }
    args->outputs[0] = m.q;
    shareComponent(m.q, 0, args->outputs[1]);
    shareComponent(m.q, 1, args->outputs[2]);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrProjector, .help = "Texture coordinates by projection from a coordinate system.", .params = kParams)
