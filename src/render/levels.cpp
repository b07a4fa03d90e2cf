#include "render/levels.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "render/level_workspace.h"
#include "render/shading_floats.h"
#include "trace/world.h"

namespace kinora::render {

using geometry::Patches;
using Imath::V3d;
using Imath::V3f;
using trace::Tessellation;

namespace {

// Radii of a footprint that a pixel's length stands for. A camera ray's is half a pixel: it sees the finest rate also
// where a patch comes nearer to it than where rates were asked.
constexpr float kRadiiOfPixel = 1.41421356f;

// Footprints of diffuse bounces and of shadow rays to skies grow by up to half the distance. That is right for
// textures, whose means are what such rays want; coarse grids lose the crevices between bumps, whose shade is no mean.
// At an eighth no difference is measured from rays that all see the finest level.
constexpr float kMostSpread = 0.125f;

// Rays look into all patches whose boxes they meet. Where a bound makes these so many times as large as the patches, and
// there are no more micropolygons than this, all are diced once to find out where they are.
constexpr double kMostOverlap = 4;
constexpr double kMostDicedForBoxes = 64e6;

constexpr double kSameNormal = 1 - 1e-5;

std::string shortNumber(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

int kindOf(uint32_t mask) {
  if (mask & trace::kSeenByCamera) return 0;
  return mask & (trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow) ? 2 : 1;
}

// Added up on each thread, since every ray counts.
void countFound(std::atomic<uint64_t>& found) {
  thread_local uint32_t pending = 0;
  if (++pending < 1024) return;
  pending = 0;
  found.fetch_add(1024, std::memory_order_relaxed);
}

// Of a patch's outline.
constexpr uint8_t kUnknown = 0, kBeingMade = 1, kKnown = 2;

}  // namespace

LevelledSurface::LevelledSurface(Setup setup)
    : setup_(std::move(setup)),
      patches_(setup_.patches),
      normals_(patches_->mesh()->find("N")),
      keys_(patches_->keyCount()),
      workspaces_([this] { return std::make_unique<Workspace>(setup_.world); }) {
  const shade::MaterialSet& materials = *setup_.world.materials;
  isMovedByShader_ = materials.program(materials[setup_.world.placements[0].material].program).isMovedByShader;
  uint32_t slots = 0;
  size_t largest = 0;
  for (uint32_t p = 0; p < patches_->count(); ++p) {
    firstSlot_.push_back(slots);
    slots += uint32_t(std::max(patches_->eu(p), patches_->ev(p))) + 1;
    largest = std::max(largest, Tessellation::bytesFor(patches_->eu(p), patches_->ev(p), keys_));
  }
  slots_ = std::vector<trace::GeometryCache::Slot>(slots);
  outlines_.resize(patches_->count());
  outlineStates_ = std::vector<std::atomic<uint8_t>>(patches_->count());
  for (uint32_t p = 0; p < patches_->count() && keys_ == 1; ++p) edges_.push_back(edgesOf(p, {}));
  findBounds(setup_.stop);
  if (largest > setup_.cache->limit())
    setup_.world.diagnostics->warning("GEOMETRY-CACHE-SMALL", setup_.pos,
                                      "a patch of " + setup_.object + " takes " + std::to_string(largest) +
                                          " bytes where it is seen closely, the "
                                          "geometry cache holds " +
                                          std::to_string(setup_.cache->limit()),
                                      "it holds the patch that is in use, and each is diced again and again",
                                      "give it at least " + std::to_string(64 * largest / 1048576 + 1) +
                                          "M: --geometry-cache, or Option \"limits\" "
                                          "\"int geocachememory\"");
}

LevelledSurface::~LevelledSurface() { setup_.cache->forget(this); }

uint64_t LevelledSurface::bytes() const {
  return patches_->bytes() + boxes_.size() * sizeof boxes_[0] + edges_.size() * sizeof edges_[0] +
         outlines_.size() * (sizeof outlines_[0] + sizeof outlineStates_[0]) + firstSlot_.size() * sizeof(uint32_t) +
         slots_.size() * sizeof slots_[0];
}

void LevelledSurface::bounds(uint32_t patch, uint32_t key, float lower[3], float upper[3]) const {
  const Box& box = boxes_[size_t(patch) * keys_ + key];
  std::copy_n(box.data(), 3, lower);
  std::copy_n(box.data() + 3, 3, upper);
}

LevelledSurface::Box LevelledSurface::boxAt(uint32_t patch, const trace::Moment& at) const {
  const Box* const b = &boxes_[size_t(patch) * keys_ + at.key];
  if (!(at.part > 0)) return *b;
  Box out;
  for (size_t k = 0; k < 6; ++k) out[k] = at.mix(b[0][k], b[1][k]);
  return out;
}

LevelledSurface::Box LevelledSurface::boxOf(uint32_t patch) const {
  const Box* const b = &boxes_[size_t(patch) * keys_];
  Box out = *b;
  for (uint32_t key = 1; key < keys_; ++key)
    for (size_t k = 0; k < 3; ++k) {
      out[k] = std::min(out[k], b[key][k]);
      out[3 + k] = std::max(out[3 + k], b[key][3 + k]);
    }
  return out;
}

// Every resolution lies within the finest one's box.
void LevelledSurface::findBounds(const std::atomic<bool>* stop) {
  boxes_.resize(size_t(patches_->count()) * keys_);
  const auto areaOf = [](const Imath::Box3d& box) {
    const V3d s = box.size();
    return s.x * s.y + s.y * s.z + s.z * s.x;
  };
  double areas = 0, wideAreas = 0, micropolygons = 0;
  const auto set = [&](uint32_t patch, uint32_t key, const Imath::Box3d& box) {
    const V3d size = box.size();
    double most = 0;
    for (int k = 0; k < 3; ++k) most = std::max({most, std::fabs(box.min[k]), std::fabs(box.max[k])});
    const double more = 1e-4 * size.length() + 1e-6 * most + 1e-30;  // than rounding may take away
    Box& of = boxes_[size_t(patch) * keys_ + key];
    for (int k = 0; k < 3; ++k) {
      of[size_t(k)] = float(box.min[k] - more);
      of[size_t(3 + k)] = float(box.max[k] + more);
    }
  };
  if (setup_.bound > 0) {
    longest_ = setup_.bound;
    for (uint32_t p = 0; p < patches_->count(); ++p) {
      const double most = setup_.bound * (hasJoint(p) ? kMostAtJoint : 1);
      for (uint32_t key = 0; key < keys_; ++key) {
        Imath::Box3d box;
        for (int k = 0; k < 4; ++k) box.extendBy(cornerAt(p, k, key));
        areas += areaOf(box);
        box.min -= V3d(most);
        box.max += V3d(most);
        wideAreas += areaOf(box);
        set(p, key, box);
      }
      micropolygons += std::ldexp(double(keys_), patches_->eu(p) + patches_->ev(p));
    }
    if (wideAreas <= kMostOverlap * areas || micropolygons > kMostDicedForBoxes) return;
  }
  areBoxesTight_ = true;
  // a thread that waits here must not begin another surface: their memory would add up
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(uint32_t(0), patches_->count(), [&](uint32_t p) {
      if (stop && stop->load(std::memory_order_relaxed)) return;
      const ShadingFloats floats;
      Workspace& w = *workspaces_.local();
      w.begin();
      for (w.key = 0; w.key < keys_; ++w.key) {
        placePoints(p, 0, false, w);
        addPointsOfGrid(p, 0, w);
        Imath::Box3d box;
        for (const V3d& x : w.moved) box.extendBy(V3d(V3f(x)));
        set(p, w.key, box);
      }
      tell(w, p);
      keepOutline(p, w.points.data());
      for (double was = longest_; was < w.longest && !longest_.compare_exchange_weak(was, w.longest);) {
      }
    });
  });
}

