// A light tracer as an integrator: paths start at the lights and are connected to the camera, and its picture is that
// of PxrPathTracer. It proves that stages, emitted rays, contexts that carry importance, the way back to the raster
// and splats are there and carry the right factors. It misses what only the camera can find: lights seen directly
// (invisible to the camera here) and mirrors seen by a pinhole.
#define KINORA_KERNEL_FILE "tests/probes/light_tracer_test.cpp"
#include <kinora/bxdf.h>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <map>
#include <new>
#include <string>
#include <vector>
#include "tests/probes/corner.h"
#include "tests/probes/probe_support.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/integrator.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>
#include <kinora/subpaths.h>
#include <kinora/simd/tables.h>

#ifndef KINORA_LIGHT_TRACER_ONCE
#define KINORA_LIGHT_TRACER_ONCE
namespace kinora::lightTracer {
enum : uint32_t { kBounces, kGain };
constexpr Param kParams[] = {
    param::integer("maxIndirectBounces", 3).range(0, 64).help("Bounces between the first surface and the one seen."),
    param::number("gain", 1.f).range(0, 2).help("Factor on all light: other than 1 it is a wrong integrator."),
};
struct Data {
  uint32_t bounces;
  float gain;
};
// Densities of points on lights, asked for and as they were told when the points were made.
struct EndCount {
  std::atomic<uint64_t> emitted, emittedOff, sampled, sampledOff;
};
inline EndCount ends;
}  // namespace kinora::lightTracer
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using namespace lightTracer;
using probes::Generated;

template <int W>
class LightPaths {
 public:
  LightPaths(Group* group, const Services* services, const Data& data) : g_(group), sv_(services), data_(data) {}

  void run() {
    const uint32_t room = g_->padded + kPad;
    float* medium[3];
    for (float*& x : medium) x = floats(room);
    events_ = static_cast<uint16_t*>(sv_->alloc(g_, room * (data_.bounces + 1) * sizeof(uint16_t)));
    room_ = room;
    uint32_t* live = words(room);
    sv_->emitLight(g_, g_->count, &emitted_);
    for (int c = 0; c < 3; ++c) throughput_[c] = emitted_.throughput[c];
    light_ = emitted_.light;
    uint32_t n = 0;
    for (uint32_t i = 0; i < g_->count; ++i) {
      for (int c = 0; c < 3; ++c) throughput_[c][i] *= data_.gain;
      if (throughput_[0][i] + throughput_[1][i] + throughput_[2][i] > 0) live[n++] = i;
    }
    for (uint32_t depth = 0; n; ++depth) {
      sv_->trace(g_, &g_->paths, RayKind::Indirect, depth, n, live, medium);
      uint32_t hits = 0;
      for (uint32_t i = 0; i < n; ++i)
        if (g_->paths.hits.t[live[i]] < 3e38f) live[hits++] = live[i];
      Context* const* contexts = nullptr;
      const uint32_t count = sv_->shade(g_, &g_->paths, kTraitLightPath, depth, hits, live, &contexts);
      for (uint32_t k = 0; k < count && !depth; ++k) compareEnds(*contexts[k]);
      for (uint32_t k = 0; k < count; ++k) connect(*contexts[k], depth);
      if (depth == data_.bounces) return;
      n = 0;
      for (uint32_t k = 0; k < count; ++k) n += scatterPaths(*contexts[k], depth, live + n);
    }
  }

 private:
  float* floats(uint32_t n) { return static_cast<float*>(sv_->alloc(g_, n * sizeof(float))); }
  uint32_t* words(uint32_t n) { return static_cast<uint32_t*>(sv_->alloc(g_, n * sizeof(uint32_t))); }

  static Vec3<W> start(const Context& c, uint32_t i, Vec3<W> wi) {
    return leave(Vec3<W>::load(c.P, i), Vec3<W>::load(c.Ng, i), Float<W>::load(c.bias + i), wi);
  }

