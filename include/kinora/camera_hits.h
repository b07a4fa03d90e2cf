// First hits of a group's camera rays, shaded: what integrators that follow no paths begin with (occlusion,
// visualisation, checks). Traces, marks alpha and makes contexts. Included per target.
#include <kinora/integrator.h>
#include <kinora/random.h>
#include <kinora/simd/wide.h>

#if defined(KINORA_CAMERA_HITS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CAMERA_HITS_H_TARGET
#undef KINORA_CAMERA_HITS_H_TARGET
#else
#define KINORA_CAMERA_HITS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

class CameraHits {
 public:
  CameraHits(Group* group, const Services* services) : group_(group), services_(services) {
    uint32_t* live = words(group->padded + kPad);
    float* through[3] = {floats(group->padded + kPad), floats(group->padded + kPad), floats(group->padded + kPad)};
    for (uint32_t i = 0; i < group->padded; ++i) live[i] = i < group->count ? i : group->count - 1;
    services->trace(group, &group->paths, RayKind::Camera, 0, group->count, live, through);
    for (uint32_t i = 0; i < group->count; ++i)
      if (group->paths.hits.t[i] < 3e38f) live[count++] = i;
    for (uint32_t i = count; count && i < padded(count); ++i) live[i] = live[count - 1];
    slots = live;
    if (!count) return;
    float* alpha = floats(padded(count));
    for (uint32_t i = 0; i < padded(count); ++i) alpha[i] = 1;
    services->cover(group, count, slots, alpha);
    contextCount =
        services->shade(group, &group->paths, kTraitEyePath | kTraitPrimaryHit, 0, count, slots, &contexts);
  }

  // The numbers by which a context's bxdf chooses direction `part` of `parts` (GenerateArgs::u).
  template <int W>
  void bxdfNumbers(const Context& c, uint32_t part, uint32_t parts, float* u[4]) const {
    for (int k = 0; k < 4; ++k) u[k] = floats(c.padded);
    for (uint32_t i = 0; i < c.padded; i += W) {
      const Int<W> seed = Int<W>::load(c.sampleSeed + i);
      const Int<W> sample = Int<W>::load(c.sampleIndex + i) * Int<W>(parts) + Int<W>(part);
      Float<W> a, b;
      draw2(services_->samples, seed, sample, subSampled(dimensionAt(0) + kDimBxdf, part, parts), a, b);
      a.store(u[0] + i);
      b.store(u[1] + i);
      draw2(services_->samples, seed, sample, subSampled(dimensionAt(0) + kDimLobe, part, parts), a, b);
      a.store(u[2] + i);
      b.store(u[3] + i);
    }
  }

  // Adds a colour at each point of a context to the picture, as light that the surface gives off: times the camera's
  // weight of the sample (vignetting), which the rows hold afterwards.
  void show(const Context& c, float* const rgb[3]) const { show(c, rgb, services_->paths.start); }
  // The same as light that the slot's lobe scatters on its way to the camera.
  void showSlot(const Context& c, uint32_t slot, float* const rgb[3]) const {
    const PathStates& paths = services_->paths;
    show(c, rgb, paths.next[paths.start * paths.eventCount + c.eventOfSlot[slot]]);
  }
  // The same in any state of light path expressions.
  void show(const Context& c, float* const rgb[3], uint32_t pathState) const {
    uint32_t *state = words(c.padded), *light = words(c.padded);
    for (uint32_t i = 0; i < c.padded; ++i) {
      for (int k = 0; k < 3; ++k) rgb[k][i] *= group_->rayWeight[c.path[i]];
      state[i] = pathState;
      light[i] = kNoLight;
    }
    const Contributions out{c.count, c.path, {rgb[0], rgb[1], rgb[2]}, state, light};
    services_->contribute(group_, &out);
  }

  // A colour for every point: fill(context, rgb) has the rows of a context's points, all 0, to be filled.
  template <class Fill>
  void showAll(Fill&& fill) const {
    for (uint32_t k = 0; k < contextCount; ++k) {
      const Context& c = *contexts[k];
      float* rgb[3] = {floats(c.padded), floats(c.padded), floats(c.padded)};
      for (float* row : rgb)
        for (uint32_t i = 0; i < c.padded; ++i) row[i] = 0;
      fill(c, rgb);
      show(c, rgb);
    }
  }

  float* floats(uint32_t n) const { return static_cast<float*>(services_->alloc(group_, n * sizeof(float))); }
  uint32_t* words(uint32_t n) const { return static_cast<uint32_t*>(services_->alloc(group_, n * sizeof(uint32_t))); }

  uint32_t count = 0;  // slots whose ray hit a surface
  const uint32_t* slots = nullptr;
  uint32_t contextCount = 0;
  Context* const* contexts = nullptr;

 private:
  Group* group_;
  const Services* services_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
