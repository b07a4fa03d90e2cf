// Thickness: an example integrator. From each point that the camera sees a ray goes into the object, in a direction
// drawn by the cosine; its way to the far side, mean by mean, is the picture. It shows rays from vertices in lists of
// their own: all hits on one object or on a set of objects, whatever else is in the way (Services::hitsOnObject).
//
// An object with holes or folds is met several times: what lies between the 2nd and 3rd hit, the 4th and 5th and so
// on is not inside. Chords of a sphere of radius r are 4/3 r long on average, wherever they begin.
#define KINORA_KERNEL_FILE "Thickness.cpp"
#include <kinora/integrator_author.h>
#include <kinora/camera_hits.h>

#if KINORA_PLAIN
#include <string>

namespace kinora::thickness {
enum : uint32_t { kScale, kTraceSet };
constexpr Param kParams[] = {
    param::number("scale", 1.f).range(0, 10).help("Value of the picture for a way of one scene unit."),
    param::string("traceSet", "")
        .traceSet()
        .help("Groups (grouping:membership) whose members count as one object; without it each object is one."),
};
struct Data {
  float scale;
  std::string traceSet;
  explicit Data(const CreateInfo& info) : scale(info.number(kScale)), traceSet(info.string(kTraceSet)) {}
};
constexpr uint32_t kMostHits = 16;  // of a chord; what lies beyond does not count
}  // namespace kinora::thickness
#endif

KINORA_KERNELS_BEGIN
using namespace thickness;

struct Thickness {
  using Data = thickness::Data;
  template <int W>
  static void integrate(const Data& data, uint32_t, Group& group, const Services& services) {
    const CameraHits hits(&group, &services);
    for (uint32_t k = 0; k < hits.contextCount; ++k) {
      const Context& c = *hits.contexts[k];
      float *o[3], *d[3], *tMax = hits.floats(c.padded), *time = hits.floats(c.padded),
                          *value = hits.floats(c.padded);
      uint32_t* point = hits.words(c.padded);
      for (int x = 0; x < 3; ++x) {
        o[x] = hits.floats(c.padded);
        d[x] = hits.floats(c.padded);
      }
      for (uint32_t i = 0; i < c.padded; i += W) {
        Float<W> u, v;
        draw2<W>(services.samples, Int<W>::load(c.sampleSeed + i), Int<W>::load(c.sampleIndex + i),
                 dimensionAt(0) + kDimUser, u, v);
        const Vec3<W> Ng = Vec3<W>::load(c.Ng, i);
        (Frame<W>(-Ng).toWorld(cosineHemisphere(u, v))).store(d, i);
        fma(Ng, -Float<W>::load(c.bias + i), Vec3<W>::load(c.P, i)).store(o, i);  // below the surface
        Float<W>(1e30f).store(tMax + i);
        Float<W>::load(c.time + i).store(time + i);
        Int<W>::lanes(int32_t(i)).store(point + i);
      }
      const Rays rays = raysAlong(o, d, tMax, time);
      ObjectHits met{};
      met.most = kMostHits;
      met.traceSet = data.traceSet.c_str();
      services.hitsOnObject(&group, &c, c.count, point, &rays, &met);
      for (uint32_t i = 0; i < c.padded; ++i) {
        value[i] = 0;
        if (i >= c.count) continue;
        // inside from the start to the first hit, from the second to the third ...
        const float* t = met.t + size_t(i) * kMostHits;
        float inside = 0;
        for (uint32_t h = 0; h < met.count[i]; h += 2) inside += h ? t[h] - t[h - 1] : t[0];
        value[i] = data.scale * inside;
      }
      float* rgb[3] = {value, value, value};
      hits.show(c, rgb);
    }
  }
};
KINORA_KERNELS_END

KINORA_INTEGRATOR(Thickness, .help = "How far it is through each visible object.", .params = kParams,
                  .setUp = setUp<Data>)
