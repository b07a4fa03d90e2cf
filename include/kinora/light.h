// The interface of a light: sampled from points (next-event estimation), hit by rays (the other half of multiple
// importance sampling), and sampled for emitted rays (light paths). Called by light/ for groups of points that chose
// the same light. Render space throughout; radiance is scene-linear Rec. 709.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

// What the host needs to know of a light, filled once after create().
struct LightDescription {
  float center[3], radius;  // bounding sphere, render space; radius < 0: infinite (dome, distant)
  float power;              // average over RGB of the emitted power (W-like units), for choosing among lights;
                            // infinite lights: radiance integral over directions, times pi R^2 of the world
  int isInfinite;           // escaping rays see it
  int isDelta;              // no ray can hit it by chance
  int visibleToCamera;      // set by the host from attributes, 1 by default
  float diffuse, specular;  // factors on diffuse and specular lobes
};

// n points (padded); arrays of padded length.
struct LightSampleArgs {
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

struct LightRayArgs {
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

struct LightEmitArgs {
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

struct LightFunctions {
  void (*sample)(const void* light, const LightSampleArgs*);
  void (*intersect)(const void* light, const LightRayArgs*);  // null for infinite and delta lights
  void (*evaluate)(const void* light, const LightRayArgs*);
  void (*emit)(const void* light, const LightEmitArgs*);
};

struct LightTraits {
  void (*describe)(const void* light, LightDescription*);
  // Tests: closed form of the irradiance on a plane facing the light, or null (see docs of the testing kit).
  double (*irradiance)(const void* light, const double P[3], const double N[3]);
};

}  // namespace kinora
