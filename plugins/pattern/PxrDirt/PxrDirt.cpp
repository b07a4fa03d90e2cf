// PxrDirt: how much of what lies around a point is closed by surfaces, as a mix of two colours. Each ray that meets
// something at distance t counts as closed by exp(-falloff t).
#define KINORA_KERNEL_FILE "plugins/pattern/PxrDirt/PxrDirt.cpp"
#include <limits>

#include <kinora/pattern_author.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kOccluded,
  kUnoccluded,
  kNumSamples,
  kDistribution,
  kCosineSpread,
  kFalloff,
  kMaxDistance,
  kDirection,
  kBiasDirection,
  kBiasDirectionCoordsys,
  kTraceSet
};
enum Distribution : int { kUniform, kCosine, kReflection };
enum Direction : int { kOutside, kInside, kBoth };
constexpr Param kParams[] = {
    param::color("occluded", 1.f).help("Where all rays meet something."),
    param::color("unoccluded", 0.f).help("Where none does."),
    param::integer("numSamples", 4).range(1, 64).help("Rays from each point; for direction 2 to each side."),
    param::integer("distribution", 1)
        .range(0, 2)
        .options("0 uniform, 1 cosine, 2 reflection")
        .help("Over the hemisphere about the normal, evenly or by the cosine; or by the cosine about the mirrored "
              "view."),
    param::number("cosineSpread", 1.f)
        .range(0, 100)
        .help("Exponent of the cosine in distributions 1 and 2; larger is narrower."),
    param::number("falloff", 0.f)
        .range(0, 10)
        .help("What is met at distance t counts as exp(-falloff t); 0: wholly, at any distance."),
    param::number("maxDistance", 0.f).range(0, 100).help("Length of the rays, scene units; 0: any."),
    param::integer("direction", 0)
        .range(0, 2)
        .options("0 outside, 1 inside, 2 both")
        .help("To the side that the point is seen from, to the other one, which finds edges and thin parts, or to "
              "both."),
    param::vector("biasDirection", 0, 0, 0)
        .help("Added to the unit normal about which rays are spread: (0 0 0) leaves it. What then goes below the "
              "surface is mirrored at it."),
    param::string("biasDirectionCoordsys", "").help("Coordinate system of biasDirection; empty: world."),
    param::string("traceSet", "")
        .traceSet()
        .help("Groups of objects (grouping:membership), apart by spaces, that rays meet; empty: all that reflections "
              "of the object see. Without rays (where the pattern decides whether a surface is there that another "
              "pattern's ray met) the result is unoccluded."),
    param::output(Type::Color, "resultRGB"),
    param::output(Type::Float, "resultR"),
    param::output(Type::Float, "resultG"),
    param::output(Type::Float, "resultB"),
};

struct PxrDirt {
  // What the directions of a context's rays are made of.
  struct Rays {
    int distribution;
    Value spread, bias;
    MatrixValue toRender;
    bool isPlaced = false;  // bias has a coordinate system of its own

