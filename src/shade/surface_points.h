// The one surface point: wide kernels that turn the places of a context's points and a time into positions, normals,
// derivatives, footprints and primvars. Whoever in shade/ and render/ wants to know how the surface runs at a point
// asks here; the loads behind it are in surface_spot.h. Render space unless another is said.
#pragma once
#include <kinora/context.h>

#include "shade/surface_spot.h"
#include "trace/world.h"

namespace kinora::shade {

struct ShadingWorld;
class GroupState;

// Where n points lie (n is padded), by point.
struct SurfaceArgs {
  uint32_t n;
  const ShadingWorld* world;
  Places at;
  const float* time;                           // of the shutter
  const float* quad[2] = {nullptr, nullptr};   // parameters on quads; [0] -1: not on one. Null: no point is
  const StrandPlace* const* strand = nullptr;  // null: no point lies on one
  // What points lie on where geometry has several resolutions: `at` then says where on its mesh, this how the surface
  // that was hit runs there. Null: no point does, or, by point, this one does not.
  const trace::UserFacet* const* facet = nullptr;
  bool isByParameter = false;  // points of quads lie where their parameters say, see ShadingWorld::placesByParameter
  Spot spot(uint32_t i) const;
  trace::Affine toRender(uint32_t i) const;
};

// A value of at most three components and its changes along the edges() of the place.
struct Slopes {
  float *value[3], *d1[3], *d2[3];
};

// What the slopes are asked of, by point.
enum class Implied : uint8_t { None, St, S, T, Color, Opacity };
struct SlopeSource {
  enum class What : uint8_t { PatchUV, St, Primvar } what;
  const geometry::Primvar* const* primvar = nullptr;  // Primvar: by point; null: the implied one there
  Implied implied = Implied::None;
  uint32_t first = 0;  // component, of primvars that have more than three
};

struct SurfaceKernels {
  // Where the points have moved to at a.time.
  void (*positions)(const SurfaceArgs& a, float* const P[3]);
  // Geometric normals as Hits::ng: of the triangles, in the geometry's own space, as long as twice their areas.
  void (*facets)(const SurfaceArgs& a, float* const ng[3]);
  // Geometric normals (raw: as Hits::ng) and unit smooth ones (zero: the facet's), both oriented by the mesh; either
  // may be null.
  void (*normals)(const SurfaceArgs& a, const float* const raw[3], float* const ng[3], float* const smooth[3]);
  // What slopes are taken along: from the first corner of the triangle to the others; one unit of u and of v on quads
  // and strands.
  void (*edges)(const SurfaceArgs& a, float* const e1[3], float* const e2[3]);
  // A primvar of one component fills all of them; where there are fewer, or none, the rest is 0. Not transformed.
  void (*slopes)(const SurfaceArgs& a, const SlopeSource& source, uint32_t components, const Slopes& out);
  // Object space, undeformed; and by how much lengths shrink on the way there. shift: null, or how far along the edges
  // P lies from the place; strands know nothing of it.
  void (*rest)(const SurfaceArgs& a, const float* const P[3], const float* const e1[3], const float* const e2[3],
               const float* const shift[2], float* const Po[3], float* scale);
  // Mean curvature about the mesh's own normals: half their divergence over the triangle. 0 where there are none, or
  // one for the whole face.
  void (*curvatures)(const SurfaceArgs& a, float* out);
  // Of the surface by two parameters whose slopes these are.
  void (*derivatives)(uint32_t n, const float* const e1[3], const float* const e2[3], const Slopes& uv,
                      float* const du[3], float* const dv[3]);
  // Footprints in units of two parameters: by the ratio of areas.
  void (*footprints)(uint32_t n, const float* radius, const float* const e1[3], const float* const e2[3],
                     const Slopes& st, float* out);
  // Where they are ellipses: half diameters across the direction that the surface is seen from and along it, s and t of
  // each; 0 at points of wider paths.
  void (*ellipses)(const struct EllipseArgs& a, float* const axes[4]);
  // Makes d perpendicular to the unit normal and of unit length; where nothing is left any direction across will do.
  void (*across)(uint32_t n, const float* const N[3], float* const d[3]);
  // How far along the edges steps go: step = a e1 + b e2, by least squares; 0 where the edges span no plane.
  void (*alongEdges)(uint32_t n, const float* const e1[3], const float* const e2[3], const float* const step[3],
                     float* a, float* b);
  // Edges of the facets, and how much the unit normals of normals() change along them; 0 where there are none.
  void (*facetSlopes)(const SurfaceArgs& a, float* const e1[3], float* const e2[3], float* const dn1[3],
                      float* const dn2[3]);
  // shadow_terminator.h
  void (*terminatorOffsets)(const struct TerminatorArgs& a);
};
const SurfaceKernels& surfaceKernels(uint32_t width);

struct EllipseArgs {
  uint32_t n;
  const float *radius, *spread;
  const uint32_t* sampleIndex;  // in their pixels
  const float *const *wo, *const *Ng;
  const float *const *e1, *const *e2;  // edges that the slopes are taken along
  Slopes st;
};
// Paths whose radius grows by no more than that a unit of distance are narrow: those of cameras, and of what they meet
// by mirrors, glass and sharp reflections. Wider ones are averages over so many directions that the shape of a
// footprint does not show.
inline constexpr float kNarrowSpread = 1.f / 64;
// How many times longer than wide an ellipse is at most. That of sample k of a pixel is 1 + k / 4 times shorter than
// the pixel's: what the first ones blur others resolve, so that noise and blur go together with their number.
inline constexpr float kMostStretch = 16;

// For GroupState::findTerminatorOffsets: see shadow_terminator.cpp. By point; Ng is changed.
struct TerminatorArgs {
  SurfaceArgs at;
  const uint32_t* entering;
  const float* N[3];
  float* Ng[3];
  float* facet[3];
  float* terminatorOffset[3];
};

// The lazy side of it: what a context's points have been asked already.
class SurfacePoints {
 public:
  // Before the points themselves are known: no strands yet.
  void begin(GroupState& group, const Context* c, bool hasQuads);
  // Of geometry with several resolutions: footprints are kept so small that rays that leave find the surface where it
  // was hit. Another resolution lies elsewhere, and a ray would begin on its other side, or in its own shadow.
  void limitFootprints(float* radius) const;
  const SurfaceArgs& args() { return strandsAsked_ ? args_ : withStrands(); }
  // Triangles and quads only: for what strands know themselves, or have not.
  const SurfaceArgs& meshArgs() {
    if (quadsWait_) findQuads();
    return args_;
  }
  // Of points that are asked for facets alone: places on quads are not there.
  const SurfaceArgs& facetArgs() const { return args_; }
  const SurfaceKernels& kernels() const { return *kernels_; }
  const float* const* edge(int k) {
    if (!edges_[0][0]) findEdges();
    return edges_[k];
  }
  // `components` of three at most; arrays of the context's memory.
  Slopes slopes(const SlopeSource& source, uint32_t components);
  // As the kernel of that name, of the context's points.
  void rest(float* const Po[3], float* scale);
  // The points of `c` are those of this one moved along the surface, by so much of each edge (by point): what is stored
  // goes on there by its slopes; places, edges and slopes, which are known, stay.
  void moveTo(const Context* c, const float* const along[2]);
  float* floats() const;

