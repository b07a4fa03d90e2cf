// The interface of an integrator: it owns everything inside the loop; the renderer gives it a group of samples and
// services. The stock integrators use exactly this. Groups belong to one thread; nothing here locks or allocates.
// Arrays are padded to kPad elements, in the group's arena. Render space.
//
// Rays live in lists. The group's own list, `paths`, has a slot for each sample; an integrator makes further lists of
// any size, whose rays leave any vertices (chords through an object, connections of subpaths). A vertex is a point of
// a context, which owns all that is known of it until the group ends or its memory is released: its place on the
// geometry, what lights it, which objects its rays see, the media around it, its address of random numbers. A ray
// takes that over when it leaves the vertex (Services::leave). Records of vertices outlive the group
// (Services::keepVertices).
#pragma once
#include <kinora/bxdf.h>
#include <kinora/light.h>
#include <kinora/sample_table.h>

namespace kinora {

enum class RayKind : uint32_t { Camera, Indirect, Transmission };

// Rays by entry of their list.
struct Rays {
  float* o[3];
  float* d[3];  // unit
  float* tMax;  // in: farthest distance
  float* time;
  float* radius;  // footprint radius at o
  float* spread;  // its growth per unit distance
};

// Rays without footprints, for requests that ask for none.
inline Rays raysAlong(float* const o[3], float* const d[3], float* tMax, float* time) {
  return {{o[0], o[1], o[2]}, {d[0], d[1], d[2]}, tMax, time, nullptr, nullptr};
}

struct Hits {  // by entry, like Rays
  float* t;    // distance; infinity: the ray escaped
  float* u;    // barycentric b1, b2 (triangles) or the geometry's own parameters
  float* v;
  float* ng[3];         // geometric normal in the geometry's own space, unnormalised
  uint32_t* instance;   // index of the instance in the world
  uint32_t* geometry;   // index of the geometry in the world
  uint32_t* primitive;  // patch
  uint32_t* level;      // of resolution
};

// How the vertex that a ray comes from sent it on, in RayList::origin. None of them: a diffuse reflection.
enum RayOrigin : uint32_t {
  kFromDiscrete = 1,      // no light sample could have found its direction: mirrors, perfect glass, the camera
  kFromSpecular = 2,      // by a specular lobe
  kFromTransmission = 4,  // through the surface
  kFromTintedLight = 8,   // light samples of that vertex took shadow rays in all its directions that go straight
                          // through glass (ShadowRays::tinted)
  kOriginBits = 16        // bits from this one on are the integrator's own
};

// How rays came through media that may end them, up to where they ended: stretches of each ray, with the factor on its
// path there. On average over all that might have been drawn that is the transmittance. Within it the ray also passed
// space without media.
struct MediumWays {
  const uint32_t* first;  // by entry: its stretches, first[e] to first[e] + count[e] - 1
  const uint32_t* count;
  // By stretch, in order along each ray.
  const float* from;  // distances along the ray
  const float* to;
  const float* factor[3];
  const float* absorption[3];  // by entry, per unit of length: what glass around the ray takes besides. Null: none
};

// Rays that are traced, shaded and asked for lights together, all or a listed part of them.
struct RayList {
  uint32_t capacity;
  Rays rays;
  Hits hits;
  uint32_t* sampleSeed;  // address of random numbers
  uint32_t* sampleIndex;
  uint32_t* origin;  // RayOrigin bits of the ray, 0 unless the integrator writes them with each new direction;
                     // shaders ask for them by raytype()
  void* host;        // the renderer's part: what each ray took over from the vertex that it left
  const float* throughput[3];  // of each ray's path, where the integrator says it (null: it does not): channels that
                               // show what lies at the ends of rays weigh it so
  // Written by trace(): what media emitted along each ray as far as it went, as radiance at its origin. Null where
  // nothing in space emits.
  float* glow[3];
  // Where an integrator says both, lightSamples() has samples of what media emit too, and `glow` is the other half of
  // that estimate. By entry, with each new direction: its density per solid angle times the directions that were
  // followed from the vertex over the light samples taken there, infinite where no light sample could have made it; and
  // the share of the vertex in its light, see TowardsLights. They have no meaning before trace() and none after it.
  const float* againstLights;
  const float* share;
  uint32_t wantsWays;  // 1: trace() writes `ways`, in the group's memory, for the rays that it is asked for
  MediumWays ways;
  // Where an integrator says them (null: it does not): rays that came straight out of a body, within which they began, and
  // by which lights are to be weighed as from there. By entry: how far behind the origin that is (0: no such ray), and
  // where. For trace() (what light samples find of `glow`), lightHits() and lightsBeyond(), whose distances are from the
  // origin all the same: lights within the body are not told of.
  const float* behind;
  const float* begin[3];
  uint32_t passesMedia;  // 1: trace() ends no ray of the list in a medium, and says what media let through instead
};

enum class StageKind : uint32_t { CameraPaths, LightPaths };
struct Stage {
  StageKind kind;
  uint32_t pathsPerSample;
};  // LightPaths: how many a pixel of the picture and sample

// One group of samples. For camera stages paths.rays hold the camera rays; for light stages emitted rays are made by
// Services::emitLight. A sample's slot in `paths` never changes while it lives; live slots are listed, not moved.
struct Group {
  uint32_t count;  // samples (slots) in use
  uint32_t padded;
  uint32_t width;  // SIMD width
  StageKind stage;
  RayList paths;
  // By slot: the path's number among those of its stage and sample. Of a camera path y * Services::resolution[0] + x,
  // of light paths from 0 on; they have the shutter time of the camera path of that number (modulo the picture).
  const uint64_t* number;
  const int32_t* pixel[2];  // raster pixel of the sample
  const float* rayWeight;   // camera's weight of the sample
  // By slot, 1: the path is one of those that the integrator learns from (Services::teach). Null: none is.
  const uint32_t* teaches = nullptr;
  // Factors on what lights are expected to bring, which decides how likely each is sampled: rows of kLightClusters
  // numbers above 0, by row and cluster. Set by the integrator before its first vertex, and kept until the group
  // ends; points choose a row by Services::weighLights, and row 0 where it says nothing. Null: all factors are 1.
  const float* lightWeights = nullptr;
  // How many surfaces trace() lets a ray pass because they are not present where it meets them; the next one then is.
  // Set by the integrator before its first vertex.
  uint32_t mostPassed = ~0u;
  // Where the integrator takes the samples that lights ask for themselves (Services::ownLightSamples): how many of
  // lightSamples() it takes there, which then leave those lights out. Densities of those lights, in samples and of rays
  // that meet them, then are of all of their own, over this number. 0: it takes none. To be set as it goes from vertex to
  // vertex.
  uint32_t besideOwnSamples = 0;
  void* host;
};

// Lights' answer at the points of a context: one light sample a point.
struct LightSamples {
  const float* wi[3];
  const float* distance;     // that a shadow ray goes; 0: nothing shadows this light
  const float* t;            // to the point on the light; infinity for infinite lights
  const float* radiance[3];  // unshadowed
  // Instead of `radiance` what specular slots get, where a light's filters weigh on them otherwise. Null: the same.
  const float* specularRadiance[3] = {nullptr, nullptr, nullptr};
  const float* pdf;      // choice of the light included; 0: none
  const float* diffuse;  // factors on diffuse and specular slots
  const float* specular;
  const uint32_t* flags;  // LightSampleFlags
  const uint32_t* light;  // index, for light path events
  // Growth of a shadow ray's footprint, see ShadowRays: a quarter of the radius of the cone that the light is sampled
  // over, 0 for delta lights. Null where nothing in the scene is looked at by footprints of shadow rays.
  const float* spread;
  // The light's cluster (see kLightClusters), and how likely that was chosen over its share in what all are expected to
  // bring, before Group::lightWeights. Null where there are none of these, or nothing to choose.
  const uint32_t* cluster;
  const float* chance;
};
// Clusters that all lights of a scene fall into, at most: with so many lights, each is its own.
inline constexpr uint32_t kLightClusters = 16;

// Of points on lights, where paths begin or end.
enum LightEndFlags : uint32_t {
  kLightIsDelta = 1,  // no ray finds it: of its two densities one is a probability. Where it is infinite that is the
                      // direction's, else the position's
  kLightIsInfinite = 2  // positions lie on a disk outside of the world, across the direction
};

// Light that the paths of a light stage start with, by slot.
struct EmittedLight {
  float* throughput[3];  // radiance * cosine / (pdfPosition * pdfDirection); 0: the slot has no path
  uint32_t* light;
  const float* N[3];          // unit, of the light there; infinite and delta lights: the ray's direction
  const float* pdfPosition;   // per area; choice of the light included
  const float* pdfDirection;  // per solid angle
  const uint32_t* flags;      // LightEndFlags
  const float* diffuse;       // factors on diffuse and specular slots of the surface that the path meets first
  const float* specular;
};

// Light met by rays: area lights in front of the hit, and infinite lights where nothing was hit; lights without
// shadows behind it too. Sorted by the order of the rays that were listed. Radiance is what arrives at the ray's
// origin, through all media: it is not to be multiplied by the transmittance that trace() wrote. Where a medium
// scattered the ray it has met the lights behind that as well, up to the surface that it would have hit.
struct LightHits {
  uint32_t count;
  const uint32_t* slot;  // the ray's entry in its list
  const float* radiance[3];
  const float* specularRadiance[3];  // as in LightSamples; of rays that specular lobes sent
  const float* pdf;  // with which lightSamples() at the previous vertex would have made this direction
  const float* t;
  const float* diffuse;
  const float* specular;
  const uint32_t* light;
  const uint32_t* blocks;  // 1: camera ray that ends here (a light seen by the camera); hits.t was set to infinity
};

// How shadows have to do with a contribution. Only where Services::wantsUnshadowed is set do the last three matter:
// some output wants light as if nothing were in its way.
enum class LightKind : uint32_t {
  Arrives,    // no shadow could have fallen on it: glow, lights seen directly or by a mirror
  Shadowed,   // light samples behind their shadow rays, or lights found by chance: one estimate in two parts
  Unshadowed  // as if nothing were in its way: light samples, and lights along rays (lightsAlong()); in two parts, too
};

// A contribution to the picture: value times throughput, with the state of its light path (see PathStates).
struct Contributions {
  uint32_t count;
  const uint32_t* slot;  // in any order; a slot may come several times
  const float* value[3];
  const uint32_t* state;  // after all events but the light's
  const uint32_t* light;  // index of the light, or kNoLight for emission of surfaces
  LightKind kind = LightKind::Arrives;
};
inline constexpr uint32_t kNoLight = 0xffffffffu;

// Shadow rays: any number, each from a vertex. Runs of them say which: rays up to `end` leave points of `context`,
// or, where that is null, the vertices that rays of `list` left.
struct ShadowRun {
  const Context* context;
  const RayList* list;
  uint32_t end;
};
struct ShadowRays {
  uint32_t count;
  const float* o[3];
  const float* d[3];
  const float* tMax;  // nothing is in the way of rays that go nowhere (0 and below)
  const float* time;
  const uint32_t* point;  // by ray: of the run's context, or entry of its list; null: 0, 1, ... of each run
  uint32_t runCount;
  const ShadowRun* runs;
  const uint32_t* tinted;   // by ray, 1: it goes straight through glass and takes its tint (the stock default where
                            // caustics are off), 0: glass blocks it; 2: as 1, but what manifold walks go through
                            // blocks it, since they bring that light. Null: 0
  float* transmittance[3];  // out
  // Radius by which the ray's footprint grows a unit of distance, beside that at its vertex: surfaces of several
  // resolutions are met as coarsely as it says (but for the patch that the ray leaves), in a light's penumbra more so
  // than as the vertex was seen. The vertex's own spread where that is larger. Null: that one.
  const float* spread = nullptr;
  // By ray: the light that it goes to, whose own shadow controls then hold; kNoLight, null: none.
  const uint32_t* light = nullptr;
};

// What single lights want otherwise, see Services::lightExceptions.
enum LightExceptions : uint8_t {
  kLightBlockedByGlass = 1,   // no shadow ray goes straight through glass; paths that refract find the light instead
  kLightUnseenByMirrors = 2,  // directions that no light sample could have made do not find it: by reflection,
  kLightUnseenByLenses = 4    // by refraction
};

// What the weights of bidirectional methods ask of rays that met a light, by whatever technique: with which densities
// the others would have made them.
struct LightEnds {
  // in, by ray
  uint32_t count;
  const float* d[3];      // unit, towards the light
  const float* t;         // to the point on the light, as in LightSamples and LightHits
  const uint32_t* light;  // kNoLight: all that comes out is 0
  const uint32_t* point;  // with `runs`: the vertex that it left, as in ShadowRays
  uint32_t runCount;
  const ShadowRun* runs;
  // out, in the group's memory
  const float* pdf;  // of lightSamples() at that vertex, as in LightHits; delta lights: the choice's probability
  const float* N[3];
  const float* pdfPosition;  // of emitLight(), as there, for the light that comes back along the ray
  const float* pdfDirection;
  const uint32_t* flags;
};

// A vertex put aside, in a form that means something to the renderer only. It holds while the world that it is of
// does, in any thread.
struct VertexRecord {
  uint32_t words[24];
};

// Points on surfaces that no ray found (dicing, baking, probes), by point. Triangles and quads only: of curves,
// points and user geometry there are none.
struct SurfacePlaces {
  const uint32_t* instance;  // as Places
  const uint32_t* geometry;
  const uint32_t* primitive;
  const float* u;  // barycentric b1, b2
  const float* v;
  const float* time;         // of the shutter, 0..1
  const float* radius;       // footprint, render units
  const uint32_t* isInside;  // 1: seen from the side that the outward normal turns away from; null: from outside
  const uint32_t* sampleSeed;
  const uint32_t* sampleIndex;
  // Where light comes out that went in at points of a context: by place, the point. It has the depth, the media and
  // the kind of lights of that vertex, and in its context no closure is bound (kTraitComesOut). Null: as above.
  const Context* from = nullptr;
  const uint32_t* fromPoint = nullptr;
};

// All that chords meet of the objects that they began on, or of a set of objects; see Services::hitsOnObject.
struct ObjectHits {
  uint32_t most;         // in: room for each ray
  const char* traceSet;  // in: the text of a parameter of the integrator or of a material that is declared with
                         // traceSet(): members of these groups are met. Null, "": each ray's own object
  uint32_t* count;       // out, by ray: hits stored, the nearest ones
  uint32_t* beyond;      // out, by ray: hits for which there was no room
  float* t;              // out, [ray * most + hit], nearest first
  float* u;
  float* v;
  float* ng[3];  // as in Hits
  uint32_t* instance;
  uint32_t* geometry;
  uint32_t* primitive;
  uint32_t* level;
  uint32_t* leaves;          // 1: the chord comes out there, on the side of the outward normal
  uint32_t nearestOnly = 0;  // in, 1: nothing is looked for when there is no more room; `beyond` stays 0
};

// Convex regions that a surface does not reach into, by place; see Services::freeRegions. What a ball and a second, larger
// one beside the surface have in common: with y = x - center, points x of a region have |y| < radius and
// dot(y, normal) + curvature * dot(y, y) < offset. Render space.
struct FreeRegions {
  float* center[3];
  float* radius;     // 0: nothing is known, and the others are not set
  float* normal[3];  // unit; 0, with an offset of 1, where the first ball is all free
  float* curvature;  // not negative; half of one over the second ball's radius, 0: it is a half-space
  float* offset;
};

// What happened to paths below a surface that did not come out as they should, see Services::noteBelow.
enum class BelowSurface : uint32_t {
  Open,    // nothing of the object lay below: it is not closed, or has no inside (curves)
  Endless  // too many steps, or far outside of everything
};

// The automaton over light path expressions: an integrator keeps a state for each path and steps it at each event.
// Expressions are read from the camera, so a path from a light keeps a tail instead, what its events do to the state of
// a camera path that it is joined to: 0 at the light, stepped at each vertex that the path leaves.
struct PathStates {
  const uint32_t* next;  // [state * eventCount + event]
  uint32_t eventCount;
  uint32_t start;            // after "C"
  const uint32_t* nextTail;  // [tail * eventCount + event]; this and the next: where an integrator has light paths
  const uint32_t* end;       // [tail * stateCount + state]: the state behind all events of the tail
  uint32_t stateCount;
};

// Where manifold walks go (kinora/manifold.h): places on lights with cheapCaustics, whatever side of them a point may
// see, since walks come from anywhere. By walk.
struct WalkTargets {
  uint32_t* light;
  float* to[3];     // a point, or for infinite lights the unit direction towards them; render space
  float* N[3];      // unit, of the light there; infinite lights and points: 0
  float* pdf;       // choice of the light included: per area, or for infinite lights per solid angle. 0: no place.
                    // Delta lights: the choice's probability
  uint32_t* flags;  // LightEndFlags
};
// A sphere around objects that walks go through, over all of the shutter; render space.
struct WalkBound {
  float center[3], radius;
};
// What became of walks: for statistics, and the events of a path that is printed.
struct WalkNote {
  uint32_t count;
  const uint32_t* slot;        // of the path that each started from
  const uint32_t* interfaces;  // that its path goes through; 0: none was found
  const float* d[3];           // in which the path leaves its vertex
  const uint32_t* trials;      // until the way was found again; 0: it was not looked for
  const float* value[3];       // that it brings to the vertex, throughput and bxdf aside
};

// A connection of a light path's vertex to the camera, by point of a context. From points that camera rays hit it is
// the way back along the ray, to where it left the lens.
struct CameraConnection {
  const float* wi[3];  // towards the lens, unit, render space
  const float* distance;
  const float* importance;  // cosine at the lens included; 0: not seen. A splat is
                            // throughput * f * |cosine at the point| * importance / distance^2
  const float* pdf;         // of the camera making this direction, per solid angle at the lens
  const float* raster[2];
  const float* begin;  // of `distance`, from the lens: before that camera rays meet nothing (clipping planes); else 0
};

// A list of records that an integrator keeps from one stage of a pass to the next: what light paths left for camera
// paths to find. Any thread appends; once the stage is over the list is in the order of sample index, path number and
// appending along a path, whatever the threads and groups were.
struct RecordList {
  uint32_t bytes;  // of one record
  uint32_t stage;  // that writes it; what others append is dropped, with a message
};
struct StoredRecords {
  uint64_t count;
  const void* records;  // one behind the other; null when there are none
};

// What an integrator learns over the samples of a frame: a state that camera paths of one epoch read and that follows
// from what paths of the epochs before have found. Epochs are counts of samples a pixel: sample 0, 1, 2 to 3, 4 to 7 and
// so on. Which paths teach depends on pixel, sample and seed alone, over the whole picture: those that a crop, a part of
// the frame's samples, adaptive sampling or the replay of one sample leaves out are followed for the lesson only. So the
// state of an epoch, and every pixel, is the same for all of them. Only for integrators whose last stage is the one of
// camera paths, which alone teach; all stages read the state. What they teach must not depend on records of the stages
// before: paths that are followed for the lesson find none.
struct Learning {
  uint32_t recordBytes = 0;  // of one record that a path leaves
  uint32_t samples = 0;      // paths of sample indices below this teach; rounded down to a power of two
  uint32_t paths = 0;        // about so many paths of an epoch teach at most, in whole blocks of 4 x 4 pixels
};

// Further places in media where rays scatter, see Services::scatterTowardsLights.
struct TowardsLights {
  RayList* list = nullptr;  // the rays once more, by the same entries, with hits in media as trace() leaves them
  uint32_t count = 0;       // of rays that have one, and their entries
  const uint32_t* entries = nullptr;
  // By entry: on the ray's path. Their share in the estimate is part of it.
  const float* factor[3] = {nullptr, nullptr, nullptr};
  // By entry, of all rays that were listed: the share of the point in a medium where trace() ended the ray. null: 1
  const float* share = nullptr;
};

// Which media rays are in on their way, from Services::mediumIntervals: stretches of each ray within which the same
// media are around it, in order; between them and outside of them space is empty. What the media are there mediaAt()
// says.
struct MediumIntervals {
  uint32_t count;
  const uint32_t* first;  // by number of the ray in the call: its intervals, first[i] to first[i + 1] - 1
  const float* from;      // by interval: distances along the ray
  const float* to;
  const uint32_t*
      firstMedium;         // by interval: its media, firstMedium[k] to firstMedium[k + 1] - 1; more than one where
                           // they overlap
  const uint32_t* medium;  // Hits::instance of what has hits in it, in rising order within an interval
};

// What Services::mediaAt finds: rays by number, each with a hit in one medium, which shade() makes contexts of.
struct MediaAt {
  RayList* list;
  uint32_t count;              // of its entries, 0 to count - 1
  const uint32_t* entries;     // these numbers, padded
  const uint32_t* point;       // by entry: which of the points
  const float* extinction[3];  // by entry: of that medium there, by render unit
  const float* emission[3];    // radiance by render unit of length; null: nothing in space emits
};

// A light that asks for samples of its own at what the camera sees, whatever it brings (fixedSampleCount).
struct OwnLightSamples {
  uint32_t light, samples;
};

struct MemoryMark {
  uint64_t block, used;
};

struct Services {
  void* host;
  SampleTable samples;
  PathStates paths;
  float worldCenter[3], worldRadius;
  int32_t resolution[2];  // of the whole picture, pixels
  // At the middle of the shutter. Seen from the camera a pixel is pixelSize + distance * pixelAngle wide.
  float cameraCenter[3], pixelSize, pixelAngle;
  uint32_t lightCount;
  uint32_t hasMedia;          // 0: all of space is empty, and trace() may be given no transmittance
  uint32_t mediaScatter;      // 1: trace() ends rays in media, see IntegratorTraits::scattersInMedia
  uint32_t hasTintedShadows;  // 0: lightsBeyond() finds nothing
  uint32_t wantsUnshadowed;   // 1: light is to be contributed as if unshadowed, too, see LightKind
  // Manifold walks: spheres around what they go through (0: nothing, or no light has them), and 1 for each light that
  // has cheapCaustics.
  uint32_t walkBoundCount;
  const WalkBound* walkBounds;
  const uint8_t* lightWalks;
  const uint8_t* lightExceptions;  // by light, LightExceptions; null: no light has any
  uint32_t hasShadowControls;      // 0: ShadowRays::light need not be given
  uint32_t ownSampleCount;         // lights that ask for samples of their own
  const OwnLightSamples* ownSamples;

