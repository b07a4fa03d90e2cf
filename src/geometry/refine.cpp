#include "geometry/refine.h"

#include <opensubdiv/bfr/parameterization.h>
#include <opensubdiv/bfr/tessellation.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

#include "geometry/facets.h"
#include "geometry/points_in_space.h"

namespace kinora::geometry {

using Imath::V2f;
using Imath::V3d;
using Imath::V3f;
namespace Bfr = OpenSubdiv::Bfr;

namespace {

constexpr int kMostSteps = 4096;  // an edge
constexpr uint32_t kNone = ~0u;
constexpr size_t kBetweenStops = 256;  // elements

// A triangle, or the two that are a quad.
struct Element {
  uint32_t triangle;
  int corners;
};

// Weights of an element's corners.
using CornerWeights = std::array<double, 4>;

class Refiner {
 public:
  Refiner(const Mesh& base, const DiceRate& rate)
      : base_(base), rate_(rate), keys_(size_t(base.keyCount())), places_(base) {
    for (uint32_t t = 0; t < base.triangleCount();) {
      const bool isQuad = base.quadOf(t) == t;
      elements_.push_back({t, isQuad ? 4 : 3});
      t += isQuad ? 2 : 1;
    }
  }

  Mesh run() {
    findEdges();
    chooseRates();
    listValues();
    out_ = emptyLike(base_);
    out_.times = base_.times;
    firstAt_.assign(size_t(siteCount_), kNone);
    for (size_t e = 0; e < elements_.size(); ++e) {
      if (e % kBetweenStops == 0 && rate_.isStopped()) break;
      cut(e);
    }
    finish();
    return std::move(out_);
  }

 private:
  // What varies over faces: normals first (of each key), then primvars.
  struct Source {
    const Primvar* primvar;
    int first;  // of its values
  };
  // How a face of these rates is cut.
  struct Pattern {
    std::vector<double> coords;
    std::vector<int> facets;
    int facetSize;
    int outline;  // points of it, first in `coords`
  };

  size_t cornerOf(const Element& e, int k) const {
    return e.corners == 4 ? Mesh::quadCorner(e.triangle, k) : 3 * size_t(e.triangle) + size_t(k);
  }
  uint32_t vertexOf(const Element& e, int k) const { return base_.indices[cornerOf(e, k)]; }
  uint32_t placeOf(const Element& e, int k) const { return places_.ofVertex[vertexOf(e, k)]; }
  V3d point(uint32_t vertex, size_t key) const { return V3d(base_.points[key * base_.vertexCount + vertex]); }

  void findEdges();
  double segmentsAlong(const V3d& a, const V3d& b) const;
  double stepped(uint32_t edge, bool forward, double t) const;
  void chooseRates();
  double estimate() const;
  void listValues();
  void cornerValues(const Element& e, int k, std::vector<double>& out) const;
  V3d faceNormal(const Element& e, size_t key) const;
  const Pattern& patternOf(int corners, const std::array<int, 4>& rates);
  void cut(size_t element);
  void mix(const CornerWeights& w, int corners);
  void mixAlong(int a, int b, double t);
  uint32_t emit(int64_t site);
  void finish();

  const Mesh& base_;
  const DiceRate& rate_;
  const size_t keys_;
  PointsInSpace places_;
  std::vector<Element> elements_;
  std::vector<std::array<uint32_t, 4>> edgesOf_;  // by element
  std::vector<double> wanted_;                    // segments, by edge
  // Where the steps of an edge lie, from its end with the lesser number: shares of its length at even shares of its
  // steps. Only edges between quads, along which the rate differs.
  std::unordered_map<uint32_t, std::array<float, 17>> spacing_;
  std::vector<int> rates_;
  std::vector<int64_t> firstSite_;  // of an edge's inner points
  int64_t siteCount_ = 0;
  std::vector<Source> sources_;
  int width_ = 0;  // values of a vertex
  std::map<std::array<int, 5>, Pattern> patterns_;
  std::unordered_map<uint32_t, std::vector<V3d>> normalOfFace_;  // where no N is: by key

