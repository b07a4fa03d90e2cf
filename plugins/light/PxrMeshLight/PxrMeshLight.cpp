// PxrMeshLight: the geometry of its attribute block emits, from the side of its outward normal. Sampled by area: a
// triangle by inversion of the areas' sums, then a point in it. Each triangle keeps the density with which it is
// really chosen (sums are rounded), so that sample and evaluate agree exactly. A ray meets the first triangle whose
// emitting side it sees; what lies behind it on the same ray belongs to nobody, so sample() rejects points that the
// light itself hides. Where triangles move while the shutter is open each is chosen by its area averaged over the keys,
// whatever the time, and its points are as dense as its area at that time says.
#define KINORA_KERNEL_FILE "plugins/light/PxrMeshLight/PxrMeshLight.cpp"
#include <kinora/light_mesh.h>
#include <kinora/light_setup.h>
#include <memory>
#include "plugins/light/PxrMeshLight/triangle_tree.h"
#include <kinora/light_author.h>

#if KINORA_PLAIN
namespace kinora::pxrMeshLight {
inline constexpr std::array kTexture = {
    param::color("textureColor", 1.f).help("Factor on the colour; a pattern connected here does not count yet."),
};
constexpr auto kParams = joinParams(lightParams::kRadiance, lightParams::kNormalize, kTexture, lightParams::kShaping,
                                    lightParams::kControl);

struct Data {
  LightCommon common;
  Shaping shaping;
  Triangles triangles;
  TriangleTree tree;
  std::vector<float> cdf;      // count + 1
  std::vector<float> density;  // of points on each triangle, per area; of moving ones the chance of each
  int32_t steps = 0;           // of the binary search
  bool convex = false;         // no point of the emitting side hides another
  Double3 center;
  double radius = 0, area = 0;  // area: the mean over the keys
  // With areaNormalize, of what deforms: `area` over that at even times over the shutter. Empty: the same at all times.
  std::vector<float> meanOverArea;
  bool isBlack = true;
};

constexpr double kPi = 3.14159265358979323846;

Double3 corner(const LightMesh& m, uint32_t key, uint32_t index) {
  const float* p = m.P + 3 * (size_t(key) * m.vertexCount + index);
  return {p[0], p[1], p[2]};
}

// A triangle at a key.
struct Facet {
  Double3 p[3], e1, e2, n;
  double twice = 0;  // its area, twice
  Facet(const LightMesh& m, uint32_t key, const uint32_t* v)
      : p{corner(m, key, v[0]), corner(m, key, v[1]), corner(m, key, v[2])},
        e1(p[1] - p[0]),
        e2(p[2] - p[0]),
        n(cross(e1, e2)),
        twice(length(n)) {}
  bool isFinite() const { return std::isfinite(twice) && std::isfinite(length(p[0])); }
  bool hasArea() const { return twice > 1e-30 && twice > 1e-7 * length(e1) * length(e2); }
};

// Triangles with area at some key; returns how many had none or were broken.
uint32_t gatherTriangles(const LightMesh& m, Data& k) {
  uint32_t left = 0;
  std::vector<Triangles> byKey(m.keyCount);
  Double3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  for (uint32_t i = 0; i < m.triangleCount; ++i) {
    const uint32_t* v = m.triangles + 3 * size_t(i);
    if (v[0] >= m.vertexCount || v[1] >= m.vertexCount || v[2] >= m.vertexCount) {
      ++left;
      continue;
    }
    bool isFinite = true, hasArea = false;
    for (uint32_t key = 0; key < m.keyCount; ++key) {
      const Facet f(m, key, v);
      isFinite &= f.isFinite();
      hasArea |= f.hasArea();
    }
    if (!isFinite || !hasArea) {
      ++left;
      continue;
    }
    for (uint32_t key = 0; key < m.keyCount; ++key) {
      const Facet f(m, key, v);
      const double parts[3][3] = {{f.p[0].x, f.p[0].y, f.p[0].z}, {f.e1.x, f.e1.y, f.e1.z}, {f.e2.x, f.e2.y, f.e2.z}};
      const double n[3] = {f.n.x, f.n.y, f.n.z}, twice = f.twice > 0 ? f.twice : 1;
      Triangles& to = byKey[key];
      for (int c = 0; c < 3; ++c) {
        to.v0[c].push_back(float(parts[0][c]));
        to.e1[c].push_back(float(parts[1][c]));
        to.e2[c].push_back(float(parts[2][c]));
        to.normal[c].push_back(float(n[c] / twice));
      }
      for (const Double3& q : f.p) {
        low = {std::fmin(low.x, q.x), std::fmin(low.y, q.y), std::fmin(low.z, q.z)};
        high = {std::fmax(high.x, q.x), std::fmax(high.y, q.y), std::fmax(high.z, q.z)};
      }
    }
  }
  k.triangles = std::move(byKey[0]);
  k.triangles.keyCount = m.keyCount;
  for (uint32_t key = 1; key < m.keyCount; ++key)
    for (int c = 0; c < 3; ++c) {
      const auto append = [](std::vector<float>& to, const std::vector<float>& x) {
        to.insert(to.end(), x.begin(), x.end());
      };
      append(k.triangles.v0[c], byKey[key].v0[c]);
      append(k.triangles.e1[c], byKey[key].e1[c]);
      append(k.triangles.e2[c], byKey[key].e2[c]);
      append(k.triangles.normal[c], byKey[key].normal[c]);
    }
  if (k.triangles.count()) {
    k.center = (low + high) * 0.5;
    k.radius = length(high - low) * 0.5;
  }
  return left;
}

Double3 get(const std::vector<float> v[3], uint32_t i) { return {v[0][i], v[1][i], v[2][i]}; }

// Whether every triangle lies behind every other's plane, or in it; asked of small lights that stay as they are only.
bool isConvex(const Data& k) {
  const Triangles& t = k.triangles;
  constexpr uint32_t kMost = 1024;
  if (t.moves() || t.count() > kMost) return false;
  for (uint32_t i = 0; i < t.count(); ++i) {
    const Double3 n = get(t.normal, i), o = get(t.v0, i);
    for (uint32_t j = 0; j < t.count(); ++j) {
      const Double3 p = get(t.v0, j) - o;
      const double most = std::fmax(dot(p, n), std::fmax(dot(p + get(t.e1, j), n), dot(p + get(t.e2, j), n)));
      if (most > 1e-5 * k.radius) return false;
    }
  }
  return true;
}

void buildDistribution(Data& k) {
  const Triangles& t = k.triangles;
  std::vector<double> area(t.count());
  for (uint32_t i = 0; i < t.count(); ++i) {
    for (uint32_t key = 0; key < t.keyCount; ++key) {
      const uint32_t at = key * t.count() + i;
      area[i] += 0.5 * length(cross(get(t.e1, at), get(t.e2, at)));
    }
    k.area += area[i] /= t.keyCount;
  }
  double sum = 0;
  k.cdf.push_back(0);
  for (uint32_t i = 0; i < t.count(); ++i) {
    sum += area[i];
    k.cdf.push_back(i + 1 == t.count() ? 1.f : std::fmin(1.f, float(sum / k.area)));
    const double chance = double(k.cdf[i + 1]) - k.cdf[i];
    k.density.push_back(float(t.moves() ? chance : chance / area[i]));
  }
  while ((int64_t(1) << k.steps) < t.count()) ++k.steps;
}

// Radiance goes with one over the area of each time, so that the power does not.
void findAreas(Data& k) {
  const Triangles& t = k.triangles;
  constexpr uint32_t kStepsOfKey = 32;
  const uint32_t steps = (t.keyCount - 1) * kStepsOfKey;
  for (uint32_t s = 0; s <= steps; ++s) {
    const uint32_t key = std::min(s / kStepsOfKey, t.keyCount - 2);
    const double part = double(s) / kStepsOfKey - key;
    double area = 0;
    for (uint32_t i = key * t.count(); i < (key + 1) * t.count(); ++i) {
      const auto then = [&](const std::vector<float> e[3]) {
        const Double3 a = get(e, i), b = get(e, i + t.count());
        return a + (b - a) * part;
      };
      area += 0.5 * length(cross(then(t.e1), then(t.e2)));
    }
    k.meanOverArea.push_back(float(k.area / std::fmax(area, 1e-6 * k.area)));
  }
}

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  LocalFrame::of(info);  // refuses placements that are not finite
  auto light = std::make_unique<Data>();
  const LightMesh* mesh = static_cast<const LightMesh*>(info.extra);
  const uint32_t left = mesh ? gatherTriangles(*mesh, *light) : 0;
  if (left)
    values.warn("LIGHT-DEGENERATE", std::to_string(left) + " triangles of the light have no area",
                "they do not emit");
  if (light->triangles.count()) {
    light->tree.build(light->triangles);
    buildDistribution(*light);
    light->convex = isConvex(*light);
  }
  light->common = LightCommon::of(values, light->area);
  if (light->triangles.count() && light->triangles.moves() && values.integer("areaNormalize")) findAreas(*light);
  for (int c = 0; c < 3; ++c) light->common.radiance[c] *= float(values.number("textureColor", c));
  light->shaping = Shaping::of(values, false);
  values.warnNoEffect();
  if (!light->triangles.count())
    values.warn("LIGHT-DEGENERATE", "no geometry with area follows the light in its attribute block",
                "the light is black");
  else
    light->isBlack = light->common.isBlack();
  return light;
}