// Whether sides that are moved as one meet at an angle at a corner of the patch, or along its edges.
bool LevelledSurface::hasJoint(uint32_t patch) const {
  const auto isSmooth = [&](const Patches::Side& a, const Patches::Side& b) {
    bool yes = true;
    for (uint32_t key = 0; key < keys_ && yes; ++key)
      yes = normalAt(a.patch, a.number, key).dot(normalAt(b.patch, b.number, key)) > kSameNormal;
    return yes;
  };
  for (int k = 0; k < 4; ++k) {
    uint32_t count;
    bool isJoined;
    const Patches::Side* sides = patches_->around(patches_->siteOf(patch, k), &count, &isJoined);
    for (uint32_t i = 1; i < count && isJoined; ++i)
      if (!isSmooth(sides[i], sides[0])) return true;
  }
  return false;
}

// Said once: of the patch that came first.
void LevelledSurface::tell(Workspace& w, uint32_t patch) const {
  if (w.notFinite && !toldNotFinite_.exchange(true))
    setup_.world.diagnostics->warning("DISPLACEMENT-NOT-FINITE", setup_.pos,
                                      "displacement '" + setup_.displacement + "' moves points of " + setup_.object +
                                          " nowhere or too far, some of them on face " +
                                          std::to_string(patches_->mesh()->faceOf(2 * patch)),
                                      "these points stay where they are");
  if (w.beyondBound && !toldBound_.exchange(true))
    setup_.world.diagnostics->warning(
        "DISPLACEMENT-BOUND", setup_.pos,
        "displacement '" + setup_.displacement + "' moves points of " + setup_.object + " by up to " +
            shortNumber(w.longest) + " (object), displacementbound allows " + shortNumber(setup_.bound) + ": " +
            shortNumber(w.longest / setup_.bound) + " times that",
        "they are moved as far as it allows",
        "it says where rays look for the surface, which is diced when they do; a larger one costs time, without one "
        "all patches are diced once to find out");
  w.notFinite = w.beyondBound = 0;
}

