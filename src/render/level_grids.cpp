// The grids of a LevelledSurface: where their points are asked of the displacement, and go to, and normals there.
#include <algorithm>
#include <utility>

#include "base/elapsed.h"
#include "geometry/displace.h"
#include "render/level_workspace.h"
#include "render/shading_floats.h"
#include "trace/world.h"

namespace kinora::render {

using geometry::Patches;
using Imath::V3d;
using Imath::V3f;
using trace::Tessellation;

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

constexpr uint32_t kPlacesAtOnce = 1024;  // of a context

V3d within(const V3d (&corner)[4], const Patches::Place& place) {
  const double u = double(place.u) / Patches::kUnit, v = double(place.v) / Patches::kUnit;
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

}  // namespace kinora::render
