// Into how many segments each edge of a subdivision cage is cut, by what the limit surface around it is like.
#include <algorithm>
#include <cmath>

#include "geometry/subdivider.h"

namespace kinora::geometry {

using Imath::V3d;
namespace Bfr = OpenSubdiv::Bfr;

namespace {

constexpr int kMostSegments = 1024;  // an edge

}  // namespace

// Wishes of one face for its edges: from the limit at its corners, the middles of its edges and its centre.
void Subdivider::rateFace(int face, std::vector<double>& wanted) {
  const auto vertices = level_.GetFaceVertices(face);
  const auto edges = level_.GetFaceEdges(face);
  const int n = vertices.size();
  if (displaced_ == false && std::isfinite(rate_.at(V3d(keys_[0][3 * vertices[0]], keys_[0][3 * vertices[0] + 1],
                                                        keys_[0][3 * vertices[0] + 2])))) {
    // Cages that are already finer than the picture need no look at their surface.
    bool tiny = true;
    for (int k = 0; k < n && tiny; ++k) {
      const double *a = &keys_[0][3 * vertices[k]], *b = &keys_[0][3 * vertices[(k + 1) % n]];
      const V3d p(a[0], a[1], a[2]), q(b[0], b[1], b[2]);
      tiny = (p - q).length() < rate_.at(p);
    }
    if (tiny) return;
  }
  if (!start(face)) return;
  const Bfr::Parameterization& param = parameterization_;
  for (size_t key = 0; key < keys_.size(); key += std::max<size_t>(1, keys_.size() - 1)) {  // first and last
    preparePoints(key);
    std::vector<V3d> corner(n), cornerN(n), middle(n), middleN(n);
    double uv[2];
    for (int k = 0; k < n; ++k) {
      param.GetVertexCoord(k, uv);
      corner[k] = position(key, uv, cornerN[k]);
      param.GetEdgeCoord(k, 0.5, uv);
      middle[k] = position(key, uv, middleN[k]);
    }
    param.GetCenterCoord(uv);
    V3d centreN;
    const V3d centre = position(key, uv, centreN);
    const double edge = rate_.at(centre);
    for (int k = 0; k < n; ++k) {
      const int next = (k + 1) % n;
      auto wish = [&](int at, double length, double turn, const V3d& where) {
        double& w = wanted[edges[at]];
        w = std::max(w, segmentsFor(length, turn, std::min(edge, rate_.at(where)), displaced_));
      };
      wish(k, (middle[k] - corner[k]).length() + (corner[next] - middle[k]).length(),
           turnBetween(cornerN[k], middleN[k]) + turnBetween(middleN[k], cornerN[next]), middle[k]);
      if (n == 4) {
        // The line through the centre to the opposite edge governs the two edges that run with it.
        const int opposite = (k + 2) % 4;
        const double length = (centre - middle[k]).length() + (middle[opposite] - centre).length();
        const double turn = turnBetween(middleN[k], centreN) + turnBetween(centreN, middleN[opposite]);
        wish(next, length, turn, centre);
      } else {
        const double length = 2 * (centre - middle[k]).length(), turn = 2 * turnBetween(middleN[k], centreN);
        for (int at = 0; at < n; ++at) wish(at, length, turn, centre);
      }
    }
    if (key == 0 && n == 4) ratePlace(face, edge, wanted);
  }
}

// How far points and values inside a quad are from a bilinear mixture: lines across it, at five places each.
void Subdivider::ratePlace(int face, double edge, std::vector<double>& wanted) {
  constexpr int kSteps = 4;
  const auto edges = level_.GetFaceEdges(face);
  const auto vertices = level_.GetFaceVertices(face);
  double most = 0;  // segments that the micropolygon edge allows
  bool mayGrow = false;
  for (int k = 0; k < 4; ++k) {
    const double *a = &keys_[0][3 * vertices[k]], *b = &keys_[0][3 * vertices[(k + 1) % 4]];
    most = std::max(most, (V3d(a[0], a[1], a[2]) - V3d(b[0], b[1], b[2])).length() / edge);
  }
  for (int k = 0; k < 4; ++k) mayGrow |= !std::isfinite(edge) || most > wanted[edges[k]];
  if (!mayGrow || most <= 2) return;  // what spans so few micropolygons shows no error
  prepare(face, true);
  V3d p[kSteps + 1][kSteps + 1], normal[kSteps + 1][kSteps + 1];
  std::vector<double> values[kSteps + 1][kSteps + 1];
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= kSteps; ++i) {
      const double uv[2] = {double(i) / kSteps, double(j) / kSteps};
      p[j][i] = position(0, uv, normal[j][i]);
      evaluateValues(uv);
      values[j][i] = sampleValues_;
    }
  for (int line = 0; line <= kSteps; ++line)
    for (const bool alongV : {false, true}) {
      const auto at = [&](auto& grid, int k) -> auto& { return alongV ? grid[k][line] : grid[line][k]; };
      double share = 0, length = 0;
      for (int k = 0; k < kSteps; ++k) length += (at(p, k + 1) - at(p, k)).length();
      for (int k = 1; k < kSteps; ++k) {
        const double t = double(k) / kSteps;
        V3d off = at(p, k) - (at(p, 0) * (1 - t) + at(p, kSteps) * t);
        off -= at(normal, k) * off.dot(at(normal, k));
        if (length > 0) share = std::max(share, off.length() / length);
        for (size_t c = 0; c < valueRange_.size(); ++c)
          if (valueRange_[c] > 0)
            share = std::max(share,
                             std::abs(at(values, k)[c] - (at(values, 0)[c] * (1 - t) + at(values, kSteps)[c] * t)) /
                                 valueRange_[c]);
      }
      const double segments = segmentsForPlace(share, length, edge);
      for (const int k : {0, 2}) {
        double& w = wanted[edges[k + int(alongV)]];
        w = std::max(w, segments);
      }
    }
}

