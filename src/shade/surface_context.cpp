// What a context's points have been asked about their surface, kept for its life.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/context_host.h"

namespace kinora::shade {

void SurfacePoints::begin(GroupState& group, const Context* c, bool hasQuads) {
  group_ = &group;
  c_ = c;
  args_.n = c->padded;
  args_.world = &group.world();
  args_.at = c->place;
  args_.time = c->time;
  kernels_ = &surfaceKernels(group.world().width);
  args_.isByParameter = group.world().placesByParameter;
  quadsWait_ = hasQuads;
  if (hasQuads && group.world().world->hasUserGeometry()) args_.facet = findFacets(group, args_);
}

void SurfacePoints::findQuads() {
  ContextHost::of(c_).remember();
  quadsWait_ = false;
  float *u = floats(), *v = floats();
  findQuadPlaces(*group_, args_, u, v);
  args_.quad[0] = u;
  args_.quad[1] = v;
}

void SurfacePoints::limitFootprints(float* radius) const {
  for (uint32_t i = 0; args_.facet && i < args_.n; ++i)
    if (args_.facet[i]) radius[i] = std::min(radius[i], args_.facet[i]->radius);
}

float* SurfacePoints::floats() const { return group_->arena().make<float>(args_.n); }

const SurfaceArgs& SurfacePoints::withStrands() {
  ContextHost::of(c_).remember();
  strandsAsked_ = true;
  meshArgs();
  const trace::World& w = *args_.world->world;
  if (!w.hasStrands()) return args_;
  const Program* program = ContextHost::of(c_).program;
  const bool isFiber = program && program->isFiber;
  const StrandPlace** places = group_->arena().make<const StrandPlace*>(args_.n);
  for (uint32_t i = 0; i < args_.n; ++i) {
    places[i] = nullptr;
    const geometry::Mesh& mesh = w.mesh(args_.at.geometry[i]);
    if (!mesh.isStrand()) continue;
    const bool isBaked = w.instance(args_.at.instance[i]).baked;
    const trace::Affine toRender = isBaked ? trace::Affine() : w.objectToRender(args_.at.instance[i], args_.time[i]);
    float P[3] = {c_->P[0][i], c_->P[1][i], c_->P[2][i]};
    if (isFiber && mesh.isTube()) {  // P lies on the axis, see GroupState::leaveStrands
      const float radius = radiusOfStrand(w, args_.at, i, args_.time[i]);
      for (int k = 0; k < 3; ++k) P[k] += radius * c_->Ng[k][i];
    }
    const float wo[3] = {c_->wo[0][i], c_->wo[1][i], c_->wo[2][i]};
    places[i] = new (group_->arena().allocate(sizeof(StrandPlace))) StrandPlace(
        placeOnStrand(mesh, args_.at.primitive[i], args_.at.u[i], args_.time[i], isBaked, toRender, P, wo));
    args_.strand = places;
  }
  return args_;
}

void SurfacePoints::findEdges() {
  ContextHost::of(c_).remember();
  for (auto& edge : edges_)
    for (float*& x : edge) x = floats();
  kernels_->edges(args(), edges_[0], edges_[1]);
}

Slopes SurfacePoints::slopes(const SlopeSource& source, uint32_t components) {
  Slopes s{};
  for (uint32_t j = 0; j < components; ++j) {
    s.value[j] = floats();
    s.d1[j] = floats();
    s.d2[j] = floats();
  }
  kernels_->slopes(args(), source, components, s);
  for (uint32_t j = 0; shift_[0] && j < components; ++j)
    for (uint32_t i = 0; i < args_.n; ++i) s.value[j][i] += shift_[0][i] * s.d1[j][i] + shift_[1][i] * s.d2[j][i];
  return s;
}

void SurfacePoints::rest(float* const Po[3], float* scale) {
  const SurfaceArgs& a = args();
  kernels_->rest(a, c_->P, edge(0), edge(1), shift_[0] ? shift_ : nullptr, Po, scale);
  // strands that are not baked are where they began: P knows of the step, that does not
  for (uint32_t i = 0; shift_[0] && a.strand && i < a.n; ++i) {
    if (!a.strand[i] || a.world->world->instance(a.at.instance[i]).baked) continue;
    trace::Affine back = a.world->world->objectToRender(a.at.instance[i], a.time[i]).inverse();
    for (float& x : back.t) x = 0;
    float step[3], own[3];
    for (int k = 0; k < 3; ++k) step[k] = shift_[0][i] * edge(0)[k][i] + shift_[1][i] * edge(1)[k][i];
    back.point(step, own);
    Imath::V3d d(own[0], own[1], own[2]);
    if (const BakedSpace* baked = a.world->geometries[a.at.geometry[i]].baked.get())
      baked->toObject.multDirMatrix(Imath::V3d(d), d);
    for (int k = 0; k < 3; ++k) Po[k][i] += float(d[k]);
  }
}

void SurfacePoints::moveTo(const Context* c, const float* const along[2]) {
  c_ = c;
  float* sums[2] = {floats(), floats()};
  for (int k = 0; k < 2; ++k) {
    for (uint32_t i = 0; i < args_.n; ++i) sums[k][i] = along[k][i] + (shift_[k] ? shift_[k][i] : 0.f);
    shift_[k] = sums[k];
  }
}

void positionsAt(const Context* c, const float* time, float* const P[3]) {
  SurfacePoints& surface = ContextHost::of(c).surface;
  SurfaceArgs a = surface.args();
  a.time = time;
  // micropolygons that deform lie elsewhere then
  const ContextHost& h = ContextHost::of(c);
  const trace::World& w = *a.world->world;
  bool moves = false;
  for (uint32_t i = 0; a.facet && i < a.n && !moves; ++i)
    moves = a.facet[i] && w.mesh(a.at.geometry[i]).keyCount() > 1;
  if (moves) a.facet = findFacets(*h.group, a);
  surface.kernels().positions(a, P);
}

void curvatureOf(const Context* c, float* out) {
  SurfacePoints& surface = ContextHost::of(c).surface;
  surface.kernels().curvatures(surface.meshArgs(), out);
  // N of the mesh looks outward; seen from inside the surface bends the other way
  for (uint32_t i = 0; i < c->padded; ++i)
    if (!c->entering[i]) out[i] = -out[i];
}

const geometry::Primvar** primvarsOf(const Context* c, const char* name) {
  const trace::World& w = *ContextHost::of(c).group->world().world;
  const geometry::Primvar** found = c->alloc<const geometry::Primvar*>(c->padded);
  const uint32_t* geometry = c->place.geometry;
  for (uint32_t i = 0; i < c->padded; ++i) {
    if (i && geometry[i] == geometry[i - 1]) {
      found[i] = found[i - 1];
      continue;
    }
    const geometry::Primvar* p = w.mesh(geometry[i]).find(name);
    found[i] = p && !p->data.empty() && p->width >= 1 ? p : nullptr;
  }
  return found;
}

void gradientOf(const float e1[3], const float e2[3], float f1, float f2, float g[3]) {
  // of slivers the determinant is a small difference
  double a = 0, b = 0, c = 0;
  for (int i = 0; i < 3; ++i) {
    a += double(e1[i]) * e1[i];
    b += double(e1[i]) * e2[i];
    c += double(e2[i]) * e2[i];
  }
  const double det = a * c - b * b, inv = det > 1e-14 * a * c ? 1 / det : 0;
  for (int i = 0; i < 3; ++i) g[i] = float(((c * f1 - b * f2) * e1[i] + (a * f2 - b * f1) * e2[i]) * inv);
}

void primvarToRender(const geometry::Primvar& p, const SurfaceArgs& a, uint32_t point, float v[3],
                     bool isDifference) {
  const bool isNormal = p.type == scene::ValueType::Normal,
             isPoint = p.type == scene::ValueType::Point && !isDifference;
  if (!(isNormal || p.type == scene::ValueType::Point || p.type == scene::ValueType::Vector)) return;
  const trace::World& w = *a.world->world;
  if (w.instance(a.at.instance[point]).baked) return;
  const trace::Affine m = w.objectToRender(a.at.instance[point], a.time[point]);
  const Imath::V3d& origin = w.mesh(a.at.geometry[point]).origin;
  float q[3];
  if (isNormal) {
    const trace::Affine inverse = m.inverse();
    for (int j = 0; j < 3; ++j) q[j] = inverse.m[0][j] * v[0] + inverse.m[1][j] * v[1] + inverse.m[2][j] * v[2];
  } else {
    float f[3];
    for (int j = 0; j < 3; ++j) f[j] = isPoint ? v[j] - float(origin[j]) : v[j];
    for (int j = 0; j < 3; ++j)
      q[j] = m.m[j][0] * f[0] + m.m[j][1] * f[1] + m.m[j][2] * f[2] + (isPoint ? m.t[j] : 0.f);
  }
  std::memcpy(v, q, 12);
}

}  // namespace kinora::shade
