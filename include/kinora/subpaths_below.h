// Subpaths of the camera that go below surfaces. Where they come out, and how they go on, is found as in the forward
// loop (path_below.h); light is brought there by whoever follows them. Nothing makes such a way from the light's end: in
// the books on densities a path begins anew where it comes out (PathDensities::beginAnew). Included per target.
#include <kinora/math/sampling.h>
#include <kinora/path_densities.h>
#include <kinora/ray_start.h>
#include <kinora/scatter_once.h>
#include <kinora/subpaths.h>
#include <kinora/subsurface.h>

#if defined(KINORA_SUBPATHS_BELOW_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SUBPATHS_BELOW_H_TARGET
#undef KINORA_SUBPATHS_BELOW_H_TARGET
#else
#define KINORA_SUBPATHS_BELOW_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
class SubpathsBelow {
 public:
  SubpathsBelow(Group* group, const Services* services, Subpaths<W>& paths, PathDensities& sums)
      : g_(group), sv_(services), paths_(paths), sums_(sums) {}

  // emerges(out): contexts of points where paths have come out, to be lit and scattered as others are, though they emit
  // nothing. scatters(once): points in the body at which paths scatter once, to be lit by light samples alone.
  template <class Emerges, class Scatters>
  void follow(const SunkPoints& sunk, const Emerges& emerges, const Scatters& scatters) {
    if (!sunk.count) return;
    const Context& in = *sunk.context;
    uint32_t *below = words(sunk.count), *once = words(sunk.count), *straight = words(sunk.count);
    uint32_t sinking = 0, turning = 0, crossing = 0;
    for (uint32_t i = 0; i < sunk.count; ++i) {
      const uint32_t p = sunk.points[i], flags = sunk.made.flags[p];
      if (!(flags & kSampleOnce))
        below[sinking++] = p;
      else if (flags & kSampleStraight)
        straight[crossing++] = p;
      else
        once[turning++] = p;
    }
    eachMediumBelow(sunk.made, sinking, below, words(sunk.count), [&](uint32_t which, uint32_t n, uint32_t* points) {
      const Emerged out = PathsBelow<W>(g_, sv_).follow(in, which, n, points, sunk.made, 0, 1, paths_.throughput);
      for (uint32_t k = 0; k < out.count; ++k)
        for (uint32_t i = 0; i < out.contexts[k]->count; ++i) sums_.beginAnew(out.contexts[k]->path[i]);
      if (out.count) emerges(out);
    });
    if (crossing) goStraight(sunk, crossing, straight);
    ScatterOnce<W> inBody(g_, sv_);
    if (!turning || !inBody.scatter(in, turning, once, sunk.made, 0, 1, paths_.throughput)) return;
    scatters(inBody);
    goOnFrom(inBody);
  }

 private:
  uint32_t* words(uint32_t n) const {
    return static_cast<uint32_t*>(sv_->alloc(g_, (padded(n) + kPad) * sizeof(uint32_t)));
  }
  float* floats(uint32_t n) const { return static_cast<float*>(sv_->alloc(g_, (padded(n) + kPad) * sizeof(float))); }

  // What they find behind the body they find alone.
  void goStraight(const SunkPoints& sunk, uint32_t n, const uint32_t* points) {
    const Context& in = *sunk.context;
    const auto out = ScatterOnce<W>(g_, sv_).pass(in, n, points, sunk.made, 0, 1, paths_.throughput);
    for (uint32_t i = 0; i < out.count; ++i) {
      const float o[3] = {out.o[0][i], out.o[1][i], out.o[2][i]}, d[3] = {out.d[0][i], out.d[1][i], out.d[2][i]};
      sums_.beginAnew(out.path[i]);
      paths_.goOn(out.path[i], o, d, out.at.radius[i], out.at.spread[i], in.eventOfSlot[sunk.made.slot[points[0]]],
                  kFromDiscrete | kFromSpecular | kFromTransmission, HUGE_VALF);
    }
    if (out.count) sv_->leave(g_, &g_->paths, &out.at, out.count, out.point, out.path, nullptr);
  }
  // One direction from each point where light samples have taken all that lights send there.
  void goOnFrom(const ScatterOnce<W>& once) {
    const Context& c = once.context();
    float *o[3], *d[3], *factor[3], *pdf = floats(c.count);
    for (int k = 0; k < 3; ++k) {
      o[k] = floats(c.count);
      d[k] = floats(c.count);
      factor[k] = floats(c.count);
    }
    uint32_t *point = words(c.count), *slot = words(c.count), n = 0;
    const uint32_t count = once.directions(point, o, d, pdf);
    once.leaveBody(count, point, o, d, nullptr, nullptr, factor);
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t s = c.path[i];
      bool brings = false;
      for (int k = 0; k < 3; ++k) brings |= (paths_.throughput[k][s] *= factor[k][i]) > 0;
      if (!brings) continue;
      const float from[3] = {o[0][i], o[1][i], o[2][i]}, along[3] = {d[0][i], d[1][i], d[2][i]};
      sums_.beginAnew(s, true);
      paths_.goOn(s, from, along, c.radius[i], spreadAfter(Float<1>(c.spread[i]), Float<1>(kInvTwoPi * 0.5f)).lane0(),
                  c.eventOfSlot[0], kFromSpecular, 0);
      slot[n] = s;
      point[n++] = i;
    }
    if (n) sv_->leave(g_, &g_->paths, &c, n, point, slot, nullptr);
  }

  Group* g_;
  const Services* sv_;
  Subpaths<W>& paths_;
  PathDensities& sums_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