const Tessellation* LevelledSurface::held(uint32_t patch, int level, int kind,
                                          trace::GeometryCache::Reading& reading) const {
  trace::GeometryCache::Slot& s = slot(patch, level);
  if (const Tessellation* t = setup_.cache->find(s)) {
    countFound(setup_.counters->found);
    return t;
  }
  if (setup_.cache->isStopping()) {  // a group has hundreds of rays, each of which may want several patches
    trace::GeometryCache::wasCutShort() = true;
    return nullptr;
  }
  reading.leave();
  Tessellation::Ptr made = dice(patch, level);
  setup_.counters->micropolygons[level][kind].fetch_add(uint64_t(1) << (made->eu() + made->ev()),
                                                        std::memory_order_relaxed);
  reading.enter();
  return setup_.cache->put(this, s, std::move(made));
}

void LevelledSurface::keepOutline(uint32_t patch, const V3f* points) const {
  const int eu = patches_->eu(patch), ev = patches_->ev(patch);
  uint8_t unknown = kUnknown;
  if (!outlineStates_[patch].compare_exchange_strong(unknown, kBeingMade, std::memory_order_relaxed)) return;
  outlines_[patch].set(eu, ev, points, boxOf(patch), keys_);
  outlineStates_[patch].store(kKnown, std::memory_order_release);
}

bool LevelledSurface::goesBy(uint32_t patch, const Choice& choice, const trace::GridRay& ray) const {
  int least = std::min(patches_->eu(patch), patches_->ev(patch)) - choice.level;
  for (const uint8_t steps : choice.steps) least = std::min(least, int(steps));
  return least >= trace::GridOutline::kLeastExponent && !outlines_[patch].mayMeetFine(boxOf(patch), ray);
}

// By how many levels: 0 where the footprint is no larger than that of a camera ray.
int LevelledSurface::coarser(float footprint, float size) const {
  const float steps = kRadiiOfPixel * setup_.pixels * footprint / size;
  if (!(steps >= 2)) return 0;
  return steps < 1024 ? int(std::bit_cast<uint32_t>(steps) >> 23) - 127 : Patches::kMostExponent;
}

float LevelledSurface::largestStep(uint32_t patch) const {
  float size = 0;
  for (const uint32_t e : patches_->edgesOf(patch)) size = std::max(size, patches_->edge(e).size);
  return size;
}

