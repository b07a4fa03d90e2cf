// PxrCurvature: how far the surface bends around a point, found by rays: behind the surface they come out near convex
// edges, before it they meet what is near in concave ones. A hit at distance t of a ray of length m counts as
// max(0, 1 - (t / m) (1 - b) / b) for a bias b: linearly less with the distance, at .5 down to nothing at m, at 1 not
// less at all. The renderer that the parameters are known from publishes them, not what it computes.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrCurvature/PxrCurvature.cpp"
#include "plugins/pattern/probes/side_rays.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kNumSamples,
  kMaxDistance,
  kTraceSet,
  kDistribution,
  kCosineSpread,
  kBias,
  kConvexThreshold,
  kConcaveThreshold,
  kOutputGain,
  kOutputType,
  kMonochrome,
  kClampOutput
};
enum Distribution : int { kUniform, kCosine };
enum OutputType : int { kConcave, kConvex, kBoth };
constexpr Param kParams[] = {
    param::integer("numSamples", 4).range(1, 64).help("Rays from each point to each side that outputType asks for."),
    param::number("maxDistance", 0.1f)
        .range(0, 100)
        .help("Length of the rays, scene units; 0: any. What is thinner than that counts as convex."),
    param::string("traceSet", "")
        .traceSet()
        .help("Groups of objects (grouping:membership), apart by spaces, that rays meet; empty: all that reflections "
              "of the object see."),
    param::integer("distribution", 0)
        .options("0 uniform, 1 cosine")
        .help("Of rays over the hemisphere about the normal: evenly, or by the cosine."),
    param::number("cosineSpread", 1.f)
        .range(0, 10)
        .help("With distribution 1: rays are spread by the cosine to the power 1 / cosineSpread; smaller is "
              "narrower, and the effect keeps closer to edges."),
    param::number("bias", 0.5f)
        .help("How much hits count that are not close: 1 all alike, .5 linearly less down to nothing at maxDistance, "
              "smaller down to nothing before it. Without a maxDistance all count alike."),
    param::number("convexThreshold", 0.f).help("Convex curvature that is not above this counts as 0."),
    param::number("concaveThreshold", 0.f).help("Concave curvature that is not above this counts as 0."),
    param::number("outputGain", 1.f).range(0, 2).help("All outputs are multiplied by it."),
    param::integer("outputType", 2)
        .range(0, 2)
        .options("0 concave, 1 convex, 2 both")
        .help("What resultRGB and resultF tell; both: the sum."),
    param::flag("monochrome", true)
        .help("1: resultRGB is grey; 0: red where the surface is convex, green where it is concave."),
    param::flag("clampOutput", true).help("1: no output is above 1."),
    KINORA_COLOR_OUTPUTS,
    param::output(Type::Float, "resultF"),
    param::output(Type::Float, "resultConvex"),
    param::output(Type::Float, "resultConcave"),
};

struct PxrCurvature {
  // The mean over the rays to a side: 0 at the threshold and below it, times the gain.
  template <int W>
  static void measure(const Context& c, SideRays<W>& rays, ProbeSide side, float* out) {
    using F = Float<W>;
    const uint32_t n = c.padded;
    const Value spread = c.param(kCosineSpread), farthest = c.param(kMaxDistance), bias = c.param(kBias);
    const Value threshold = c.param(side == ProbeSide::Behind ? kConvexThreshold : kConcaveThreshold);
    const Value gain = c.param(kOutputGain);
    const ProbeSpread how = spreadBy(fixedInteger(c, kDistribution) == kUniform, spread);
    for (uint32_t i = 0; i < n; ++i) out[i] = 0;
    const uint32_t traced = rays.add(
        side,
        [&](uint32_t part, At at) {
          const F power = F(1.f) / max(loadFloat<W>(spread, at), F(1e-4f));
          const F sign(signOf(side));
          return turnTo(drawAboutZ<W>(c, part, rays.parts(), side, how, power, at),
                        Vec3<W>::load(c.N, at.first) * sign, Vec3<W>::load(c.Ng, at.first) * sign);
        },
        [&](F distance, At at) {
          const F length = loadFloat<W>(farthest, at), b = min(max(loadFloat<W>(bias, at), F(1e-6f)), F(1.f));
          const Mask<W> ends = length > F(0.f);
          const F less = distance / select(ends, length, F(1.f)) * ((F(1.f) - b) / b);
          return select(ends, max(F(1.f) - less, F(0.f)), F(1.f));
        },
        out);
    const F scale(traced ? 1.f / float(traced) : 0.f);
    for (uint32_t i = 0; i < n; i += W) {
      const At at{i, false};
      const F mean = F::load(out + i) * scale;
      select(mean > loadFloat<W>(threshold, at), mean * max(loadFloat<W>(gain, at), F(0.f)), F(0.f)).store(out + i);
    }
  }

  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const uint32_t n = c->padded;
    const int type = fixedInteger(*c, kOutputType);
    const F most(fixedInteger(*c, kClampOutput) ? 1.f : 3.4e38f);
    const bool isGrey = fixedInteger(*c, kMonochrome);
    SideRays<W> rays(*c, raysAsked(fixedInteger(*c, kNumSamples)), c->param(kMaxDistance), c->fn->text(c, kTraceSet));
    float *rgb[3], *sum[3], *convex[3], *concave[3];
    makeOutput(*c, args->outputs[0], 3, rgb);
    makeOutput(*c, args->outputs[4], 1, sum);
    makeOutput(*c, args->outputs[5], 1, convex);
    makeOutput(*c, args->outputs[6], 1, concave);
    for (uint32_t i = 0; i < n; ++i) convex[0][i] = concave[0][i] = 0;
    if (type != kConcave) measure<W>(*c, rays, ProbeSide::Behind, convex[0]);
    if (type != kConvex) measure<W>(*c, rays, ProbeSide::Seen, concave[0]);
    for (uint32_t i = 0; i < n; i += W) {
      const F out = F::load(convex[0] + i), in = F::load(concave[0] + i);
      const F all = min(out + in, most);
      min(out, most).store(convex[0] + i);
      min(in, most).store(concave[0] + i);
      all.store(sum[0] + i);
      const Rgb<W> color = isGrey ? Rgb<W>(all, all, all) : Rgb<W>(min(out, most), min(in, most), F(0.f));
      color.store(rgb, i);
    }
    shareComponents(*args, 0);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrCurvature, .help = "How far the surface bends: bright along edges, in creases, or both.",
               .params = kParams)
