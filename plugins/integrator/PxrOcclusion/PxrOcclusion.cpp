// PxrOcclusion: how open each visible point is: the share of directions, spread as `distribution` says, in which
// nothing is met. Lights play no part. A direction that meets something at distance t is closed by exp(-falloff t).
#define KINORA_KERNEL_FILE "plugins/integrator/PxrOcclusion/PxrOcclusion.cpp"
#include <limits>
#include <kinora/integrator_author.h>
#include <kinora/camera_hits.h>
#include <kinora/path_loop.h>

#if KINORA_PLAIN
namespace kinora::pxrOcclusion {
enum : uint32_t { kNumSamples, kDistribution, kCosineSpread, kFalloff, kMaxDistance, kUseAlbedo };
enum Distribution : int { kUniform, kCosine, kReflection };
constexpr Param kParams[] = {
    param::integer("numSamples", 4).range(1, 64).help("Directions from each camera hit."),
    param::integer("distribution", 1)
        .range(0, 2)
        .options("0 uniform, 1 cosine, 2 reflection")
        .help("Over the hemisphere about the normal, evenly or by the cosine; or as the material samples."),
    param::number("cosineSpread", 1.f).range(0, 20).help("Exponent of the cosine in distribution 1."),
    param::number("falloff", 0.f)
        .range(0, 10)
        .help("What is met at distance t closes a direction by exp(-falloff t); 0: wholly, at any distance."),
    param::number("maxDistance", 0.f).range(0, 100).help("Farthest that surfaces occlude, scene units; 0: any."),
    param::onOff("useAlbedo", false).help("Multiply by the material's albedo."),
};
struct Data {
  uint32_t samples = 4;
  int distribution = kCosine;
  float spread = 1, falloff = 0, farthest = 0;
  bool useAlbedo = false;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const int samples = info.integer(kNumSamples);
  const auto positive = [](float x) { return x > 0 && x < 1e30f ? x : 0.f; };
  return std::make_unique<Data>(Data{uint32_t(samples < 1      ? 1
                                              : samples > 4096 ? 4096
                                                               : samples),
                                     info.integer(kDistribution), positive(info.number(kCosineSpread)),
                                     positive(info.number(kFalloff)), positive(info.number(kMaxDistance)),
                                     info.integer(kUseAlbedo) != 0});
}
}  // namespace kinora::pxrOcclusion
#endif

KINORA_KERNELS_BEGIN
using namespace pxrOcclusion;

struct PxrOcclusion {
  using Data = pxrOcclusion::Data;
  // Direction `part` for each point of a context; points without one keep their normal and ok 0.
  template <int W>
  static void directions(const Data& k, const CameraHits& hits, const Context& c, uint32_t part, float* const wi[3],
                         uint32_t* ok) {
    using F = Float<W>;
    float* u[4];
    hits.bxdfNumbers<W>(c, part, k.samples, u);
    for (uint32_t i = 0; i < c.padded; ++i) ok[i] = 1;
    if (k.distribution == kReflection) {
      GenerateArgs g{};
      for (int x = 0; x < 4; ++x) g.u[x] = u[x];
      for (int x = 0; x < 3; ++x) {
        g.wi[x] = wi[x];
        g.weight[x] = hits.floats(c.padded);
      }
      g.pdf = hits.floats(c.padded);
      g.slot = hits.words(c.padded);
      g.flags = hits.words(c.padded);
      c.bxdf->generate(&c, c.closure, &g);
      for (uint32_t i = 0; i < c.padded; ++i) ok[i] = g.slot[i] != kNoLobe && g.pdf[i] > 0;
      return;
    }
    for (uint32_t i = 0; i < c.padded; i += W) {
      const F a = F::load(u[0] + i), b = F::load(u[1] + i);
      Vec3<W> local;
      if (k.distribution == kUniform) {
        local = uniformCone(a, b, F(1.f));
      } else {
        local = cosineHemisphere(a, b);
        if (k.spread != 1) local = bendToPower(local, F(k.spread));
      }
      Frame<W>(Vec3<W>::load(c.N, i)).toWorld(local).store(wi, i);
    }
  }

