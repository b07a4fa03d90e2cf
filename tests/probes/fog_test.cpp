// A scattering event in homogeneous fog: an integrator samples a free flight before the surface hit and scatters
// once, isotropically, taking light samples at points that lie on no surface. Transmittance and single scattering in
// a slab have closed forms. It misses media bounded by surfaces, coloured extinction and phase functions: they come
// with volumes.
#define KINORA_KERNEL_FILE "tests/probes/fog_test.cpp"
#include <kinora/bxdf.h>
#include <iterator>
#include <new>
#include "tests/probes/probe_support.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/integrator.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>
#include <kinora/simd/tables.h>

#ifndef KINORA_FOG_ONCE
#define KINORA_FOG_ONCE
namespace kinora::fog {
enum : uint32_t { kExtinction, kAlbedo, kNear, kFar };
constexpr Param kParams[] = {
    param::number("extinction", 1.f).range(0, 10).help("Per unit of distance."),
    param::number("albedo", 0.5f).range(0, 1).help("Fraction of the extinction that scatters."),
    param::number("near", 1.f).range(0, 10).help("z at which the slab of fog begins."),
    param::number("far", 2.f).range(0, 10).help("z at which it ends."),
};
struct Data {
  float extinction, albedo, z[2];
};
}  // namespace kinora::fog
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using namespace fog;

// Where rays are inside the slab: from t0 to t1, empty where t1 <= t0.
template <int W>
KN_INLINE void insideSlab(const Data& k, Float<W> oz, Float<W> dz, Float<W>& t0, Float<W>& t1) {
  using F = Float<W>;
  const Mask<W> flat = abs(dz) < F(1e-9f);
  const F inv = F(1.f) / select(flat, F(1e-9f), dz);
  const F a = (F(k.z[0]) - oz) * inv, b = (F(k.z[1]) - oz) * inv;
  t0 = max(min(a, b), F(0.f));
  t1 = max(a, b);
}

struct Fog {
  template <int W>
  static void integrate(const void* integrator, uint32_t, Group* g, const Services* sv) {
    using F = Float<W>;
    const Data& k = *static_cast<const Data*>(integrator);
    const auto floats = [&](uint32_t n) { return static_cast<float*>(sv->alloc(g, n * sizeof(float))); };
    const auto words = [&](uint32_t n) { return static_cast<uint32_t*>(sv->alloc(g, n * sizeof(uint32_t))); };
    const auto states = [&](uint32_t n) { return static_cast<uint32_t*>(sv->alloc(g, n * sizeof(uint32_t))); };
    const uint32_t room = g->padded + kPad;
    uint32_t* all = words(room);
    for (uint32_t i = 0; i < g->count; ++i) all[i] = i;
    sv->trace(g, &g->paths, RayKind::Camera, 0, g->count, all, nullptr);

    // free flights
    float *flight = floats(room), *end = floats(room);
    for (uint32_t i = 0; i < g->padded; i += W) {
      F u, v, t0, t1;
      draw2<W>(sv->samples, Int<W>::load(g->paths.sampleSeed + i), Int<W>::load(g->paths.sampleIndex + i),
               dimensionAt(0) + kDimUser, u, v);
      insideSlab<W>(k, F::load(g->paths.rays.o[2] + i), F::load(g->paths.rays.d[2] + i), t0, t1);
      (t0 - log(F(1.f) - u) / F(k.extinction)).store(flight + i);
      min(t1, F::load(g->paths.hits.t + i)).store(end + i);
    }
    uint32_t *in = words(room), *on = words(room), inside = 0, hits = 0;
    for (uint32_t i = 0; i < g->count; ++i) {
      if (flight[i] < end[i])
        in[inside++] = i;
      else if (g->paths.hits.t[i] < 3e38f)
        on[hits++] = i;
    }

    // what came through: the wall's own light
    Context* const* contexts = nullptr;
    const uint32_t count = sv->shade(g, &g->paths, kTraitEyePath | kTraitPrimaryHit, 0, hits, on, &contexts);
    for (uint32_t c = 0; c < count; ++c) {
      const Context& x = *contexts[c];
      if (!x.bxdf->emission) continue;
      float* e[3];
      for (float*& y : e) y = floats(x.padded);
      x.bxdf->emission(&x, x.closure, e);
      uint32_t* light = words(x.padded);
      uint32_t* state = states(x.padded);
      for (uint32_t i = 0; i < x.count; ++i) {
        light[i] = kNoLight;
        state[i] = sv->paths.start;
      }
      const Contributions out{x.count, x.path, {e[0], e[1], e[2]}, state, light};
      sv->contribute(g, &out);
    }

    // scattering: one light sample at each point
    if (!inside || !sv->lightCount) return;
    const Context& p = *sv->pointsInSpace(g, &g->paths, kTraitEyePath, 0, inside, in, flight);
    LightSamples ls;
    sv->lightSamples(g, &p, 0, 1, &ls);
    float *tMax = floats(p.padded), *value[3], *T[3];
    for (int c = 0; c < 3; ++c) {
      value[c] = floats(p.padded);
      T[c] = floats(p.padded);
    }
    uint32_t* state = states(p.padded);
    const uint16_t event = sv->event(g, kLobeReflect, kLobeDiffuse);
    for (uint32_t i = 0; i < p.padded; i += W) {
      F t0, t1;
      insideSlab<W>(k, F::load(p.P[2] + i), F::load(ls.wi[2] + i), t0, t1);
      const F length = max(min(t1, F::load(ls.distance + i)) - t0, F(0.f)), pdf = F::load(ls.pdf + i);
      const F weight =
          zeroUnless(pdf > F(0.f), F(k.albedo * kInvFourPi) * exp(-(length * F(k.extinction))) / max(pdf, F(1e-30f)));
      (Vec3<W>::load(ls.radiance, i) * weight).store(value, i);
      F::load(ls.distance + i).store(tMax + i);
    }
    const ShadowRun run{&p, nullptr, inside};
    const ShadowRays rays{
        inside,  {p.P[0], p.P[1], p.P[2]}, {ls.wi[0], ls.wi[1], ls.wi[2]}, tMax, p.time, nullptr, 1, &run,
        nullptr, {T[0], T[1], T[2]}};
    sv->shadow(g, 0, &rays);
    for (uint32_t i = 0; i < inside; ++i) {
      for (int c = 0; c < 3; ++c) value[c][i] *= T[c][i];
      state[i] = sv->paths.next[sv->paths.start * sv->paths.eventCount + event];
    }
    const Contributions out{inside, p.path, {value[0], value[1], value[2]}, state, ls.light};
    sv->contribute(g, &out);
  }
  template <int W>
  static constexpr IntegratorFunctions table() {
    return IntegratorFunctions{&integrate<W>};
  }
};
KINORA_WIDTH_TABLES(Fog, IntegratorFunctions)

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::probes {
namespace {

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&] {
    return new fog::Data{info->number(fog::kExtinction),
                         info->number(fog::kAlbedo),
                         {info->number(fog::kNear), info->number(fog::kFar)}};
  });
}
void destroy(void* p) { delete static_cast<fog::Data*>(p); }
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kFog{
    kAbiVersion,  sizeof(Descriptor),      Kind::Integrator, 0, "ProbeFog", "One scattering event in a slab of fog.",
    fog::kParams, std::size(fog::kParams), kTables,          4, nullptr,    &create,
    &destroy};

