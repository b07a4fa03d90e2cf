// Footprints of camera paths on surfaces that are seen at an angle, shorter with each sample of a pixel: an integrator of the test asks each context for the
// half diameters of its ellipses, and compares them with those worked out from the place of the eye and the way that
// texture coordinates lie on the surface. What a wide path has found has circles. Misses what textures make of them
// (src/texture/ellipse_lookup_test.cpp).
#include <kinora/integrator.h>
#include <kinora/pattern_author.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>

#include "shade/surface_points.h"
#include "tests/probes/probe_support.h"

namespace kinora::probes {
namespace {

// How s and t change along a wall: by its point, about an origin.
struct Mapping {
  double s[3], t[3];
};
struct Shared {
  Mapping mapping;
  const char* primvar = nullptr;
  bool afterMirror = false;
  float spread = 0;  // of the rays that go on; 0: as they were
  std::mutex mutex;
  uint64_t compared = 0, circles = 0, wrong = 0;
  double longest = 0, worst = 0;
} shared;

void judge(const Context& c) {
  Value axes[2];
  const bool some = c.fn->ellipses(&c, shared.primvar, axes) != 0;
  uint64_t circles = 0, wrong = 0;
  double longest = 0, worst = 0;
  for (uint32_t i = 0; i < c.count; ++i) {
    const double u[2] = {some ? double(axes[0].data[0][i]) : 0, some ? double(axes[0].data[1][i]) : 0},
                 v[2] = {some ? double(axes[1].data[0][i]) : 0, some ? double(axes[1].data[1][i]) : 0};
    if (u[0] == 0 && u[1] == 0 && v[0] == 0 && v[1] == 0) {
      ++circles;
      continue;
    }
    // the moments of the ellipse on the wall, r^2 (1 + (stretch^2 - 1) d d'), seen through the mapping
    double cosine = 0, flat[3], l2 = 0;
    for (int k = 0; k < 3; ++k) cosine += double(c.wo[k][i]) * double(c.Ng[k][i]);
    for (int k = 0; k < 3; ++k) {
      flat[k] = double(c.wo[k][i]) - cosine * double(c.Ng[k][i]);
      l2 += flat[k] * flat[k];
    }
    const double whole = std::min(1 / cosine, double(shade::kMostStretch)),
                 stretch = std::max(1., whole / (1 + 0.25 * c.sampleIndex[i]));
    longest = std::max(longest, stretch);
    const auto moment = [&](const double a[3], const double b[3]) {
      double n[2] = {0, 0}, product = 0, along[2] = {0, 0};
      for (int k = 0; k < 3; ++k) {
        n[0] += a[k] * double(c.Ng[k][i]);
        n[1] += b[k] * double(c.Ng[k][i]);
        product += a[k] * b[k];
        along[0] += a[k] * flat[k];
        along[1] += b[k] * flat[k];
      }
      product -= n[0] * n[1];  // the wall's own directions alone
      const double r2 = double(c.radius[i]) * double(c.radius[i]);
      return r2 * (product + (l2 > 1e-12 ? (stretch * stretch - 1) * along[0] * along[1] / l2 : 0));
    };
    const double expected[3] = {moment(shared.mapping.s, shared.mapping.s),
                                moment(shared.mapping.t, shared.mapping.t),
                                moment(shared.mapping.s, shared.mapping.t)};
    const double got[3] = {u[0] * u[0] + v[0] * v[0], u[1] * u[1] + v[1] * v[1], u[0] * u[1] + v[0] * v[1]};
    const double size = expected[0] + expected[1];
    for (int k = 0; k < 3; ++k) {
      const double error = std::fabs(got[k] - expected[k]) / size;
      worst = std::max(worst, error);
      wrong += !(error < 2e-3);
    }
  }
  const std::lock_guard lock(shared.mutex);
  shared.compared += c.count;
  shared.circles += circles;
  shared.wrong += wrong;
  shared.longest = std::max(shared.longest, longest);
  shared.worst = std::max(shared.worst, worst);
}

void integrate(const void*, uint32_t, Group* g, const Services* s) {
  const auto floats = [&](size_t n) { return static_cast<float*>(s->alloc(g, n * sizeof(float))); };
  const auto words = [&](size_t n) { return static_cast<uint32_t*>(s->alloc(g, n * sizeof(uint32_t))); };
  uint32_t* live = words(g->padded + kPad);
  for (uint32_t i = 0; i < g->padded; ++i) live[i] = std::min(i, g->count - 1);
  float* T[3] = {floats(g->padded + kPad), floats(g->padded + kPad), floats(g->padded + kPad)};
  s->trace(g, &g->paths, RayKind::Camera, 0, g->count, live, T);
  const auto shadeHits = [&](RayList& list, uint32_t count, uint32_t depth, Context* const** made) {
    uint32_t *hit = words(padded(count) + kPad), n = 0;
    for (uint32_t i = 0; i < count; ++i)
      if (!std::isinf(list.hits.t[i])) hit[n++] = i;
    for (uint32_t i = n; n && i < padded(n); ++i) hit[i] = hit[n - 1];
    return n ? s->shade(g, &list, kTraitEyePath | (depth ? 0u : kTraitPrimaryHit), depth, n, hit, made) : 0u;
  };
  Context* const* made;
  const uint32_t n = shadeHits(g->paths, g->count, 0, &made);
  for (uint32_t k = 0; k < n; ++k) {
    const Context& c = *made[k];
    if (!shared.afterMirror) {
      judge(c);
      continue;
    }
    RayList& list = *s->makeRays(g, c.count);
    uint32_t *points = words(padded(c.count)), *entries = words(padded(c.count));
    for (uint32_t i = 0; i < padded(c.count); ++i) {
      const uint32_t p = points[i] = entries[i] = std::min(i, c.count - 1);
      if (i >= c.count) continue;
      float cosine = 0;
      for (int x = 0; x < 3; ++x) cosine += c.wo[x][p] * c.N[x][p];
      for (int x = 0; x < 3; ++x) {
        list.rays.o[x][i] = c.P[x][p] + c.bias[p] * c.Ng[x][p];
        list.rays.d[x][i] = 2 * cosine * c.N[x][p] - c.wo[x][p];
      }
      list.rays.tMax[i] = 1e30f;
      list.rays.time[i] = c.time[p];
      list.rays.radius[i] = c.radius[p];
      list.rays.spread[i] = shared.spread > 0 ? shared.spread : c.spread[p];
      list.origin[i] = kFromDiscrete | kFromSpecular;
    }
    s->leave(g, &list, &c, c.count, points, entries, nullptr);
    float* open[3] = {floats(list.capacity), floats(list.capacity), floats(list.capacity)};
    s->trace(g, &list, RayKind::Indirect, 1, c.count, entries, open);
    Context* const* next;
    const uint32_t m = shadeHits(list, c.count, 1, &next);
    for (uint32_t j = 0; j < m; ++j) judge(*next[j]);
  }
}
uint32_t stages(const void*, Stage* out, uint32_t capacity) {
  if (!capacity) return 0;
  out[0] = {StageKind::CameraPaths, 0};
  return 1;
}
constexpr IntegratorFunctions kFunctions{&integrate};
constexpr IntegratorTraits kTraits{&stages};
constexpr Descriptor kProbe = probeOf<kFunctions>("ProbeEllipse", "Half diameters of footprints.", kTraits);

void renderProbe(const std::string& world, uint32_t width, const char* camera = "") {
  shared.compared = shared.circles = shared.wrong = 0;
  shared.longest = shared.worst = 0;
  Workshop stage{&kProbe};
  render::Settings s;
  s.threads = 2;
  s.width = width;
  s.integrator = "ProbeEllipse";
  const auto r =
      stage.load(sceneOf("Hider \"raytrace\" \"int maxsamples\" [4]\nDisplay \"p.exr\" \"openexr\" \"Ci\"\n"
                         "Format 64 48 1\nPixelFilter \"box\" 1 1\nProjection \"perspective\" \"fov\" [40]\n" +
                             std::string(camera) + "\nWorldBegin\n" + world + "WorldEnd\n",
                         stage.messages),
                 s);
  ASSERT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
}

// A floor at y = -1, as polygons, quads, a subdivision mesh and placed by an instance, with coordinates that are
// stretched, sheared and mirrored.
TEST(Ellipse, AreThoseOfTheFloor) {
  const char* const kFloors[] = {
      R"(Polygon "P" [-40 -1 1  40 -1 1  40 -1 81  -40 -1 81] "facevarying float[2] st" [0 0 1 0 1 1 0 1])",
      R"(PointsPolygons [3 3] [0 1 2 0 2 3] "P" [-40 -1 1  40 -1 1  40 -1 81  -40 -1 81] "vertex float[2] st" [0 0 1 0 1 1 0 1])",
      R"(SubdivisionMesh "catmull-clark" [4] [0 1 2 3] ["interpolateboundary"] [1 0] [2] [] "P" [-40 -1 1  40 -1 1  40 -1 81  -40 -1 81] "facevarying float[2] st" [0 0 1 0 1 1 0 1])",
      R"(Patch "bilinear" "P" [-40 -1 1  40 -1 1  -40 -1 81  40 -1 81])",
      R"(AttributeBegin ObjectBegin "o" Polygon "P" [-20 0 -20  20 0 -20  20 0 20  -20 0 20] "facevarying float[2] st" [0 0 1 0 1 1 0 1] ObjectEnd Translate 0 -1 41 Scale 2 1 2 ObjectInstance "o" AttributeEnd)",
  };
  shared.primvar = nullptr;
  shared.afterMirror = false;
  shared.spread = 0;
  const double side = 80;
  shared.mapping = {{1 / side, 0, 0}, {0, 0, 1 / side}};
  for (const char* const floor : kFloors)
    for (const uint32_t width : {1u, 4u, 8u, 16u}) {
      renderProbe(floor, width);
      EXPECT_GT(shared.compared, 3000u) << floor;
      EXPECT_EQ(shared.circles, 0u) << floor;
      // a subdivision mesh of one face is round: no wall, but its parameter lines are straight along the middle
      if (std::string_view(floor).starts_with("Subdivision")) continue;
      EXPECT_EQ(shared.wrong, 0u) << floor << " of " << shared.compared << ", worst " << shared.worst;
      EXPECT_EQ(shared.longest, double(shade::kMostStretch)) << "the horizon is among them";
    }
  const std::string skew =
      R"(Polygon "P" [-40 -1 1  40 -1 1  40 -1 81  -40 -1 81] "facevarying float[2] st" [0 0 -3 1 -2.5 3 .5 2])";
  shared.mapping = {{-3 / side, 0, 0.5 / side}, {1 / side, 0, 2 / side}};
  renderProbe(skew, 8);
  EXPECT_EQ(shared.wrong, 0u) << "skew, worst " << shared.worst;
  // the same of a named primitive variable, and none of one that is no place
  const std::string named =
      R"(Polygon "P" [-40 -1 1  40 -1 1  40 -1 81  -40 -1 81] "facevarying float[2] map" [0 0 -3 1 -2.5 3 .5 2] "uniform float heat" [1])";
  shared.primvar = "map";
  renderProbe(named, 8);
  EXPECT_EQ(shared.wrong, 0u) << "named, worst " << shared.worst;
  EXPECT_EQ(shared.circles, 0u);
  for (const char* const other : {"heat", "nothing", "map"}) {
    shared.primvar = other;
    renderProbe(std::string_view(other) == "map" ? skew : named, 8);
    EXPECT_EQ(shared.circles, shared.compared) << other;
  }
}

// What a mirror shows has ellipses, what a wider path finds has circles.
TEST(Ellipse, FollowMirrorsAndLeaveWidePaths) {
  shared.primvar = nullptr;
  shared.afterMirror = true;
  shared.mapping = {{1 / 80., 0, 0}, {0, 0, 1 / 80.}};
  // a mirror ahead that leans, the floor is seen in it alone
  const std::string room = R"(
    Polygon "P" [-30 -1 -60  30 -1 -60  30 -1 20  -30 -1 20] "facevarying float[2] st" [0 0 .75 0 .75 1 0 1]
    AttributeBegin Attribute "visibility" "int indirect" [0] Polygon "P" [-9 -.9 6  9 -.9 6  9 9 5  -9 9 5] AttributeEnd)";
  for (const float spread : {0.f, 1 / 128.f, 1 / 32.f, 0.25f, 1e9f}) {
    shared.spread = spread;
    renderProbe(room, 8, "Rotate 8 1 0 0");
    EXPECT_GT(shared.compared, 1000u);
    EXPECT_EQ(shared.wrong, 0u) << "of " << shared.compared << ", worst " << shared.worst;
    EXPECT_EQ(shared.circles, spread > shade::kNarrowSpread ? shared.compared : 0u) << spread;
  }
}

// Strands are thinner than what a long footprint would show.
TEST(Ellipse, StrandsHaveCircles) {
  shared.primvar = nullptr;
  shared.afterMirror = false;
  renderProbe("Curves \"linear\" [2] \"nonperiodic\" \"P\" [-3 0 9  3 .3 7] \"constant float constantwidth\" [2]\n",
              8);
  EXPECT_GT(shared.compared, 500u);
  EXPECT_EQ(shared.circles, shared.compared);
}

// Pictures of textures that are seen at an angle, directly, in a mirror and after diffuse bounces, with a manifold and without.
TEST(Ellipse, SameBitsOfTexturesForAllWidthsThreadsGroupsAndParts) {
  const std::string picture = ::testing::TempDir() + "ellipse-grain.pgm";
  {
    std::ofstream out(picture);
    out << "P5\n200 120\n255\n";
    uint32_t h = 1;
    for (int i = 0; i < 200 * 120; ++i) out.put(char((h = h * 1664525u + 1013904223u) >> 24));
  }
  std::string room = R"(Hider "raytrace" "int maxsamples" [16]
Display "p.exr" "openexr" "Ci"
Format 40 30 1
Projection "perspective" "fov" [60]
WorldBegin
Light "PxrDomeLight" "sky"
Pattern "PxrManifold2D" "place" "float angle" [20] "float scaleS" [9] "float scaleT" [5]
Pattern "PxrTexture" "placed" "string filename" ["FILE"] "reference struct manifold" ["place:result"]
Pattern "PxrTexture" "plain" "string filename" ["FILE"] "int filter" [7] "float blur" [.002]
AttributeBegin Bxdf "PxrDiffuse" "b" "reference color diffuseColor" ["placed:resultRGB"]
Polygon "P" [-9 -1 0  9 -1 0  9 -1 40  -9 -1 40] "facevarying float[2] st" [0 0 1 0 1 1 0 1] AttributeEnd
AttributeBegin Bxdf "PxrSurface" "m" "float diffuseGain" [0] "color specularEdgeColor" [1 1 1] "color specularFaceColor" [1 1 1]
  "float specularRoughness" [0] "int specularDoubleSided" [1] Polygon "P" [-3 -1 8  0 -1 6  0 3 6  -3 3 8] AttributeEnd
AttributeBegin Bxdf "PxrDiffuse" "c" "reference color diffuseColor" ["plain:resultRGB"] Translate 1 0 5 Sphere 1 -1 1 360 AttributeEnd
WorldEnd
)";
  for (size_t at; (at = room.find("FILE")) != std::string::npos;) room.replace(at, 4, picture);
  expectSameBits({}, room, "PxrPathTracer");
  std::filesystem::remove(picture);
}

}  // namespace
}  // namespace kinora::probes
