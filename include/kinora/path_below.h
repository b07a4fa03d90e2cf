// Paths of the forward loop that go below a surface: light where they come out of it or scatter in it, and the
// directions in which they leave it. subsurface.h and scatter_once.h bring them there. Included per target.
#include <kinora/math/sampling.h>
#include <kinora/path_state.h>
#include <kinora/random.h>
#include <kinora/scatter_once.h>
#include <kinora/subsurface.h>

#if defined(KINORA_PATH_BELOW_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PATH_BELOW_H_TARGET
#undef KINORA_PATH_BELOW_H_TARGET
#else
#define KINORA_PATH_BELOW_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Lights: VertexLights, by which the points where paths come out are lit as all others.
template <int W, class Lights>
class SunkPaths {
 public:
  SunkPaths(PathState<W>& paths, Lights& lights)
      : p_(paths), g_(paths.g), sv_(paths.sv), o_(paths.o), lights_(lights) {}

  // Paths below the surface, medium by medium of the material: light where they come out, and their next directions from
  // there. They are still at the vertex where they went in, of which each followed `parts` directions; slots that go on
  // are appended to `live`. `points` are put in another order.
  uint32_t followBelow(const Context& in, uint32_t n, uint32_t* points, const GenerateArgs& made, uint32_t depth,
                       uint32_t part, uint32_t parts, uint32_t* live, uint32_t m) {
    eachMediumBelow(made, n, points, p_.words(in.padded + kPad), [&](uint32_t which, uint32_t taken, uint32_t* of) {
      m = followMedium(in, which, taken, of, made, depth, part, parts, live, m);
    });
    return m;
  }

