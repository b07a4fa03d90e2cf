#include "geometry/patches.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "geometry/facets.h"
#include "geometry/points_in_space.h"
#include "geometry/vertex_means.h"

namespace kinora::geometry {

using Imath::V2f;
using Imath::V3d;
using Imath::V3f;

namespace {

constexpr double kSmoothNormals = 1 - 1e-5;  // cosine, as in displace.cpp

// Sides that join smoothly are one piece. Each looks at all before it, and behind the first few hundred at the first of
// each piece alone: of a pole, or of a surface that folds up into a point, millions may meet.
template <class AreSmooth>
void findPieces(Patches::Side* sides, uint32_t count, AreSmooth&& areSmooth) {
  constexpr uint32_t kFew = 256;
  uint32_t firsts[kFew], pieces = 0;
  for (uint32_t i = 0; i < count; ++i) {
    sides[i].piece = uint16_t(std::min(i, 65535u));
    const uint32_t others = i < kFew ? i : pieces;
    bool isJoined = false;
    for (uint32_t k = 0; k < others && !isJoined; ++k) {
      const uint32_t j = i < kFew ? k : firsts[k];
      isJoined = areSmooth(i, j);
      if (isJoined) sides[i].piece = sides[j].piece;
    }
    if (!isJoined && pieces < kFew) firsts[pieces++] = i;
  }
}

}  // namespace

Patches::Patches(Mesh mesh, const DiceRate& rate) : mesh_(std::make_shared<Mesh>(std::move(mesh))) {
  if (rate.isStopped()) return;
  splitIntoQuads();
  mesh_->quadPairs = true;  // faces are listed all the same
  if (rate.isStopped()) return;
  findEdges(rate);
  if (rate.isStopped()) return;
  findSites();
}

// Each quad must begin with triangle 2 * patch.
void Patches::splitIntoQuads() {
  bool isWhole = true;
  for (uint32_t t = 0; t < mesh_->triangleCount() && isWhole; t += 2) isWhole = mesh_->quadOf(t) == t;
  if (isWhole) {
    edgesOf_.resize(mesh_->triangleCount() / 2);
    return;
  }
  // the vertices at each key are a mesh of their own, to which the same are added; the first has the faces
  std::vector<Mesh> at;
  for (uint32_t key = 0; key < keyCount(); ++key) at.push_back(verticesOf(*mesh_, key));
  std::vector<VertexMeans> means;
  for (Mesh& m : at) means.emplace_back(m);
  Mesh& out = at[0];
  const auto between = [&](uint32_t a, uint32_t b) {
    uint32_t v = 0;
    for (VertexMeans& m : means) v = m.between(a, b);
    return v;
  };
  const auto meanOf = [&](const uint32_t* of, int n) {
    uint32_t v = 0;
    for (VertexMeans& m : means) v = m.of(of, n);
    return v;
  };
  for (uint32_t t = 0; t < mesh_->triangleCount();) {
    const bool isQuad = mesh_->quadOf(t) == t;
    const int n = isQuad ? 4 : 3;
    uint32_t v[4], middle[4];
    V2f uv[4], uvMiddle[4], uvCentre(0);
    for (int k = 0; k < n; ++k) {
      v[k] = mesh_->indices[isQuad ? Mesh::quadCorner(t, k) : 3 * size_t(t) + size_t(k)];
      uv[k] = isQuad && k == 3 ? mesh_->uvOf(t + 1, 2) : mesh_->uvOf(t, k);
      uvCentre += uv[k] / float(n);
    }
    for (int k = 0; k < n; ++k) {
      middle[k] = between(v[k], v[(k + 1) % n]);
      uvMiddle[k] = (uv[k] + uv[(k + 1) % n]) * 0.5f;
    }
    const uint32_t centre = meanOf(v, n);
    for (int k = 0; k < n; ++k) {
      const int before = (k + n - 1) % n;
      appendFacet(out, mesh_->faceOf(t), {v[k], middle[k], centre, middle[before]},
                  {uv[k], uvMiddle[k], uvCentre, uvMiddle[before]}, 4);
    }
    t += isQuad ? 2 : 1;
  }
  out.points.reserve(at.size() * out.points.size() + 2);  // for Embree, see trace/world.cpp
  for (size_t key = 1; key < at.size(); ++key) {
    out.points.insert(out.points.end(), at[key].points.begin(), at[key].points.end());
    for (const Primvar& p : at[key].primvars) {
      const auto same = std::find_if(out.primvars.begin(), out.primvars.end(),
                                     [&](const Primvar& of) { return of.name == p.name; });
      same->data.insert(same->data.end(), p.data.begin(), p.data.end());
    }
  }
  out.times = mesh_->times;
  *mesh_ = std::move(out);
  edgesOf_.resize(mesh_->triangleCount() / 2);
}

bool Patches::isSmooth(uint32_t a, uint32_t b) const {
  if (a == b) return true;
  const Primvar* n = mesh_->find("N");
  const size_t keys = mesh_->movesWithKeys(*n) ? keyCount() : 1, stride = 3 * size_t(mesh_->vertexCount);
  bool yes = true;  // at all times
  for (size_t key = 0; key < keys && yes; ++key) {
    const float *x = &n->data[key * stride + 3 * size_t(a)], *y = &n->data[key * stride + 3 * size_t(b)];
    yes = double(x[0]) * y[0] + double(x[1]) * y[1] + double(x[2]) * y[2] > kSmoothNormals;
  }
  return yes;
}

void Patches::findEdges(const DiceRate& rate) {
  const PointsInSpace places(*mesh_);
  siteOfVertex_ = places.ofVertex;
  std::unordered_map<uint64_t, uint32_t> numbers;
  std::vector<uint32_t> sidesOf;
  for (uint32_t p = 0; p < count(); ++p) {
    if (p % 4096 == 0 && rate.isStopped()) return;
    for (int k = 0; k < 4; ++k) {
      const uint32_t va = vertexOf(p, k), vb = vertexOf(p, (k + 1) % 4), a = siteOfVertex_[va], b = siteOfVertex_[vb];
      const auto [it, isNew] = numbers.try_emplace(pairOf(a, b), uint32_t(edges_.size()));
      edgesOf_[p][size_t(k)] = it->second;
      if (!isNew) {
        ++sidesOf[it->second];
        continue;
      }
      sidesOf.push_back(1);
      double longest = 0;
      int exponent = 0;
      for (uint32_t key = 0; key < keyCount(); ++key) {
        const size_t first = size_t(key) * mesh_->vertexCount;
        const V3d from(mesh_->points[first + va]), to(mesh_->points[first + vb]);
        const double length = (to - from).length();
        double step = INFINITY;
        for (int i = 0; i <= 4; ++i) step = std::min(step, rate.at(from + (to - from) * (i / 4.) + mesh_->origin));
        while (exponent < kMostExponent && std::ldexp(step, exponent) < length * (1 - 1e-6)) ++exponent;
        longest = std::max(longest, length);
      }
      edges_.push_back(
          {{std::min(a, b), std::max(a, b)}, 0, float(std::ldexp(longest, -exponent)), uint8_t(exponent), false});
    }
  }
  uint32_t at = 0;
  for (size_t e = 0; e < edges_.size(); ++e) {
    edges_[e].firstSide = at;
    at += sidesOf[e];
    sidesOf[e] = edges_[e].firstSide;
  }
  edges_.push_back({{0, 0}, at, 0, 0, false});
  edgeSides_.resize(at);
  for (uint32_t p = 0; p < count(); ++p)
    for (int k = 0; k < 4; ++k) {
      const uint32_t e = edgesOf_[p][size_t(k)];
      const bool isReversed = siteOfVertex_[vertexOf(p, k)] != edges_[e].site[0];
      edgeSides_[sidesOf[e]++] = {p, uint8_t(k), isReversed, 0};
    }
  const auto ends = [&](const Side& s) {
    const uint32_t a = vertexOf(s.patch, s.number), b = vertexOf(s.patch, (s.number + 1) % 4);
    return s.isReversed ? std::pair{b, a} : std::pair{a, b};
  };
  for (size_t e = 0; e + 1 < edges_.size(); ++e) {
    Side* const sides = edgeSides_.data() + edges_[e].firstSide;
    const uint32_t sideCount = edges_[e + 1].firstSide - edges_[e].firstSide;
    findPieces(sides, sideCount, [&](uint32_t i, uint32_t j) {
      const auto [a, b] = ends(sides[i]);
      const auto [c, d] = ends(sides[j]);
      return isSmooth(a, c) && isSmooth(b, d);
    });
    for (uint32_t i = 0; i < sideCount; ++i) edges_[e].isJoined |= ends(sides[i]) != ends(sides[0]);
  }
}

void Patches::findSites() {
  uint32_t sites = 0;
  for (const uint32_t s : siteOfVertex_) sites = std::max(sites, s + 1);
  firstAtSite_.assign(sites + 1, {0, INFINITY, false});
  for (uint32_t p = 0; p < count(); ++p)
    for (int k = 0; k < 4; ++k) ++firstAtSite_[siteOf(p, k) + 1].first;
  for (size_t s = 0; s < sites; ++s) firstAtSite_[s + 1].first += firstAtSite_[s].first;
  siteSides_.resize(firstAtSite_[sites].first);
  std::vector<uint32_t> next(sites);
  for (size_t s = 0; s < sites; ++s) next[s] = firstAtSite_[s].first;
  for (uint32_t p = 0; p < count(); ++p)
    for (int k = 0; k < 4; ++k) siteSides_[next[siteOf(p, k)]++] = {p, uint8_t(k), false, 0};
  for (size_t s = 0; s < sites; ++s) {
    Site& site = firstAtSite_[s];
    const uint32_t first = site.first, last = firstAtSite_[s + 1].first;
    const auto vertex = [&](uint32_t i) { return vertexOf(siteSides_[i].patch, siteSides_[i].number); };
    findPieces(siteSides_.data() + first, last - first,
               [&](uint32_t i, uint32_t j) { return isSmooth(vertex(first + i), vertex(first + j)); });
    for (uint32_t i = first; i < last; ++i) {
      site.isJoined |= vertex(i) != vertex(first);
      for (const int k : {int(siteSides_[i].number), (siteSides_[i].number + 3) % 4}) {
        const float size = edges_[edgesOf_[siteSides_[i].patch][size_t(k)]].size;
        if (size > 0) site.size = std::min(site.size, size);
      }
    }
    if (!std::isfinite(site.size)) site.size = 0;
  }
}

uint64_t Patches::triangles() const {
  uint64_t sum = 0;
  for (uint32_t p = 0; p < count(); ++p) sum += uint64_t(2) << (eu(p) + ev(p));
  return sum;
}

uint64_t Patches::bytes() const {
  return edgesOf_.size() * sizeof edgesOf_[0] + edges_.size() * sizeof(Edge) +
         (edgeSides_.size() + siteSides_.size()) * sizeof(Side) + firstAtSite_.size() * sizeof(Site) +
         siteOfVertex_.size() * sizeof(uint32_t);
}

Patches::Place Patches::onEdge(const Side& side, uint32_t t) {
  const uint32_t along = side.isReversed ? kUnit - t : t;
  switch (side.number) {
    case 0:
      return {side.patch, uint16_t(along), 0};
    case 1:
      return {side.patch, uint16_t(kUnit), uint16_t(along)};
    case 2:
      return {side.patch, uint16_t(kUnit - along), uint16_t(kUnit)};
    default:
      return {side.patch, 0, uint16_t(kUnit - along)};
  }
}

Patches::Place Patches::atCorner(const Side& side) {
  const bool isRight = side.number == 1 || side.number == 2, isTop = side.number >= 2;
  return {side.patch, uint16_t(isRight ? kUnit : 0), uint16_t(isTop ? kUnit : 0)};
}

}  // namespace kinora::geometry
