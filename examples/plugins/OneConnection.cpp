// OneConnection: an example integrator, bidirectional. A light path runs beside each camera path; the first stage
// stores its vertices. In the second each vertex of the camera path is connected to a light and to one vertex of its
// light path; all ways to find the same path share it by their densities. Caustics of lights that nothing can hit are
// missing, as in any path tracer.
//
// What services do runs in lanes; the little in between is written a point at a time.
#define KINORA_KERNEL_FILE "OneConnection.cpp"
#include <kinora/integrator_author.h>
#include <kinora/path_densities.h>
#include <kinora/subpaths.h>

#if KINORA_PLAIN
#include <algorithm>
namespace kinora::oneConnection {
enum : uint32_t { kBounces };
constexpr Param kParams[] = {
    param::integer("maxIndirectBounces", 4).range(0, 12).help("Bounces beyond the first surface."),
};
struct Data {
  uint32_t bounces;
  explicit Data(const CreateInfo& info) : bounces(uint32_t(info.integer(kBounces))) {}
};
struct Stored {
  PathVertex at;
  PathSums sums;
};
inline uint32_t stages(const void*, Stage* out, uint32_t) {
  out[0] = {StageKind::LightPaths, 1};
  out[1] = {StageKind::CameraPaths, 0};
  return 2;
}
inline uint32_t lists(const void*, RecordList* out, uint32_t) {
  out[0] = {sizeof(Stored), 0};  // written by stage 0
  return 1;
}
}  // namespace kinora::oneConnection
#endif

KINORA_KERNELS_BEGIN
using namespace oneConnection;
using V = Vec3<1>;

template <int W>
class Bidirectional {
 public:
  Bidirectional(Group* group, const Services* services, uint32_t traits, uint32_t bounces)
      : g_(group),
        sv_(services),
        bounces_(bounces),
        paths_(group, services, traits),
        sums_(group, services),
        arrivals_(group, services) {}