  // Paths that scatter once below the surface, in the same way: light where they scatter, and one direction from there.
  // Lights that it meets beyond the body are weighed against light samples as seen from within.
  uint32_t followOnce(const Context& in, uint32_t n, uint32_t* points, const GenerateArgs& made, uint32_t depth,
                      uint32_t part, uint32_t parts, uint32_t* live, uint32_t m) {
    uint32_t *clear = p_.words(in.padded + kPad), straight = 0, turned = 0;
    for (uint32_t i = 0; i < n; ++i) {
      if (made.flags[points[i]] & kSampleStraight)
        clear[straight++] = points[i];
      else
        points[turned++] = points[i];
    }
    n = turned;
    if (straight) m = followStraight(in, straight, clear, made, part, parts, live, m);
    ScatterOnce<W> once(g_, sv_);
    if (!once.scatter(in, n, points, made, part, parts, p_.throughput)) return m;
    const Context& c = once.context();
    Context* const contexts[] = {const_cast<Context*>(&c)};
    const auto scale = [&](float by) {
      for (uint32_t i = 0; parts > 1 && i < c.count; ++i)
        for (float* t : p_.throughput) t[c.path[i]] *= by;
    };
    float* share = p_.share;
    p_.share = nullptr;
    scale(1.f / float(parts));
    lights_.sample(1, contexts, depth, depth == 0 ? o_.lightSamples : 1, 1, &once);
    scale(float(parts));
    p_.share = share;
    float *o[3], *d[3], *factor[3];
    const uint32_t room = c.padded + kPad;
    for (int k = 0; k < 3; ++k) {
      o[k] = p_.floats(room);
      d[k] = p_.floats(room);
      factor[k] = p_.floats(room);
    }
    uint32_t *point = p_.words(room), *slot = p_.words(room), leaving = 0;
    float *pdf = p_.floats(room), *begin[3] = {p_.floats(room), p_.floats(room), p_.floats(room)};
    const uint32_t count = once.directions(point, o, d, pdf);
    for (int k = 0; k < 3; ++k)
      for (uint32_t i = 0; i < count; ++i) begin[k][i] = o[k][i];
    once.leaveBody(count, point, o, d, nullptr, nullptr, factor);
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t s = c.path[i];
      bool brings = false;
      for (int k = 0; k < 3; ++k) brings |= (p_.throughput[k][s] *= factor[k][i]) > 0;
      if (!brings) continue;
      for (int k = 0; k < 3; ++k) {
        r.o[k][s] = o[k][i];
        r.d[k][s] = d[k][i];
      }
      uint32_t flags = uint32_t(kFromSpecular) | PathFlags::kFromBody;
      if (!o_.allowCaustics) flags |= PathFlags::kHadDiffuse | uint32_t(kFromTintedLight);
      p_.pdf[s] = pdf[i] / float(parts);
      float length = 0;
      for (int k = 0; k < 3; ++k) {
        p_.begin[k][s] = begin[k][i];
        length += (o[k][i] - begin[k][i]) * d[k][i];
      }
      p_.behind[s] = length;
      r.tMax[s] = o_.farthest;
      r.radius[s] = c.radius[i];
      r.spread[s] = spreadAfter(Float<1>(c.spread[i]), Float<1>(kInvTwoPi * 0.5f)).lane0();
      p_.state[s] = sv_->paths.next[p_.state[s] * sv_->paths.eventCount + c.eventOfSlot[0]];
      p_.flags[s] = flags;
      live[m++] = s;
      slot[leaving] = s;
      point[leaving++] = i;
    }
    if (leaving) sv_->leave(g_, &g_->paths, &c, leaving, point, slot, nullptr);
    return m;
  }

  // The rays of `live` are ended: the next ones begin where they leave a surface.
  void endWithin(uint32_t n, const uint32_t* live) {
    for (uint32_t i = 0; i < n; ++i)
      if (p_.flags[live[i]] & PathFlags::kFromBody) p_.behind[live[i]] = 0;
  }

 private:
  // Of one medium of the material: see Subsurface::which.
  uint32_t followMedium(const Context& in, uint32_t which, uint32_t n, const uint32_t* points,
                        const GenerateArgs& made, uint32_t depth, uint32_t part, uint32_t parts, uint32_t* live,
                        uint32_t m) {
    using F = Float<W>;
    const Emerged out = PathsBelow<W>(g_, sv_).follow(in, which, n, points, made, part, parts, p_.throughput);
    const auto scale = [&](float by) {
      for (uint32_t k = 0; parts > 1 && k < out.count; ++k)
        for (uint32_t i = 0; i < out.contexts[k]->count; ++i)
          for (float* t : p_.throughput) t[out.contexts[k]->path[i]] *= by;
    };
    scale(1.f / float(parts));
    const uint32_t lightParts = depth == 0 ? o_.lightSamples : 1;
    lights_.sample(out.count, out.contexts, depth, lightParts, 1);
    lights_.walk(out.count, out.contexts, depth);
    scale(float(parts));
    for (uint32_t k = 0; k < out.count; ++k) {
      const Context& c = *out.contexts[k];
      uint32_t *point = p_.words(c.padded + kPad), *slot = p_.words(c.padded + kPad), leaving = 0;
      for (uint32_t i = 0; i < c.count; i += W) {
        Mask<W> on = Mask<W>::firstN(int(c.count - i < W ? c.count - i : W));
        const Slots<W> s = Slots<W>::load(c.path + i);
        F a, b;
        draw2(sv_->samples, Int<W>::load(c.sampleSeed + i),
              Int<W>::load(c.sampleIndex + i) * Int<W>(parts) + Int<W>(part),
              subSampled(dimensionAt(depth) + kDimBelow, part, parts), a, b);
        const Vec3<W> local = cosineHemisphere(a, b), Ng = Vec3<W>::load(c.Ng, i);
        const Vec3<W> w = Frame<W>(Vec3<W>::load(c.N, i)).toWorld(local);
        on =
            on & (dot(Ng, w) > F(0.f)) & (local.z > F(0.f)) & (maxComponent(Vec3<W>::get(p_.throughput, s)) > F(0.f));
        if (on.none()) continue;
        const F p = local.z * F(kInvPi);
        p_.send(on, c, i, s, w);
        s.put(on, p * F(1.f / float(parts)), p_.pdf);  // FoundLights reckons with `parts` directions from one place
        s.put(on, spreadAfter(F::load(c.spread + i), p), g_->paths.rays.spread);
        p_.step(on, s, Int<W>(uint32_t(c.eventOfSlot[0])));
        const Int<W> walked = p_.walkedAfter(c, i, s, Int<W>(0), Mask<W>(false));
        s.put(on, o_.allowCaustics ? walked : walked | p_.withoutCaustics(c, i, s, w, Int<W>(0), Mask<W>(false)),
              p_.flags);
        const Packer<W> pack(on);
        pack.put(s.s, live + m);
        pack.put(s.s, slot + leaving);
        pack.put(Int<W>::lanes(int32_t(i)), point + leaving);
        m += uint32_t(pack.count);
        leaving += uint32_t(pack.count);
      }
      if (leaving) sv_->leave(g_, &g_->paths, &c, leaving, point, slot, nullptr);
    }
    return m;
  }

  // Paths that go straight through the body, as through clear glass: what they find behind it they find alone.
  uint32_t followStraight(const Context& in, uint32_t n, const uint32_t* points, const GenerateArgs& made,
                          uint32_t part, uint32_t parts, uint32_t* live, uint32_t m) {
    const auto out = ScatterOnce<W>(g_, sv_).pass(in, n, points, made, part, parts, p_.throughput);
    if (!out.count) return m;
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < out.count; ++i) {
      const uint32_t s = out.path[i];
      for (int k = 0; k < 3; ++k) {
        r.o[k][s] = out.o[k][i];
        r.d[k][s] = out.d[k][i];
      }
      p_.pdf[s] = 1;
      r.tMax[s] = o_.farthest;
      r.radius[s] = out.at.radius[i];
      r.spread[s] = out.at.spread[i];
      p_.state[s] = sv_->paths.next[p_.state[s] * sv_->paths.eventCount + in.eventOfSlot[made.slot[points[0]]]];
      uint32_t flags = kFromDiscrete | kFromSpecular | kFromTransmission;
      if (!o_.allowCaustics && p_.flags[s] & PathFlags::kHadDiffuse)
        flags |= PathFlags::kHadDiffuse | PathFlags::kCaustic;
      p_.flags[s] = flags;
      live[m++] = s;
    }
    sv_->leave(g_, &g_->paths, &out.at, out.count, out.point, out.path, nullptr);
    return m;
  }

  PathState<W>& p_;
  Group* g_;
  const Services* sv_;
  const PathLoopOptions& o_;
  Lights& lights_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