  // Memory until the group ends, aligned to 64 bytes.
  void* (*alloc)(Group*, size_t bytes);
  // What media let through of the mean channel over segments, about: from o in direction d (unit) over `length` (which
  // may be infinite). It follows from the segment's place and time alone, and is the same from either end, whatever rays
  // see the media: what bidirectional methods weigh the techniques by that could have made a path, where densities of
  // tracked distances have no closed form. Exact for media that are the same everywhere. 1 in empty space.
  void (*meanTransmittance)(Group*, uint32_t n, const float* const o[3], const float* const d[3], const float* length,
                            const float* time, float* out);
  // Intervals of media along the listed rays of a list that was traced, up to their hits: geometry alone, nothing is
  // drawn. What has no density anywhere (a flame that glows) is a medium all the same.
  void (*mediumIntervals)(Group*, const RayList*, uint32_t n, const uint32_t* entries, MediumIntervals* out);
  // All media at n points of rays of a list that were traced: of the ray entries[i] at distance t[i]. As many hits as
  // there are media; sample addresses and times are the rays'.
  void (*mediaAt)(Group*, const RayList*, uint32_t depth, uint32_t n, const uint32_t* entries, const float* t,
                  MediaAt* out);
  // A list of rays with room for `capacity`, until the group ends; they leave empty space.
  RayList* (*makeRays)(Group*, uint32_t capacity);
  // Says that the ray at entries[i] of the list leaves point points[i] of the context: it takes over what is known of
  // the vertex. through[i]: 1 where it goes through the surface, which changes the media around it (null: none does).
  // Origin, direction and the other numbers of the ray are the integrator's. entries null: the points' own slots.
  void (*leave)(Group*, RayList*, const Context*, uint32_t n, const uint32_t* points, const uint32_t* entries,
                const uint32_t* through);
  // Nearest accepted hit of each listed ray: presence is decided, surfaces inside a medium of higher priority are
  // passed. Writes the list's hits. `transmittance` (by entry) gets what the media passed let through (1 in empty
  // space). `depth` addresses the random numbers of presence. Where media scatter (mediaScatter) a ray may end in one:
  // its hit is then the point of a medium, `transmittance` the factor on its path, and shade() makes contexts of such
  // points too (kTraitInSpace), with the phase function for a bxdf. Else media only take light away.
  void (*trace)(Group*, RayList*, RayKind, uint32_t depth, uint32_t n, const uint32_t* entries,
                float* const transmittance[3]);
  // Sorts the listed hits by shading program, evaluates and binds closures; contexts live until the group ends or
  // their memory is released. Returns their number. Rays that escaped must not be listed. `traits`: eye or light
  // path. Context::path tells a point's entry.
  uint32_t (*shade)(Group*, RayList*, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* entries,
                    Context* const** contexts);
  // Records of the listed points, and contexts of n records in any mixture: with equal bits, but for Context::path,
  // which is the record's index. Records of one depth and path share contexts. Points of media have records too; those
  // of pointsInSpace() have none.
  void (*keepVertices)(Group*, const Context*, uint32_t n, const uint32_t* points, VertexRecord* out);
  uint32_t (*shadeVertices)(Group*, uint32_t n, const VertexRecord* records, Context* const** contexts);
  // Records of n points that no ray found, in empty space, seen along their geometric normals, for shadeVertices().
  // They are packed: out[i] is of place which[i]; what is no place on a triangle of the world is left out. Returns
  // their number. out null: which places those are, and no more.
  uint32_t (*makeVertices)(Group*, uint32_t n, const SurfacePlaces*, VertexRecord* out, uint32_t* which);
  // Hits of rays that leave the listed points of a context (o, d, tMax, time by ray) on the objects of those points,
  // whatever presence, visibility and other objects have to say; or on the members of a set of objects, as far as
  // these are seen by indirect rays.
  void (*hitsOnObject)(Group*, const Context*, uint32_t n, const uint32_t* points, const Rays* rays, ObjectHits*);
  // Of n places P (render space) in the objects of the listed points: regions around them that the surface of that
  // object does not reach into, so that a way from P that ends in its region meets nothing of it. None is known very close
  // to the surface, and in objects that move or are no triangles. What is much farther than `reach` (render units) is
  // not looked for.
  void (*freeRegions)(Group*, const Context*, uint32_t n, const uint32_t* points, const float* const P[3],
                      const float* reach, FreeRegions* out);
  // releaseMemory() lets go of all memory and contexts made since the mark was taken; marks nest. A loop that needs
  // only its last vertex keeps within the cache that way.
  MemoryMark (*markMemory)(Group*);
  void (*releaseMemory)(Group*, MemoryMark);
  // One light sample for each point; u: kDimLightChoice and kDimLight of the vertex, sub-sample `part` of `parts`.
  void (*lightSamples)(Group*, const Context*, uint32_t part, uint32_t parts, LightSamples*);
  // Light met by the listed rays (after trace). Camera rays stop at lights seen by the camera.
  void (*lightHits)(Group*, RayList*, RayKind, uint32_t n, const uint32_t* entries, LightHits*);
  // Lights that the listed rays (after trace, before their hits are shaded) would meet beyond what they hit, were
  // they to go straight on, where that lets tinted shadows pass; nothing in between is looked at. With a tinted
  // shadow ray for each entry this is the other half of light samples behind tinted shadow rays.
  void (*lightsBeyond)(Group*, RayList*, uint32_t n, const uint32_t* entries, LightHits*);
  void (*shadow)(Group*, uint32_t depth, const ShadowRays*);
  void (*contribute)(Group*, const Contributions*);
  // Marks the listed slots as covering their pixel: alpha.
  void (*cover)(Group*, uint32_t n, const uint32_t* slots, const float* alpha);
  // Light paths: fills the first n of the group's paths with emitted rays. The arrays are the group's memory.
  void (*emitLight)(Group*, uint32_t n, EmittedLight*);
  void (*lightEnds)(Group*, LightEnds*);
  void (*connectCamera)(Group*, const Context*, CameraConnection*);
  // Adds values at raster positions, through the picture's pixel filter; the renderer normalises light paths of a pass.
  // By splat: `state` is that of the path read from the camera, `light` the index of the light that it began at.
  void (*splat)(Group*, uint32_t n, const float* const raster[2], const float* const value[3], const uint32_t* state,
                const uint32_t* light);
  // Event codes of the automaton for what integrators add themselves: kLobeVolume with kLobeDiffuse for a phase
  // function.
  uint16_t (*event)(Group*, uint32_t type, uint32_t lobe);
  // Records of the listed paths of the group, one each, for list `list` of IntegratorTraits::lists.
  void (*append)(Group*, uint32_t list, uint32_t n, const uint32_t* slots, const void* records);
  // All records of this pass that an earlier stage has written; and where in them those of n paths are, by path
  // number and sample index.
  StoredRecords (*stored)(Group*, uint32_t list);
  void (*findStored)(Group*, uint32_t list, uint32_t n, const uint64_t* paths, const uint32_t* samples,
                     uint64_t* first, uint32_t* count);
  // One more point on each listed ray, after trace() and lightHits(), where a medium scatters light of a lamp nearby: where distances
  // drawn by extinction alone would seldom come. Not all rays have one. shade() makes contexts of them (with
  // kTraitScattersOnce, for no directions are followed from there), which take light samples as if these were all the
  // light. Points where trace() ended the rays then have a share only in what light samples there, and rays from there,
  // find of lights. `depth` is that of trace().
  // With parts > 1: part `part` of so many calls for the same rays, each of which has one point of a ray; what they find adds
  // up, and the shares of points where rays ended are to be averaged.
  void (*scatterTowardsLights)(Group*, RayList*, uint32_t depth, uint32_t part, uint32_t parts, uint32_t n,
                               const uint32_t* entries, TowardsLights*);
  // What IntegratorFunctions::commit has made of the records; null: nothing.
  const void* (*index)(Group*);
  // Records that the listed paths leave to be learned from, one each; a path may leave several, one call after the other.
  // Slots that do not teach must not be listed.
  void (*teach)(Group*, uint32_t n, const uint32_t* slots, const void* records);
  // What IntegratorFunctions::learn has made of the epochs before that of the group's samples; null: nothing yet.
  const void* (*learned)(Group*);
  // Points in space at distance t[entry] along the listed rays: where a medium scatters. The context takes light
  // samples and camera connections; it has no bxdf, no slots and no parameters (kTraitInSpace), N and Ng are wo. All
  // lights light them; with kTraitComesOut among the traits those that light what the rays left.
  Context* (*pointsInSpace)(Group*, RayList*, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* entries,
                            const float* t);
  // Paths below the surface that went in at the listed points and came out there too, for want of another place: they
  // are counted, and the frame ends with a message that names an object.
  void (*noteBelow)(Group*, const Context*, uint32_t n, const uint32_t* points, BelowSurface);
  // Manifold walks. traceWalks: nearest hits of the listed rays with what walks go through, as if there were nothing
  // else; surfaces inside a medium of higher priority are passed as trace() passes them. shade() takes such hits.
  void (*traceWalks)(Group*, RayList*, uint32_t depth, uint32_t n, const uint32_t* entries);
  // Places on lights for n walks; u: the light (0), then four numbers; by walk, padded.
  void (*walkTargets)(Group*, uint32_t n, const float* const u[5], const float* time, WalkTargets* out);
  // What the listed rays bring from delta lights (`light`, by entry) that they point at, if nothing is in between; and
  // the lights' factors on specular lobes. By entry. A light that is not linked to the vertex that a ray left is black.
  void (*deltaLights)(Group*, const RayList*, uint32_t n, const uint32_t* entries, const uint32_t* light,
                      float* const radiance[3], float* specular);
  void (*noteWalks)(Group*, const WalkNote*);
  // Rows of Group::lightWeights by which the points of a context choose their lights, by point (padded): for light
  // samples there, and for what is said of lights that rays from there meet. To be said before either. Only where an
  // integrator learns (IntegratorTraits::learning).
  void (*weighLights)(Group*, const Context*, const uint32_t* rows);
  // All lights along the listed rays (after trace, before their hits are shaded), as if there were neither surfaces nor
  // media: the other half of light samples without shadow rays. Nothing blocks.
  void (*lightsAlong)(Group*, RayList*, uint32_t n, const uint32_t* entries, LightHits*);
  // One sample of that light for each point, which lightSamples() leave out: `part` of the `parts` that it asks for.
  // Its estimate is that of lightSamples(), over Group::besideOwnSamples, which must be set.
  void (*ownLightSamples)(Group*, const Context*, uint32_t light, uint32_t part, uint32_t parts, LightSamples*);
};

// At the barrier behind a stage, on one thread.
struct CommitServices {
  void* host;
  uint32_t firstSample, lastSample;  // of the pass, half open
  StoredRecords (*stored)(const CommitServices*, uint32_t list);
  // Memory until the pass ends, aligned to 64 bytes; null: there is not so much, and the frame will end.
  void* (*allocate)(const CommitServices*, uint64_t bytes);
  // Calls body(context, i) for i from 0 to n - 1, on all threads.
  void (*parallelFor)(const CommitServices*, uint64_t n, void* context, void (*body)(void* context, uint64_t i));
  // What Services::index gives from now on in this pass.
  void (*setIndex)(const CommitServices*, const void* index);
};

// At the end of an epoch, on one thread.
struct LearnServices {
  void* host;
  uint32_t firstSample, lastSample;  // of the epoch, half open
  float worldCenter[3], worldRadius;
  StoredRecords records;  // of the epoch, in the order of sample index, path number and teaching
  // What was learned before, null at the end of the first epoch. It holds until learn() returns.
  const void* state;
  uint64_t stateBytes;
  // Memory for the state from now on, zeroed and aligned to 64 bytes; when it is not asked for the old one stays. It is
  // plain data without pointers, a function of the records and the state before alone: not of threads. Null: there is
  // not so much memory, and the frame will end.
  void* (*makeState)(const LearnServices*, uint64_t bytes);
  // Memory until learn() returns, aligned to 64 bytes; null as above.
  void* (*allocate)(const LearnServices*, uint64_t bytes);
  // Calls body(context, i) for i from 0 to n - 1, on all threads.
  void (*parallelFor)(const LearnServices*, uint64_t n, void* context, void (*body)(void* context, uint64_t i));
};

struct IntegratorFunctions {
  void (*integrate)(const void* integrator, uint32_t stage, Group*, const Services*);
  // Makes an index of what the stage stored (null: none is wanted). It must not depend on threads.
  void (*commit)(const void* integrator, uint32_t stage, const CommitServices*) = nullptr;
  // Makes the state of the next epoch (IntegratorTraits::learning).
  void (*learn)(const void* integrator, const LearnServices*) = nullptr;
};

struct IntegratorTraits {
  // Stages of a pass, in order; null: one stage of camera paths.
  uint32_t (*stages)(const void* integrator, Stage* out, uint32_t capacity);
  // Lists of records that it keeps between stages, at most 16; null: none.
  uint32_t (*lists)(const void* integrator, RecordList* out, uint32_t capacity) = nullptr;
  // The most samples that a pass may hold; 0: the renderer's choice. Records live for a pass.
  uint32_t passSamples = 0;
  // Whether contexts may be points of media (0, null: to this integrator media only take light away).
  uint32_t (*scattersInMedia)(const void* integrator) = nullptr;
  // What it learns; returns 0 where this node learns nothing (null: none does).
  uint32_t (*learning)(const void* integrator, Learning* out) = nullptr;
  // Whether it asks bit 0 of Context::eventOfSlot (specular) beside what outputs and lights ask: no slot then holds
  // lobes of both kinds, but where there are more than kMaxSlots (null: it does not).
  uint32_t (*tellsLobesApart)(const void* integrator) = nullptr;
};

inline uint32_t scatterInMedia(const void*) { return 1; }  // of those that always do

}  // namespace kinora
