// Checks of a light against the contract of light.h: what sample() makes against what intersect() and evaluate() see,
// the density's integral, irradiance, emitted power, equal bits at all widths. Called by tests over the registry, by
// kinora-check-plugin and by plug-in authors. It traces no scene: nothing shadows the light.
//
// Names of the checks, as failures begin with them:
//   finite          outputs are written and finite, directions are unit vectors, densities not negative
//   width           all widths give the same bits, for several counts
//   consistent      evaluate (after intersect, for finite lights) finds the density, distance and radiance of sample
//   chi-square      directions made by sample are distributed as evaluate's pdf says
//   pdf-integral    that pdf integrates to the probability of a sample, never above 1
//   irradiance      by sampling and by integration over directions; by the declared closed form where there is one
//   power           by emit and by sample from points about the light
//   emission        emitted rays start on the light, and seen from there have the radiance that evaluate gives
//   declaration     a table or create() that cannot be used
#pragma once
#include <kinora/light.h>
#include <kinora/testing/report.h>
#include <kinora/testing/setting.h>

namespace kinora::testing {

struct LightCheckOptions {
  uint64_t seed = 1;  // of all random numbers: the same seed gives the same report
  uint32_t randomSettings = 24;
  uint32_t samples = 1u << 16;  // of each statistical test
};

// The value of a file parameter for which the kit's host hands out a small image with bright and dark regions.
inline constexpr const char* kTestImage = "kinora-test-image";

// All settings derived from the declaration, at several placements.
CheckReport checkLight(const Descriptor& light, const LightCheckOptions& options = {});
// One setting at all placements.
CheckReport checkLight(const Descriptor& light, const Setting& setting, const LightCheckOptions& options = {});

}  // namespace kinora::testing