double Subdivider::estimate() const {
  double total = 0;
  for (int f = 0; f < level_.GetNumFaces(); ++f) {
    const auto edges = level_.GetFaceEdges(f);
    double sum = 0, most = 0;
    for (int k = 0; k < edges.size(); ++k) {
      sum += rates_[edges[k]];
      most = std::max<double>(most, rates_[edges[k]]);
    }
    if (isSplit(f))
      total += sum * most / 2;
    else
      total += edges.size() == 3 ? sum * sum / 9 : sum * sum / 8;
  }
  return total;
}

void Subdivider::chooseRates() {
  std::vector<double> wanted(size_t(level_.GetNumEdges()), 1);
  for (int f = 0; f < level_.GetNumFaces(); ++f) rateFace(f, wanted);
  std::vector<char> even(wanted.size(), 0);
  for (int f = 0; f < level_.GetNumFaces(); ++f)
    if (isSplit(f)) {
      const auto edges = level_.GetFaceEdges(f);
      for (int k = 0; k < edges.size(); ++k) even[edges[k]] = 1;
    }
  rates_.resize(wanted.size());
  for (double scale = 1;; scale *= 0.8) {
    bool least = true;
    for (size_t e = 0; e < wanted.size(); ++e) {
      int r = int(std::ceil(std::clamp(wanted[e] * scale - 1e-6, 1.0, double(kMostSegments))));
      least &= r == 1;
      if (even[e]) r += r & 1;
      rates_[e] = r;
    }
    if (least || estimate() <= rate_.maxTriangles) break;
  }
  edgeOffset_.resize(rates_.size());
  int64_t shared = level_.GetNumVertices();
  for (size_t e = 0; e < rates_.size(); ++e) {
    edgeOffset_[e] = shared;
    shared += rates_[e] - 1;
  }
  firstAt_.assign(size_t(shared), kNone);
}

}  // namespace kinora::geometry
