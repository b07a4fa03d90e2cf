// Turns one primitive of the scene description into a Mesh. Called by render/ while it builds or edits a world, on
// any thread, one primitive at a time. It reads no camera: how fine is fine enough comes in as a DiceRate. It
// displaces nothing and shades nothing, and it keeps nothing between calls.
#pragma once
#include <ImathVec.h>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "base/diagnostics.h"
#include "base/explain.h"
#include "geometry/mesh.h"
#include "scene/scene.h"

namespace kinora::geometry {

struct DiceRate {
  // Object-space length of one micropolygon edge near an object-space point: the finest over all uses of the
  // primitive, longer where nothing is on screen. Empty: every primitive gets its own least rate.
  std::function<double(const Imath::V3d&)> edgeLength;
  // Most triangles that dicing may make of one primitive. A cage or polygon mesh that has more to begin with keeps
  // them.
  uint32_t maxTriangles = 4'000'000;
  // The surface will be displaced: it is cut to the edge length wherever it is flat, too.
  bool isDisplaced = false;
  // The camera mirrors the world (det(worldToCamera) < 0). Only the orientations "lh" and "rh" depend on it.
  bool worldMirrored = false;
  double pixelsPerEdge = 1;  // how long an edge is on screen
  // By how much the edge length changes at most, by the length of a way; 0: not known. And the least that it is anywhere.
  double slope = 0, least = 0;
  // Set: nobody wants the result any more, and what takes long ends early with a part of it. Null: it is wanted.
  const std::atomic<bool>* stop = nullptr;

  bool isStopped() const { return stop && stop->load(std::memory_order_relaxed); }
  // The edge length at p, or +infinity where the function is missing or gives nothing usable.
  double at(const Imath::V3d& p) const;
};

// Nothing when the primitive has no area, is broken beyond use, or is of a kind that is not rendered; a message with
// a GEOM- code then says which and why.
std::optional<Mesh> tessellate(const scene::Primitive& primitive, const DiceRate& rate, Diagnostics& diagnostics);

// Whether the object-space normal is -(dPdu x dPdv). Orientations follow the primitive's own coordinate system and so
// are immune to mirroring transforms; "lh" and "rh" name a handedness in camera space, which is left-handed, as of
// the world: only a camera that mirrors it counts.
bool flipsNormals(const scene::Primitive& primitive, bool worldMirrored);

// What every GEOM- code means, for `kinora explain`.
std::span<const Explanation> explanations();

}  // namespace kinora::geometry