  static bool isNear(float a, float b) { return std::fabs(a - b) <= 0.02f * std::max(std::fabs(a), std::fabs(b)); }

  // At the first vertices of light paths: of the way back to where each began, and of light samples.
  void compareEnds(const Context& c) {
    const ShadowRun run{&c, nullptr, c.count};
    LightEnds end{};
    end.count = c.count;
    end.runCount = 1;
    end.runs = &run;
    float* t = floats(c.padded);
    uint32_t* light = words(c.padded);
    for (uint32_t i = 0; i < c.count; ++i) {
      t[i] = g_->paths.hits.t[c.path[i]];
      light[i] = light_[c.path[i]];
    }
    for (int x = 0; x < 3; ++x) end.d[x] = c.wo[x];
    end.t = t;
    end.light = light;
    sv_->lightEnds(g_, &end);
    for (uint32_t i = 0; i < c.count; ++i) {
      const uint32_t s = c.path[i];
      float facing = 0;
      for (int x = 0; x < 3; ++x) facing += end.N[x][i] * emitted_.N[x][s];
      ends.emitted.fetch_add(1, std::memory_order_relaxed);
      if (!isNear(end.pdfPosition[i], emitted_.pdfPosition[s]) ||
          !isNear(end.pdfDirection[i], emitted_.pdfDirection[s]) || !(facing > 0.99f) ||
          end.flags[i] != emitted_.flags[s])
        ends.emittedOff.fetch_add(1, std::memory_order_relaxed);
    }
    LightSamples samples;
    sv_->lightSamples(g_, &c, 0, 1, &samples);
    for (int x = 0; x < 3; ++x) end.d[x] = samples.wi[x];
    end.t = samples.t;
    end.light = samples.light;
    sv_->lightEnds(g_, &end);
    for (uint32_t i = 0; i < c.count; ++i) {
      if (!(samples.pdf[i] > 0)) continue;
      ends.sampled.fetch_add(1, std::memory_order_relaxed);
      if (!isNear(end.pdf[i], samples.pdf[i]) || !(end.pdfPosition[i] > 0))
        ends.sampledOff.fetch_add(1, std::memory_order_relaxed);
    }
  }

  void connect(const Context& c, uint32_t depth) {
    CameraConnection camera;
    sv_->connectCamera(g_, &c, &camera);
    EvaluateArgs e{};
    for (int x = 0; x < 3; ++x) e.wi[x] = camera.wi[x];
    for (uint32_t l = 0; l < c.slotCount; ++l)
      for (int x = 0; x < 3; ++x) e.weight[l][x] = floats(c.padded);
    e.pdf = floats(c.padded);
    c.bxdf->evaluate(&c, c.closure, &e);
    float *o[3], *factor = floats(c.padded), *tMax = floats(c.padded);
    for (float*& x : o) x = floats(c.padded);
    for (uint32_t i = 0; i < c.padded; i += W) {
      const Vec3<W> wi = Vec3<W>::load(camera.wi, i);
      const Float<W> distance = Float<W>::load(camera.distance + i), bias = Float<W>::load(c.bias + i);
      (adjointFactor(c, i, wi) * Float<W>::load(camera.importance + i) / max(distance * distance, Float<W>(1e-20f)))
          .store(factor + i);
      start(c, i, wi).store(o, i);
      fma(distance, Float<W>(0.99999f), -(bias + bias)).store(tMax + i);
    }
    float* T[3];
    for (float*& x : T) x = floats(c.padded);
    const ShadowRun run{&c, nullptr, c.count};
    const ShadowRays rays{
        c.count, {o[0], o[1], o[2]}, {camera.wi[0], camera.wi[1], camera.wi[2]}, tMax, c.time, nullptr, 1, &run,
        nullptr, {T[0], T[1], T[2]}};
    sv_->shadow(g_, depth, &rays);
    const uint32_t room = c.padded * c.slotCount;
    float *raster[2] = {floats(room), floats(room)}, *value[3];
    for (float*& x : value) x = floats(room);
    uint32_t* state = words(room);
    uint32_t* light = words(room);
    uint32_t m = 0;
    for (uint32_t l = 0; l < c.slotCount; ++l) {
      // the vertex that the camera sees is the first of the path as expressions read it
      const auto step = [&](uint32_t s, uint16_t event) {
        return sv_->paths.next[s * sv_->paths.eventCount + event];
      };
      const uint32_t first = step(sv_->paths.start, c.eventOfSlot[l]);
      for (uint32_t i = 0; i < c.count; ++i) {
        if (!(camera.importance[i] > 0)) continue;
        for (int x = 0; x < 3; ++x) value[x][m] = throughput_[x][c.path[i]] * e.weight[l][x][i] * T[x][i] * factor[i];
        if (!(value[0][m] + value[1][m] + value[2][m] > 0)) continue;
        for (int x = 0; x < 2; ++x) raster[x][m] = camera.raster[x][i];
        uint32_t s = first;
        for (uint32_t d = depth; d-- > 0;) s = step(s, events_[d * room_ + c.path[i]]);
        light[m] = light_[c.path[i]];
        state[m++] = s;
      }
    }
    if (m) sv_->splat(g_, m, raster, value, state, light);
  }