void describe(const void* data, LightDescription* d) {
  const Data& k = *static_cast<const Data*>(data);
  *d = describeSurfaceLight(k.common, k.shaping, k.isBlack, Float3(k.center), k.radius * (1 + 1e-6), k.area);
  if (!k.triangles.count()) return;
  Double3 mean;
  LightBox box;
  const uint32_t count = k.triangles.count();
  for (uint32_t i = 0; i < count * k.triangles.keyCount; ++i) {
    const Double3 v0 = get(k.triangles.v0, i), e1 = get(k.triangles.e1, i), e2 = get(k.triangles.e2, i);
    mean = mean + cross(e1, e2) * 0.5;
    for (const Double3& p : {v0, v0 + e1, v0 + e2}) box.add(p);
  }
  box.describe(*d);
  // normals that point apart are those of a closed surface
  mean = normalized(mean);
  double least = 1;
  for (uint32_t i = 0; i < count * k.triangles.keyCount; ++i)
    least = std::fmin(least, dot(get(k.triangles.normal, i), mean));
  // Between two keys a normal goes by a parabola: it keeps to the cone of that one's three corners, where the cone is no
  // wider than a hemisphere.
  for (uint32_t i = 0; i + count < count * k.triangles.keyCount; ++i) {
    const Double3 a = get(k.triangles.e1, i), b = get(k.triangles.e2, i);
    const Double3 c = get(k.triangles.e1, i + count), d = get(k.triangles.e2, i + count);
    const Double3 middle = cross(a, d) + cross(c, b);
    if (length(middle) > 0) least = std::fmin(least, dot(normalized(middle), mean));
  }
  if (k.triangles.moves() && least < 0) least = -1;
  describeEmission(*d, k.shaping, least > -0.9 ? mean : Double3{}, least);
}