constexpr double kPi64 = 3.14159265358979323846;
constexpr int kSide = 32;

struct Measured {
  testing::Moments wall, scattered;
};

// A camera looks along +z through a slab from z = 1 to `end` at a glowing wall at z = 4; the sun stands behind the
// camera, `degrees` off its axis.
Measured render(double extinction, double albedo, double end, double degrees, uint32_t width) {
  Measured m;
  Workshop stage{&kFog};
  const std::string text = R"(
Hider "raytrace" "int maxsamples" [16]
Display "probe.exr" "openexr" "Ci,emissive,directDiffuse"
DisplayChannel "color emissive"
DisplayChannel "color directDiffuse"
Format 32 32 1
PixelFilter "box" 1 1
Projection "orthographic"
WorldBegin
  AttributeBegin
    Rotate )" + std::to_string(degrees) +
                           R"( 1 0 0
    Light "PxrDistantLight" "sun" "float intensity" [3] "float angleExtent" [0]
  AttributeEnd
  Bxdf "PxrConstant" "glow" "color emitColor" [0.8 0.8 0.8]
  Polygon "vertex point P" [-9 -9 4  9 -9 4  9 9 4  -9 9 4]
WorldEnd
)";
  for (uint32_t seed = 0; seed < 12; ++seed) {
    render::Settings s;
    s.threads = 1;
    s.seed = seed;
    s.width = width;
    s.integrator = "ProbeFog";
    s.sets = {{"integrator.extinction", std::to_string(extinction)},
              {"integrator.albedo", std::to_string(albedo)},
              {"integrator.near", "1"},
              {"integrator.far", std::to_string(end)}};
    const auto r = stage.load(sceneOf(text, stage.messages), s);
    const auto mean = [&](const image::Image& img) {
      double sum = 0;
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) sum += img.at(x, y)[0];
      return sum / (kSide * kSide);
    };
    m.wall.add(mean(pictureOf(*r, "emissive")));
    m.scattered.add(mean(r->film().resolve(r->film().layout().find("directDiffuse"))));
  }
  return m;
}

void check(double extinction, double albedo, double end, double degrees) {
  const double depth = extinction * (end - 1), mu = std::cos(degrees * kPi64 / 180), k = 1 + 1 / mu;
  const double wall = 0.8 * std::exp(-depth);
  // in along the sun's ray, out along the camera's: the integral over the slab of albedo * extinction * E / 4 pi
  const double scattered = albedo * 3 / (4 * kPi64) * (1 - std::exp(-depth * k)) / k;
  const Measured m = render(extinction, albedo, end, degrees, 8);
  // 12 renders: 6 standard errors of a t distribution with 11 degrees of freedom are a chance of 1e-4
  EXPECT_NEAR(m.wall.mean(), wall, 6 * m.wall.standardError() + 1e-6);
  EXPECT_NEAR(m.scattered.mean(), scattered, 6 * m.scattered.standardError() + 1e-6);
  EXPECT_LT(m.wall.standardError(), 0.005 * wall);
  EXPECT_LT(m.scattered.standardError(), 0.005 * scattered);
}

TEST(Fog, ThinSlabUnderSlantedSun) { check(0.5, 0.9, 2, 50); }
TEST(Fog, DenseSlabUnderSunBehindTheCamera) { check(1.3, 0.6, 3, 0); }

TEST(Fog, EveryWidthGivesTheSameBits) {
  const Measured a = render(0.7, 0.8, 2.5, 30, 8), b = render(0.7, 0.8, 2.5, 30, 1);
  EXPECT_EQ(a.wall.mean(), b.wall.mean());
  EXPECT_EQ(a.scattered.mean(), b.scattered.mean());
}

}  // namespace
}  // namespace kinora::probes
#endif
