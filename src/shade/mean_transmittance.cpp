// What media let through along segments, about: see Services::meanTransmittance.
#include <algorithm>
#include <cmath>

#include "shade/beer_lambert.h"
#include "shade/clock.h"
#include "shade/medium_tracks.h"

namespace kinora::shade {

void GroupState::meanTransmittance(uint32_t n, const float* const o[3], const float* const d[3], const float* length,
                                   const float* time, float* out) {
  std::fill_n(out, n, 1.f);
  if (!world_.space || !n) return;
  const Clock clock(counters.nanoseconds[kTimeLights]);
  const ArenaScope memory(arena_);
  RayList& list = *makeRays(n);
  uint32_t* entries = arena_.make<uint32_t>(padded(n));
  float* ends = arena_.make<float>(padded(n));
  for (uint32_t i = 0; i < padded(n); ++i) {
    const uint32_t from = std::min(i, n - 1);
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][i] = o[k][from];
      list.rays.d[k][i] = d[k][from];
    }
    list.rays.time[i] = time[from];
    list.sampleSeed[i] = list.sampleIndex[i] = 0;
    entries[i] = i;
    ends[i] = std::min(length[from], 1e30f);
  }
  // whatever rays see them: those of the other techniques see them otherwise
  findCrossings(list.rays, n, entries, ~0u);
  MediumTracks tracks(*this, crossings_, list.rays, ends, list.sampleSeed, list.sampleIndex, nullptr, 0, n, entries,
                      false);
  MediumTracks::Stretch s;
  for (uint32_t i = 0; i < tracks.count(); ++i) {
    Track& t = tracks[i];
    float depth[3] = {0, 0, 0};
    do {
      tracks.stretch(t, s);
      for (int c = 0; c < 3; ++c) depth[c] += s.extinction[c] > 0 ? s.extinction[c] * (s.until - t.t) : 0.f;
    } while (tracks.pass(t, s.until));
    float sum = 0;
    for (const float x : depth) sum += beerLambert(x, 1.f);
    constexpr float kLeast = 1e-20f;  // a weight may be 0 by rounding, but no quotient of two of them undefined
    out[t.entry] = std::max(sum * (1.f / 3), kLeast);
  }
}

}  // namespace kinora::shade
