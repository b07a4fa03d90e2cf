// The wide kernels that turn listed hits into the arrays of a context. Internal to shade/.
#pragma once
#include <cstdint>
#include <vector>

#include "geometry/mesh.h"

namespace kinora::shade {

struct PointsArgs {
  uint32_t n;  // padded; slots are repeated at the end
  const uint32_t* slots;
  // by slot
  const float* o[3];
  const float* d[3];
  const float* t;
  bool isRecord;  // o is the point itself, radius the footprint there
  const float* radius;
  const float* spread;
  const float* time;
  const uint32_t* seed;
  const uint32_t* index;
  const float* reach;  // by point: distance from where the ray began
  // by point: geometric normal in render space (not unit), side +-1; normal (unit, oriented; zero: Ng is taken) or
  // null: all Ng
  const float* ng[3];
  const float* side;
  const float* smooth[3];
  // out, by point
  float* P[3];
  float* N[3];
  float* Ng[3];
  float* wo[3];
  float* outRadius;
  float* outSpread;
  float* outTime;
  float* bias;
  uint32_t* entering;
  uint32_t* outSeed;
  uint32_t* outIndex;
};

// What is read of a mesh for every point on it, in one line of the cache.
struct alignas(64) MeshView {
  const geometry::Mesh* mesh;
  const uint32_t* indices;
  const Imath::V3f* points;  // null: strands
  const float* normals;      // null: none, or strands
  const float* st;           // by vertex; null: another rate, or none
  geometry::Primvar::Rate rateOfNormals;
  bool isMoving, movesNormals;  // have several keys
};

// What grouping asks of each hit, as arrays for gathers.
struct SurfaceTables {
  std::vector<MeshView> meshes;           // by geometry
  std::vector<uint32_t> flagsOfGeometry;  // GeometryFlags
  std::vector<float> sideOfGeometry;
  const uint32_t* instances = nullptr;  // trace::World::instanceWords(), infoSteps()
  const uint32_t* infoSteps = nullptr;
  std::vector<uint32_t> materialOfInfo, linkSetOfInfo;  // by trace::World::infoOf()
  std::vector<uint32_t> programOfMaterial, blockOfMaterial;
};

// Programs of n listed hits.
struct ProgramsArgs {
  uint32_t n;
  const uint32_t* slots;
  const uint32_t *instance, *geometry;  // by slot
  const SurfaceTables* tables;
  uint32_t* program;  // room to the next multiple of 16
};
using ProgramsKernel = void (*)(const ProgramsArgs&);
ProgramsKernel programsKernel(uint32_t width);

// What n (padded) listed hits are, by point; blocks and sides.
struct SurfacesArgs {
  uint32_t n;
  const uint32_t* slots;
  // by slot
  const uint32_t *instance, *geometry, *primitive, *level, *origin;
  const float *u, *v, *t, *time;
  const float* ng[3];
  const SurfaceTables* tables;
  // out, by point
  uint32_t* linkSet;  // null: not wanted
  uint32_t* block;
  float* side;
  uint32_t *outInstance, *outGeometry, *outPrimitive, *outLevel, *outOrigin;
  float *outU, *outV, *outT, *outTime;
  float* outNg[3];
  uint32_t anyFlags, anyPlaced;  // out: what some point has; whether some object is not baked
};
using SurfacesKernel = void (*)(SurfacesArgs&);
SurfacesKernel surfacesKernel(uint32_t width);

// Bilinear parameters of n (padded) points in quads, from their place in the quad's two triangles: a point is corner
// 0 + x0 e[0] + x1 e[1] + x2 e[2], where e leads from corner 0 to corners 1, 2 and 3, and x0 or x2 is 0. All by
// point.
struct QuadsArgs {
  uint32_t n;
  const float* x[3];
  const float* e[3][3];
  float *u, *v;  // out; u is -1 where the quad is not convex or has no area
};
using QuadsKernel = void (*)(const QuadsArgs&);
QuadsKernel quadsKernel(uint32_t width);

using PointsKernel = void (*)(const PointsArgs&);
PointsKernel pointsKernel(uint32_t width);

}  // namespace kinora::shade