LevelledSurface::Edges LevelledSurface::edgesOf(uint32_t patch, const trace::Moment& at) const {
  const geometry::Mesh& mesh = *patches_->mesh();
  const auto cornerThen = [&](int corner) {
    const V3f* const p = &mesh.points[size_t(at.key) * mesh.vertexCount + patches_->vertexOf(patch, corner)];
    return at.part > 0 ? p[0] + (p[mesh.vertexCount] - p[0]) * at.part : p[0];
  };
  const V3f corner[4] = {cornerThen(0), cornerThen(1), cornerThen(2), cornerThen(3)};
  Edges out;
  for (size_t k = 0; k < 4; ++k) {
    const V3f &a = corner[k], &b = corner[(k + 1) % 4];
    for (int i = 0; i < 3; ++i) out.middle[i][k] = 0.5f * (a[i] + b[i]);
    out.reach[k] = 0.5f * (b - a).length();
    const Patches::Edge& edge = patches_->edge(patches_->edgesOf(patch)[k]);
    out.size[k] = edge.size;
    out.exponent[k] = edge.exponent;
  }
  out.least = std::min(std::min(out.size[0], out.size[1]), std::min(out.size[2], out.size[3]));
  out.largest = largestStep(patch);
  out.across = 0;
  for (int k = 1; k < 4; ++k) {
    V3f way;
    for (int i = 0; i < 3; ++i) way[i] = out.middle[i][k] - out.middle[i][0];
    out.across = std::max(out.across, way.length());
  }
  return out;
}

LevelledSurface::Choice LevelledSurface::choose(uint32_t patch, const trace::UserRay& ray) const {
  const trace::Moment at = trace::momentAt(ray.time, keys_);
  Edges then;
  if (edges_.empty()) then = edgesOf(patch, at);
  const Edges& edges = edges_.empty() ? then : edges_[patch];
  Choice c{0, edges.exponent};
  if (!(ray.radius > 0) && !(ray.spread > 0)) return c;
  const float length = std::sqrt(ray.d[0] * ray.d[0] + ray.d[1] * ray.d[1] + ray.d[2] * ray.d[2]);
  const float growth = length > 0 ? std::min(ray.spread / length, kMostSpread) : 0;
  const Box box = boxAt(patch, at);
  float d2 = 0;
  for (size_t k = 0; k < 3; ++k) {
    const float d = std::max(0.f, std::max(box[k] - ray.o[k], ray.o[k] - box[3 + k]));
    d2 += d * d;
  }
  c.level = coarser(ray.radius + growth * std::sqrt(d2), edges.largest);
  if (c.level == 0 && growth == 0) return c;
  const float* const size = edges.size;
  float far2[4] = {}, footprint[4];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 4; ++k) {
      const float d = edges.middle[i][k] - ray.o[i];
      far2[k] += d * d;
    }
  // most rays of the camera see the finest grid along all edges: no footprint is larger than this, rounding included
  if (coarser(1.0001f * (ray.radius + growth * (std::sqrt(far2[0]) + edges.across)), edges.least) == 0) {
    c.level = 0;
    return c;
  }
  for (int k = 0; k < 4; ++k) footprint[k] = ray.radius + growth * std::max(0.f, std::sqrt(far2[k]) - edges.reach[k]);
  for (size_t k = 0; k < 4; ++k) {
    const int level = coarser(footprint[k], size[k]);
    c.steps[k] = uint8_t(std::max(0, edges.exponent[k] - level));
    // an edge of no length asks for nothing
    if (size[k] > 0) c.level = std::min(c.level, level);
  }
  return c;
}

