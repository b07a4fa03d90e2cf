// Haze: an example integrator, a path tracer that finds its own way through media. trace() ends none of its rays there
// (RayList::passesMedia); Services::mediumIntervals says between which distances a ray is in which media. One point a ray
// is taken evenly over all of these, and Services::mediaAt says what the media emit and scatter there. A path goes on
// from that point or from the surface behind. Written as a hit the point becomes a vertex like others: shade() makes a
// context of it, whose bxdf is the phase function. It has the mean of PxrPathTracer with more noise: lights are found by
// light samples, and by rays that no light sample could have taken. Alpha it leaves alone.
#define KINORA_KERNEL_FILE "Haze.cpp"
#include <kinora/integrator_author.h>
#include <kinora/subpaths.h>

#if KINORA_PLAIN
#include <algorithm>
namespace kinora::haze {
enum : uint32_t { kBounces };
constexpr Param kParams[] = {
    param::integer("maxIndirectBounces", 4).range(0, 64).help("Bounces beyond the first vertex, in media too."),
};
struct Data {
  uint32_t bounces;
  explicit Data(const CreateInfo& info) : bounces(uint32_t(info.integer(kBounces))) {}
};
}  // namespace kinora::haze
#endif

KINORA_KERNELS_BEGIN
using namespace haze;

template <int W>
class HazePaths {
 public:
  HazePaths(Group* group, const Services* services)
      : g_(group), sv_(services), paths_(group, services, kTraitEyePath), arrivals_(group, services) {}

