// Embree's side of user_geometry.h: callbacks, and what a query hands them besides the ray. Internal to trace/.
#pragma once
#include <embree3/rtcore.h>

#include "trace/strands.h"
#include "trace/user_geometry.h"

namespace kinora::trace {

class Solids;

// Context of one query. Embree hands callbacks a pointer to its first member; ray.id indexes the arrays.
struct QueryContext {
  RTCIntersectContext embree;
  const float* radius;  // footprints in render units; null: none, the finest level
  const float* spread;
  uint32_t* level;  // out, where user geometry is the nearest hit so far; null in shadow queries
  // The world's rays, for surfaces of its solids; null: there are none.
  const Solids* solids = nullptr;
  const float* const* o = nullptr;
  const float* const* d = nullptr;
  Draws draws;                // of camera rays: who sees a curve that is drawn wider than it is
  void* crossings = nullptr;  // what a line through a solid crosses is counted here
  QueryContext(bool coherent, const float* radii, const float* spreads, uint32_t* levels);
  void askSolids(const Solids* ofWorld, const float* const origins[3], const float* const directions[3]) {
    solids = ofWorld;
    o = origins;
    d = directions;
  }
};

// An Embree geometry over the patches; `geometry` must outlive it. Not committed yet.
RTCGeometry makeUserGeometry(RTCDevice device, const UserGeometry& geometry);

}  // namespace kinora::trace