  Mesh out_;
  std::vector<V3d> cornerPoint_[4];  // of the current element, by key
  std::vector<double> cornerValue_[4];
  std::vector<V3d> samplePoint_;
  std::vector<double> sampleValue_;
  std::vector<std::vector<V3f>> outPoints_;  // by key
  std::vector<float> outValues_;
  std::vector<uint32_t> firstAt_, nextAt_;  // vertices at a site
};

constexpr int kSamples = 16;  // of the rate along a line

// Segments that a straight line wants.
double Refiner::segmentsAlong(const V3d& a, const V3d& b) const {
  const double step = (b - a).length() / kSamples;
  double sum = 0;
  for (int i = 0; i < kSamples; ++i) sum += step / rate_.at(a + (b - a) * ((i + 0.5) / kSamples) + base_.origin);
  return sum;
}

// The place of step t of an edge, 0..1 both; `forward`: from the end with the lesser number.
double Refiner::stepped(uint32_t edge, bool forward, double t) const {
  const auto it = spacing_.find(edge);
  if (it == spacing_.end()) return t;
  const double x = (forward ? t : 1 - t) * kSamples;
  const int i = std::min(int(x), kSamples - 1);
  const double at =
      double(it->second[size_t(i)]) + (x - i) * (it->second[size_t(i) + 1] - double(it->second[size_t(i)]));
  return forward ? at : 1 - at;
}

void Refiner::findEdges() {
  std::unordered_map<uint64_t, uint32_t> numbers;
  numbers.reserve(2 * elements_.size());
  edgesOf_.resize(elements_.size());
  std::vector<std::array<uint32_t, 2>> ends;  // vertices, of the lesser number first
  std::vector<uint8_t> isEven;                // some triangle has it
  for (size_t i = 0; i < elements_.size(); ++i) {
    const Element& e = elements_[i];
    for (int k = 0; k < e.corners; ++k) {
      const int next = (k + 1) % e.corners;
      const uint32_t a = placeOf(e, k), b = placeOf(e, next);
      const auto [it, isNew] =
          numbers.try_emplace(uint64_t(std::min(a, b)) << 32 | std::max(a, b), uint32_t(ends.size()));
      if (isNew) {
        const uint32_t from = vertexOf(e, k), to = vertexOf(e, next);
        ends.push_back(a <= b ? std::array{from, to} : std::array{to, from});
        isEven.push_back(0);
      }
      isEven[it->second] |= e.corners == 3;
      edgesOf_[i][size_t(k)] = it->second;
    }
  }
  wanted_.assign(ends.size(), 1);
  constexpr int kLines = 4;
  for (const size_t key : {size_t(0), keys_ - 1})
    for (size_t i = 0; i < elements_.size(); ++i) {
      if (i % kBetweenStops == 0 && rate_.isStopped()) break;
      const Element& e = elements_[i];
      const auto at = [&](int k) { return point(vertexOf(e, k), key); };
      const auto wish = [&](int k, double segments) {
        double& w = wanted_[edgesOf_[i][size_t(k)]];
        w = std::max(w, segments);
      };
      // of what is cut little or not at all one place tells enough: meshes have millions of such faces
      V3d middle(0);
      for (int k = 0; k < e.corners; ++k) middle += at(k) / e.corners;
      const double here = rate_.at(middle + base_.origin);
      double longest = 0;
      for (int k = 0; k < e.corners; ++k) longest = std::max(longest, (at((k + 1) % e.corners) - at(k)).length());
      if (longest <= 4 * here) {
        for (int k = 0; k < e.corners; ++k) {
          const double segments = (at((k + 1) % e.corners) - at(k)).length() / here;
          wish(k, segments);
          if (e.corners == 4) wish((k + 2) % 4, segments);
        }
      } else if (e.corners == 4) {
        // lines from side to side, both ways
        for (int side = 0; side < 2; ++side)
          for (int line = 0; line <= kLines; ++line) {
            const double t = double(line) / kLines;
            const V3d from = at(side) + (at((side + 3) % 4) - at(side)) * t,
                      to = at(side + 1) + (at((side + 2) % 4) - at(side + 1)) * t;
            const double segments = segmentsAlong(from, to);
            wish(side, segments);
            wish(side + 2, segments);
          }
      } else {
        // steps are even: the finest that any place asks for
        double edge = INFINITY;
        for (int y = 0; y <= kLines; ++y)
          for (int x = 0; x <= kLines - y; ++x) {
            const double u = double(x) / kLines, v = double(y) / kLines;
            edge = std::min(edge, rate_.at(at(0) * (1 - u - v) + at(1) * u + at(2) * v + base_.origin));
          }
        for (int k = 0; k < 3; ++k) wish(k, (at((k + 1) % 3) - at(k)).length() / edge);
      }
    }
  for (uint32_t e = 0; e < ends.size(); ++e) {
    if (isEven[e] || !(wanted_[e] > 1)) continue;
    const V3d a = point(ends[e][0], 0), b = point(ends[e][1], 0);
    double sum[kSamples + 1] = {0}, least = INFINITY, most = 0;
    for (int i = 0; i < kSamples; ++i) {
      const double rate = rate_.at(a + (b - a) * ((i + 0.5) / kSamples) + base_.origin);
      least = std::min(least, rate);
      most = std::max(most, rate);
      sum[i + 1] = sum[i] + 1 / rate;
    }
    if (most < 1.5 * least) continue;  // even steps will do, and are the same for an eye a little aside
    if (!(sum[kSamples] > 0) || !std::isfinite(sum[kSamples])) continue;
    std::array<float, 17>& places = spacing_[e];
    for (int i = 0, piece = 0; i <= kSamples; ++i) {
      const double share = sum[kSamples] * i / kSamples;
      while (piece + 1 < kSamples && sum[piece + 1] < share) ++piece;
      places[size_t(i)] = float((piece + (share - sum[piece]) / (sum[piece + 1] - sum[piece])) / kSamples);
    }
    places.front() = 0;
    places.back() = 1;
  }
}

double Refiner::estimate() const {
  double total = 0;
  for (size_t i = 0; i < elements_.size(); ++i) {
    double sum = 0;
    for (int k = 0; k < elements_[i].corners; ++k) sum += rates_[edgesOf_[i][size_t(k)]];
    total += elements_[i].corners == 3 ? sum * sum / 9 : sum * sum / 8;
  }
  return total;
}

void Refiner::chooseRates() {
  rates_.resize(wanted_.size());
  // The first power of 0.8 that fits, which is looked for by halves: of surfaces that are far too large it is a high
  // one, and a try looks at millions of edges.
  const auto fits = [&](int power) {
    double scale = 1;
    for (int k = 0; k < power; ++k) scale *= 0.8;
    bool least = true;
    for (size_t e = 0; e < wanted_.size(); ++e) {
      rates_[e] = int(std::ceil(std::clamp(std::min(wanted_[e], 1e300) * scale - 1e-6, 1.0, double(kMostSteps))));
      least &= rates_[e] == 1;
    }
    return least || estimate() <= rate_.maxTriangles;
  };
  if (!fits(0)) {
    int low = 0, high = 1;  // too many; few enough
    while (!fits(high)) {
      low = high;
      high *= 2;
    }
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      (fits(middle) ? high : low) = middle;
    }
    fits(high);
  }
  siteCount_ = places_.count;
  firstSite_.resize(rates_.size());
  for (size_t e = 0; e < rates_.size(); ++e) {
    firstSite_[e] = siteCount_;
    siteCount_ += rates_[e] - 1;
  }
}

void Refiner::listValues() {
  using Rate = Primvar::Rate;
  width_ = int(3 * keys_);
  for (const Primvar& p : base_.primvars) {
    if (p.name == "N" || (p.rate != Rate::PerVertex && p.rate != Rate::PerCorner) || p.data.empty()) continue;
    sources_.push_back({&p, width_});
    width_ += p.width;
  }
  samplePoint_.resize(keys_);
  sampleValue_.resize(size_t(width_));
  outPoints_.resize(keys_);
  const Primvar* n = base_.find("N");
  if (n && n->width == 3 && !n->data.empty()) return;
  // what is one face lies in one plane, more or less
  for (const Element& e : elements_) {
    std::vector<V3d>& sum = normalOfFace_[base_.faceOf(e.triangle)];
    sum.resize(keys_, V3d(0));
    for (size_t key = 0; key < keys_; ++key) sum[key] += faceNormal(e, key);
  }
  for (auto& [face, normals] : normalOfFace_)
    for (V3d& x : normals) x = x.length() > 0 ? x.normalized() : V3d(0, 0, 1);
}

V3d Refiner::faceNormal(const Element& e, size_t key) const {
  V3d n(0);
  const V3d a = point(vertexOf(e, 0), key);
  for (int k = 1; k + 1 < e.corners; ++k)
    n += (point(vertexOf(e, k), key) - a).cross(point(vertexOf(e, k + 1), key) - a);
  return base_.flipNormals ? -n : n;
}

void Refiner::cornerValues(const Element& e, int k, std::vector<double>& out) const {
  using Rate = Primvar::Rate;
  out.resize(size_t(width_));
  const size_t corner = cornerOf(e, k), vertex = base_.indices[corner];
  if (normalOfFace_.empty()) {
    const Primvar& n = *base_.find("N");
    const size_t at = n.rate == Rate::PerVertex   ? vertex
                      : n.rate == Rate::PerCorner ? corner
                      : n.rate == Rate::PerFace   ? base_.faceOf(e.triangle)
                                                  : 0;
    const size_t stride = base_.movesWithKeys(n) ? base_.vertexCount : 0;
    for (size_t key = 0; key < keys_; ++key)
      for (size_t c = 0; c < 3; ++c) out[3 * key + c] = n.data[3 * (key * stride + at) + c];
  } else {
    const std::vector<V3d>& ofFace = normalOfFace_.at(base_.faceOf(e.triangle));
    for (size_t key = 0; key < keys_; ++key) {
      V3d n = ofFace[key];
      if (e.corners == 4) {  // as the quad lies at this corner: it need not be flat
        const V3d p = point(vertexOf(e, k), key);
        V3d own = (point(vertexOf(e, (k + 1) % 4), key) - p).cross(point(vertexOf(e, (k + 3) % 4), key) - p);
        if (base_.flipNormals) own = -own;
        if (own.length() > 1e-6 * faceNormal(e, key).length() && own.dot(n) > 0) n = own.normalized();
      }
      for (size_t c = 0; c < 3; ++c) out[3 * key + c] = n[int(c)];
    }
  }
  for (const Source& s : sources_) {
    const size_t width = size_t(s.primvar->width);
    const float* from = &s.primvar->data[(s.primvar->rate == Rate::PerVertex ? vertex : corner) * width];
    std::copy(from, from + width, out.begin() + s.first);
  }
}

const Refiner::Pattern& Refiner::patternOf(int corners, const std::array<int, 4>& rates) {
  const auto [it, isNew] =
      patterns_.try_emplace({corners, rates[0], rates[1], rates[2], corners == 4 ? rates[3] : 0}, Pattern());
  Pattern& p = it->second;
  if (!isNew) return p;
  Bfr::Tessellation::Options options;
  p.facetSize = corners;
  options.SetFacetSize(corners).PreserveQuads(true);
  const Bfr::Parameterization face(corners == 4 ? OpenSubdiv::Sdc::SCHEME_CATMARK : OpenSubdiv::Sdc::SCHEME_LOOP,
                                   corners);
  const Bfr::Tessellation cell(face, corners, rates.data(), options);
  p.outline = cell.GetNumBoundaryCoords();
  p.coords.resize(size_t(cell.GetNumCoords()) * 2);
  cell.GetCoords(p.coords.data());
  p.facets.resize(size_t(cell.GetNumFacets()) * size_t(corners));
  cell.GetFacets(p.facets.data());
  return p;
}

void Refiner::mix(const CornerWeights& w, int corners) {
  for (size_t key = 0; key < keys_; ++key) {
    samplePoint_[key] = V3d(0);
    for (int k = 0; k < corners; ++k) samplePoint_[key] += cornerPoint_[k][key] * w[size_t(k)];
  }
  for (size_t c = 0; c < sampleValue_.size(); ++c) {
    sampleValue_[c] = 0;
    for (int k = 0; k < corners; ++k) sampleValue_[c] += cornerValue_[k][c] * w[size_t(k)];
  }
}

// From corner a to b: what both faces of an edge compute, from its end with the lesser number.
void Refiner::mixAlong(int a, int b, double t) {
  for (size_t key = 0; key < keys_; ++key)
    samplePoint_[key] = cornerPoint_[a][key] + (cornerPoint_[b][key] - cornerPoint_[a][key]) * t;
  for (size_t c = 0; c < sampleValue_.size(); ++c)
    sampleValue_[c] = cornerValue_[a][c] + (cornerValue_[b][c] - cornerValue_[a][c]) * t;
}

void Refiner::cut(size_t element) {
  const Element& e = elements_[element];
  const int n = e.corners;
  std::array<int, 4> rates{1, 1, 1, 1};
  for (int k = 0; k < n; ++k) rates[size_t(k)] = rates_[edgesOf_[element][size_t(k)]];
  const Pattern& pattern = patternOf(n, rates);
  V2f uv[4];
  for (int k = 0; k < n; ++k) {
    cornerPoint_[k].resize(keys_);
    for (size_t key = 0; key < keys_; ++key) cornerPoint_[k][key] = point(vertexOf(e, k), key);
    cornerValues(e, k, cornerValue_[k]);
    uv[k] = base_.uvOf(e.triangle + uint32_t(k == 3), k == 3 ? 2 : k);
  }
  const int count = int(pattern.coords.size() / 2);
  // where the steps of side k lie on it, in the direction of the face
  const auto along = [&](int k, double t) {
    return stepped(edgesOf_[element][size_t(k)], placeOf(e, k) <= placeOf(e, (k + 1) % n), t);
  };
  std::vector<uint32_t> vertices(static_cast<size_t>(count));
  std::vector<V2f> place(static_cast<size_t>(count));
  const auto weightsAt = [&](double x, double y) {
    return n == 3 ? CornerWeights{1 - x - y, x, y, 0}
                  : CornerWeights{(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
  };
  int side = 0, step = 0;  // on the outline
  for (int i = 0; i < count; ++i) {
    double x = pattern.coords[2 * size_t(i)], y = pattern.coords[2 * size_t(i) + 1];
    if (n == 4) {
      const double u = (1 - y) * along(0, x) + y * (1 - along(2, 1 - x));
      const double v = (1 - x) * (1 - along(3, 1 - y)) + x * along(1, y);
      x = u;
      y = v;
    }
    const CornerWeights w = weightsAt(x, y);
    place[size_t(i)] = V2f(0);
    for (int k = 0; k < n; ++k) place[size_t(i)] += uv[k] * float(w[size_t(k)]);
    int64_t site = -1;
    if (i < pattern.outline) {
      const int next = (side + 1) % n, rate = rates[size_t(side)];
      if (step == 0) {
        for (size_t key = 0; key < keys_; ++key) samplePoint_[key] = cornerPoint_[side][key];
        sampleValue_ = cornerValue_[side];
        site = placeOf(e, side);
      } else {
        const bool forward = placeOf(e, side) <= placeOf(e, next);
        const int from = forward ? step : rate - step;
        mixAlong(forward ? side : next, forward ? next : side,
                 stepped(edgesOf_[element][size_t(side)], true, double(from) / rate));
        site = firstSite_[edgesOf_[element][size_t(side)]] + from - 1;
      }
      if (++step == rate) {
        step = 0;
        ++side;
      }
    } else {
      mix(w, n);
    }
    vertices[size_t(i)] = emit(site);
  }
  const uint32_t face = base_.faceOf(e.triangle);
  for (size_t f = 0; f < pattern.facets.size(); f += size_t(pattern.facetSize)) {
    const int corners = pattern.facetSize == 4 && pattern.facets[f + 3] >= 0 ? 4 : 3;
    std::array<uint32_t, 4> at{};
    std::array<V2f, 4> atUV;
    for (int k = 0; k < corners; ++k) {
      const auto i = size_t(pattern.facets[f + size_t(k)]);
      at[size_t(k)] = vertices[i];
      atUV[size_t(k)] = place[i];
    }
    appendFacet(out_, face, at, atUV, corners);
  }
}

uint32_t Refiner::emit(int64_t site) {
  for (size_t key = 0; key < keys_; ++key) {
    double* n = &sampleValue_[3 * key];
    const double length = V3d(n[0], n[1], n[2]).length();
    for (int c = 0; c < 3; ++c) n[c] = length > 0 ? n[c] / length : double(c == 2);
  }
  if (site >= 0)
    for (uint32_t v = firstAt_[size_t(site)]; v != kNone; v = nextAt_[v]) {
      bool same = true;
      for (size_t c = 0; c < sampleValue_.size() && same; ++c) {
        const double a = outValues_[size_t(v) * sampleValue_.size() + c], b = sampleValue_[c];
        same = std::abs(a - b) <= 1e-4 * (std::abs(a) + 1e-3);
      }
      if (same) return v;
    }
  const auto v = uint32_t(outPoints_[0].size());
  for (size_t key = 0; key < keys_; ++key) {
    // at a site all have the floats of the first
    const uint32_t first = site >= 0 ? firstAt_[size_t(site)] : kNone;
    outPoints_[key].push_back(first != kNone ? outPoints_[key][first] : V3f(samplePoint_[key]));
  }
  for (const double x : sampleValue_) outValues_.push_back(float(x));
  nextAt_.push_back(site >= 0 ? firstAt_[size_t(site)] : kNone);
  if (site >= 0) firstAt_[size_t(site)] = v;
  return v;
}

void Refiner::finish() {
  using Rate = Primvar::Rate;
  const size_t count = outPoints_[0].size(), width = size_t(width_);
  out_.vertexCount = uint32_t(count);
  out_.points.reserve(count * keys_ + 2);  // for Embree, see trace/world.cpp
  for (const std::vector<V3f>& p : outPoints_) out_.points.insert(out_.points.end(), p.begin(), p.end());
  Primvar n = Primvar::normals();
  n.data.reserve(count * keys_ * 3);
  for (size_t key = 0; key < keys_; ++key)
    for (size_t v = 0; v < count; ++v)
      n.data.insert(n.data.end(), &outValues_[v * width + 3 * key], &outValues_[v * width + 3 * key] + 3);
  out_.primvars.push_back(std::move(n));
  for (const Primvar& p : base_.primvars)
    if (p.name != "N" && (p.rate == Rate::Constant || p.rate == Rate::PerFace)) out_.primvars.push_back(p);
  for (const Source& s : sources_) {
    Primvar p;
    p.name = s.primvar->name;
    p.type = s.primvar->type;
    p.width = s.primvar->width;
    p.rate = Rate::PerVertex;
    p.data.reserve(count * size_t(p.width));
    for (size_t v = 0; v < count; ++v) {
      const float* from = &outValues_[v * width + size_t(s.first)];
      p.data.insert(p.data.end(), from, from + p.width);
    }
    out_.primvars.push_back(std::move(p));
  }
}

}  // namespace

Mesh refined(const Mesh& mesh, const DiceRate& rate) { return Refiner(mesh, rate).run(); }

}  // namespace kinora::geometry
