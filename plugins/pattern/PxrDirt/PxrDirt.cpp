// PxrDirt: how much of what lies around a point is closed by surfaces, as a mix of two colours. Each ray that meets
// something at distance t counts as closed by exp(-falloff t).
#define KINORA_KERNEL_FILE "plugins/pattern/PxrDirt/PxrDirt.cpp"
#include "plugins/pattern/probes/side_rays.h"

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
    KINORA_COLOR_OUTPUTS,
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
    // Ray `part` of `parts` to a side, at W points.
    template <int W>
    KN_INLINE Vec3<W> direction(const Context& c, uint32_t part, uint32_t parts, ProbeSide side, At at) const {
      using F = Float<W>;
      const F sign(signOf(side));
      const Vec3<W> N = Vec3<W>::load(c.N, at.first), Ng = Vec3<W>::load(c.Ng, at.first) * sign;
      const Vec3<W> local = drawAboutZ<W>(c, part, parts, side, spreadBy(distribution == kUniform, spread),
                                          loadFloat<W>(spread, at), at);
      Vec3<W> axis = N * sign;
      if (distribution == kReflection) {
        const Vec3<W> wo = Vec3<W>::load(c.wo, at.first);
        axis = side == ProbeSide::Behind ? -wo : reflect(wo, N);
      }
      Vec3<W> b = loadVec<W>(bias, at);
      if (isPlaced) b = moveBy<W>(toRender, Moves::Vector, b, at);
      const Vec3<W> sum = axis + b;
      const F length2 = dot(sum, sum);
      const Mask<W> isAxis = (length2 > F(1e-8f)) & (length2 < F(1e30f));  // a bias may cancel it, or be no number
      axis = select(isAxis, sum * (F(1.f) / sqrt(select(isAxis, length2, F(1.f)))), axis);
      return turnTo(local, axis, Ng);
    }
  };

  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const uint32_t n = c->padded;
    const Value falloff = c->param(kFalloff);
    const int direction = fixedInteger(*c, kDirection);
    const Rays rays(*c);
    SideRays<W> sent(*c, raysAsked(fixedInteger(*c, kNumSamples)), c->param(kMaxDistance), c->fn->text(c, kTraceSet));
    float* closed = c->alloc<float>(n);
    for (uint32_t i = 0; i < n; ++i) closed[i] = 0;
    uint32_t traced = 0;
    for (const ProbeSide side : {ProbeSide::Seen, ProbeSide::Behind}) {
      if (direction == (side == ProbeSide::Seen ? kInside : kOutside)) continue;
      traced += sent.add(
          side, [&](uint32_t part, At at) { return rays.direction<W>(*c, part, sent.parts(), side, at); },
          [&](F distance, At at) { return exp(-max(loadFloat<W>(falloff, at), F(0.f)) * distance); }, closed);
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