  uint32_t scatterPaths(const Context& c, uint32_t depth, uint32_t* live) {
    const Generated made(g_, sv_, c);
    float *o[3], *factor = floats(c.padded);
    for (float*& x : o) x = floats(c.padded);
    for (uint32_t i = 0; i < c.padded; i += W) {
      const Int<W> seed = Int<W>::load(c.sampleSeed + i), sample = Int<W>::load(c.sampleIndex + i);
      Float<W> a, b;
      draw2(sv_->samples, seed, sample, dimensionAt(depth) + kDimBxdf, a, b);
      a.store(made.u[0] + i);
      b.store(made.u[1] + i);
      draw2(sv_->samples, seed, sample, dimensionAt(depth) + kDimLobe, a, b);
      a.store(made.u[2] + i);
      b.store(made.u[3] + i);
    }
    made.generate(c);
    for (uint32_t i = 0; i < c.padded; i += W) {
      const Vec3<W> w = Vec3<W>::load(made.wi, i);
      const Mask<W> discrete = (Int<W>::load(made.flags + i) & Int<W>(uint32_t(kSampleDiscrete))) != Int<W>(0);
      select(discrete, Float<W>(1.f), adjointFactor(c, i, w)).store(factor + i);
      start(c, i, w).store(o, i);
    }
    uint32_t m = 0;
    uint32_t *point = words(c.padded), *through = words(c.padded);
    for (uint32_t i = 0; i < c.count; ++i) {
      if (made.slot[i] == kNoLobe || !(made.pdf[i] > 0)) continue;
      through[m] = (made.flags[i] & kSampleTransmit) != 0;
      point[m] = i;
      const uint32_t s = c.path[i];
      for (int x = 0; x < 3; ++x) {
        throughput_[x][s] *= made.weight[x][i] * factor[i] / made.pdf[i];
        g_->paths.rays.o[x][s] = o[x][i];
        g_->paths.rays.d[x][s] = made.wi[x][i];
      }
      g_->paths.rays.tMax[s] = 1e30f;
      events_[depth * room_ + s] = c.eventOfSlot[made.slot[i]];
      live[m++] = s;
    }
    sv_->leave(g_, &g_->paths, &c, m, point, nullptr, through);
    return m;
  }

  Group* g_;
  const Services* sv_;
  const Data& data_;
  float* throughput_[3];
  uint32_t room_ = 0;
  EmittedLight emitted_;
  uint32_t* light_ = nullptr;   // by slot
  uint16_t* events_ = nullptr;  // by depth from the light, and slot
};

