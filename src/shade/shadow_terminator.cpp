// Coarse polygons with smooth normals shade themselves in steps near the terminator: facets that are turned away from
// a light shadow themselves although their normals look at it. Their shadow rays start from the smooth surface that
// the normals mean: the hit point projected to the tangent planes of the triangle's corners, interpolated (J. Hanika,
// "Hacking the shadow terminator", Ray Tracing Gems II, 2021, chapter 4).
//
// That surface is a guess, so it counts only where it is a good one and where it is needed:
// - Corner normals lean little from the facet, and the offset is small against the triangle. Else they were averaged
// over
//   hard edges, and the smooth surface is not what the shape is.
// - The light lies behind the facet or grazes it: nothing convex shadows facets that face the light, and what an offset
//   passes by no longer casts its shadow.
// - Nothing lies between the facet and the smooth surface.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/context_host.h"

namespace kinora::shade {
namespace {

// Sine of a light's elevation over the facet from which on it is clearly seen, as far as shadows of the mesh on
// itself go.
constexpr float kFacing = 0.1f;

float dot3(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// 1 up to `full`, 0 from `none` on.
float fade(float x, float full, float none) { return std::clamp((none - x) / (none - full), 0.f, 1.f); }

}  // namespace

void GroupState::moveShadowOrigins(ShadowRays* rays) {
  const uint32_t n = rays->count, m = padded(n);
  const auto f = [&] { return arena_.make<float>(m); };
  // the few near the terminator, from their facets to where they would start
  float *o[3] = {}, *d[3] = {}, *length = nullptr, *time = nullptr;
  uint32_t *point = nullptr, *list = nullptr, count = 0;
  ShadowRun* runs = arena_.make<ShadowRun>(rays->runCount);
  uint32_t runCount = 0;
  forEachRun(*rays, [&](const ShadowRun& run, const VertexState& left, uint32_t first) {
    for (uint32_t i = first; i < run.end; ++i) {
      const uint32_t s = rays->point[i];
      const float offset[3] = {left.terminatorOffset[0][s], left.terminatorOffset[1][s], left.terminatorOffset[2][s]};
      const float l2 = dot3(offset, offset);
      if (!(l2 > 0)) continue;
      float side = 0, facing = 0;
      for (int k = 0; k < 3; ++k) {
        side += rays->d[k][i] * left.Ng[k][s];
        facing += rays->d[k][i] * left.facet[k][s];
      }
      const float part = fade(facing, 0, kFacing);
      if (!(side > 0) || !(part > 0)) continue;  // light that comes through the surface; light that is clearly seen
      if (!list) {
        for (int k = 0; k < 3; ++k) o[k] = f(), d[k] = f();
        length = f();
        time = f();
        point = arena_.make<uint32_t>(m);
        list = arena_.make<uint32_t>(m);
      }
      const float l = std::sqrt(l2);
      for (int k = 0; k < 3; ++k) {
        o[k][count] = rays->o[k][i];
        d[k][count] = offset[k] / l;
      }
      length[count] = part * l;
      time[count] = rays->time[i];
      point[count] = s;
      list[count++] = i;
    }
    runs[runCount++] = {run.context, run.list, count};
  });
  if (!count) return;
  uint32_t* blocked = arena_.make<uint32_t>(m);
  occluded({count, {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, length, time, point, runCount, runs, nullptr, {}}, blocked,
           true);

  float *from[3], *to[3], *tMax = f();
  for (int k = 0; k < 3; ++k) {
    from[k] = f();
    to[k] = f();
    std::memcpy(from[k], rays->o[k], n * sizeof(float));
    std::memcpy(to[k], rays->d[k], n * sizeof(float));
    rays->o[k] = from[k];
    rays->d[k] = to[k];
  }
  std::memcpy(tMax, rays->tMax, n * sizeof(float));
  rays->tMax = tMax;
  for (uint32_t j = 0; j < count; ++j) {
    if (blocked[j]) continue;
    const uint32_t i = list[j];
    // the end stays where it is, or the ray would pass through what the light hangs from
    double end[3], t2 = 0;
    for (int k = 0; k < 3; ++k) {
      const float step = length[j] * d[k][j];
      from[k][i] += step;
      end[k] = double(to[k][i]) * tMax[i] - step;
      t2 += end[k] * end[k];
    }
    if (!(t2 > 0) || std::isinf(tMax[i])) continue;  // infinitely far: all directions are the same
    const double t = std::sqrt(t2);
    for (int k = 0; k < 3; ++k) to[k][i] = float(end[k] / t);
    tMax[i] = float(t);
  }
}

void GroupState::findTerminatorOffsets(const Context* c, float* const Ng[3]) {
  ContextHost& h = ContextHost::of(c);
  TerminatorArgs a{h.surface.meshArgs(), c->entering, {c->N[0], c->N[1], c->N[2]}, {Ng[0], Ng[1], Ng[2]}, {}, {}};
  for (int k = 0; k < 3; ++k) {
    a.facet[k] = h.state.facet[k];
    a.terminatorOffset[k] = h.state.terminatorOffset[k];
  }
  h.surface.kernels().terminatorOffsets(a);
}

}  // namespace kinora::shade