// Lambert's formula over the triangles that face the point, cut at the receiver's horizon; -1 where triangles may
// hide each other or shaping makes the radiance vary.
double irradiance(const void* data, const double P[3], const double N[3]) {
  const Data& k = *static_cast<const Data*>(data);
  if (k.isBlack) return 0;
  if (!k.convex || k.shaping.focused || k.shaping.coned) return -1;
  const Double3 p{P[0], P[1], P[2]}, n = normalized({N[0], N[1], N[2]});
  double sum = 0;
  for (uint32_t i = 0; i < k.triangles.count(); ++i) {
    const Double3 v0 = get(k.triangles.v0, i) - p, e1 = get(k.triangles.e1, i), e2 = get(k.triangles.e2, i);
    if (dot(v0, cross(e1, e2)) >= 0) continue;
    const Double3 v[3] = {v0, v0 + e1, v0 + e2};
    Double3 cut[6];
    int count = 0;
    for (int j = 0; j < 3; ++j) {
      const Double3 a = v[j], b = v[(j + 1) % 3];
      const double ha = dot(a, n), hb = dot(b, n);
      if (ha >= 0) cut[count++] = a;
      if ((ha < 0) != (hb < 0)) cut[count++] = a + (b - a) * (ha / (ha - hb));
    }
    double one = 0;
    for (int j = 0; j < count; ++j) {
      const Double3 a = normalized(cut[j]), b = normalized(cut[(j + 1) % count]), c = cross(a, b);
      const double s = length(c);
      if (s > 1e-15) one += std::atan2(s, dot(a, b)) * dot(c, n) / s;
    }
    sum += std::fabs(one) / 2;
  }
  return (double(k.common.radiance[0]) + k.common.radiance[1] + k.common.radiance[2]) / 3 * sum;
}
}  // namespace kinora::pxrMeshLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrMeshLight;

template <int W>
KN_INLINE Vec3<W> at(const std::vector<float> v[3], Int<W> i) {
  return {gather(v[0].data(), i), gather(v[1].data(), i), gather(v[2].data(), i)};
}

// Largest i with cdf[i] <= u.
template <int W>
KN_INLINE Int<W> find(const Data& k, Float<W> u) {
  using I = Int<W>;
  I low(0), high(int32_t(k.triangles.count()));
  for (int32_t s = 0; s < k.steps; ++s) {
    const I middle = (low + high).template shr<1>();
    const Mask<W> above = gather(k.cdf.data(), middle) <= u;
    low = select(above, middle, low);
    high = select(above, high, middle);
  }
  return low;
}

