// What the forward path loop is asked to do; see path_loop.h. Plain: set-up code of integrators fills it.
#pragma once
#include <kinora/guiding_state.h>
#include <kinora/manifold_options.h>
#include <kinora/samples_by_lobe.h>

#include <cstdint>

namespace kinora {

struct PathLoopOptions {
  uint32_t maxIndirectBounces = 8;  // 0: direct light only
  uint32_t lightSamples = 1;        // at camera hits; deeper vertices take one
  uint32_t indirectSamples = 1;     // directions followed from each camera hit
  SamplesByLobe byLobe;             // instead of that
  uint32_t lightCandidates = 1;     // of which each light sample there is one, see kinora/light_candidates.h
  uint32_t placesInMedia = 1;       // on each camera ray where lights are near, see Services::scatterTowardsLights
  uint32_t clampDepth = 2;          // ray depth (camera ray: 0) from which contributions are clamped
  float clampLuminance = 10;        // largest luminance of one contribution there
  float clampDirect = 1e30f;        // and before, but of lights that the camera sees
  float clampCaustic = 1e30f;       // of what manifold walks bring, if that is less
  float emission = 1;               // factor on what surfaces emit
  float farthest = 1e30f;           // surfaces this far from where an indirect or shadow ray starts are not met
  float unshadowedEnd = 0;          // how much of their shadows light samples at the last vertices leave out, to 1
  bool refractsAlpha = false;       // see kinora/refracted_alpha.h
  int32_t mostPassed = -1;          // Group::mostPassed; -1: no limit
  uint32_t rouletteDepth = 4;       // vertex from which Russian roulette is played
  float rouletteThreshold = 0.2f;   // on paths whose throughput is below
  // Light found through a mirror or lens after a diffuse bounce counts. Otherwise shadow rays go straight through
  // glass and take its tint; what refracted paths then find of the same light is left out.
  bool allowCaustics = false;
  bool guides = false;        // directions by what the frame has learned, see kinora/guiding.h
  bool learnsLights = false;  // which lights are worth a sample, region by region
  guiding::Options guiding;
  // IntegratorTraits::tellsLobesApart
  bool tellsLobesApart() const { return byLobe.given || refractsAlpha; }
  // Manifold walks find the light of its `cheapCaustics` lights behind walkable surfaces, whatever allowCaustics says.
  ManifoldOptions manifold;
};

}  // namespace kinora