bool LevelledSurface::intersect(uint32_t patch, const trace::UserRay& ray, trace::UserHit* hit) const {
  const trace::GridRay gridRay(ray.o, ray.d, ray.tMin, ray.tMax, ray.time);
  // boxes that were made in advance are often far larger than what is in them: most rays end here
  const bool isKnown = outlineStates_[patch].load(std::memory_order_acquire) == kKnown;
  if (isKnown && !areBoxesTight_ && !outlines_[patch].mayMeet(gridRay)) return false;
  Choice c = choose(patch, ray);
  c.level = std::min(c.level, std::max(patches_->eu(patch), patches_->ev(patch)));
  trace::GridHit h;
  {
    trace::GeometryCache::Reading reading;
    if (isKnown && !setup_.cache->has(slot(patch, c.level)) && goesBy(patch, c, gridRay)) {
      setup_.counters->passed.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    const Tessellation* t = held(patch, c.level, kindOf(ray.mask), reading);
    if (!t || !t->intersect(gridRay, c.steps, &h)) return false;
  }
  hit->t = h.t;
  const bool isFirst = h.u >= h.v;
  hit->primitive = 2 * patch + (isFirst ? 0 : 1);
  hit->u = isFirst ? h.u - h.v : h.u;
  hit->v = isFirst ? h.v : h.v - h.u;
  for (int k = 0; k < 3; ++k) hit->ng[k] = h.ng[k];
  hit->level = uint32_t(c.level);
  return true;
}

// Of the surface that is not displaced: numbers that shading can live with, for paths that are dropped.
void LevelledSurface::flatFacet(uint32_t patch, float x, float y, trace::UserFacet& f) const {
  f.u = std::clamp(x, 0.f, 1.f);
  f.v = std::clamp(y, 0.f, 1.f);
  f.isSecond = f.v > f.u;
  f.b1 = f.isSecond ? f.u : f.u - f.v;
  f.b2 = f.isSecond ? f.v - f.u : f.v;
  f.steps[0] = f.steps[1] = 1;
  f.radius = INFINITY;
  for (int c = 0; c < 4; ++c) {
    const V3d p = cornerAt(patch, c, 0), n = normalAt(patch, c, 0).normalized();
    for (int a = 0; a < 3; ++a) {
      f.P[c][a] = float(p[a]);
      f.N[c][a] = float(n[a]);
    }
  }
}

void LevelledSurface::facets(uint32_t n, const uint32_t* primitive, const uint32_t* level, const float* u,
                             const float* v, const float* time, trace::UserFacet* out) const {
  for (uint32_t k = 0; k < n; ++k) {
    trace::UserFacet& f = out[k];
    const uint32_t patch = primitive[k] / 2;
    const int most = std::max(patches_->eu(patch), patches_->ev(patch)), of = std::min(int(level[k]), most);
    const bool isFirst = primitive[k] % 2 == 0;
    const float x = isFirst ? u[k] + v[k] : u[k], y = isFirst ? v[k] : u[k] + v[k];
    trace::GeometryCache::Reading reading;
    const Tessellation* const found = held(patch, of, 1, reading);
    if (!found) {
      flatFacet(patch, x, y, f);
      continue;
    }
    const Tessellation& t = *found;
    const float nu = float(1u << t.eu()), nv = float(1u << t.ev());
    const float i = std::clamp(std::floor(x * nu), 0.f, nu - 1), j = std::clamp(std::floor(y * nv), 0.f, nv - 1);
    f.u = std::clamp(x * nu - i, 0.f, 1.f);
    f.v = std::clamp(y * nv - j, 0.f, 1.f);
    f.isSecond = f.v > f.u;
    f.b1 = f.isSecond ? f.u : f.u - f.v;
    f.b2 = f.isSecond ? f.v - f.u : f.v;
    f.steps[0] = nu;
    f.steps[1] = nv;
    static constexpr uint32_t kX[4] = {0, 1, 1, 0}, kY[4] = {0, 0, 1, 1};
    const trace::Moment at = trace::momentAt(time[k], keys_);
    for (int c = 0; c < 4; ++c) {
      const V3f p = t.point(uint32_t(i) + kX[c], uint32_t(j) + kY[c], at),
                m = t.normal(uint32_t(i) + kX[c], uint32_t(j) + kY[c], at);
      for (int a = 0; a < 3; ++a) {
        f.P[c][a] = p[a];
        f.N[c][a] = m[a];
      }
    }
    f.radius =
        of < most ? 0.999f * std::ldexp(largestStep(patch), of + 1) / (kRadiiOfPixel * setup_.pixels) : INFINITY;
  }
}

}  // namespace kinora::render