// Triangles of the lanes at their times.
template <int W>
struct Facets {
  Vec3<W> v0, e1, e2, N;
  Float<W> density;                 // of points, per area
  Float<W> factor = Float<W>(1.f);  // of the radiance
  KN_INLINE Facets(const Data& k, Int<W> triangle, Float<W> time) {
    using F = Float<W>;
    using I = Int<W>;
    const Triangles& t = k.triangles;
    density = gather(k.density.data(), triangle);
    if (!t.moves()) {
      v0 = at<W>(t.v0, triangle);
      e1 = at<W>(t.e1, triangle);
      e2 = at<W>(t.e2, triangle);
      N = at<W>(t.normal, triangle);
      return;
    }
    // as TriangleKeys has them
    const F held = zeroUnless(time > F(0.f), min(time, F(1.f))), x = held * F(float(t.keyCount - 1));
    const F key = min(floor(x), F(float(t.keyCount - 2))), part = x - key;
    const I first = toInt(key) * I(int32_t(t.count())) + triangle, second = first + I(int32_t(t.count()));
    v0 = lerp(at<W>(t.v0, first), at<W>(t.v0, second), part);
    e1 = lerp(at<W>(t.e1, first), at<W>(t.e1, second), part);
    e2 = lerp(at<W>(t.e2, first), at<W>(t.e2, second), part);
    N = cross(e1, e2);
    // one without area has no side that is seen
    const F twice = max(length(N), F(1e-30f));
    N = N * (F(1.f) / twice);
    density = density * (F(2.f) / twice);
    if (k.meanOverArea.empty()) return;
    const F most(float(k.meanOverArea.size() - 1)), s = held * most;
    const F below = min(floor(s), most - F(1.f));
    const float* areas = k.meanOverArea.data();
    factor = lerp(gather(areas, toInt(below)), gather(areas, toInt(below) + I(1)), s - below);
  }
  // Evenly in them (Turk, "Generating Random Points in Triangles", Graphics Gems, 1990).
  KN_INLINE Vec3<W> point(Float<W> u, Float<W> v) const {
    using F = Float<W>;
    const F root = sqrt(u), b1 = root * (F(1.f) - v), b2 = root * v;
    return fma(e1, b1, fma(e2, b2, v0));
  }
};

// One ray after the other through the tree: first triangles (as they are where none) and distances.
template <int W>
inline Mask<W> firstHits(const Data& k, Vec3<W> o, Vec3<W> d, Float<W> time, Float<W> tMax, Int<W>& triangle,
                         Float<W>& t) {
  alignas(64) float os[3][W], ds[3][W], times[W], most[W], ts[W], found[W];
  alignas(64) int32_t is[W];
  float* const op[3] = {os[0], os[1], os[2]};
  float* const dp[3] = {ds[0], ds[1], ds[2]};
  o.store(op, 0);
  d.store(dp, 0);
  time.store(times);
  tMax.store(most);
  for (int i = 0; i < W; ++i) {
    const float from[3] = {os[0][i], os[1][i], os[2][i]}, way[3] = {ds[0][i], ds[1][i], ds[2][i]};
    const uint32_t hit = k.tree.first(k.triangles, from, way, times[i], most[i], ts[i]);
    found[i] = hit != TriangleTree::kNone ? 1.f : 0.f;
    is[i] = hit != TriangleTree::kNone ? int32_t(hit) : 0;
  }
  triangle = Int<W>::load(is);
  t = Float<W>::load(ts);
  return Float<W>::load(found) > Float<W>(0.f);
}

struct PxrMeshLight {
  using Data = pxrMeshLight::Data;
  static constexpr bool kIntersects = true, kDeforms = true;

  template <int W>
  static KN_INLINE Rgb<W> radiance(const Data& k, const Facets<W>& on, Float<W> cosine) {
    return wideRgb<W>(k.common.radiance) * shape<W>(k.shaping, cosine) * on.factor;
  }

