// The interface of a light: sampled from points (next-event estimation), hit by rays (the other half of multiple
// importance sampling), and sampled for emitted rays (light paths). Functions belong to a kind: each lane of a call
// has a light of its own, so that a thousand lamps of one plug-in fill the lanes as one does. Called by light/ for
// groups of points that chose lights of one kind. Render space throughout; radiance is scene-linear Rec. 709.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

// What the host needs to know of a light, filled once after create(). Lights are chosen by the irradiance that they
// could bring to a point, so what is said here must hold: where a light does not reach by these words it is never
// sampled.
struct LightDescription {
  float center[3], radius;  // bounding sphere, render space; radius < 0: infinite (dome, distant)
  float power;              // average over RGB of the emitted power (W-like units), for choosing among lights;
                            // infinite lights: radiance integral over directions. 0: black, and never asked
  int isInfinite;           // escaping rays see it
  int isDelta;              // no ray can hit it by chance
  int visibleToCamera;      // set by the host from attributes, 1 by default
  float diffuse, specular;  // factors on diffuse and specular lobes
  // Bounding box, where it is tighter than the sphere; low = high = 0: that of the sphere.
  float low[3], high[3];
  // Finite lights: its normals lie within the angle of cosNormals about `axis` (unit), and it emits within the angle
  // of cosEmission about each of them, in proportion to the cosine. axis 0: to all sides, whatever the cosines.
  // Infinite lights: mean direction towards the light over the radiance that samples are made for; its length is 1 for a
  // single direction and 0 for light from all around.
  float axis[3];
  float cosNormals, cosEmission;
  int isTwoSided;  // emits likewise about the opposite normals
  // Infinite lights: cosine of the angle about `axis` within which all of it lies; rays that point elsewhere do not
  // ask for it. 0 (the host's default) and below: anywhere.
  float cosReach;
  // Of `power`: for how much of it samples are made; the rest is left to rays that find the light. It counts in the
  // choice among lights. 0: all of it.
  float sampledShare;
};

// The lights of a call, by lane: instances of one plug-in. lightStride 1: an array of padded length; 0: all lanes
// have light[0].
struct LightLanes {
  const void* const* light;
  uint32_t lightStride;
};

// n points (padded); arrays of padded length.
struct LightSampleArgs : LightLanes {
  uint32_t count;
  const float* P[3];
  const float* time;
  const float* u[2];                  // in [0, 1)
  float worldCenter[3], worldRadius;  // bounding sphere of the scene, render space
  float* wi[3];                       // out: unit, towards the light
  float* distance;                    // out: to the sampled point; infinity for infinite lights
  float* radiance[3];                 // out: arriving if nothing is in between
  float* pdf;       // out: per solid angle; 0: no sample here. Delta lights: 1, and kSampleDelta in flags
  uint32_t* flags;  // out
};
enum LightSampleFlags : uint32_t { kSampleDelta = 1 };

struct LightRayArgs : LightLanes {
  uint32_t count;
  const float* o[3];
  const float* d[3];  // unit
  const float* time;
  float worldCenter[3], worldRadius;
  float* t;            // intersect: in the farthest distance wanted, out the hit nearer than it (else unchanged,
                       // and hit = 0); evaluate: in
  uint32_t* hit;       // intersect: out
  float* radiance[3];  // evaluate: out, from the hit point (or from infinity) along -d
  float* pdf;          // evaluate: out, density per solid angle with which sample() from o makes d
};

struct LightEmitArgs : LightLanes {
  uint32_t count;
  const float* u[4];
  const float* time;
  float worldCenter[3], worldRadius;
  float* o[3];  // out: point on the light (on a disk outside the world for infinite lights)
  float* d[3];  // out: unit direction of emission
  float* N[3];  // out: unit normal at o (d itself for infinite and delta lights)
  float* radiance[3];
  float* pdfPosition;   // out: per area
  float* pdfDirection;  // out: per solid angle
};

// Rays that meet their light as evaluate()'s do, or point at it as samples of delta lights do: with which densities
// would emit() have made the light that comes back along them? What bidirectional weights ask of a light that a path
// found.
struct LightDensityArgs : LightLanes {
  uint32_t count;
  const float* o[3];
  const float* d[3];  // unit, towards the light
  const float* t;     // to the point on the light; any for infinite lights
  const float* time;
  float worldCenter[3], worldRadius;
  float* N[3];          // out: unit normal at the point on the light (-d for infinite lights)
  float* pdfPosition;   // out: per area, of the point; 0 where emit() makes no such ray
  float* pdfDirection;  // out: per solid angle, of -d from there
};

struct LightFunctions {
  void (*sample)(const LightSampleArgs*);
  void (*intersect)(const LightRayArgs*);  // null for infinite and delta lights
  void (*evaluate)(const LightRayArgs*);
  void (*emit)(const LightEmitArgs*);
  void (*densities)(const LightDensityArgs*);  // null: it does not say, and bidirectional methods do without it
  uint32_t mixes;  // 1: lanes with different lights cost as little as lanes with the same; 0: the host sorts them
};

// A light that lights nothing and marks the surfaces that it is linked to, in a display channel. Lights with one are
// never asked for light; light filters on them change the mark.
struct LightMark {
  const char* channel;  // the source of a display channel; lives as long as the light's data. "": none
  float color[3];       // added to the channel where a surface is marked; of a single float its luminance
  int inFirst;          // surfaces that the camera sees are marked,
  int inReflection;     // those that mirror-like reflections show,
  int inRefraction;     // those behind glass
  int isInverted;       // 1: the surfaces that the light is not linked to instead
  int isWeighted;       // 1: a reflection or refraction counts as much as it passes on, 0: all or nothing
};

struct LightTraits {
  void (*describe)(const void* light, LightDescription*);
  // Tests: closed form of the irradiance on a plane facing the light, or null (see docs of the testing kit).
  double (*irradiance)(const void* light, const double P[3], const double N[3]);
  void (*mark)(const void* light, LightMark*) = nullptr;  // null: it is no such light
};

// What a light declares.
struct LightPlugin {
  using Functions = LightFunctions;
  static constexpr Kind kKind = Kind::Light;
  const char* help = "";
  ListOf<Param> params = {};
  SetUp setUp = {};
  void (*describe)(const void* light, LightDescription*) = nullptr;
  double (*irradiance)(const void* light, const double P[3], const double N[3]) = nullptr;
  void (*mark)(const void* light, LightMark*) = nullptr;
  constexpr LightTraits traits() const { return {describe, irradiance, mark}; }
};

}  // namespace kinora
