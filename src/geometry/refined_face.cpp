#include "geometry/refined_face.h"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <array>
#include <unordered_map>

namespace kinora::geometry {

namespace Far = OpenSubdiv::Far;
namespace Bfr = OpenSubdiv::Bfr;
namespace Sdc = OpenSubdiv::Sdc;

namespace {

// The face on the other side of an edge that has two, one each way; -1: there is none.
int across(const Far::TopologyLevel& level, int edge, int face) {
  const auto faces = level.GetEdgeFaces(edge);
  if (faces.size() != 2 || faces[0] == faces[1] || level.IsEdgeNonManifold(edge)) return -1;
  return faces[0] == face ? faces[1] : faces[0];
}

// The face that this one folds over at a corner; -1: there is none.
int foldAt(const Far::TopologyLevel& level, int face, int corner) {
  const auto edges = level.GetFaceEdges(face);
  const int n = edges.size(), before = edges[(corner + n - 1) % n], after = edges[corner];
  if (before == after) return -1;
  const int other = across(level, before, face);
  return across(level, after, face) == other ? other : -1;
}

// Whether two faces have a facevarying value in common at a vertex: a seam between them is no fold.
bool isJoined(const Far::TopologyLevel& level, int face, int corner, int other, int channel) {
  const int v = level.GetFaceVertices(face)[corner], value = level.GetFaceFVarValues(face, channel)[corner];
  const auto vertices = level.GetFaceVertices(other);
  const auto values = level.GetFaceFVarValues(other, channel);
  for (int k = 0; k < vertices.size(); ++k)
    if (vertices[k] == v && values[k] == value) return true;
  return false;
}

// The faces around a corner that are joined with this one: all of them, but where the vertex holds together what no
// edge does. Sorted.
std::vector<int> facesAround(const Far::TopologyLevel& level, int face, int vertex) {
  const auto all = level.GetVertexFaces(vertex);
  std::vector<int> out(all.begin(), all.end());
  if (level.IsVertexNonManifold(vertex)) {
    const auto edges = level.GetVertexEdges(vertex);
    out.assign(1, face);
    for (size_t i = 0; i < out.size(); ++i)
      for (const int e : level.GetFaceEdges(out[i])) {
        if (std::find(edges.begin(), edges.end(), e) == edges.end()) continue;
        const int next = across(level, e, out[i]);
        if (next >= 0 && std::find(out.begin(), out.end(), next) == out.end()) out.push_back(next);
      }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Rows of `width` values, as OpenSubdiv's interpolation sees them.
struct Rows {
  double* at;
  int width;
  struct Row {
    double* at;
    int width;
    void Clear() { std::fill(at, at + width, 0.0); }
    void AddWithWeight(const Row& other, double weight) {
      for (int k = 0; k < width; ++k) at[k] += weight * other.at[k];
    }
  };
  Row operator[](int i) const { return {at + size_t(i) * size_t(width), width}; }
};

}  // namespace

bool foldsAtCorner(const Far::TopologyLevel& level, int face) {
  for (int k = 0; k < level.GetFaceVertices(face).size(); ++k)
    if (foldAt(level, face, k) >= 0) return true;
  return false;
}

bool needsRefinement(const Far::TopologyRefiner& refiner, int face) {
  if (refiner.GetSchemeType() == Sdc::SCHEME_BILINEAR) return false;  // has no patches but plain faces
  const Far::TopologyLevel& level = refiner.GetLevel(0);
  if (!foldsAtCorner(level, face)) return false;
  const auto vertices = level.GetFaceVertices(face);
  constexpr int kOfPoints = -1;
  for (int channel = kOfPoints; channel < level.GetNumFVarChannels(); ++channel) {
    bool isFolded = false, isSharp = false, isAtBoundary = false;
    for (int k = 0; k < vertices.size(); ++k) {
      const int v = vertices[k];
      int sharp = 0, infinitelySharp = 0;
      for (const int e : level.GetVertexEdges(v)) {
        if (level.GetEdgeFaces(e).size() < 2) continue;
        sharp += level.GetEdgeSharpness(e) > 0;
        infinitelySharp += level.IsEdgeInfSharp(e);
      }
      const int other = foldAt(level, face, k);
      const bool isFoldedHere = other >= 0 && (channel < 0 || isJoined(level, face, k, other, channel));
      if (isFoldedHere && infinitelySharp == 1) return true;
      isFolded |= isFoldedHere;
      isSharp |= sharp > 0;
      isAtBoundary |= level.IsVertexBoundary(v) || level.IsVertexNonManifold(v) ||
                      (channel >= 0 && !level.DoesVertexFVarTopologyMatch(v, channel));
    }
    if (isFolded && isSharp && isAtBoundary) return true;
  }
  return false;
}

// A face by itself, first of its ring.
struct RefinedFace::Piece {
  struct Values {
    CageValues::Kind kind;
    int channel, width;
    std::vector<double> control;  // of the ring
    Bfr::Surface<double> surface;
    size_t like = 0;  // the values whose surface is theirs
    std::vector<double> patch;
    std::vector<double> limit;  // instead, on the last level of the refiner
  };
  std::unique_ptr<Far::TopologyRefiner> refiner;
  int size = 4;
  std::vector<Values> values;
  std::vector<std::unique_ptr<Piece>> parts;  // one for each corner

  Piece(const Far::TopologyRefiner& from, int levelNumber, int face, const std::vector<CageValues>& in, int levels) {
    gather(from, levelNumber, face, in);
    if (!refiner) return;
    if (!needsRefinement(*refiner, 0)) {
      findSurfaces();
    } else if (isLoop()) {
      refineAll();
    } else if (levels > 0 || size != 4) {
      split(levels - 1);
    } else {
      findLimits(controls());
    }
  }

  bool isLoop() const { return refiner->GetSchemeType() == Sdc::SCHEME_LOOP; }

  // The ring's own topology, with what is sharp in it.
  void gather(const Far::TopologyRefiner& from, int levelNumber, int face, const std::vector<CageValues>& in) {
    const Far::TopologyLevel& level = from.GetLevel(levelNumber);
    std::vector<int> faces{face};
    for (const int v : level.GetFaceVertices(face))
      for (const int f : facesAround(level, face, v))
        if (std::find(faces.begin(), faces.end(), f) == faces.end()) faces.push_back(f);
    std::unordered_map<int, int> own;
    std::vector<int> sizes, indices, vertices, corners, creases;
    std::vector<float> cornerWeights, creaseWeights;
    size = level.GetFaceVertices(face).size();
    const auto number = [](std::unordered_map<int, int>& numbers, std::vector<int>& list, int i) {
      const auto [it, isNew] = numbers.try_emplace(i, int(list.size()));
      if (isNew) list.push_back(i);
      return it->second;
    };
    std::vector<int> edges;
    for (const int f : faces) {
      sizes.push_back(level.GetFaceVertices(f).size());
      for (const int v : level.GetFaceVertices(f)) indices.push_back(number(own, vertices, v));
      for (const int e : level.GetFaceEdges(f)) edges.push_back(e);
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    for (const int e : edges)
      if (const float s = level.GetEdgeSharpness(e); s > 0) {
        for (const int v : level.GetEdgeVertices(e)) creases.push_back(own.at(v));
        creaseWeights.push_back(s);
      }
    for (size_t i = 0; i < vertices.size(); ++i)
      if (const float s = level.GetVertexSharpness(vertices[i]); s > 0) {
        corners.push_back(int(i));
        cornerWeights.push_back(s);
      }
    Far::TopologyDescriptor d;
    d.numVertices = int(vertices.size());
    d.numFaces = int(sizes.size());
    d.numVertsPerFace = sizes.data();
    d.vertIndicesPerFace = indices.data();
    d.numCreases = int(creaseWeights.size());
    d.creaseVertexIndexPairs = creases.data();
    d.creaseWeights = creaseWeights.data();
    d.numCorners = int(corners.size());
    d.cornerVertexIndices = corners.data();
    d.cornerWeights = cornerWeights.data();
    const int channelCount = level.GetNumFVarChannels();
    std::vector<std::vector<int>> valuesOfChannel(static_cast<size_t>(channelCount)),
        valueOfCorner(static_cast<size_t>(channelCount));
    std::vector<Far::TopologyDescriptor::FVarChannel> channels(static_cast<size_t>(channelCount));
    for (size_t c = 0; c < channels.size(); ++c) {
      std::unordered_map<int, int> numbers;
      for (const int f : faces)
        for (const int v : level.GetFaceFVarValues(f, int(c)))
          valueOfCorner[c].push_back(number(numbers, valuesOfChannel[c], v));
      channels[c].numValues = int(valuesOfChannel[c].size());
      channels[c].valueIndices = valueOfCorner[c].data();
    }
    d.numFVarChannels = channelCount;
    d.fvarChannels = channels.data();
    Sdc::Options options = from.GetSchemeOptions();
    // what is sharp at a boundary is said by its edges and vertices, and the ring's own edge is none
    options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    refiner.reset(Factory::Create(d, Factory::Options(from.GetSchemeType(), options)));
    if (!refiner) return;
    values.resize(in.size());
    for (size_t i = 0; i < in.size(); ++i) {
      Values& v = values[i];
      v.kind = in[i].kind;
      v.channel = in[i].channel;
      v.width = in[i].width;
      const std::vector<int>& list =
          v.kind == CageValues::Kind::FaceVarying ? valuesOfChannel[size_t(v.channel)] : vertices;
      for (const int k : list) {
        const double* row = in[i].values + size_t(k) * size_t(v.width);
        v.control.insert(v.control.end(), row, row + v.width);
      }
    }
  }

  void findSurfaces() {
    const Bfr::RefinerSurfaceFactory<> factory(*refiner, Bfr::SurfaceFactory::Options().EnableCaching(false));
    for (size_t i = 0; i < values.size(); ++i) {
      Values& v = values[i];
      v.like = i;
      for (size_t k = 0; k < i && v.like == i; ++k)
        if (values[k].kind == v.kind && values[k].channel == v.channel) v.like = k;
      if (v.like == i) {
        if (v.kind == CageValues::Kind::Vertex)
          factory.InitVertexSurface(0, &v.surface);
        else if (v.kind == CageValues::Kind::Varying)
          factory.InitVaryingSurface(0, &v.surface);
        else
          factory.InitFaceVaryingSurface(0, &v.surface, Bfr::SurfaceFactory::FVarID(v.channel));
      }
      const Bfr::Surface<double>* surface = surfaceOf(i);
      if (!surface) continue;
      v.patch.resize(size_t(surface->GetNumPatchPoints()) * size_t(v.width));
      surface->PreparePatchPoints(v.control.data(), v.width, v.patch.data(), v.width);
    }
  }
  const Bfr::Surface<double>* surfaceOf(size_t which) const {
    const Bfr::Surface<double>& s = values[values[which].like].surface;
    return s.IsValid() ? &s : nullptr;
  }

  // The limits at all points of the last level that the refiner has.
  void findLimits(const std::vector<std::vector<double>>& last) {
    const Far::PrimvarRefinerReal<double> interpolation(*refiner);
    for (size_t i = 0; i < values.size(); ++i) {
      Values& v = values[i];
      v.limit = last[i];
      const Rows from{const_cast<double*>(last[i].data()), v.width};
      Rows to{v.limit.data(), v.width};
      if (v.kind == CageValues::Kind::FaceVarying)
        interpolation.LimitFaceVarying(from, to, v.channel);
      else if (v.kind == CageValues::Kind::Vertex)
        interpolation.Limit(from, to);
    }
  }
  std::vector<std::vector<double>> controls() const {
    std::vector<std::vector<double>> out;
    for (const Values& v : values) out.push_back(v.control);
    return out;
  }
  // Values on the next level from those of the one before.
  std::vector<std::vector<double>> finer(int level, const std::vector<std::vector<double>>& before) const {
    const Far::TopologyLevel& l = refiner->GetLevel(level);
    const Far::PrimvarRefinerReal<double> interpolation(*refiner);
    std::vector<std::vector<double>> out(values.size());
    for (size_t i = 0; i < values.size(); ++i) {
      const Values& v = values[i];
      const bool isFaceVarying = v.kind == CageValues::Kind::FaceVarying;
      out[i].resize(size_t(isFaceVarying ? l.GetNumFVarValues(v.channel) : l.GetNumVertices()) * size_t(v.width));
      const Rows from{const_cast<double*>(before[i].data()), v.width};
      Rows to{out[i].data(), v.width};
      if (isFaceVarying)
        interpolation.InterpolateFaceVarying(level, from, to, v.channel);
      else if (v.kind == CageValues::Kind::Varying)
        interpolation.InterpolateVarying(level, from, to);
      else
        interpolation.Interpolate(level, from, to);
    }
    return out;
  }
  void refine(int levels) {
    Far::TopologyRefiner::UniformOptions options(levels);
    options.fullTopologyInLastLevel = true;
    refiner->RefineUniform(options);
  }

  // Two triangles that share two edges share the third, and so do their parts: by their points alone, which is how
  // rings are gathered, the parts' edges could not be told from each other. The whole ring is refined instead.
  void refineAll() {
    constexpr int kLevels = 5;
    refine(kLevels);
    std::vector<std::vector<double>> now = controls();
    for (int level = 1; level <= kLevels; ++level) now = finer(level, now);
    findLimits(now);
  }

  void split(int levels) {
    refine(1);
    const std::vector<std::vector<double>> parts1 = finer(1, controls());
    std::vector<CageValues> in;
    for (size_t i = 0; i < values.size(); ++i)
      in.push_back({values[i].kind, values[i].channel, values[i].width, parts1[i].data()});
    for (const int f : refiner->GetLevel(0).GetFaceChildFaces(0))
      parts.push_back(std::make_unique<Piece>(*refiner, 1, f, in, levels));
  }

  void evaluate(double s, double t, size_t which, double* value, double* du, double* dv) const {
    if (!refiner) return;
    if (!parts.empty()) {
      const size_t part = inPart(s, t);
      if (part < parts.size()) parts[part]->evaluate(s, t, which, value, du, dv);
      return;
    }
    const Values& v = values[which];
    if (const Bfr::Surface<double>* surface = surfaceOf(which)) {
      const double uv[2] = {s, t};
      if (du && dv)
        surface->Evaluate(uv, v.patch.data(), v.width, value, du, dv);
      else
        surface->Evaluate(uv, v.patch.data(), v.width, value);
      return;
    }
    if (v.limit.empty()) return;
    const int last = refiner->GetMaxLevel();
    int face = 0;
    double sign = 1;  // the middle one of four triangles is turned by half a turn
    for (int level = 0; level < last; ++level) {
      const size_t part = inPart(s, t);
      if (part == 3) sign = -sign;
      face = refiner->GetLevel(level).GetFaceChildFaces(face)[int(part)];
    }
    const Far::TopologyLevel& level = refiner->GetLevel(last);
    const auto at = v.kind == CageValues::Kind::FaceVarying ? level.GetFaceFVarValues(face, v.channel)
                                                            : level.GetFaceVertices(face);
    std::array<double, 4> w, wu, wv;
    if (at.size() == 4) {
      w = {(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t};
      wu = {t - 1, 1 - t, t, -t};
      wv = {s - 1, -s, s, 1 - s};
    } else {
      w = {1 - s - t, s, t, 0};
      wu = {-sign, sign, 0, 0};
      wv = {-sign, 0, sign, 0};
    }
    for (int k = 0; k < v.width; ++k) {
      value[k] = 0;
      if (du) du[k] = 0;
      if (dv) dv[k] = 0;
      for (int c = 0; c < at.size(); ++c) {
        const double x = v.limit[size_t(at[c]) * size_t(v.width) + size_t(k)];
        value[k] += w[size_t(c)] * x;
        if (du) du[k] += wu[size_t(c)] * x;
        if (dv) dv[k] += wv[size_t(c)] * x;
      }
    }
  }

  // The part that a place lies in; the place becomes that in its parameters.
  size_t inPart(double& s, double& t) const {
    if (isLoop()) {
      s *= 2;
      t *= 2;
      if (s + t <= 1) return 0;
      if (s >= 1) {
        s -= 1;
        return 1;
      }
      if (t >= 1) {
        t -= 1;
        return 2;
      }
      s = 1 - s;
      t = 1 - t;
      return 3;
    }
    if (size != 4) {
      const Bfr::Parameterization whole(refiner->GetSchemeType(), size);
      const double uv[2] = {s, t};
      double local[2];
      const int part = whole.ConvertCoordToNormalizedSubFace(uv, local);
      s = local[0];
      t = local[1];
      return size_t(part);
    }
    s *= 2;
    t *= 2;
    const bool right = s >= 1, up = t >= 1;
    s -= right;
    t -= up;
    return up ? (right ? 2 : 3) : (right ? 1 : 0);
  }
};

RefinedFace::RefinedFace(const Far::TopologyRefiner& refiner, int face, const std::vector<CageValues>& values,
                         int levels)
    : whole_(std::make_unique<Piece>(refiner, 0, face, values, levels)) {}

RefinedFace::~RefinedFace() = default;

void RefinedFace::evaluate(const double uv[2], size_t which, double* value, double* du, double* dv) const {
  whole_->evaluate(uv[0], uv[1], which, value, du, dv);
}

}  // namespace kinora::geometry