  template <int W>
  static void sample(const Data& k, const LightPoint<W>& in, LightSample<W>& out) {
    using F = Float<W>;
    if (k.isBlack) return;
    const Int<W> triangle = find<W>(k, in.u);
    const F c0 = gather(k.cdf.data(), triangle), c1 = gather(k.cdf.data(), triangle + Int<W>(1));
    const F u = clamp((in.u - c0) / max(c1 - c0, F(1e-30f)), F(0.f), F(1.f));
    const Facets<W> on(k, triangle, in.time);
    const Vec3<W> to = on.point(u, in.v) - in.P;
    const F d2 = dot(to, to), distance = sqrt(d2);
    out.wi = to * (F(1.f) / max(distance, F(1e-30f)));
    out.distance = distance;
    const F cosine = -dot(out.wi, on.N);
    Mask<W> seen = cosine > F(0.f);
    if (!k.convex && seen.any()) {
      Int<W> first;
      F t;
      const Mask<W> hit = firstHits<W>(k, in.P, out.wi, in.time, distance * F(1.f - 1e-4f), first, t);
      seen &= !(hit & (first != triangle));
    }
    out.pdf = zeroUnless(seen, on.density * d2 / max(cosine, F(1e-30f)));
    out.radiance = radiance<W>(k, on, cosine);
  }

  template <int W>
  static Mask<W> intersect(const Data& k, const LightRay<W>& ray, Float<W>& t) {
    if (k.isBlack) return Mask<W>(false);
    Int<W> triangle;
    Float<W> found;
    const Mask<W> hit = firstHits<W>(k, ray.o, ray.d, ray.time, t, triangle, found);
    t = select(hit, found, t);
    return hit;
  }

  template <int W>
  static void evaluate(const Data& k, const LightRay<W>& ray, Rgb<W>& l, Float<W>& pdf) {
    using F = Float<W>;
    if (k.isBlack) return;
    Int<W> triangle;
    F t;
    const Mask<W> hit = firstHits<W>(k, ray.o, ray.d, ray.time, F(3e38f), triangle, t);
    const Facets<W> on(k, triangle, ray.time);
    const F cosine = -dot(ray.d, on.N);
    const Mask<W> lit = hit & (cosine > F(0.f));
    l = zeroUnless(lit, radiance<W>(k, on, cosine));
    pdf = zeroUnless(lit, on.density * (t * t) / max(cosine, F(1e-30f)));
  }

  template <int W>
  static void emit(const Data& k, const EmitInput<W>& in, LightEmission<W>& out) {
    using F = Float<W>;
    if (k.isBlack) return;
    const Int<W> triangle = find<W>(k, in.u0);
    const F c0 = gather(k.cdf.data(), triangle), c1 = gather(k.cdf.data(), triangle + Int<W>(1));
    const F u = clamp((in.u0 - c0) / max(c1 - c0, F(1e-30f)), F(0.f), F(1.f));
    const Facets<W> on(k, triangle, in.time);
    out.o = on.point(u, in.u1);
    out.N = on.N;
    F a, b;
    concentricDisk(in.u2, in.u3, a, b);
    a *= F(k.shaping.sinCone);
    b *= F(k.shaping.sinCone);
    const F cosine = safeSqrt(fnma(a, a, fnma(b, b, F(1.f))));
    out.d = Frame<W>(out.N).toWorld({a, b, cosine});
    out.pdfPosition = on.density;
    out.pdfDirection = cosine * F(kInvPi / (k.shaping.sinCone * k.shaping.sinCone));
    out.radiance = radiance<W>(k, on, cosine);
    if (!k.convex) {
      // what leaves into the light's own emitting side stays there: nobody sees it behind what lies in front
      Int<W> first;
      F t;
      const Mask<W> blocked = firstHits<W>(k, out.o + out.d * F(float(4 * k.radius)), -out.d, in.time,
                                           F(float(4 * k.radius * (1 - 1e-4))), first, t) &
                              (first != triangle);
      out.pdfPosition = zeroUnless(!blocked, out.pdfPosition);
    }
  }

  template <int W>
  static void densities(const Data& k, const LightRay<W>& ray, LightDensities<W>& out) {
    using F = Float<W>;
    if (k.isBlack) return;
    Int<W> triangle;
    F t;
    const Mask<W> hit = firstHits<W>(k, ray.o, ray.d, ray.time, F(3e38f), triangle, t);
    const Facets<W> on(k, triangle, ray.time);
    out.N = on.N;
    out.pdfPosition = zeroUnless(hit, on.density);
    out.pdfDirection = coneDensity<W>(-dot(ray.d, out.N), F(k.shaping.sinCone));
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(PxrMeshLight,
             .help =
                 "The geometry that follows in its attribute block emits, from the side of its outward normal; the "
                 "geometry itself is not rendered. Focus and cone are measured from the surface's normal.",
             .params = kParams, .setUp = setUpBy<make>, .describe = describe, .irradiance = irradiance)