  void follow(uint32_t bounces) {
    paths_.startAtCamera();
    g_->paths.passesMedia = 1;
    g_->paths.againstLights = g_->paths.share = nullptr;  // emission of media is met by chance alone
    for (float*& x : through_) x = make<float>(g_->padded);
    for (uint32_t depth = 0; paths_.count; ++depth) {
      const RayKind kind = depth ? RayKind::Indirect : RayKind::Camera;
      sv_->trace(g_, &g_->paths, kind, depth, paths_.count, paths_.live, through_);
      meetLights(kind, depth);
      passMedia(depth, depth <= bounces);
      if (depth > bounces) return;
      uint32_t n = 0;
      for (uint32_t i = 0; i < paths_.count; ++i) {
        const uint32_t s = paths_.live[i];
        for (int k = 0; k < 3; ++k) paths_.throughput[k][s] *= through_[k][s];
        paths_.live[n] = s;
        n += g_->paths.hits.t[s] < 3e38f;
      }
      paths_.count = 0;  // from here on they are those that scatter() lets live
      if (!n) return;
      Context* const* contexts;
      const uint32_t count = sv_->shade(g_, &g_->paths, depth ? kTraitEyePath : kTraitEyePath | kTraitPrimaryHit,
                                        depth, n, paths_.live, &contexts);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        paths_.contributeEmission(c);
        sampleLights(c);
        if (!(c.traits & kTraitScattersOnce)) paths_.scatter(c, depth);
      }
    }
  }

 private:
  struct Point {
    float length;  // of all stretches of its ray
    float chance;  // that the path goes on from there, as it does; 0: it does not
    float pick;    // of one of the media there
  };
  template <class T>
  T* make(uint32_t n) const {
    return static_cast<T*>(sv_->alloc(g_, (n + kPad) * sizeof(T)));
  }

  void meetLights(RayKind kind, uint32_t depth) {
    LightHits h;
    sv_->lightHits(g_, &g_->paths, kind, paths_.count, paths_.live, &h);
    float* weight = make<float>(h.count);
    for (uint32_t i = 0; i < h.count; ++i) weight[i] = g_->paths.origin[h.slot[i]] & kFromDiscrete ? 1.f : 0.f;
    paths_.contribute(h, depth, weight);
  }

  // A point on each ray that is in media somewhere. What they emit there is contributed; where the path goes on from
  // there the ray's hit becomes that of the medium, and through_ the factor on the path, else that of the surface.
  void passMedia(uint32_t depth, bool goesOn) {
    if (!sv_->hasMedia) return;
    MediumIntervals in;
    sv_->mediumIntervals(g_, &g_->paths, paths_.count, paths_.live, &in);
    if (!in.count) return;
    Point* point = make<Point>(in.count);
    float* t = make<float>(in.count);
    uint32_t *ray = make<uint32_t>(in.count), n = 0;
    for (uint32_t i = 0; i < paths_.count; ++i) {
      uint32_t k = in.first[i];
      const uint32_t s = ray[n] = paths_.live[i], last = in.first[i + 1];
      if (k == last) continue;
      Float<1> u[4];
      for (uint32_t x = 0; x < 4; x += 2)
        draw2(sv_->samples, Int<1>(g_->paths.sampleSeed[s]), Int<1>(g_->paths.sampleIndex[s]),
              dimensionAt(depth) + kDimUser + x / 2, u[x], u[x + 1]);
      float length = 0;
      for (uint32_t x = k; x < last; ++x) length += in.to[x] - in.from[x];
      float rest = u[0].lane0() * length;
      for (; k + 1 < last && rest >= in.to[k] - in.from[k]; ++k) rest -= in.to[k] - in.from[k];
      t[n] = std::min(in.from[k] + rest, in.to[k]);
      // half of the paths scatter where there is a surface behind
      const float chance = g_->paths.hits.t[s] < 3e38f ? 0.5f : 1.f;
      const bool scatters = goesOn && u[1].lane0() < chance;
      if (!scatters)
        for (float* f : through_) f[s] /= 1 - chance;
      point[n++] = {length, scatters ? chance : 0.f, u[2].lane0()};
    }
    scatter(depth, n, ray, t, point);
  }

  void scatter(uint32_t depth, uint32_t n, const uint32_t* ray, const float* t, const Point* point) {
    // what media let through up to the points: shadow rays along the rays, from the vertices that these left
    float *o[3], *d[3], *T[3], *value[3], *time = make<float>(n);
    for (int k = 0; k < 3; ++k) {
      for (float** x : {&o[k], &d[k], &T[k], &value[k]}) *x = make<float>(n);
      for (uint32_t i = 0; i < n; ++i) {
        o[k][i] = g_->paths.rays.o[k][ray[i]], d[k][i] = g_->paths.rays.d[k][ray[i]];
        time[i] = g_->paths.rays.time[ray[i]];
      }
    }
    const ShadowRun run{nullptr, &g_->paths, n};
    const ShadowRays rays{n,       {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, t, time, ray, 1, &run,
                          nullptr, {T[0], T[1], T[2]}};
    sv_->shadow(g_, depth, &rays);
    MediaAt at;
    sv_->mediaAt(g_, &g_->paths, depth, n, ray, t, &at);
    uint32_t *state = make<uint32_t>(n), *light = make<uint32_t>(n), e = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = ray[i], first = e;
      float glow[3] = {0, 0, 0}, sum = 0, own = 0;
      for (; e < at.count && at.point[e] == i; ++e)
        for (int k = 0; k < 3; ++k) {
          sum += at.extinction[k][e];
          if (at.emission[0]) glow[k] += at.emission[k][e];
        }
      state[i] = paths_.state[s], light[i] = kNoLight;
      for (int k = 0; k < 3; ++k) value[k][i] = paths_.throughput[k][s] * T[k][i] * glow[k] * point[i].length;
      if (!(point[i].chance > 0)) continue;
      // one of the media, by what each of them takes
      uint32_t m = first;
      for (float rest = point[i].pick * sum; m < e; ++m, rest -= own) {
        own = at.extinction[0][m] + at.extinction[1][m] + at.extinction[2][m];
        if (rest < own || m + 1 == e) break;
      }
      g_->paths.hits.t[s] = HUGE_VALF;
      if (!(own > 0)) continue;  // empty there: it ends
      for (int k = 0; k < 3; ++k)
        through_[k][s] = T[k][i] * at.extinction[k][m] * point[i].length * sum / (own * point[i].chance);
      const Hits &x = at.list->hits, &y = g_->paths.hits;
      const auto copy = [&](const auto* from, auto* to) { to[s] = from[m]; };
      copy(x.t, y.t), copy(x.u, y.u), copy(x.v, y.v), copy(x.ng[0], y.ng[0]), copy(x.ng[1], y.ng[1]);
      copy(x.ng[2], y.ng[2]), copy(x.instance, y.instance), copy(x.geometry, y.geometry);
      copy(x.primitive, y.primitive), copy(x.level, y.level);
    }
    const Contributions out{n, ray, {value[0], value[1], value[2]}, state, light, LightKind::Arrives};
    if (at.emission[0]) sv_->contribute(g_, &out);
  }

  void sampleLights(const Context& c) {
    LightSamples ls;
    sv_->lightSamples(g_, &c, 0, 1, &ls);
    const EvaluateArgs e = evaluateBxdf(c, ls.wi);
    arrivals_.of(c);
    for (uint32_t i = 0; i < c.count; ++i) {
      if (!(ls.pdf[i] > 0)) continue;
      const Vec3<1> path = Vec3<1>::load(paths_.throughput, c.path[i]) / Float<1>(ls.pdf[i]);
      arrivals_.from(i, Vec3<1>::load(ls.wi, i), ls.distance[i], c.slotCount, 0, ls.light[i]);
      for (uint32_t l = 0; l < c.slotCount; ++l)
        arrivals_.add(path * Vec3<1>::load(ls.radiance, i) * Vec3<1>::load(e.weight[l], i) *
                          Float<1>(c.eventOfSlot[l] & 1 ? ls.specular[i] : ls.diffuse[i]),
                      stepState(sv_->paths, paths_.state[c.path[i]], c.eventOfSlot[l]), ls.light[i]);
    }
    arrivals_.send();
  }

  Group* g_;
  const Services* sv_;
  Subpaths<W> paths_;
  Arrivals<W> arrivals_;
  float* through_[3];  // by slot: factor on the path behind the ray
};

struct Haze {
  using Data = haze::Data;
  template <int W>
  static void integrate(const Data& data, uint32_t, Group& group, const Services& services) {
    HazePaths<W>(&group, &services).follow(data.bounces);
  }
};
KINORA_KERNELS_END

KINORA_INTEGRATOR(Haze, .help = "Path tracing through media, with distances of its own.", .params = kParams,
                  .setUp = setUp<Data>, .scattersInMedia = scatterInMedia)