 private:
  const SurfaceArgs& withStrands();
  void findQuads();
  void findEdges();
  SurfaceArgs args_{};
  GroupState* group_ = nullptr;
  const Context* c_ = nullptr;
  const SurfaceKernels* kernels_ = nullptr;
  float* edges_[2][3] = {};
  const float* shift_[2] = {nullptr, nullptr};  // see moveTo(); null: the points are where their places are
  bool strandsAsked_ = false;
  bool quadsWait_ = false;  // some points lie on quads, and nobody has asked where
};

// Parameters in their quads of the points of `a`; u is -1 where place is the triangle's own: on other triangles, and
// on quads that are not convex.
void findQuadPlaces(GroupState& group, const SurfaceArgs& a, float* u, float* v);
// What points of geometry with several resolutions lie on (null: of others); null where none does.
const trace::UserFacet* const* findFacets(GroupState& group, const SurfaceArgs& a);
// A point of a strand: `s` is the hit's parameter along a piece of curve, `towards` points to where the ray came
// from.
StrandPlace placeOnStrand(const geometry::Mesh& mesh, uint32_t primitive, float s, float time, bool isBaked,
                          const trace::Affine& toRender, const float P[3], const float towards[3]);
// Radius of the strand there, in its own space.
float strandRadius(const geometry::Mesh& mesh, uint32_t primitive, float s, float time);
// Of the strand that a point of a context lies on, in render space.
float radiusOfStrand(const trace::World& world, const Places& at, uint32_t point, float time);

// Where a context's points are at other times of the shutter (by point, 0..1; padded).
void positionsAt(const Context* c, const float* time, float* const P[3]);
// Mean curvature, by point: a sphere of radius r seen from outside has 1 / r; facets have none.
void curvatureOf(const Context* c, float* out);
// The primvars of that name of a context's points (null: the object has none), in the context's memory.
const geometry::Primvar** primvarsOf(const Context* c, const char* name);

// The gradient, in the plane of the edges, of what changes by f1 and f2 along them; 0 where they span no plane.
void gradientOf(const float e1[3], const float e2[3], float f1, float f2, float g[3]);

// A primvar's value, or a difference of values, of three components: points, vectors and normals from object to
// render space, other types stay. Those of objects baked into render space are there already. (The points of a mesh
// are stored from its origin, primvars are not.)
void primvarToRender(const geometry::Primvar& p, const SurfaceArgs& a, uint32_t point, float v[3],
                     bool isDifference = false);

}  // namespace kinora::shade