  void lightStage() {
    paths_.startAtLights();
    for (uint32_t depth = 0; paths_.count && depth < bounces_; ++depth) {
      Context* const* contexts;
      paths_.trace(depth);
      const uint32_t count = paths_.shade(depth, &contexts);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        depth ? sums_.arrive(c) : sums_.begin(g_, sv_, c, paths_.light);
        const PathVertex* vertices = paths_.vertices(c, depth);
        Stored* records = c.alloc<Stored>(c.count);
        for (uint32_t i = 0; i < c.count; ++i) records[i] = {vertices[i], sums_[c.path[i]]};
        sv_->append(g_, 0, c.count, c.path, records);
        sums_.leave(c, paths_.scatter(c, depth));
      }
    }
  }

  void cameraStage() {
    paths_.startAtCamera();
    for (uint32_t depth = 0; paths_.count; ++depth) {
      Context* const* contexts;
      paths_.trace(depth);
      meetLights(depth);
      if (depth > bounces_) return;
      const uint32_t count = paths_.shade(depth, &contexts);
      for (uint32_t k = 0; k < count; ++k) {
        const Context& c = *contexts[k];
        sums_.arrive(c);
        paths_.contributeEmission(c);
        connectLights(c);
        connectPaths(c, depth);
        sums_.leave(c, paths_.scatter(c, depth));
      }
    }
  }

 private:
  // Lights that camera paths meet by chance.
  void meetLights(uint32_t depth) {
    LightHits h;
    sv_->lightHits(g_, &g_->paths, depth ? RayKind::Indirect : RayKind::Camera, paths_.count, paths_.live, &h);
    const LightDensities light(g_, sv_, h);
    float* weight = static_cast<float*>(sv_->alloc(g_, (h.count + 1) * sizeof(float)));
    for (uint32_t i = 0; i < h.count; ++i) weight[i] = 1 / (1 + othersOfHit(sums_[h.slot[i]], h.pdf[i], light, i));
    paths_.contribute(h, depth, weight);
  }

  // A light sample at each point.
  void connectLights(const Context& c) {
    LightSamples ls;
    sv_->lightSamples(g_, &c, 0, 1, &ls);
    const LightDensities light(g_, sv_, c, ls.wi, ls.t, ls.light);
    const EvaluateArgs e = evaluateBxdf(c, ls.wi);
    arrivals_.of(c);
    for (uint32_t i = 0; i < c.count; ++i) {
      if (!(ls.pdf[i] > 0)) continue;
      const uint32_t s = c.path[i];
      const V wi = V::load(ls.wi, i);
      using F = Float<1>;
      const float others =
          othersOfSample(sums_.at(Int<1>(s)), c, i, wi, F(e.pdf[i]), F(e.pdfReverse[i]), light, F(0.f)).lane0();
      const V share = V::load(paths_.throughput, s) / Float<1>(ls.pdf[i] * (1 + others));
      const V arriving = share * V::load(ls.radiance, i);
      const V glossy = ls.specularRadiance[0] ? share * V::load(ls.specularRadiance, i) : arriving;
      arrivals_.from(i, wi, ls.distance[i], c.slotCount, ls.spread ? ls.spread[i] : 0, ls.light[i]);
      for (uint32_t l = 0; l < c.slotCount; ++l) {
        const float factor = c.eventOfSlot[l] & 1 ? ls.specular[i] : ls.diffuse[i];
        arrivals_.add((c.eventOfSlot[l] & 1 ? glossy : arriving) * V::load(e.weight[l], i) * Float<1>(factor),
                      stepState(sv_->paths, paths_.state[s], c.eventOfSlot[l]), ls.light[i]);
      }
    }
    arrivals_.send();
  }

  // A connection of each point to one vertex of its light path, chosen uniformly.
  void connectPaths(const Context& c, uint32_t depth) {
    uint64_t *number = c.alloc<uint64_t>(c.count), *first = c.alloc<uint64_t>(c.count);
    uint32_t *found = c.alloc<uint32_t>(c.count), *point = c.alloc<uint32_t>(c.count), n = 0;
    for (uint32_t i = 0; i < c.count; ++i) number[i] = g_->number[c.path[i]];
    sv_->findStored(g_, 0, c.count, number, c.sampleIndex, first, found);
    const Stored *all = static_cast<const Stored*>(sv_->stored(g_, 0).records),
                 **ends = c.alloc<const Stored*>(c.count);
    VertexRecord* vertices = c.alloc<VertexRecord>(c.count);
    for (uint32_t i = 0; i < c.count; ++i) {
      found[i] = std::min(found[i], bounces_ - depth);  // no longer paths than the camera's own
      if (!found[i]) continue;
      Float<1> u, unused;
      draw2(sv_->samples, Int<1>(c.sampleSeed[i]), Int<1>(c.sampleIndex[i]), dimensionAt(depth) + kDimUser, u,
            unused);
      ends[n] = all + first[i] + uint32_t(u.lane0() * float(found[i]));
      vertices[n] = ends[n]->at.vertex;
      point[n++] = i;
    }
    if (!n) return;
    const Connections to(g_, sv_, c, n, point, vertices);
    arrivals_.of(c);
    for (uint32_t r = 0; r < n; ++r) {
      const uint32_t i = point[r], s = c.path[i], j = to.end[r].point;
      const Context& end = *to.end[r].context;
      const EvaluateArgs &e = to.bxdf, &f = *to.end[r].bxdf;
      const PathVertex& at = ends[r]->at;
      const V d = V::load(to.d, i);
      const float others =
          othersOfConnection(to.distance[r], {sums_[s], f.pdf[j], surfaceCosine(c, i, d), e.pdfReverse[i]},
                             {ends[r]->sums, e.pdf[i], surfaceCosine(end, j, d), f.pdfReverse[j]});
      const Float<1> share =
          adjointFactor(end, j, -d) * Float<1>(float(found[i]) / (to.distance[r] * to.distance[r] * (1 + others)));
      const V arriving =
          V::load(paths_.throughput, s) * V(at.throughput[0], at.throughput[1], at.throughput[2]) * share;
      const V way = to.between(c, r);
      const Float<1> reach = max(length(way), Float<1>(1e-18f));
      arrivals_.from(i, way / reach, reach.lane0(), c.slotCount * end.slotCount);
      for (uint32_t l = 0; l < c.slotCount; ++l)
        for (uint32_t m = 0; m < end.slotCount; ++m)
          arrivals_.add(arriving * V::load(e.weight[l], i) * V::load(f.weight[m], j) *
                            Float<1>(at.factorOf(end.eventOfSlot[m])),
                        stepState(sv_->paths, stepState(sv_->paths, paths_.state[s], c.eventOfSlot[l]),
                                  end.eventOfSlot[m], at.tail),
                        at.light);
    }
    arrivals_.send();
  }

  Group* g_;
  const Services* sv_;
  uint32_t bounces_;
  Subpaths<W> paths_;
  PathDensities sums_;
  Arrivals<W> arrivals_;
};

struct OneConnection {
  using Data = oneConnection::Data;
  template <int W>
  static void integrate(const Data& data, uint32_t, Group& group, const Services& services) {
    if (group.stage == StageKind::LightPaths)
      Bidirectional<W>(&group, &services, kTraitLightPath, data.bounces).lightStage();
    else
      Bidirectional<W>(&group, &services, kTraitEyePath, data.bounces).cameraStage();
  }
};
KINORA_KERNELS_END

KINORA_INTEGRATOR(OneConnection, .help = "Bidirectional path tracing with one connection a vertex.",
                  .params = kParams, .setUp = setUp<Data>, .stages = stages, .lists = lists)
