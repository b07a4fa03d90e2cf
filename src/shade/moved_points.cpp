// How parameters that patterns feed change along the surface (ContextFunctions::paramGradient). Patterns know values
// alone, so all that feeds the parameter runs again for the same points moved by a step, in two directions: a context
// each, whose places are the old ones and whose stored values go on by their slopes. Bumps in what feeds a bump move
// points that have moved already.
#include <algorithm>
#include <cmath>

#include "shade/context_host.h"

namespace kinora::shade {

struct MovedPoints {
  static constexpr int kDirections = 2;
  Context* context[kDirections];
  float* step[kDirections][3];  // by point, render space
};

namespace {

// A step is as long as the footprint, over which noises and textures are averages already. Where that is narrower than
// differences of float positions tell, it is this many times the distance that rays start off the surface.
constexpr float kLeastStepInBiases = 8;
// Of strands that distance is their thickness; this times a position's largest component is what floats may be off.
constexpr float kRounding = 1e-6f;

// The point moved by `step`, which is `along` of each edge; what it has been asked is not known of it.
Context* movedContext(const Context* c, const float* const step[3], const float* const along[2]) {
  ContextHost& from = ContextHost::of(c);
  Arena& arena = from.group->arena();
  const uint32_t n = c->padded;
  Context* moved = new (arena.allocate(sizeof(Context))) Context(*c);
  ContextHost* h = new (arena.allocate(sizeof(ContextHost))) ContextHost(from);
  moved->host = h;
  moved->closure = nullptr;
  h->born = arena.now();
  h->known = ContextHost::Known();
  h->startNetwork();
  h->surface.moveTo(moved, along);
  float *P[3], *N[3], *part[2] = {arena.make<float>(n), arena.make<float>(n)};
  // normals change with the facet, along which the step may be longer or shorter than in units of what the place is of
  const Value e1 = c->builtin(Builtin::FacetEdge1), e2 = c->builtin(Builtin::FacetEdge2),
              n1 = c->builtin(Builtin::DNEdge1), n2 = c->builtin(Builtin::DNEdge2);
  from.surface.kernels().alongEdges(n, e1.data, e2.data, step, part[0], part[1]);
  for (int k = 0; k < 3; ++k) {
    moved->P[k] = P[k] = arena.make<float>(n);
    moved->N[k] = N[k] = arena.make<float>(n);
  }
  for (uint32_t i = 0; i < n; ++i) {
    float l2 = 0;
    for (int k = 0; k < 3; ++k) {
      P[k][i] = c->P[k][i] + step[k][i];
      N[k][i] = c->N[k][i] + part[0][i] * n1.data[k][i] + part[1][i] * n2.data[k][i];
      l2 += N[k][i] * N[k][i];
    }
    const float inverse = l2 > 0 ? 1 / std::sqrt(l2) : 0;
    for (int k = 0; k < 3; ++k) N[k][i] = l2 > 0 ? N[k][i] * inverse : c->N[k][i];
  }
  return moved;
}

// Along the first texture coordinate and across it, in the plane of the edges.
const MovedPoints& movedPoints(const Context* c) {
  ContextHost& h = ContextHost::of(c);
  if (h.known.moved) return *h.known.moved;
  h.remember();
  Arena& arena = h.group->arena();
  const uint32_t n = c->padded;
  const Value tangent = c->builtin(Builtin::Tangent);
  const SurfaceArgs& args = h.surface.args();  // known before it is copied
  const float *const *e1 = h.surface.edge(0), *const *e2 = h.surface.edge(1);
  auto* moved = new (arena.allocate(sizeof(MovedPoints))) MovedPoints();
  for (int d = 0; d < MovedPoints::kDirections; ++d) {
    float* const* step = moved->step[d];
    for (float*& x : moved->step[d]) x = arena.make<float>(n);
    for (uint32_t i = 0; i < n; ++i) {
      float bias = c->bias[i];
      if (args.strand && args.strand[i])
        bias = std::min(bias,
                        kRounding * std::max({std::fabs(c->P[0][i]), std::fabs(c->P[1][i]), std::fabs(c->P[2][i])}));
      const float length = std::max(c->radius[i], kLeastStepInBiases * bias);
      for (int k = 0; k < 3; ++k) {
        const int x = (k + 1) % 3, y = (k + 2) % 3;
        step[k][i] = length * (d == 0 ? tangent.data[k][i]
                                      : c->N[x][i] * tangent.data[y][i] - c->N[y][i] * tangent.data[x][i]);
      }
    }
    float* along[2] = {arena.make<float>(n), arena.make<float>(n)};
    h.surface.kernels().alongEdges(n, e1, e2, step, along[0], along[1]);
    for (uint32_t i = 0; i < n; ++i)
      for (int k = 0; k < 3; ++k) step[k][i] = along[0][i] * e1[k][i] + along[1][i] * e2[k][i];
    moved->context[d] = movedContext(c, step, along);
  }
  h.known.moved = moved;
  return *moved;
}

}  // namespace

Value paramGradient(const Context* c, uint32_t index, uint32_t component) {
  ContextHost& h = ContextHost::of(c);
  Value out;
  if (c->traits & kTraitInSpace || !c->isConnected(index)) return out;
  const uint32_t n = c->padded;
  const Value here = c->param(index);
  const MovedPoints& moved = movedPoints(c);
  Value there[MovedPoints::kDirections];
  for (int d = 0; d < MovedPoints::kDirections; ++d) {
    ContextHost::of(moved.context[d]).node = h.node;
    there[d] = moved.context[d]->param(index);
  }
  float* g[3];
  for (int k = 0; k < 3; ++k) out.data[k] = g[k] = c->alloc<float>(n);
  out.components = 3;
  out.stride = 1;
  const auto at = [&](const Value& v, uint32_t i) {
    return v.data[std::min(component, v.components - 1)][v.stride ? i : 0];
  };
  for (uint32_t i = 0; i < n; ++i) {
    float e[2][3], gradient[3];
    for (int d = 0; d < MovedPoints::kDirections; ++d)
      for (int k = 0; k < 3; ++k) e[d][k] = moved.step[d][k][i];
    gradientOf(e[0], e[1], at(there[0], i) - at(here, i), at(there[1], i) - at(here, i), gradient);
    for (int k = 0; k < 3; ++k) g[k][i] = gradient[k];
  }
  return out;
}

}  // namespace kinora::shade
