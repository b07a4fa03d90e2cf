// PxrDefault: every surface lit from the eye, for a first look at scenes without lights. No shadows, no bounces: the
// bxdf answers for light coming from where it is seen (radiance pi, so that a white diffuse surface facing the eye is
// white).
#define KINORA_KERNEL_FILE "plugins/integrator/PxrDefault/PxrDefault.cpp"
#include <kinora/integrator_author.h>

KINORA_KERNELS_BEGIN

struct Runner {
  template <int W>
  static void integrate(const void*, uint32_t, Group* g, const Services* sv) {
    const auto floats = [&](uint32_t n) { return static_cast<float*>(sv->alloc(g, n * sizeof(float))); };
    const auto words = [&](uint32_t n) { return static_cast<uint32_t*>(sv->alloc(g, n * sizeof(uint32_t))); };
    uint32_t* live = words(g->padded + kPad);
    for (uint32_t i = 0; i < g->padded; ++i) live[i] = i < g->count ? i : g->count - 1;
    sv->trace(g, &g->paths, RayKind::Camera, 0, g->count, live, nullptr);
    uint32_t hits = 0;
    for (uint32_t i = 0; i < g->count; ++i) {
      live[hits] = live[i];
      hits += g->paths.hits.t[live[i]] < 3e38f;
    }
    for (uint32_t i = hits; hits && i < padded(hits); ++i) live[i] = live[hits - 1];
    Context* const* contexts;
    const uint32_t count = sv->shade(g, &g->paths, kTraitEyePath | kTraitPrimaryHit, 0, hits, live, &contexts);
    for (uint32_t k = 0; k < count; ++k) {
      const Context& c = *contexts[k];
      EvaluateArgs e{};
      for (int x = 0; x < 3; ++x) e.wi[x] = c.wo[x];
      for (uint32_t l = 0; l < c.slotCount; ++l)
        for (int x = 0; x < 3; ++x) e.weight[l][x] = floats(c.padded);
      e.pdf = floats(c.padded);
      c.bxdf->evaluate(&c, c.closure, &e);
      float* glow[3];
      for (float*& x : glow) x = floats(c.padded);
      const bool glows = c.bxdf->emission != nullptr;
      if (glows) c.bxdf->emission(&c, c.closure, glow);
      uint32_t* state = static_cast<uint32_t*>(sv->alloc(g, c.padded * sizeof(uint32_t)));
      uint32_t* light = words(c.padded);
      for (uint32_t i = 0; i < c.padded; ++i) light[i] = kNoLight;
      const auto weigh = [&](float* const rgb[3], float factor) HWY_ATTR {
        for (uint32_t i = 0; i < c.padded; i += W)
          (Vec3<W>::load(rgb, i) * (gather(g->rayWeight, Int<W>::load(c.path + i)) * Float<W>(factor))).store(rgb, i);
      };
      for (uint32_t l = 0; l < c.slotCount; ++l) {
        weigh(e.weight[l], kPi);
        for (uint32_t i = 0; i < c.padded; ++i)
          state[i] = sv->paths.next[sv->paths.start * sv->paths.eventCount + c.eventOfSlot[l]];
        const Contributions out{c.count, c.path, {e.weight[l][0], e.weight[l][1], e.weight[l][2]}, state, light};
        sv->contribute(g, &out);
      }
      if (glows) {
        weigh(glow, 1);
        for (uint32_t i = 0; i < c.padded; ++i) state[i] = sv->paths.start;
        const Contributions out{c.count, c.path, {glow[0], glow[1], glow[2]}, state, light};
        sv->contribute(g, &out);
      }
    }
  }
  template <int W>
  static constexpr IntegratorFunctions table() {
    return IntegratorFunctions{&integrate<W>};
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(PxrDefault, Runner, IntegratorPlugin,
              .help = "A headlight: each surface lit from the eye, for scenes without lights.")
