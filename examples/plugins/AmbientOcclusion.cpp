// AmbientOcclusion: an example integrator. At each camera hit one ray is sent into the hemisphere about the normal;
// what arrives within maxDistance darkens the pixel. Lights play no part.
//
// It shows the calls every integrator makes: trace the group's rays, shade the hits (which gives contexts with
// positions and normals), send shadow rays, contribute. A group belongs to one thread; memory comes from its arena.
#define KINORA_KERNEL_FILE "AmbientOcclusion.cpp"
#include <limits>
#include <kinora/integrator_author.h>

#if KINORA_PLAIN
namespace kinora::ambientOcclusion {
enum : uint32_t { kMaxDistance };
constexpr Param kParams[] = {
    param::number("maxDistance", 0.f).range(0, 10).help("How far surfaces occlude, scene units; 0: any distance."),
};
struct Data {
  float maxDistance;
  explicit Data(const CreateInfo& info) : maxDistance(info.number(kMaxDistance)) {}
};
}  // namespace kinora::ambientOcclusion
#endif

KINORA_KERNELS_BEGIN
using namespace ambientOcclusion;

struct AmbientOcclusion {
  using Data = ambientOcclusion::Data;
  // One shadow ray for each point of a context, appended at `first`.
  template <int W>
  static void makeRays(const Services& services, const Context& c, uint32_t first, float* const o[3],
                       float* const d[3]) {
    for (uint32_t i = 0; i < c.count; i += W) {
      Float<W> u, v;
      draw2<W>(services.samples, Int<W>::load(c.sampleSeed + i), Int<W>::load(c.sampleIndex + i),
               dimensionAt(0) + kDimUser, u, v);
      const Vec3<W> N = Vec3<W>::load(c.N, i), Ng = Vec3<W>::load(c.Ng, i);
      const Vec3<W> wi = Frame<W>(N).toWorld(cosineHemisphere(u, v));
      wi.store(d, first + i);
      // start off the surface, so that it does not occlude itself
      fma(Ng, Float<W>::load(c.bias + i), Vec3<W>::load(c.P, i)).store(o, first + i);
    }
  }

  template <int W>
  static void integrate(const Data& k, uint32_t, Group& group, const Services& services) {
    Group* const g = &group;
    const float farthest = k.maxDistance;
    const auto floats = [&](uint32_t n) { return static_cast<float*>(services.alloc(g, n * sizeof(float))); };
    const auto words = [&](uint32_t n) { return static_cast<uint32_t*>(services.alloc(g, n * sizeof(uint32_t))); };

    uint32_t* slots = words(g->padded);
    for (uint32_t i = 0; i < g->count; ++i) slots[i] = i;
    float* through[3] = {floats(g->padded), floats(g->padded), floats(g->padded)};
    services.trace(g, &g->paths, RayKind::Camera, 0, g->count, slots, through);

    uint32_t hits = 0;
    float* alpha = floats(g->padded);
    for (uint32_t i = 0; i < g->count; ++i)
      if (g->paths.hits.t[i] < std::numeric_limits<float>::infinity()) {
        alpha[hits] = 1;
        slots[hits++] = i;
      }
    services.cover(g, hits, slots, alpha);
    Context* const* contexts = nullptr;
    const uint32_t contextCount =
        services.shade(g, &g->paths, kTraitEyePath | kTraitPrimaryHit, 0, hits, slots, &contexts);

    // contexts are padded each, so that rays of several need room for the padding of all
    const uint32_t room = padded(hits) + contextCount * kPad;
    float* o[3] = {floats(room), floats(room), floats(room)};
    float* d[3] = {floats(room), floats(room), floats(room)};
    float* light[3] = {floats(room), floats(room), floats(room)};
    float *tMax = floats(room), *time = floats(room);
    uint32_t *slot = words(room), *emitter = words(room);
    uint32_t* state = static_cast<uint32_t*>(services.alloc(g, room * sizeof(uint32_t)));
    ShadowRun* runs = static_cast<ShadowRun*>(services.alloc(g, contextCount * sizeof(ShadowRun)));
    uint32_t n = 0;
    for (uint32_t x = 0; x < contextCount; ++x) {
      const Context& c = *contexts[x];
      makeRays<W>(services, c, n, o, d);
      for (uint32_t i = 0; i < c.count; ++i, ++n) {
        slot[n] = c.path[i];
        time[n] = c.time[i];
        tMax[n] = farthest > 0 ? farthest : std::numeric_limits<float>::infinity();
        emitter[n] = kNoLight;  // to the picture this is light given off by the surface that was hit
        state[n] = services.paths.start;
      }
      runs[x] = {&c, nullptr, n};  // one ray for each of its points, in order
    }
    ShadowRays rays{n, {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, tMax, time, nullptr, contextCount, runs, nullptr, {}};
    for (int x = 0; x < 3; ++x) rays.transmittance[x] = light[x];
    rays.tinted = nullptr;  // a 1 for a ray would let it go through glass in a straight line
    services.shadow(g, 0, &rays);
    const Contributions value{n, slot, {light[0], light[1], light[2]}, state, emitter};
    services.contribute(g, &value);
  }
};
KINORA_KERNELS_END

KINORA_INTEGRATOR(AmbientOcclusion, .help = "How open to the sky each visible point is.", .params = kParams,
                  .setUp = setUp<Data>)
