// Distances in media that suit lights. Extinction alone knows nothing of a lamp in thin fog: it lets most rays through,
// and stops few where the lamp is near. So a point of some light is taken for each ray, and one more distance drawn: by
// the angle at which that point sees the ray (Kulla and Fajardo, EGSR 2012), by what there is to scatter light and by
// what of it gets back, cell by cell, as far as means of cells tell. (Suns and domes see all of it under one angle; in thin
// media it pays all the same to have a place on each ray.) Both distances take light samples, and share what
// they find by the power heuristic. Shares that sum to 1 at each distance are right in the mean whatever they follow
// from, so means will do where the densities of tracking are not known.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "sampling/draw.h"
#include "shade/beer_lambert.h"
#include "shade/clock.h"
#include "shade/context_host.h"
#include "shade/equiangular.h"
#include "shade/medium_tracks.h"

namespace kinora::shade {

namespace {

constexpr float kDeep = 5;      // optical depth beyond which nothing is looked for
constexpr float kThin = 1.1f;   // where 1 / kWorthIt is lost: 1 - exp(-1.1)
constexpr float kThick = 0.4f;  // of a stretch that is divided
constexpr int kParts = 6;       // into so many of the same angle
// A distance is drawn for so many of the rays of that depth: those of the camera, and fewer the farther paths have come.
constexpr float kChance[] = {1, 0.5f, 0.25f};
constexpr uint32_t kChances = std::size(kChance);
constexpr float kWorthIt = 1.5f;  // so much denser than the other distances, averaged over themselves

float weighed(const float path[3], const float x[3]) { return path[0] * x[0] + path[1] * x[1] + path[2] * x[2]; }

// A part of a ray in media, as a light's point sees it.
struct Piece {
  float from, to;
  float firstAngle, angle;  // and the angle that it spans
  float plain, towards;     // light that gets back times what scatters it, by length: for either kind of distances
};
constexpr uint32_t kMostPieces = 192;  // beyond them no more is looked for

// What is known of a ray's pieces: `density` of its distances at t, by `all`, and what extinction would draw there.
struct Pieces {
  uint32_t count = 0;
  float all = 0,
        squares = 0;  // integral of the densities, before they are normed; of their square over the plain ones
  Piece piece[kMostPieces];
  const Piece* at(float t) const {
    for (uint32_t k = 0; k < count; ++k)
      if (t >= piece[k].from && t < piece[k].to) return piece + k;
    return nullptr;
  }
  float density(const EquiangularPoint& p, const Piece& x, float t) const {
    return x.towards * angleDensity(p, t) / all;
  }
};

// Up to `reach` along the track.
void findPieces(MediumTracks& media, const Track& track, const EquiangularPoint& p, float reach, Pieces& out) {
  TrackAhead ahead(track);
  Track& t = ahead.t;
  float depth[3] = {0, 0, 0}, through[3] = {1, 1, 1};
  MediumTracks::Stretch s;
  out.count = 0;
  out.all = out.squares = 0;
  for (;;) {
    media.stretch(t, s);
    const float until = std::min(s.until, reach);
    const float thick = weighed(t.path, s.extinction) * (until - t.t);
    if (thick > 0) {
      const int parts = thick > kThick ? kParts : 1;
      const float first = angleAt(p, t.t), part = (angleAt(p, until) - first) / float(parts);
      float from = t.t;
      for (int k = 1; k <= parts; ++k) {
        const float to = k == parts ? until : std::clamp(distanceAt(p, first + part * float(k)), from, until);
        float after[3], plain[3], towards[3];
        for (int c = 0; c < 3; ++c) {
          depth[c] += s.extinction[c] * (to - from);
          after[c] = c && depth[c] == depth[0] ? after[0] : beerLambert(depth[c], 1.f);
          const float mean = 0.5f * (through[c] + after[c]);
          through[c] = after[c];
          plain[c] = s.plain[c] * mean;
          towards[c] = s.towards[c] * mean;
        }
        if (to > from) {
          if (out.count == kMostPieces) return;
          const Piece x{
              from, to, first + part * float(k - 1), part, weighed(t.path, plain), weighed(t.path, towards)};
          const float own = x.towards * x.angle;
          out.all += own;
          if (own > 0) out.squares += own * own / (x.plain * (to - from));  // infinite where nothing is plain
          out.piece[out.count++] = x;
        }
        from = to;
      }
    }
    if (!(until < reach) || !media.pass(t, until)) return;
  }
}

// On along the track to a distance.
void goTo(MediumTracks& media, Track& t, float to) {
  MediumTracks::Stretch s;
  for (;;) {
    media.stretch(t, s);
    if (to <= s.until || !media.pass(t, s.until)) break;
  }
  t.t = to;
}

// Where a ray comes to so deep, or leaves the media for good (then true); and where those begin on it that distances
// are to suit lights in, -1: nowhere.
bool findReach(MediumTracks& media, const Track& track, float deep, float& begin, float& end) {
  TrackAhead ahead(track);
  Track& t = ahead.t;
  MediumTracks::Stretch s;
  begin = -1;
  for (float depth = 0;;) {
    media.stretch(t, s);
    const float lost = weighed(t.path, s.extinction), more = lost * (s.until - t.t);
    if (weighed(t.path, s.towards) > 0 && begin < 0) begin = t.t;
    if (depth + more > deep) {
      end = t.t + (deep - depth) / lost;
      return false;
    }
    depth += more;
    end = s.until;
    if (!media.pass(t, end)) return true;
  }
}

// About the radius of the light that was sampled, by how large it looks: from one place it is, and its density is that
// of the sample without the choice.
float radiusOf(float t, float density) {
  return density > 0 && t < 1e30f ? t / std::sqrt(3.14159265f * density) : 0.f;
}

// What was found of a ray that another distance is drawn on.
struct Drawn {
  uint32_t track;
  float t, density, weight;
};

}  // namespace

void GroupState::scatterTowardsLights(RayList& list, uint32_t depth, uint32_t part, uint32_t parts, uint32_t n,
                                      const uint32_t* entries, TowardsLights* out) {
  *out = TowardsLights{};
  if (!world_.space || !world_.lights->size() || !n) return;
  const Clock clock(counters.nanoseconds[kTimeLights]);
  const SpaceMedia& space = *world_.space;
  const ListHost& host = ListHost::of(list);
  const MediaSight sight = mediaSeen(list, n, entries);
  findCrossings(list.rays, n, entries, sight);
  crossings_.swap(crossingsTowards_);  // samples of lights look for crossings too
  const float* reaches = clippedEnds(arena_, list, host.surfaceT, n, entries);
  MediumTracks tracks(*this, crossingsTowards_, list.rays, reaches, list.sampleSeed, list.sampleIndex,
                      host.left.bounces, depth, n, entries, true, part, parts);
  const uint32_t count = tracks.count();
  if (!count) return;
  const auto floats = [&](size_t m) { return arena_.make<float>(m); };

  // a place on each ray, and from there a point of a light
  const float chance = depth < kChances ? kChance[depth] : kChance[kChances - 1];
  bool* draws = arena_.make<bool>(count);
  uint32_t *asked = arena_.make<uint32_t>(padded(count)), *trackOf = arena_.make<uint32_t>(padded(count)), m = 0;
  float *reach = floats(padded(count)), *place = floats(list.capacity);
  for (uint32_t i = 0; i < count; ++i) {
    Track& t = tracks[i];
    setPathOf(list, t);
    t.seed = mixedSeed(t.seed, 0x3C6EF372u + part);
    // towards what has no place distances only count where extinction lets most rays through
    float begin, end;
    const bool isThin = findReach(tracks, t, world_.hasPlacedLights ? kDeep : kThin, begin, end);
    if (begin < 0 || !(end > begin) || !(end < 1e30f) || !(isThin || world_.hasPlacedLights)) continue;
    const bool isDrawn = chance >= 1 || MediumTracks::number(t) < chance;
    if (!isDrawn && !(list.hits.t[t.entry] < host.surfaceT[t.entry])) continue;
    draws[m] = isDrawn;
    place[t.entry] = begin + (end - begin) * MediumTracks::number(t);
    reach[m] = end;
    trackOf[m] = i;
    asked[m++] = t.entry;
  }
  if (!m) return;
  LightSamples lights;
  const Context* points = startInSpace(list, kTraitEyePath, depth, m, asked, place);
  lightSamples(points, part, parts, &lights);

  float *choice = floats(points->padded), *size = floats(points->padded);
  uint32_t* chosenLight = arena_.make<uint32_t>(points->padded);
  const VertexState& state = ContextHost::of(points).state;
  for (uint32_t i = 0; i < points->padded; ++i) {
    choice[i] = 1;
    chosenLight[i] = lights.light[i] == kNoLight ? 0 : lights.light[i];  // what media emit has no number here
  }
  light::LightSet::Points where{};
  where.count = m;
  where.padded = points->padded;
  for (int k = 0; k < 3; ++k) {
    where.P[k] = points->P[k];
    where.N[k] = state.lightN[k];
  }
  where.time = points->time;
  where.linkSet = state.linkSet;
  where.weights = group_.lightWeights;
  where.row = state.lightRow;
  world_.lights->probabilities(world_.width, where, chosenLight, choice);
  for (uint32_t i = 0; i < m; ++i) {
    const float known = lights.light[i] != kNoLight && choice[i] > 0 ? choice[i] : 1.f;
    size[i] = lights.flags[i] & kSampleDelta ? 0.f : radiusOf(lights.t[i], lights.pdf[i] / known);
  }

  // a distance for each of them
  float* share = floats(list.capacity);
  for (uint32_t i = 0; i < n; ++i) share[entries[i]] = 1;
  out->share = share;
  const float number = chance * float(parts);  // of these distances, in the mean
  Drawn* drawn = arena_.make<Drawn>(m);
  Pieces& pieces = *arena_.make<Pieces>(1);
  uint32_t found = 0;
  for (uint32_t i = 0; i < m; ++i) {
    if (!(lights.pdf[i] > 0)) continue;
    Track& t = tracks[trackOf[i]];
    const uint32_t s = t.entry;
    float o[3], d[3], p[3];
    for (int k = 0; k < 3; ++k) {
      o[k] = list.rays.o[k][s];
      d[k] = list.rays.d[k][s];
      p[k] = points->P[k][i] + lights.wi[k][i] * lights.t[i];
    }
    const EquiangularPoint seen = lights.t[i] < 1e30f ? seenFrom(o, d, p, size[i]) : kPointAtInfinity;
    const float met = list.hits.t[s] < host.surfaceT[s] ? list.hits.t[s] : -1;
    findPieces(tracks, t, seen, reach[i], pieces);
    if (!(pieces.all > 0) || !(pieces.squares > kWorthIt * pieces.all * pieces.all)) continue;
    const Piece* at = met >= 0 ? pieces.at(met) : nullptr;
    if (at && at->towards > 0) {
      const float r = number * pieces.density(seen, *at, met) / at->plain;
      share[s] = 1 / (1 + r * r);
    }
    if (!draws[i]) continue;
    float rest = tracks.numberTowards(trackOf[i]) * pieces.all;
    Drawn x{trackOf[i], -1, 0, 0};
    for (uint32_t k = 0; k < pieces.count && (rest > 0 || x.t < 0); ++k) {
      const Piece& y = pieces.piece[k];
      const float own = y.towards * y.angle;
      if (!(own > 0)) continue;
      x.t = std::clamp(distanceAt(seen, y.firstAngle + y.angle * std::min(rest / own, 1.f)), y.from, y.to);
      x.density = number * pieces.density(seen, y, x.t);
      const float r = y.plain / x.density;
      x.weight = 1 / (1 + r * r);
      rest -= own;
    }
    if (!(x.t > 0) || !(x.density > 0)) continue;
    goTo(tracks, t, x.t);
    drawn[found++] = x;
  }
  if (!found) return;

  // which medium scatters there, and what of it comes back
  uint32_t lookups = 0;
  for (uint32_t i = 0; i < found; ++i) lookups += tracks[drawn[i].track].count;
  MediumLookups media(arena_, padded(lookups), false);
  for (uint32_t i = 0; i < found; ++i) {
    const Track& t = tracks[drawn[i].track];
    for (uint32_t k = 0; k < t.count; ++k) media.add(space, t, t.around[k]);
  }
  media.run(*this, list.rays, depth);
  counters.mediaLookups += lookups;
  RayList* ends = new (arena_.allocate(sizeof(RayList))) RayList(list);
  Hits& hits = ends->hits;
  const auto words = [&] { return arena_.make<uint32_t>(list.capacity); };
  for (float** x : {&hits.t, &hits.u, &hits.v, &hits.ng[0], &hits.ng[1], &hits.ng[2]}) *x = floats(list.capacity);
  for (uint32_t** x : {&hits.instance, &hits.geometry, &hits.primitive, &hits.level}) *x = words();
  float *factor[3], *far = floats(list.capacity);
  for (float*& x : factor) x = floats(list.capacity);
  uint32_t *chosen = arena_.make<uint32_t>(padded(found)), going = 0;
  for (uint32_t i = 0, at = 0; i < found; ++i) {
    const Drawn& x = drawn[i];
    Track& t = tracks[x.track];
    float met = 0;
    const auto own = [&](uint32_t k) {
      const float e[3] = {media.extinction[0][at + k], media.extinction[1][at + k], media.extinction[2][at + k]};
      return weighed(t.path, e);
    };
    for (uint32_t k = 0; k < t.count; ++k) met += own(k);
    if (met > 0) {
      float rest = MediumTracks::number(t) * met, part = 0;
      uint32_t which = 0;
      for (uint32_t k = 0; k < t.count && (rest >= 0 || !(part > 0)); ++k) {
        if (!(own(k) > 0)) continue;
        which = k;
        part = own(k);
        rest -= part;
      }
      const SpaceMedium& here = space.media[t.around[which].medium];
      setMediumHit(hits, t.entry, here, x.t);
      const bool isHole =
          hole_ && host.kind == RayKind::Camera && world_.placements[world_.world->instance(here.instance).info].hole;
      const float brings = isHole ? 0.f : t.bounces ? here.contributionByBounce : 1.f;
      for (int c = 0; c < 3; ++c) {
        factor[c][t.entry] = host.absorbed[c] ? host.absorbed[c][t.entry] : 1.f;
        factor[c][t.entry] *= brings * x.weight * media.extinction[c][at + which] * met / (part * x.density);
      }
      absorbUntil(list, t.entry, x.t, factor);
      far[t.entry] = x.t;
      chosen[going++] = t.entry;
    }
    at += t.count;
  }
  std::sort(chosen, chosen + going);
  if (going)
    thinOut(list.rays, far, sight, list.sampleSeed, list.sampleIndex, host.left.bounces, depth, going, chosen,
            factor);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < going; ++i) {
    float sum = 0;
    for (float* f : factor) sum += std::fabs(f[chosen[i]]);
    if (sum > 0 && sum < 1e30f) chosen[kept++] = chosen[i];
  }
  for (uint32_t i = kept; kept && i < padded(kept); ++i) chosen[i] = chosen[kept - 1];
  out->list = ends;
  out->count = kept;
  out->entries = chosen;
  for (int c = 0; c < 3; ++c) out->factor[c] = factor[c];
}

}  // namespace kinora::shade
