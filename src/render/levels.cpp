#include "render/levels.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "base/elapsed.h"
#include "geometry/displace.h"
#include "render/shading_floats.h"
#include "trace/world.h"

namespace kinora::render {

using geometry::Patches;
using Imath::V3d;
using Imath::V3f;
using trace::Tessellation;

namespace {

constexpr uint32_t kPlacesAtOnce = 1024;  // of a context
constexpr uint32_t kUnit = Patches::kUnit;

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

// A box whose faces all move by a distance has corners that move by 1.73 times that: what meets at an angle is moved as
// one, and may go so many times farther than a bound says.
constexpr double kMostAtJoint = 2;
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

// What one thread needs to dice a patch.
struct LevelledSurface::Workspace {
  explicit Workspace(const shade::ShadingWorld& world) : group(world) {}
  shade::GroupState group;
  uint32_t key = 0;  // at which the points below are
  // Points of the surface: where they lie undisplaced, and go to; what a shader says of their normal (0: nothing).
  std::vector<V3d> base, moved, given;
  std::vector<uint32_t> firstRequest;  // by point; one more at the end
  // What is shaded for them: places, where these lie undisplaced.
  std::vector<Patches::Place> request;
  std::vector<float> radius;
  std::vector<V3d> from, normal, offset, turned;
  Corners corners{~0u, 0, 0, {}, {}};  // of the patch that was asked last
  // The points around a grid: beyond its edges, by edge and step; of corners, two for each patch around.
  std::array<uint32_t, 4> beyond{};
  std::array<bool, 4> hasBeyond{};
  std::array<uint32_t, 4> atCorner{}, cornerPairs{};
  std::vector<V3d> offsets, normalsOfPoint;  // scratch
  // Of one patch, over all keys: its grid, key after key.
  std::vector<V3f> points, normals;
  double longest = 0;
  uint32_t notFinite = 0, beyondBound = 0;
  void begin() {
    points.clear();
    normals.clear();
    longest = 0;
  }
};

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

V3d LevelledSurface::cornerAt(uint32_t patch, int corner, uint32_t key) const {
  const geometry::Mesh& mesh = *patches_->mesh();
  return V3d(mesh.points[size_t(key) * mesh.vertexCount + patches_->vertexOf(patch, corner)]);
}

V3d LevelledSurface::normalAt(uint32_t patch, int corner, uint32_t key) const {
  const geometry::Mesh& mesh = *patches_->mesh();
  const size_t first = mesh.movesWithKeys(*normals_) ? size_t(key) * mesh.vertexCount : 0;
  const float* n = &normals_->data[3 * (first + patches_->vertexOf(patch, corner))];
  return V3d(n[0], n[1], n[2]);
}

namespace {

V3d within(const V3d (&corner)[4], const Patches::Place& place) {
  const double u = double(place.u) / kUnit, v = double(place.v) / kUnit;
  return (corner[0] * (1 - u) + corner[1] * u) * (1 - v) + (corner[3] * (1 - u) + corner[2] * u) * v;
}

V3d unitWithin(const V3d (&corner)[4], const Patches::Place& place) {
  const V3d n = within(corner, place);
  const double length = n.length();
  return length > 0 ? n / length : V3d(0, 0, 1);
}

}  // namespace

const LevelledSurface::Corners& LevelledSurface::cornersOf(uint32_t patch, Workspace& w) const {
  Corners& c = w.corners;
  if (c.patch == patch && c.key == w.key) return c;
  c.patch = patch;
  c.key = w.key;
  c.size = 0;
  for (const uint32_t e : patches_->edgesOf(patch)) c.size += 0.25f * patches_->edge(e).size;
  for (int k = 0; k < 4; ++k) {
    c.point[k] = cornerAt(patch, k, w.key);
    c.normal[k] = normalAt(patch, k, w.key);
  }
  return c;
}

// A point that patches share is the same one whichever of them asks: what is shaded for it, and from where it moves,
// follows from its edge or corner.
void LevelledSurface::addPoint(Workspace& w, const Patches::Place& place) const {
  const Patches& all = *patches_;
  const auto request = [&](const Patches::Place& at, float size) {
    const Corners& corners = cornersOf(at.patch, w);
    w.request.push_back(at);
    w.radius.push_back(0.5f * size * setup_.toRender);
    w.from.push_back(within(corners.point, at));
    w.normal.push_back(unitWithin(corners.normal, at));
  };
  const auto sitePoint = [&](uint32_t site) {
    uint32_t count;
    bool isJoined;
    const Patches::Side& s = *all.around(site, &count, &isJoined);
    return cornerAt(s.patch, s.number, w.key);
  };
  const auto atSite = [&](uint32_t site) {
    uint32_t count;
    bool isJoined;
    const Patches::Side* sides = all.around(site, &count, &isJoined);
    w.base.push_back(sitePoint(site));
    for (uint32_t i = 0; i < (isJoined ? count : 1u); ++i) {
      bool isNew = true;
      for (uint32_t j = 0; j < i && isNew; ++j)
        isNew = all.vertexOf(sides[j].patch, sides[j].number) != all.vertexOf(sides[i].patch, sides[i].number);
      if (isNew) request(Patches::atCorner(sides[i]), all.sizeAt(site));
    }
  };
  const bool isLeft = place.u == 0, isRight = place.u == kUnit, isLow = place.v == 0, isHigh = place.v == kUnit;
  if ((isLeft || isRight) && (isLow || isHigh)) {
    atSite(all.siteOf(place.patch, isLow ? (isLeft ? 0 : 1) : (isLeft ? 3 : 2)));
  } else if (isLeft || isRight || isLow || isHigh) {
    const int k = isLow ? 0 : isRight ? 1 : isHigh ? 2 : 3;
    const uint32_t e = all.edgesOf(place.patch)[size_t(k)];
    const Patches::Edge& edge = all.edge(e);
    if (edge.site[0] == edge.site[1]) {
      atSite(edge.site[0]);
    } else {
      const uint32_t along = k == 0 ? place.u : k == 1 ? place.v : k == 2 ? kUnit - place.u : kUnit - place.v;
      const uint32_t t = all.siteOf(place.patch, k) == edge.site[0] ? along : kUnit - along;
      const double part = double(t) / kUnit;
      w.base.push_back(sitePoint(edge.site[0]) * (1 - part) + sitePoint(edge.site[1]) * part);
      uint32_t count;
      const Patches::Side* sides = all.sides(e, &count);
      const auto ends = [&](const Patches::Side& s) {
        const uint32_t a = all.vertexOf(s.patch, s.number), b = all.vertexOf(s.patch, (s.number + 1) % 4);
        return s.isReversed ? std::pair{b, a} : std::pair{a, b};
      };
      for (uint32_t i = 0; i < (edge.isJoined ? count : 1u); ++i) {
        bool isNew = true;
        for (uint32_t j = 0; j < i && isNew; ++j) isNew = ends(sides[j]) != ends(sides[i]);
        if (isNew) request(Patches::onEdge(sides[i], t), edge.size);
      }
    }
  } else {
    request(place, cornersOf(place.patch, w).size);
    w.base.push_back(w.from.back());
  }
  w.firstRequest.push_back(uint32_t(w.request.size()));
}

void LevelledSurface::placePoints(uint32_t patch, int level, bool isAround, Workspace& w) const {
  for (auto* list : {&w.base, &w.from, &w.normal}) list->clear();
  w.request.clear();
  w.radius.clear();
  w.firstRequest.assign(1, 0);
  const Patches& all = *patches_;
  const int eu = std::max(0, all.eu(patch) - level), ev = std::max(0, all.ev(patch) - level);
  const uint32_t nu = 1u << eu, nv = 1u << ev, stepU = kUnit >> eu, stepV = kUnit >> ev;
  for (uint32_t j = 0; j <= nv; ++j)
    for (uint32_t i = 0; i <= nu; ++i) addPoint(w, {patch, uint16_t(i * stepU), uint16_t(j * stepV)});
  for (int k = 0; k < 4 && isAround; ++k) {
    // the row next to the edge of the patch beyond it, at the steps of this one
    uint32_t count;
    const uint32_t e = all.edgesOf(patch)[size_t(k)];
    const Patches::Side* sides = all.sides(e, &count);
    const Patches::Side *own = nullptr, *other = nullptr;
    for (uint32_t i = 0; i < count; ++i)
      if (sides[i].patch == patch && sides[i].number == k) own = &sides[i];
    for (uint32_t i = 0; i < count && !other; ++i)
      if (&sides[i] != own && sides[i].piece == own->piece) other = &sides[i];
    w.hasBeyond[size_t(k)] = other != nullptr && all.edge(e).site[0] != all.edge(e).site[1];
    w.beyond[size_t(k)] = uint32_t(w.base.size());
    if (!w.hasBeyond[size_t(k)]) continue;
    const int across = std::max(0, (other->number % 2 ? all.eu(other->patch) : all.ev(other->patch)) - level);
    const uint32_t inward = kUnit >> across, steps = k % 2 ? nv : nu, step = kUnit / steps;
    for (uint32_t i = 1; i < steps; ++i) {
      const uint32_t along = k < 2 ? i * step : kUnit - i * step;  // from corner k
      const uint32_t t = own->isReversed ? kUnit - along : along;
      Patches::Place p = Patches::onEdge(*other, t);
      switch (other->number) {
        case 0:
          p.v = uint16_t(inward);
          break;
        case 1:
          p.u = uint16_t(kUnit - inward);
          break;
        case 2:
          p.v = uint16_t(kUnit - inward);
          break;
        default:
          p.u = uint16_t(inward);
          break;
      }
      addPoint(w, p);
    }
  }
  for (int k = 0; k < 4 && isAround; ++k) {
    uint32_t count, piece = 0;
    bool isJoined;
    const Patches::Side* sides = all.around(all.siteOf(patch, k), &count, &isJoined);
    for (uint32_t i = 0; i < count; ++i)
      if (sides[i].patch == patch && sides[i].number == k) piece = sides[i].piece;
    w.atCorner[size_t(k)] = uint32_t(w.base.size());
    w.cornerPairs[size_t(k)] = 0;
    for (uint32_t i = 0; i < count; ++i) {
      if (sides[i].piece != piece) continue;
      const uint32_t p = sides[i].patch;
      const uint32_t su = kUnit >> std::max(0, all.eu(p) - level), sv = kUnit >> std::max(0, all.ev(p) - level);
      const int c = sides[i].number;
      const Patches::Place at = Patches::atCorner(sides[i]);
      const bool isRight = at.u != 0, isHigh = at.v != 0;
      const Patches::Place alongU{p, uint16_t(isRight ? kUnit - su : su), at.v},
          alongV{p, at.u, uint16_t(isHigh ? kUnit - sv : sv)};
      // forward along edge c, then back along the one before
      addPoint(w, c % 2 ? alongV : alongU);
      addPoint(w, c % 2 ? alongU : alongV);
      ++w.cornerPairs[size_t(k)];
    }
  }
  movePoints(w);
}

void LevelledSurface::movePoints(Workspace& w) const {
  const size_t n = w.request.size();
  w.offset.assign(n, V3d(0));
  w.turned.assign(isMovedByShader_ ? n : 0, V3d(0));
  Arena& arena = w.group.arena();
  const geometry::Mesh& mesh = *patches_->mesh();
  const float timeOfKey = keys_ > 1 ? float(w.key) / float(keys_ - 1) : 0.5f;
  for (size_t begin = 0; begin < n; begin += kPlacesAtOnce) {
    const ArenaScope memory(arena);
    const uint32_t count = uint32_t(std::min<size_t>(kPlacesAtOnce, n - begin)), room = padded(count);
    uint32_t *zero = arena.make<uint32_t>(room), *triangle = arena.make<uint32_t>(room),
             *number = arena.make<uint32_t>(room);
    const auto floats = [&] { return arena.make<float>(room); };
    float *u = floats(), *v = floats(), *time = floats(), *radius = floats();
    float *P[3] = {floats(), floats(), floats()}, *N[3] = {floats(), floats(), floats()},
          *out[3] = {floats(), floats(), floats()}, *turned[3] = {floats(), floats(), floats()};
    for (uint32_t i = 0; i < room; ++i) {
      const size_t from = begin + std::min(i, count - 1);
      const Patches::Place& place = w.request[from];
      const bool isFirst = place.u >= place.v;
      triangle[i] = 2 * place.patch + (isFirst ? 0 : 1);
      u[i] = float(isFirst ? place.u - place.v : place.u) / float(kUnit);
      v[i] = float(isFirst ? place.v : place.v - place.u) / float(kUnit);
      number[i] = i;
      zero[i] = 0;
      time[i] = timeOfKey;
      radius[i] = w.radius[from];
      const V3d p = w.from[from] + mesh.origin;
      for (int k = 0; k < 3; ++k) {
        P[k][i] = float(p[k]);
        N[k][i] = float(w.normal[from][k]);
      }
    }
    const SurfacePlaces places{zero, zero, triangle, u, v, time, radius, nullptr, number, zero};
    const bool isTurned = w.group.displace(count, places, P, N, out, turned);
    for (uint32_t i = 0; i < count; ++i) {
      V3d offset(out[0][i], out[1][i], out[2][i]);
      const double length = offset.length();
      if (!(length <= geometry::kMostOffset)) {
        offset = V3d(0);
        ++w.notFinite;
      } else {
        w.longest = std::max(w.longest, length);
        if (setup_.bound > 0 && length > setup_.bound) {
          w.beyondBound += length > setup_.bound * 1.0001;
          offset *= setup_.bound / length;
        }
      }
      w.offset[begin + i] = offset;
      if (isTurned) w.turned[begin + i] = V3d(turned[0][i], turned[1][i], turned[2][i]);
    }
  }
  w.moved.resize(w.base.size());
  w.given.assign(w.turned.empty() ? 0 : w.base.size(), V3d(0));
  for (size_t p = 0; p < w.base.size(); ++p) {
    const uint32_t first = w.firstRequest[p], last = w.firstRequest[p + 1];
    V3d offset = w.offset[first];
    if (last - first > 1) {
      w.offsets.assign(w.offset.begin() + first, w.offset.begin() + last);
      w.normalsOfPoint.assign(w.normal.begin() + first, w.normal.begin() + last);
      offset = geometry::jointOffset(w.offsets, w.normalsOfPoint);
      // what a bound holds the parts of need not hold the whole
      const double length = offset.length(), most = kMostAtJoint * setup_.bound;
      if (!(setup_.bound > 0)) {
        w.longest = std::max(w.longest, length);
      } else if (length > most) {
        w.longest = std::max(w.longest, length / kMostAtJoint);
        w.beyondBound += length > most * 1.0001;
        offset *= most / length;
      }
    }
    w.moved[p] = w.base[p] + offset;
    for (uint32_t i = first; i < last && !w.given.empty(); ++i) w.given[p] += w.turned[i];
  }
}

void LevelledSurface::addPointsOfGrid(uint32_t patch, int level, Workspace& w) const {
  const int eu = std::max(0, patches_->eu(patch) - level), ev = std::max(0, patches_->ev(patch) - level);
  const size_t n = ((size_t(1) << eu) + 1) * ((size_t(1) << ev) + 1);  // the first of all that were placed
  for (size_t i = 0; i < n; ++i) w.points.emplace_back(w.moved[i]);
}

void LevelledSurface::addNormals(uint32_t patch, int level, Workspace& w) const {
  const Patches& all = *patches_;
  const int eu = std::max(0, all.eu(patch) - level), ev = std::max(0, all.ev(patch) - level);
  const uint32_t nu = 1u << eu, nv = 1u << ev, stride = nu + 1, stepU = kUnit >> eu, stepV = kUnit >> ev;
  const double side = patches_->mesh()->flipNormals ? -1 : 1;
  const auto at = [&](uint32_t i, uint32_t j) { return size_t(j) * stride + i; };
  for (uint32_t j = 0; j <= nv; ++j)
    for (uint32_t i = 0; i <= nu; ++i) {
      const bool isLeft = i == 0, isRight = i == nu, isLow = j == 0, isHigh = j == nv;
      const size_t here = at(i, j);
      const auto normalOf = [&](const std::vector<V3d>& P) {
        const V3d& p = P[here];
        if ((isLeft || isRight) && (isLow || isHigh)) {
          const auto k = size_t(isLow ? (isLeft ? 0 : 1) : (isLeft ? 3 : 2));
          V3d sum(0);
          for (uint32_t s = 0; s < w.cornerPairs[k]; ++s) {
            const size_t a = w.atCorner[k] + 2 * s, b = a + 1;
            const double lengths = (w.base[a] - w.base[here]).length() * (w.base[b] - w.base[here]).length();
            if (lengths > 0) sum += (P[a] - p).cross(P[b] - p) / lengths;
          }
          return sum;
        }
        if (isLeft || isRight || isLow || isHigh) {
          const int k = isLow ? 0 : isRight ? 1 : isHigh ? 2 : 3;
          const size_t inner = k == 0 ? at(i, 1) : k == 1 ? at(nu - 1, j) : k == 2 ? at(i, nv - 1) : at(1, j);
          const V3d along = k % 2 ? P[at(i, j + 1)] - P[at(i, j - 1)] : P[at(i + 1, j)] - P[at(i - 1, j)];
          const double length = (w.base[inner] - w.base[here]).length();
          V3d inward = length > 0 ? (P[inner] - p) / length : P[inner] - p;
          if (w.hasBeyond[size_t(k)]) {
            const size_t outer = w.beyond[size_t(k)] + (k % 2 ? j : i) - 1;
            const double outerLength = (w.base[outer] - w.base[here]).length();
            if (outerLength > 0) inward -= (P[outer] - p) / outerLength;
          }
          return k < 2 ? along.cross(inward) : inward.cross(along);
        }
        return (P[at(i + 1, j)] - P[at(i - 1, j)]).cross(P[at(i, j + 1)] - P[at(i, j - 1)]);
      };
      const bool isInner = !(isLeft || isRight || isLow || isHigh);
      const V3d base =
          isInner ? w.normal[w.firstRequest[here]]
                  : unitWithin(cornersOf(patch, w).normal, {patch, uint16_t(i * stepU), uint16_t(j * stepV)});
      const V3d after = normalOf(w.moved);
      V3d n;
      const V3d given = w.given.empty() ? V3d(0) : w.given[here];
      if (given.length() > 1e-3 && std::isfinite(given.length()))
        n = given.dot(after) * side < 0 ? -given.normalized() : given.normalized();
      else
        n = geometry::turned(base, normalOf(w.base), after);
      w.normals.emplace_back(n);
    }
}

Tessellation::Ptr LevelledSurface::dice(uint32_t patch, int level) const {
  const double start = threadSeconds();
  const ShadingFloats floats;
  Workspace& w = *workspaces_.local();
  w.begin();
  uint64_t shaded = 0;
  for (w.key = 0; w.key < keys_; ++w.key) {
    placePoints(patch, level, true, w);
    addPointsOfGrid(patch, level, w);
    addNormals(patch, level, w);
    shaded += w.request.size();
  }
  tell(w, patch);
  const int eu = std::max(0, patches_->eu(patch) - level), ev = std::max(0, patches_->ev(patch) - level);
  if (level == 0) keepOutline(patch, w.points.data());
  Tessellation::Ptr made = Tessellation::make(eu, ev, w.points.data(), w.normals.data(), keys_);
  setup_.counters->vertices.fetch_add(shaded, std::memory_order_relaxed);
  setup_.counters->nanoseconds.fetch_add(uint64_t(1e9 * (threadSeconds() - start)), std::memory_order_relaxed);
  return made;
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
  out.largest = std::max(std::max(out.size[0], out.size[1]), std::max(out.size[2], out.size[3]));
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
