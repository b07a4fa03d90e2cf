// The renderer's side of a Context: lazy evaluation of networks, built-ins and primvars for its points. One for each
// context, in the group's arena; known to shade/ only.
#pragma once
#include <algorithm>

#include "shade/group.h"
#include "shade/surface_points.h"

namespace kinora::shade {

struct ContextHost {
  GroupState* group;
  const Program* program = nullptr;  // null: points in space
  uint32_t node = 0;                 // node being evaluated
  const uint32_t* block;             // by point: material block in the program
  Value* outputs = nullptr;          // by node and output
  Manifold* manifolds = nullptr;
  uint32_t* firstOutput = nullptr;  // by node
  uint8_t* done = nullptr;          // by node
  // What was asked for, and so is known.
  struct Known {
    Value builtins[size_t(Builtin::Count)];
    bool haveBuiltin[size_t(Builtin::Count)] = {};
    Slopes st{};                                                // of Builtin::St
    float* ellipses[4] = {nullptr, nullptr, nullptr, nullptr};  // of the same
    const struct MovedPoints* moved = nullptr;                  // see paramGradient()
    uint64_t keptFor = 0;                                       // newest mark for which remember() has kept all this
  };
  Known known;
  SurfacePoints surface;  // where the points lie on the geometry
  uint64_t born = 0;      // Arena::now()
  // The vertices, by point.
  VertexState state;
  const float* ng[3] = {nullptr, nullptr, nullptr};  // as Hits::ng
  const uint32_t* origin = nullptr;                  // RayOrigin bits of the ray
  RayKind rayKind = RayKind::Camera;                 // of the rays that met its points

  static ContextHost& of(const Context* c) { return *static_cast<ContextHost*>(c->host); }
  void evaluate(const Context* c, uint32_t node);
  // Room for what the program's nodes give: none has run.
  void startNetwork();
  // Before something becomes known: where memory has been marked since the context was made, that lasts until the mark is
  // released, and the context goes on as it was.
  void remember() {
    const uint64_t mark = group->arena().newestMark();
    if (mark > born && mark > known.keptFor) keepAll(mark);
  }

 private:
  void keepAll(uint64_t mark);
};

extern const ContextFunctions kContextFunctions;

// As ContextFunctions (moved_points.cpp).
Value paramGradient(const Context* c, uint32_t index, uint32_t component);

// Of contexts of points in media: their places in object space, with the factor of lengths on the way there; and what
// the grids of their objects hold by that name, where they do (other points keep what is there).
void placesInMedia(const Context* c, float* const Po[3], float* scale);
void fieldsInMedia(const Context* c, const char* name, uint32_t components, float* const value[3], float* has);

// Calls f(run, state, first) for each run of shadow rays, with what the vertices hand on that the rays leave.
template <class F>
void forEachRun(const ShadowRays& rays, F&& f) {
  for (uint32_t r = 0, first = 0; r < rays.runCount; first = rays.runs[r++].end) {
    const ShadowRun& run = rays.runs[r];
    f(run, run.context ? ContextHost::of(run.context).state : ListHost::of(*run.list).left, first);
  }
}

// One ray of a list into another, but for how far it goes and what it took over from its vertex.
inline void copyRay(const RayList& from, uint32_t s, RayList& to, uint32_t i) {
  for (int k = 0; k < 3; ++k) {
    to.rays.o[k][i] = from.rays.o[k][s];
    to.rays.d[k][i] = from.rays.d[k][s];
  }
  to.rays.time[i] = from.rays.time[s];
  to.rays.radius[i] = from.rays.radius[s];
  to.rays.spread[i] = from.rays.spread[s];
  to.sampleSeed[i] = from.sampleSeed[s];
  to.sampleIndex[i] = from.sampleIndex[s];
  to.origin[i] = from.origin[s];
}

// Of a ray from a vertex of its own spread.
inline float spreadAlong(const ShadowRays& rays, uint32_t i, float ofVertex) {
  return rays.spread ? std::max(rays.spread[i], ofVertex) : ofVertex;
}

}  // namespace kinora::shade
