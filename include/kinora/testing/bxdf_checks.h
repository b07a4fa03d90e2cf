// Checks of a bxdf against the contract of bxdf.h: statistics of generate against evaluate, energy, reciprocity,
// equal bits at all widths, behaviour at the edges. Called by tests over the registry, by kinora-check-plugin and by
// plug-in authors. It knows no scene and does not judge what a material looks like.
//
// Names of the checks, as failures begin with them:
//   finite          outputs are written, finite, not negative; generated directions are unit vectors
//   width           all widths give the same bits, for several counts
//   evaluate-at     evaluateAt gives the bits of evaluate; varying parameters those of uniform ones
//   consistent      generate returns the pdf and weight that evaluate gives for its direction
//   side            reflecting lobes are zero below the surface, transmitting ones above it; flags and slots agree
//   reverse-pdf     pdfReverse is the pdf with the two directions exchanged
//   reciprocity     f (f / eta^2 across an interface) does not change when the directions are exchanged
//   transport       radiance and importance differ across an interface by the square of the relative index, else not
//   chi-square      directions made by generate are distributed as evaluate's pdf says
//   pdf-integral    the pdf integrates to the probability of a continuous sample, never above 1
//   weight-integral E[weight / pdf] is the integral of evaluate, slot by slot
//   furnace         albedo by sampling and by quadrature agree within 0.3 %
//   lossless        albedo is 1 within 1 % at the declared settings
//   conserving      albedo is at most 1.003 at the declared settings
//   declaration     traits and settings that cannot be used
#pragma once
#include <kinora/bxdf.h>
#include <kinora/testing/report.h>
#include <kinora/testing/setting.h>

namespace kinora::testing {

struct BxdfCheckOptions {
  uint64_t seed = 1;  // of all random numbers: the same seed gives the same report
  uint32_t randomSettings = 64;
  // Settings of the covering set that get the statistics, besides the defaults, lossless and conserving ones; which
  // ones rotates with `seed`. All settings get the exact checks.
  uint32_t statisticalSettings = 48;
  uint32_t samples = 1u << 16;  // of each chi-square test; four times as many at the declared settings
};

// All settings derived from the declaration.
CheckReport checkBxdf(const Descriptor& bxdf, const BxdfCheckOptions& options = {});
// One setting, in full.
CheckReport checkBxdf(const Descriptor& bxdf, const Setting& setting, const BxdfCheckOptions& options = {});

}  // namespace kinora::testing