struct LightTracer {
  template <int W>
  static void integrate(const void* integrator, uint32_t stage, Group* group, const Services* services) {
    // stage 0 is the camera's: its samples stay black
    if (stage == 1) LightPaths<W>(group, services, *static_cast<const Data*>(integrator)).run();
  }
  template <int W>
  static constexpr IntegratorFunctions table() {
    return IntegratorFunctions{&integrate<W>};
  }
};
KINORA_WIDTH_TABLES(LightTracer, IntegratorFunctions)

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::probes {
namespace {

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&] {
    return new lightTracer::Data{uint32_t(info->integer(lightTracer::kBounces)), info->number(lightTracer::kGain)};
  });
}
void destroy(void* p) { delete static_cast<lightTracer::Data*>(p); }
constexpr IntegratorTraits kTraits{&cameraThenLightPaths};
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kLightTracer{kAbiVersion,
                              sizeof(Descriptor),
                              Kind::Integrator,
                              0,
                              "ProbeLightTracer",
                              "Paths from lights.",
                              lightTracer::kParams,
                              std::size(lightTracer::kParams),
                              kTables,
                              4,
                              &kTraits,
                              &create,
                              &destroy};

constexpr int kSide = 48, kTile = 8, kSeeds = 20;

std::string room(const std::string& lights, const std::string& floor, const std::string& ball) {
  return R"(
Hider "raytrace" "int maxsamples" [16]
Display "probe.exr" "openexr" "Ci,a,directDiffuse"
DisplayChannel "color directDiffuse"
Format 48 48 1
PixelFilter "box" 1 1
)" + corner(lights, floor, ball);
}
const char* const kGrey = R"(Bxdf "PxrDiffuse" "grey" "color diffuseColor" [0.6 0.6 0.7])";
const char* const kGlossy =
    R"(Bxdf "PxrSurface" "glossy" "color diffuseColor" [0.3 0.3 0.3] "int specularFresnelMode" [1]
    "color specularEdgeColor" [1 1 1] "color specularIor" [1.8 1.8 1.8] "int specularModelType" [1] "float specularRoughness" [0.45])";
const char* const kRect = R"(
    AttributeBegin
      ConcatTransform [0.8 0 0 0  0 0 0.6 0  0 -1 0 0  -0.2 1.9 1 1]
      Light "PxrRectLight" "lamp" "float intensity" [6] "color lightColor" [1 0.9 0.7]
    AttributeEnd)";
const char* const kSphere = R"(
    AttributeBegin
      Translate -0.8 0.9 0.6
      Scale 0.3 0.3 0.3
      Light "PxrSphereLight" "bulb" "float intensity" [12] "color lightColor" [0.6 0.8 1]
    AttributeEnd)";
const char* const kDistant = R"(
    AttributeBegin
      Rotate 70 1 0.3 0
      Light "PxrDistantLight" "sun" "float intensity" [29760] "float angleExtent" [4] "int areaNormalize" [1]
    AttributeEnd)";
const char* const kDome = R"(Light "PxrDomeLight" "sky" "float intensity" [0.4])";

struct Rendered {
  TileMoments Ci, direct, whole;  // whole: one tile
};

Rendered renderAll(Workshop& stage, const std::string& text, const std::string& integrator,
                   std::vector<std::pair<std::string, std::string>> sets, uint32_t firstSeed) {
  Rendered r;
  render::Settings s;
  s.integrator = integrator;
  s.sets = std::move(sets);
  forSeeds(stage, text, s, firstSeed, kSeeds, [&](render::Renderer& renderer) {
    const image::Image picture = pictureOf(renderer);
    r.Ci.add(picture, kSide, kSide, kTile);
    r.whole.add(picture, kSide, kSide, kSide);
    r.direct.add(renderer.film().resolve(renderer.film().layout().find("directDiffuse")), kSide, kSide, kTile);
  });
  return r;
}

