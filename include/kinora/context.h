// A shading context: n points that share one shading program (bxdf and network structure), made by the renderer from
// a group of hits. Bxdfs, patterns and integrators read it; everything is in render space (world moved by a
// constant). All arrays have `padded` elements; the padding repeats the last point, so kernels never need a tail
// mask.
#pragma once
#include <kinora/plugin.h>
#include <kinora/sample_table.h>

namespace kinora {

// A value over the points of a context: `components` arrays of n floats (stride 1), or of one float each (stride 0).
struct Value {
  const float* data[3] = {nullptr, nullptr, nullptr};
  uint32_t stride = 0;
  uint32_t components = 0;
  bool uniform() const { return stride == 0; }
};

// A matrix over the points of a context, for row vectors: x' = x m[0] + y m[4] + z m[8] + m[12]. 16 arrays of n
// floats (stride 1), or of one float each (stride 0).
struct MatrixValue {
  const float* m[16];
  uint32_t stride = 0;
  bool uniform() const { return stride == 0; }
};

// What a surface manifold pattern hands on ("struct" connections): 2D texture coordinates or a 3D position.
struct Manifold {
  Value q;       // 2D: s, t in data[0], data[1]; 3D: a position
  Value radius;  // footprint radius in units of q
  uint32_t dimensions = 2;
  // Of the first two components of q, along the surface, render space: vectors of change per unit of length. Made
  // where kWantGradients is asked for; no components: unknown. They lie near the surface, not exactly in it.
  Value gradient[2];
  // Two half diameters of the footprint in units of the first two components of q, see ContextFunctions::ellipses.
  // No components: circles of `radius`, as for whoever knows nothing of them.
  Value axis[2];
};

// Built-in variables beyond those held directly; computed on first use, cached for the context.
enum class Builtin : uint32_t {
  U,
  V,         // patch parameters 0..1
  St,        // texture coordinates: primvar "st", else (s, t), else (u, v)
  StRadius,  // footprint radius in st units
  DPdu,
  DPdv,      // render space, unnormalised
  Tangent,   // unit, along st's first direction, perpendicular to N
  Po,        // position in object space of the undeformed instance, object units
  PoRadius,  // footprint radius in object units
  Pworld,    // world space
  ObjectId,  // identifier:id
  Fiber,  // unit direction of the tube or of the ribbon that faces its rays, to its tip, render space; 0 0 0 elsewhere
  // How the surface runs where a ray meets it, which is on a facet; exact, for whoever differentiates paths. Edges of
  // the facet (render space, unnormalised; zero on curves), and by how much N changes along each of them.
  FacetEdge1,
  FacetEdge2,
  DNEdge1,
  DNEdge2,
  // By how much N changes per unit of the patch parameters: along DPdu and DPdv, as far as they lie in the facet.
  DNdu,
  DNdv,
  Count
};

enum ContextTraits : uint32_t {
  kTraitEyePath = 1,
  kTraitLightPath = 2,   // radiance or importance is transported
  kTraitPrimaryHit = 4,  // first hit seen from the camera
  // Paths from both ends come here, and know each other's densities: whether they go below the surface must not depend on
  // their footprints.
  kTraitBothEnds = 8,
  kTraitInSpace = 16,   // points of a medium: no surface; N and Ng are wo. The bxdf, if any, is the phase function
  kTraitEncloses = 32,  // the material bounds a medium
  kTraitTinted = 64,    // tinted shadows pass the material, see Context::tintedSlots
  // The integrator follows paths below surfaces (kSampleBelow). Where it does not, materials reflect diffusely what
  // would come out again.
  kTraitSubsurface = 128,
  kTraitComesOut = 256,  // light comes out here that went in elsewhere: no closure is bound, see SurfacePlaces::from
  kTraitScattersOnce = 512,    // of a medium whose light goes on to lights only: no directions are followed from here
  kTraitFiber = 1024,          // the bxdf stands for the whole passage through a fibre (kBxdfFiber)
  kTraitWalkable = 2048,       // manifold walks go through the surface, see Context::walkableSlots
  kTraitWalk = 4096,           // made for a manifold walk that looks for its path
  kTraitPresenceQuery = 8192,  // made for presence or opacity only; no closure will be bound
};

struct Context;
struct Services;

struct ContextFunctions {
  // Memory of the context's life, aligned to 64 bytes, uninitialised. Never null.
  void* (*alloc)(const Context*, size_t bytes);
  // The value of parameter `index` of the node being evaluated: constant, gathered by point, or computed by the
  // pattern connected to it (each node runs once a context). Files: data[0] holds handles, bit-cast int32.
  Value (*param)(const Context*, uint32_t index);
  const Manifold* (*manifold)(const Context*, uint32_t index);  // of a struct parameter; null when not connected
  const char* (*text)(const Context*, uint32_t index);          // of a (fixed) string parameter
  uint32_t (*list)(const Context*, uint32_t index,
                   const float** numbers);  // of a (fixed) array parameter; its length
  Value (*builtin)(const Context*, Builtin);
  // A primvar by name, as wide as the widest of that name in the scene: components 0 when no object has one, 0 at points
  // whose object has none. radius (may be null) gets what PrimvarAbout lists, by point: the footprint in units of the
  // primvar, how many components the object's own has, and its kind. Point, vector and normal primvars arrive in render
  // space.
  Value (*primvar)(const Context*, const char* name, Value* radius);
  // Filtered texture lookups at n points. handles as given by param(); s, t and radius in texture space (t down);
  // options fixed for the context. axes: null, or s and t of a half diameter of each footprint and of another,
  // conjugate one (ellipses()); a point where all four are 0 is looked up by its radius, as all are without. Writes
  // 3 + 1 channels; missing files give missingColor / missingAlpha.
  void (*texture)(const Context*, const Value* handles, const float* s, const float* t, const float* radius,
                  const float* const axes[4], const struct TextureOptions* options, float* const rgba[4]);
  // The matrix from `from` to `to`: "render", "world", "object" (each point's own, at the middle of the shutter),
  // "camera", or a named coordinate system. 0 when unknown (identity is returned).
  int (*matrix)(const Context*, const char* from, const char* to, MatrixValue* out);
  // The gradient along the surface, in render space, of one component of a primvar (null: of Builtin::St), which is
  // given as primvar() gives it: 3 components, 0 where the surface has no direction of change. Components 0 when the
  // scene has no primvar of that name.
  Value (*gradient)(const Context*, const char* primvar, uint32_t component);
  // Nearest hits of rays that a pattern sends from points of the context. 0 where nothing can be traced: without a
  // world (the testing kit), and where the context belongs to a surface that a pattern's ray asks whether it is
  // present. The pattern then answers as if its rays had met nothing.
  int (*probe)(const Context*, const struct ProbeRays*);
  // Footprints of camera paths and of what mirrors show are ellipses on a surface that is seen at an angle: as wide as
  // the path, and longer the other way. Two conjugate half diameters in units of the first two components of a primvar
  // (null: of Builtin::St), which are 0 where the footprint is a circle: at points that a wider path has found. 0, and
  // the axes are left alone, where all are, or the scene has no primvar of that name.
  int (*ellipses)(const Context*, const char* primvar, Value axes[2]);
  // Whether a pattern feeds parameter `index` of the node being evaluated: the same for all points of a context.
  int (*isConnected)(const Context*, uint32_t index);
  // The gradient along the surface, in render space, of one component of a parameter that a pattern feeds, per render
  // unit: by differences, for which all that feeds it runs again for the points a footprint further on, in two
  // directions. 3 components, 0 where the surface has no direction of change. Components 0 where no pattern feeds the
  // parameter, and in media.
  Value (*paramGradient)(const Context*, uint32_t index, uint32_t component);
};

// Rays from points of a context, in any number of each. They see what rays that leave the points see
// (visibility:indirect, trace:reflectsubset and its like), and pass what is not present. Arrays by ray, padded.
struct ProbeRays {
  uint32_t count = 0;
  const uint32_t* point = nullptr;  // of the context; the ray leaves it on the side of Ng that it goes to
  const uint32_t* part = nullptr;   // tells a ray from the others of its point: they have random numbers of their own
  const float* d[3] = {nullptr, nullptr, nullptr};  // unit, render space
  const float* reach = nullptr;                     // what lies farther off is not met
  // The text of a parameter declared with traceSet(): only members of these groups are seen. Null, "": no choice.
  const char* traceSet = nullptr;
  float* t = nullptr;  // out: the distance; infinity where nothing is met
};

struct TextureOptions {
  int firstChannel = 0;
  int filter = 1;  // PxrTexture's codes: 0 nearest, 1 box, 2 bilinear, 3 b-spline, 6 gaussian, 7 lagrangian
  int interpolateLevels = 1;
  int wrapS = 1, wrapT = 1;  // 0 black, 1 as the file says, else periodic, 2 clamp, 3 periodic
  float blur = 0;            // added to the radius, fraction of the image
  float missingColor[3] = {1, 0, 1};
  float missingAlpha = 1;
  int linearize = 0;  // 1: decode sRGB
};

// Where points lie on the scene's geometry. Null in contexts of points in space and in those of the testing kit.
struct Places {
  const uint32_t* instance;   // index of the placed object in the world
  const uint32_t* geometry;   // index of the geometry in the world
  const uint32_t* primitive;  // patch
  const uint32_t* level;      // of resolution
  const float* u;             // barycentric b1, b2 (triangles) or the geometry's own parameters
  const float* v;
};

struct Context {
  uint32_t count, padded, width;  // points; arrays' length; SIMD width in use
  uint32_t traits;
  const uint32_t* path;  // entry in the list of rays or of records that the points come from
  Places place;
  const float* P[3];           // hit point
  const float* N[3];           // shading normal, unit, on wo's side of the surface
  const float* Ng[3];          // geometric normal, unit, on wo's side
  const float* wo[3];          // unit, towards where the path came from
  const float* distance;       // length of the ray that found the point
  const float* radius;         // path footprint at the hit: radius, render units
  const float* spread;         // growth of the radius per unit distance
  const float* time;           // 0..1 over the shutter
  const float* bias;           // distance by which rays leaving the surface start off it, render units
  const uint32_t* entering;    // ~0: wo is outside the object (the side its outward normal points to), 0: inside
  const float* outerIor;       // index of refraction around the object (1 in empty space)
  const uint32_t* sampleSeed;  // address of random numbers, see random.h
  const uint32_t* sampleIndex;
  const SampleTable* samples;  // what draws from it; null in contexts of the testing kit
  uint32_t depth;              // bounces before this vertex
  // Lobes. The host maps each declared lobe of the bxdf to a slot that active outputs tell apart.
  uint32_t lobeCount, slotCount;
  const uint8_t* slotOfLobe;    // lobeCount
  const uint16_t* eventOfSlot;  // slotCount: event code of the light path automaton; bit 0: the slot is specular
  uint32_t tintedSlots;         // a bit for each slot whose light tinted shadows stand for: refraction. No other lobe
                                // is in such a slot
  uint32_t walkableSlots;  // a bit for each slot whose light manifold walks may find. No other lobe is in such a slot
  const struct BxdfFunctions* bxdf;
  void* closure;  // bound by the host before the integrator sees the context
  const ContextFunctions* fn;
  void* host;  // the renderer's part

  template <class T>
  T* alloc(size_t n) const {
    return static_cast<T*>(fn->alloc(this, n * sizeof(T)));
  }
  Value param(uint32_t i) const { return fn->param(this, i); }
  bool isConnected(uint32_t i) const { return fn->isConnected(this, i) != 0; }
  Value builtin(Builtin b) const { return fn->builtin(this, b); }
};

}  // namespace kinora