    explicit Rays(const Context& c)
        : distribution(fixedInteger(c, kDistribution)),
          spread(c.param(kCosineSpread)),
          bias(c.param(kBiasDirection)) {
      const char* space = c.fn->text(&c, kBiasDirectionCoordsys);
      isPlaced = space && *space && c.fn->matrix(&c, space, "render", &toRender);
    }
    // Ray `part` of `parts` at W points, to the side of the normals (sign 1) or behind them (-1).
    template <int W>
    KN_INLINE Vec3<W> direction(const Context& c, uint32_t part, uint32_t parts, float sign, At at) const {
      using F = Float<W>;
      const uint32_t i = at.first;
      F u, v;
      draw2(*c.samples, Int<W>::load(c.sampleSeed + i),
            Int<W>::load(c.sampleIndex + i) * Int<W>(parts) + Int<W>(part),
            dimensionAt(c.depth) + kDimPattern + (sign < 0), u, v);
      Vec3<W> local;
      if (distribution == kUniform) {
        local = uniformCone(u, v, F(1.f));
      } else {
        local = cosineHemisphere(u, v);
        if (!spread.uniform() || spread.data[0][0] != 1.f)
          local = bendToPower(local, min(max(loadFloat<W>(spread, at), F(0.f)), F(1e4f)));
      }
      const Vec3<W> N = Vec3<W>::load(c.N, i), Ng = Vec3<W>::load(c.Ng, i) * F(sign);
      Vec3<W> axis = N * F(sign);
      if (distribution == kReflection) {
        const Vec3<W> wo = Vec3<W>::load(c.wo, i);
        axis = sign < 0 ? -wo : reflect(wo, N);
      }
      Vec3<W> b = loadVec<W>(bias, at);
      if (isPlaced) b = moveBy<W>(toRender, Moves::Vector, b, at);
      const Vec3<W> sum = axis + b;
      const F length2 = dot(sum, sum);
      const Mask<W> isAxis = (length2 > F(1e-8f)) & (length2 < F(1e30f));  // a bias may cancel it, or be no number
      axis = select(isAxis, sum * (F(1.f) / sqrt(select(isAxis, length2, F(1.f)))), axis);
      const Vec3<W> d = Frame<W>(axis).toWorld(local);
      const F height = dot(d, Ng);
      return select(height < F(0.f), fma(Ng, height * F(-2.f), d), d);
    }
  };

  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const uint32_t n = c->padded;
    const float infinity = std::numeric_limits<float>::infinity();
    const Value falloff = c->param(kFalloff), farthest = c->param(kMaxDistance);
    const int direction = fixedInteger(*c, kDirection), asked = fixedInteger(*c, kNumSamples);
    const uint32_t parts = asked < 1 ? 1u : asked > 1024 ? 1024u : uint32_t(asked);
    const Rays rays(*c);
    uint32_t *point = c->alloc<uint32_t>(n), *part = c->alloc<uint32_t>(n);
    float* d[3] = {c->alloc<float>(n), c->alloc<float>(n), c->alloc<float>(n)};
    float *reach = c->alloc<float>(n), *t = c->alloc<float>(n), *closed = c->alloc<float>(n);
    for (uint32_t i = 0; i < n; ++i) point[i] = i < c->count ? i : c->count - 1;
    for (uint32_t i = 0; i < n; i += W) {
      const F r = loadFloat<W>(farthest, At{i, false});
      select(r > F(0.f), r, F(infinity)).store(reach + i);
      F(0.f).store(closed + i);
    }
    ProbeRays probe{c->count, point, part, {d[0], d[1], d[2]}, reach, c->fn->text(c, kTraceSet), t};
    for (uint32_t k = 0; k < n; ++k) t[k] = infinity;
    uint32_t traced = 0;
    for (int side = 0; side < 2; ++side) {
      if (direction == (side == 0 ? kInside : kOutside)) continue;
      for (uint32_t k = 0; k < parts && c->samples; ++k) {
        for (uint32_t i = 0; i < n; ++i) part[i] = k + uint32_t(side) * parts;
        for (uint32_t i = 0; i < n; i += W)
          rays.direction<W>(*c, k, parts, side == 0 ? 1.f : -1.f, At{i, false}).store(d, i);
        if (!c->fn->probe(c, &probe)) break;
        ++traced;
        for (uint32_t i = 0; i < n; i += W) {
          const At at{i, false};
          const F distance = F::load(t + i);
          const Mask<W> met = distance < F(infinity);
          const F fall = max(loadFloat<W>(falloff, at), F(0.f));
          const F share = select(met, exp(-fall * select(met, distance, F(0.f))), F(0.f));
          (F::load(closed + i) + share).store(closed + i);
        }
      }
    }
    const float scale = traced ? 1.f / float(traced) : 0.f;
    const Value occluded = c->param(kOccluded), unoccluded = c->param(kUnoccluded);
    float* out[3];
    makeOutput(*c, args->outputs[0], 3, out);
    for (uint32_t i = 0; i < n; i += W) {
      const At at{i, false};
      const Rgb<W> a = loadRgb<W>(unoccluded, at), b = loadRgb<W>(occluded, at);
      const F share = F::load(closed + i) * F(scale);
      (a + (b - a) * share).store(out, i);
    }
    shareComponents(*args, 0);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrDirt, .help = "Mixes two colours by how much surfaces close off what lies around a point.",
               .params = kParams)