  template <int W>
  static void integrate(const Data& k, uint32_t, Group& group, const Services& services) {
    Group* g = &group;
    const Services* sv = &services;
    const CameraHits hits(g, sv);
    if (!hits.count) return;
    float* open = hits.floats(g->padded + kPad);
    float* wi[3];
    float* through[3];
    for (int x = 0; x < 3; ++x) {
      wi[x] = hits.floats(g->padded + kPad);
      through[x] = hits.floats(g->padded + kPad);
    }
    uint32_t* ok = hits.words(g->padded + kPad);
    uint32_t* live = hits.words(g->padded + kPad);
    uint32_t* leaving = hits.words(g->padded + kPad);
    for (uint32_t i = 0; i < g->padded; ++i) open[i] = 0;
    const float infinity = std::numeric_limits<float>::infinity();
    for (uint32_t part = 0; part < k.samples; ++part) {
      // one ray a slot at a time: all contexts' rays are traced together
      uint32_t n = 0;
      for (uint32_t x = 0; x < hits.contextCount; ++x) {
        const Context& c = *hits.contexts[x];
        directions<W>(k, hits, c, part, wi, ok);
        uint32_t left = 0;
        for (uint32_t i = 0; i < c.count; ++i) {
          const uint32_t s = c.path[i];
          if (!ok[i]) {
            open[s] += 1;  // the material sends nothing there: nothing is closed
            continue;
          }
          const float side = wi[0][i] * c.Ng[0][i] + wi[1][i] * c.Ng[1][i] + wi[2][i] * c.Ng[2][i];
          // below the true surface although above the shading one: met at once
          if (side <= 0 && k.distribution != kReflection) continue;
          const float off = side < 0 ? -c.bias[i] : c.bias[i];
          for (int a = 0; a < 3; ++a) {
            g->paths.rays.o[a][s] = c.P[a][i] + off * c.Ng[a][i];
            g->paths.rays.d[a][s] = wi[a][i];
          }
          g->paths.rays.tMax[s] = k.farthest > 0 ? k.farthest : infinity;
          live[n++] = s;
          leaving[left++] = i;
        }
        if (left) sv->leave(g, &g->paths, &c, left, leaving, nullptr, nullptr);
      }
      for (uint32_t i = n; n && i < padded(n); ++i) live[i] = live[n - 1];
      if (n) sv->trace(g, &g->paths, RayKind::Indirect, 1 + part, n, live, through);
      for (uint32_t i = 0; i < n; ++i) {
        const uint32_t s = live[i];
        const float t = g->paths.hits.t[s];
        if (!(t < 3e38f))
          open[s] += 1;
        else if (k.falloff > 0)
          open[s] += 1.f - exp(Float<1>(-k.falloff * t)).lane0();
      }
    }
    const float scale = 1.f / float(k.samples);
    hits.showAll([&](const Context& c, float* const rgb[3]) {
      for (uint32_t i = 0; i < c.padded; ++i)
        rgb[0][i] = rgb[1][i] = rgb[2][i] = open[c.path[i < c.count ? i : c.count - 1]] * scale;
      if (!k.useAlbedo || !c.bxdf->albedo) return;
      float* albedo[3] = {hits.floats(c.padded), hits.floats(c.padded), hits.floats(c.padded)};
      c.bxdf->albedo(&c, c.closure, albedo);
      for (int a = 0; a < 3; ++a)
        for (uint32_t i = 0; i < c.padded; ++i) rgb[a][i] *= albedo[a][i];
    });
  }
};

KINORA_KERNELS_END

KINORA_INTEGRATOR(PxrOcclusion, .help = "How open each visible point is to its surroundings; lights play no part.",
                  .params = kParams, .setUp = setUpBy<make>)