// fault: how much too bright a light tracer is that the test must tell apart.
void expectSamePicture(const std::string& text, double fault = 0.03) {
  Workshop stage{&kLightTracer};
  const Rendered reference = renderAll(stage, text, "PxrPathTracer",
                                       {{"integrator.maxIndirectBounces", "3"},
                                        {"integrator.clampLuminance", "1e30"},
                                        {"integrator.rouletteThreshold", "0"}},
                                       100);
  const Rendered light = renderAll(stage, text, "ProbeLightTracer", {}, 500);
  EXPECT_GT(reference.Ci.mean(), 0.01) << stage.said;
  for (const bool direct : {false, true}) {
    const TileTest t = direct ? compareTiles(light.direct, reference.direct) : compareTiles(light.Ci, reference.Ci);
    EXPECT_TRUE(t.agrees()) << (direct ? "directDiffuse" : "Ci") << ": worst z " << t.worstZ << ", means "
                            << light.Ci.mean() << " and " << reference.Ci.mean() << "\n"
                            << stage.said;
    EXPECT_LT(t.meanError, fault);
  }
  const TileTest whole = compareTiles(light.whole, reference.whole);
  EXPECT_TRUE(whole.agrees()) << "means " << light.whole.mean() << " and " << reference.whole.mean() << ", z "
                              << whole.worstZ;
  const Rendered wrong =
      renderAll(stage, text, "ProbeLightTracer", {{"integrator.gain", std::to_string(1 + fault)}}, 500);
  EXPECT_FALSE(compareTiles(wrong.whole, reference.whole).agrees());
}

TEST(LightTracer, EqualsPathTracerUnderRectLight) { expectSamePicture(room(kRect, kGrey, kGrey)); }
TEST(LightTracer, EqualsPathTracerUnderSphereLight) { expectSamePicture(room(kSphere, kGrey, kGrey)); }
TEST(LightTracer, EqualsPathTracerUnderDistantLight) { expectSamePicture(room(kDistant, kGrey, kGrey)); }
TEST(LightTracer, EqualsPathTracerUnderDomeLight) { expectSamePicture(room(kDome, kGrey, kGrey)); }
TEST(LightTracer, EqualsPathTracerUnderTwoLightsWithGlossyFloor) {
  expectSamePicture(room(std::string(kRect) + kSphere, kGlossy, kGlossy));
}

// What weights of bidirectional methods ask, of lights of every kind at once: areas, infinite ones and deltas.
// In the room, most of which is behind the view axis.
TEST(LightTracer, EqualsPathTracerAllAround) {
  for (const char* projection :
       {"\"PxrSphereCamera\"", "\"OmnidirectionalStereo\" \"float interpupilaryDistance\" [0.2]"}) {
    std::string text = room(kRect, kGrey, kGrey);
    const std::string from = "Projection \"perspective\" \"fov\" [40]\nTranslate 0 -0.8 3.2";
    text.replace(text.find(from), from.size(),
                 std::string("Projection ") + projection + "\nRotate 140 0 1 0\nTranslate 0 -0.8 -0.4");
    expectSamePicture(text, 0.06);  // few of the light paths come near the eye
  }
}

