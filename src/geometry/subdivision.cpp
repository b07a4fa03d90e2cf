// Subdivision meshes on their limit surface (OpenSubdiv's Bfr). Each edge gets its rate from the surface itself, so
// that two faces meet with the same points; a point on an edge or corner is evaluated once and its position copied
// bit for bit where normals or facevarying values differ between the sides. Faces that are not quads are cut into the
// quads that the first refinement would make, so that (u, v) and triangles never straddle them.
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/facets.h"
#include "geometry/makers.h"
#include "geometry/polygon.h"
#include "geometry/subdivider.h"

namespace kinora::geometry {

using Imath::V3d;
using scene::StorageClass;
namespace Bfr = OpenSubdiv::Bfr;
namespace Sdc = OpenSubdiv::Sdc;

namespace {

constexpr double kNoCrease = 0.9995;  // cosine (1.8 degrees): more is a crease

}  // namespace

void Subdivider::addChannels(const std::vector<SourcePrimvar>& primvars) {
  for (Channel::Kind kind : {Channel::Kind::Vertex, Channel::Kind::Varying}) {
    Channel c;
    c.kind = kind;
    const StorageClass storage = kind == Channel::Kind::Vertex ? StorageClass::Vertex : StorageClass::Varying;
    for (const SourcePrimvar& s : primvars)
      if (s.storage == storage) {
        c.parts.emplace_back(&s, valueWidth_ + c.width);
        c.width += int(s.parameter->elementFloats());
      }
    if (c.width == 0) continue;
    const size_t points = keys_[0].size() / 3;
    c.data.assign(points * c.width, 0);
    int at = 0;
    for (const auto& [s, unused] : c.parts) {
      const int w = int(s->parameter->elementFloats());
      for (size_t i = 0; i < std::min(points, s->elements); ++i)
        for (int k = 0; k < w; ++k) c.data[i * c.width + at + k] = s->values[i * w + k];
      at += w;
    }
    valueWidth_ += c.width;
    channels_.push_back(std::move(c));
  }
  for (size_t i = 0; i < cage_.faceVarying.size(); ++i) {
    Channel c;
    c.kind = Channel::Kind::FaceVarying;
    c.index = int(i);
    c.width = cage_.faceVarying[i].width;
    c.data = cage_.faceVarying[i].values;
    c.parts.emplace_back(cage_.faceVarying[i].source, valueWidth_);
    valueWidth_ += c.width;
    channels_.push_back(std::move(c));
  }
  for (const Channel& c : channels_)
    for (int k = 0; k < c.width; ++k) {
      double low = 0, high = 0;
      for (size_t i = size_t(k); i < c.data.size(); i += size_t(c.width)) {
        low = i < size_t(c.width) ? c.data[i] : std::min(low, c.data[i]);
        high = i < size_t(c.width) ? c.data[i] : std::max(high, c.data[i]);
      }
      valueRange_.push_back(high - low);
    }
  sampleValues_.resize(valueWidth_);
  samplePoint_.resize(keys_.size());
  sampleNormal_.resize(keys_.size());
}

// Makes a face the current one. False: it has no limit surface, being a hole or at a boundary that is not interpolated.
bool Subdivider::start(int face) {
  refined_.reset();
  parameterization_ = Bfr::Parameterization(factory_.GetSchemeType(), level_.GetFaceVertices(face).size());
  if (!foldsAtCorner(level_, face)) return factory_.InitVertexSurface(face, &surface_);
  if (!needsRefinement(*cage_.refiner, face)) return unshared_.InitVertexSurface(face, &surface_);
  if (!factory_.FaceHasLimitSurface(face)) return false;
  std::vector<CageValues> values;
  for (const auto& key : keys_) values.push_back({CageValues::Kind::Vertex, 0, 3, key.data()});
  for (const Channel& c : channels_) {
    const auto kind = c.kind == Channel::Kind::Vertex    ? CageValues::Kind::Vertex
                      : c.kind == Channel::Kind::Varying ? CageValues::Kind::Varying
                                                         : CageValues::Kind::FaceVarying;
    values.push_back({kind, c.index, c.width, c.data.data()});
  }
  refined_ = std::make_unique<RefinedFace>(*cage_.refiner, face, values);
  return true;
}

V3d Subdivider::position(size_t key, const double uv[2], V3d& normal) const {
  V3d p, du, dv;
  if (refined_)
    refined_->evaluate(uv, key, &p.x, &du.x, &dv.x);
  else
    surface_.Evaluate(uv, keyPatch_[key].data(), 3, &p.x, &du.x, &dv.x);
  normal = du.cross(dv).normalized();
  return p;
}

void Subdivider::preparePoints(size_t key) {
  if (refined_) return;
  keyPatch_[key].resize(size_t(surface_.GetNumPatchPoints()) * 3);
  surface_.PreparePatchPoints(keys_[key].data(), 3, keyPatch_[key].data(), 3);
}

void Subdivider::prepare(int face, bool valuesOnly) {
  for (size_t k = 0; k < keys_.size() && !valuesOnly; ++k) preparePoints(k);
  if (refined_) return;
  const Bfr::SurfaceFactory& factory = foldsAtCorner(level_, face) ? unshared_ : factory_;
  for (Channel& c : channels_) {
    const Surface* s = &surface_;
    if (c.kind == Channel::Kind::Varying) {
      factory.InitVaryingSurface(face, &c.surface);
      s = &c.surface;
    } else if (c.kind == Channel::Kind::FaceVarying) {
      factory.InitFaceVaryingSurface(face, &c.surface, Bfr::SurfaceFactory::FVarID(c.index));
      s = &c.surface;
    }
    if (!s->IsValid()) continue;
    c.patch.resize(size_t(s->GetNumPatchPoints()) * c.width);
    s->PreparePatchPoints(c.data.data(), c.width, c.patch.data(), c.width);
  }
}

void Subdivider::evaluate(const double uv[2]) {
  for (size_t k = 0; k < keys_.size(); ++k) samplePoint_[k] = position(k, uv, sampleNormal_[k]);
  evaluateValues(uv);
}

void Subdivider::evaluateValues(const double uv[2]) {
  int at = 0;
  for (size_t i = 0; i < channels_.size(); ++i) {
    const Channel& c = channels_[i];
    const Surface& s = c.kind == Channel::Kind::Vertex ? surface_ : c.surface;
    if (refined_)
      refined_->evaluate(uv, keys_.size() + i, &sampleValues_[at]);
    else if (s.IsValid())
      s.Evaluate(uv, c.patch.data(), c.width, &sampleValues_[at]);
    at += c.width;
  }
}

// The mesh vertex for the sample at a site: the one that is there already if it agrees, else a new one, at the same
// place to the bit.
uint32_t Subdivider::emit(Site site) {
  uint32_t* head = site.shared >= 0   ? &firstAt_[size_t(site.shared)]
                   : site.inFace >= 0 ? &inFace_[site.inFace]
                                      : nullptr;
  if (head)
    for (uint32_t v = *head; v != kNone; v = nextAt_[v]) {
      bool same = true;  // at all times: what is flat now may fold
      for (size_t k = 0; k < keys_.size() && same; ++k) {
        const V3d& n = outNormals_[k][v];
        const bool undefined = n == V3d(0) || sampleNormal_[k] == V3d(0);
        same = undefined || n.dot(sampleNormal_[k]) > kNoCrease;
      }
      int at = 0;
      for (const Channel& c : channels_) {
        if (c.kind == Channel::Kind::FaceVarying)
          for (int k = at; k < at + c.width && same; ++k) {
            const double a = outValues_[size_t(v) * valueWidth_ + k], b = sampleValues_[k];
            same = std::abs(a - b) <= 1e-4 * (std::abs(a) + 1e-3);
          }
        at += c.width;
      }
      if (same) return v;
    }
  const uint32_t v = uint32_t(outPoints_[0].size());
  for (size_t k = 0; k < keys_.size(); ++k) {
    outPoints_[k].push_back(head && *head != kNone ? outPoints_[k][*head] : samplePoint_[k]);
    outNormals_[k].push_back(sampleNormal_[k]);
  }
  for (double x : sampleValues_) outValues_.push_back(float(x));
  nextAt_.push_back(head ? *head : kNone);
  if (head) *head = v;
  return v;
}

Subdivider::Site Subdivider::onEdge(int face, int k, int step) const {
  const auto vertices = level_.GetFaceVertices(face);
  const int edge = level_.GetFaceEdges(face)[k], rate = rates_[edge], n = vertices.size();
  if (step == 0) return {vertices[k]};
  if (step == rate) return {vertices[(k + 1) % n]};
  const bool forward = level_.GetEdgeVertices(edge)[0] == vertices[k];
  return {edgeOffset_[edge] + (forward ? step : rate - step) - 1};
}

// A facet of the current cell.
void Subdivider::emitFacet(int face, const int* facet, int corners) {
  std::array<uint32_t, 4> vertices{};
  std::array<Imath::V2f, 4> uv;
  for (int k = 0; k < corners; ++k) {
    vertices[size_t(k)] = cellVertex_[facet[k]];
    uv[size_t(k)] = {float(coords_[2 * facet[k]]), float(coords_[2 * facet[k] + 1])};
  }
  appendFacet(mesh_, uint32_t(face), vertices, uv, corners);
}

void Subdivider::makeCell(int face, const Bfr::Parameterization& pattern, int rateCount, const int* rates,
                          const std::vector<Site>& outline, int subFace) {
  Bfr::Tessellation::Options options;
  const int facetSize = pattern.GetFaceSize() == 4 ? 4 : 3;  // quads wherever the rates of the sides let them be
  options.SetFacetSize(facetSize).PreserveQuads(true);
  const Bfr::Tessellation cell(pattern, rateCount, rates, options);
  if (!cell.IsValid() || cell.GetNumBoundaryCoords() != int(outline.size())) return;
  const int count = cell.GetNumCoords();
  coords_.resize(size_t(count) * 2);
  cell.GetCoords(coords_.data());
  facets_.resize(size_t(cell.GetNumFacets()) * facetSize);
  cell.GetFacets(facets_.data());
  cellVertex_.resize(size_t(count));
  for (int i = 0; i < count; ++i) {
    double uv[2] = {coords_[2 * i], coords_[2 * i + 1]};
    if (subFace >= 0) {
      const double local[2] = {uv[0], uv[1]};
      parameterization_.ConvertNormalizedSubFaceToCoord(subFace, local, uv);
    }
    evaluate(uv);
    cellVertex_[i] = emit(i < int(outline.size()) ? outline[i] : Site{});
  }
  for (size_t f = 0; f < facets_.size(); f += size_t(facetSize))
    emitFacet(face, &facets_[f], facetSize == 4 && facets_[f + 3] >= 0 ? 4 : 3);
}

void Subdivider::makeFace(int face) {
  if (!start(face)) return;
  prepare(face);
  const auto edges = level_.GetFaceEdges(face);
  const int n = edges.size();
  std::vector<Site> outline;
  if (n == 4 && !isSplit(face) && isWhole(face)) {
    // Dense cages: two triangles a face, in the order that Mesh::quadPairs means.
    static const double kCorner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    uint32_t v[4];
    for (int k = 0; k < 4; ++k) {
      evaluate(kCorner[k]);
      v[k] = emit(onEdge(face, k, 0));
    }
    for (int k : {0, 1, 2, 0, 2, 3}) {
      mesh_.indices.push_back(v[k]);
      if (!allWhole_) mesh_.cornerUV.emplace_back(float(kCorner[k][0]), float(kCorner[k][1]));
    }
    mesh_.faceOfTriangle.insert(mesh_.faceOfTriangle.end(), 2, uint32_t(face));
    mesh_.quads = true;
    return;
  }
  if (!isSplit(face)) {
    int rates[4];
    for (int k = 0; k < n; ++k) {
      rates[k] = rates_[edges[k]];
      for (int i = 0; i < rates[k]; ++i) outline.push_back(onEdge(face, k, i));
    }
    makeCell(face, parameterization_, n, rates, outline, -1);
    return;
  }
  // Quad j: corner j, middle of edge j, centre, middle of the edge before. Spokes run from the middles to the centre.
  int spoke = 1;
  for (int k = 0; k < n; ++k) spoke = std::max(spoke, rates_[edges[k]] / 2);
  const int centre = n * (spoke - 1);
  inFace_.assign(size_t(centre) + 1, kNone);
  const Bfr::Parameterization quad(Sdc::SCHEME_CATMARK, 4);
  for (int j = 0; j < n; ++j) {
    const int before = (j + n - 1) % n, half = rates_[edges[j]] / 2, halfBefore = rates_[edges[before]] / 2;
    const int rates[4] = {half, spoke, spoke, halfBefore};
    outline.clear();
    for (int i = 0; i <= half; ++i) outline.push_back(onEdge(face, j, i));
    for (int i = 1; i < spoke; ++i) outline.push_back({-1, j * (spoke - 1) + i - 1});
    outline.push_back({-1, centre});
    for (int i = spoke - 1; i >= 1; --i) outline.push_back({-1, before * (spoke - 1) + i - 1});
    for (int i = halfBefore; i < 2 * halfBefore; ++i) outline.push_back(onEdge(face, before, i));
    makeCell(face, quad, 4, rates, outline, j);
  }
}

bool Subdivider::run(const std::vector<SourcePrimvar>& primvars) {
  addChannels(primvars);
  chooseRates();
  allWhole_ = true;
  for (int f = 0; f < level_.GetNumFaces() && allWhole_; ++f)
    allWhole_ = !isSplit(f) && level_.GetFaceVertices(f).size() == 4 && isWhole(f);
  const double guess = estimate();
  mesh_.indices.reserve(size_t(guess * 3));
  for (int f = 0; f < level_.GetNumFaces(); ++f) {
    if (outPoints_[0].size() > 0xf0000000u) {
      diagnostics_.error("GEOM-TOO-LARGE", primitive_.pos,
                         subject(primitive_) + " has too many faces to be subdivided",
                         "the faces from " + std::to_string(f) + " on are left out");
      break;
    }
    makeFace(f);
  }
  if (mesh_.indices.empty()) {
    diagnostics_.warning("GEOM-ZERO-AREA", primitive_.pos, subject(primitive_) + " has no limit surface",
                         "the primitive is left out",
                         "without the tag \"interpolateboundary\" the faces at a boundary have none");
    return false;
  }
  mesh_.quadPairs = allWhole_;
  const bool perFace = std::any_of(primvars.begin(), primvars.end(),
                                   [](const SourcePrimvar& s) { return s.storage == StorageClass::Uniform; });
  if (allWhole_ && !perFace && mesh_.triangleCount() == 2 * uint32_t(level_.GetNumFaces()))
    std::vector<uint32_t>().swap(mesh_.faceOfTriangle);
  mesh_.indices.shrink_to_fit();
  mesh_.faceOfTriangle.shrink_to_fit();
  mesh_.cornerUV.shrink_to_fit();

  std::vector<V3d> all;
  all.reserve(outPoints_[0].size() * keys_.size());
  for (const auto& key : outPoints_) all.insert(all.end(), key.begin(), key.end());
  storePoints(all, keys_.size(), mesh_);

  // Where the surface has no tangent plane the triangles around the vertex give the normal.
  for (size_t k = 0; k < keys_.size(); ++k) {
    std::vector<V3d>& n = outNormals_[k];
    const double side = mesh_.flipNormals ? -1 : 1;
    std::vector<uint32_t> missing;
    for (uint32_t v = 0; v < n.size(); ++v)
      if (n[v] == V3d(0) || !std::isfinite(n[v].length())) missing.push_back(v), n[v] = V3d(0);
    if (!missing.empty()) {
      std::vector<char> isMissing(n.size(), 0);
      for (uint32_t v : missing) isMissing[v] = 1;
      for (uint32_t t = 0; t < mesh_.triangleCount(); ++t)
        for (int c = 0; c < 3; ++c) {
          const uint32_t v = mesh_.indices[size_t(t) * 3 + c];
          if (isMissing[v]) n[v] += geometricNormal(mesh_, t, k) * side;
        }
      for (uint32_t v : missing) n[v] = n[v].length() > 0 ? n[v].normalized() : V3d(0, 0, 1);
    }
  }
  Primvar normals = Primvar::normals();
  normals.data.reserve(all.size() * 3);
  for (const auto& key : outNormals_)
    for (const V3d& n : key)
      for (int c = 0; c < 3; ++c) normals.data.push_back(float(mesh_.flipNormals ? -n[c] : n[c]));
  mesh_.primvars.push_back(std::move(normals));

  for (const Channel& c : channels_)
    for (const auto& [source, at] : c.parts) {
      Primvar p = emptyPrimvar(*source, Primvar::Rate::PerVertex);
      p.data.reserve(size_t(mesh_.vertexCount) * p.width);
      for (size_t v = 0; v < mesh_.vertexCount; ++v)
        for (int k = 0; k < p.width; ++k) p.data.push_back(outValues_[v * valueWidth_ + at + k]);
      mesh_.primvars.push_back(std::move(p));
    }
  for (const SourcePrimvar& s : primvars)
    if (s.storage == StorageClass::Constant || s.storage == StorageClass::Uniform) {
      Primvar p =
          emptyPrimvar(s, s.storage == StorageClass::Constant ? Primvar::Rate::Constant : Primvar::Rate::PerFace);
      p.data = s.values;
      mesh_.primvars.push_back(std::move(p));
    }
  joinTextureCoordinates(mesh_);
  return true;
}

namespace {

// Facevertex values are subdivided as vertex data is. Those with one value a vertex, and so no seam, become vertex data:
// the tag facevaryinginterpolateboundary is not about them.
void joinFaceVertex(SourcePrimvar& s, const std::vector<int>& vertices, size_t pointCount) {
  if (s.storage != StorageClass::FaceVertex || s.elements != vertices.size()) return;
  const size_t width = s.parameter->elementFloats();
  std::vector<float> values(pointCount * width);
  std::vector<char> isKnown(pointCount);
  for (size_t corner = 0; corner < vertices.size(); ++corner) {
    const auto from = s.values.begin() + std::ptrdiff_t(corner * width);
    const auto to = values.begin() + std::ptrdiff_t(size_t(vertices[corner]) * width);
    if (!std::exchange(isKnown[size_t(vertices[corner])], 1))
      std::copy_n(from, width, to);
    else if (!std::equal(from, from + std::ptrdiff_t(width), to))
      return;
  }
  s.storage = StorageClass::Vertex;
  s.elements = pointCount;
  s.values = std::move(values);
}

// The cage as plain polygons, smooth unless the scheme is linear.
bool makeCagePolygons(const scene::Primitive& primitive, const scene::SubdivisionMesh& shape, const PointKeys& points,
                      PolygonFaces faces, Diagnostics& diagnostics, Mesh& mesh) {
  const std::vector<int> holes = holesOf(shape);
  std::vector<int> sizes, vertices;
  if (!holes.empty()) {
    faces.uniformCount = faces.faceCount;
    faces.faceVaryingCount = faces.cornerCount;
    size_t corner = 0, kept = 0, next = 0;
    for (size_t f = 0; f < faces.faceCount; ++f) {
      const size_t n = size_t(faces.verticesPerLoop[f]);
      while (next < holes.size() && size_t(holes[next]) < f) ++next;
      if (next == holes.size() || size_t(holes[next]) != f) {
        faces.originalFace.push_back(uint32_t(f));
        sizes.push_back(int(n));
        for (size_t k = corner; k < corner + n; ++k) {
          faces.originalCorner.push_back(uint32_t(k));
          vertices.push_back(faces.vertices[k]);
        }
        ++kept;
      }
      corner += n;
    }
    faces.faceCount = kept;
    faces.cornerCount = vertices.size();
    faces.verticesPerLoop = sizes;
    faces.vertices = vertices;
    faces.arity = 0;
  }
  if (!makePolygons(primitive, points, faces, diagnostics, mesh)) return false;
  if (!mesh.find("N") && shape.scheme != "bilinear") addSmoothNormals(mesh);
  return true;
}

}  // namespace

bool makeSubdivision(const scene::Primitive& primitive, const scene::SubdivisionMesh& shape, const DiceRate& rate,
                     Diagnostics& diagnostics, Mesh& mesh) {
  const std::optional<PointKeys> points = readPoints(primitive, diagnostics);
  if (!points) return false;
  if (shape.verticesPerFace.empty() || shape.vertices.empty()) {
    diagnostics.warning("GEOM-ZERO-AREA", primitive.pos, subject(primitive) + " has no faces",
                        "the primitive is left out");
    return false;
  }
  PolygonFaces faces = readFaces(primitive, {}, shape.verticesPerFace, shape.vertices, points->count, diagnostics);
  std::string why;
  if (faces.faceCount < shape.verticesPerFace.size()) why = "its face list is broken";
  if (points->nonFinite) why = "a point is not finite";
  if (points->count > size_t(INT32_MAX) || faces.cornerCount > size_t(INT32_MAX)) why = "it is too large";

  // Limit normals take the place of normals that the user gives to the cage.
  scene::Primitive withoutNormals;
  const scene::Primitive* source = &primitive;
  if (why.empty() && primitive.primvars.find("N")) {
    withoutNormals = primitive;
    withoutNormals.primvars.erase("N");
    source = &withoutNormals;
  }
  if (why.empty()) {
    const ClassCounts counts{faces.faceCount, points->count, points->count, faces.cornerCount};
    std::vector<SourcePrimvar> primvars = readPrimvars(*source, counts, diagnostics);
    for (SourcePrimvar& s : primvars) joinFaceVertex(s, shape.vertices, points->count);
    const std::unique_ptr<Cage> cage = makeCage(primitive, shape, points->count, primvars, diagnostics, why);
    if (cage) mesh.times = points->times;
    if (cage) return Subdivider(primitive, *points, *cage, rate, diagnostics, mesh).run(primvars);
  }
  diagnostics.warning("GEOM-SUBDIVISION-CAGE", primitive.pos, subject(primitive) + " cannot be subdivided: " + why,
                      "its cage is rendered as polygons");
  return makeCagePolygons(primitive, shape, *points, faces, diagnostics, mesh);
}

}  // namespace kinora::geometry