TEST(LightTracer, DensitiesOfLightEndsAreThoseOfMakingThem) {
  const std::string lights = std::string(kRect) + kSphere + kDistant + kDome + R"(
    AttributeBegin
      Translate 0.5 1.5 1.5
      Light "PointLight" "bare" "float intensity" [2] "float coneAngle" [120]
      Light "PxrDistantLight" "ray" "float intensity" [0.3] "float angleExtent" [0]
    AttributeEnd)";
  lightTracer::ends.emitted = lightTracer::ends.emittedOff = 0;
  lightTracer::ends.sampled = lightTracer::ends.sampledOff = 0;
  Workshop stage{&kLightTracer};
  render::Settings s;
  s.threads = 1;
  s.integrator = "ProbeLightTracer";
  const auto renderer = stage.load(sceneOf(room(lights, kGrey, kGlossy), stage.messages), s);
  ASSERT_EQ(renderer->renderFilm(), render::Outcome::Complete);
  EXPECT_GT(lightTracer::ends.emitted, 5000u) << stage.said;
  EXPECT_GT(lightTracer::ends.sampled, 3000u);
  // rays that graze a light lose digits of place and cosine
  EXPECT_LT(lightTracer::ends.emittedOff, lightTracer::ends.emitted / 100);
  EXPECT_LT(lightTracer::ends.sampledOff, lightTracer::ends.sampled / 100);
}

// The ball is lit by the rect light alone, the rest by both: light paths obey links, and channels by light group and
// by label take the same share of them as of the camera's paths.
TEST(LightTracer, ObeysLightLinkingAndChannels) {
  const std::string lights = std::string(kRect) + R"(
    AttributeBegin
      Attribute "grouping" "string membership" ["blue"]
      Translate -0.8 0.9 0.6
      Scale 0.3 0.3 0.3
      Light "PxrSphereLight" "bulb" "float intensity" [12] "color lightColor" [0.6 0.8 1] "string lightGroup" ["bulb"]
    AttributeEnd)";
  const std::string ball = std::string(
                               "Attribute \"lighting\" \"string excludesubset\" [\"blue\"]\nAttribute \"identifier\" "
                               "\"string lpegroup\" [\"ball\"]\n") +
                           kGrey;
  std::string text = room(lights, kGrey, ball);
  text.replace(text.find("\"Ci,a,directDiffuse\""), 20, "\"Ci,a,bulb,ball,bulbOnBall,indirect\"");
  text.insert(text.find("Format"), R"(DisplayChannel "color bulb" "string source" ["lpe:C.*<L.'bulb'>"]
DisplayChannel "color ball" "string source" ["lpe:C<.D'ball'>.*L"]
DisplayChannel "color bulbOnBall" "string source" ["lpe:C<.D'ball'><L.'bulb'>"]
)");
  Workshop stage{&kLightTracer};
  std::map<std::string, TileMoments> moments[2];
  const std::vector<std::string> names{"Ci", "bulb", "ball", "indirect"};
  for (int k = 0; k < 2; ++k)
    for (uint32_t seed = 0; seed < kSeeds; ++seed) {
      render::Settings s;
      s.threads = 1;
      s.seed = 100 + 400 * uint32_t(k) + seed;
      s.integrator = k ? "ProbeLightTracer" : "PxrPathTracer";
      if (!k)
        s.sets = {{"integrator.maxIndirectBounces", "3"},
                  {"integrator.clampLuminance", "1e30"},
                  {"integrator.rouletteThreshold", "0"}};
      const auto renderer = stage.load(sceneOf(text, stage.messages), s);
      ASSERT_EQ(renderer->renderFilm(), render::Outcome::Complete);
      for (const std::string& name : names)
        moments[k][name].add(renderer->film().resolve(renderer->film().layout().find(name)), kSide, kSide, kTile);
      const image::Image none = renderer->film().resolve(renderer->film().layout().find("bulbOnBall"));
      EXPECT_EQ(*std::max_element(none.pixels.begin(), none.pixels.end()), 0) << s.integrator;
    }
  for (const std::string& name : names) {
    const TileTest t = compareTiles(moments[1][name], moments[0][name]);
    EXPECT_GT(moments[0][name].mean(), 0.003) << name;
    EXPECT_TRUE(t.agrees()) << name << ": worst z " << t.worstZ << ", means " << moments[1][name].mean() << " and "
                            << moments[0][name].mean() << "\n"
                            << stage.said;
  }
}

}  // namespace
}  // namespace kinora::probes
#endif
