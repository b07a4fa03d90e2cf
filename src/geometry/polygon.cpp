// All four polygon requests. Meshes of triangles are copied straight through (18 bytes a triangle); quads are cut
// along the diagonal that suits them; everything else goes through the Triangulator, and outlines that cross
// themselves through fillByWinding(), whose new points stand behind those of the mesh. A deforming mesh is cut by its
// first key.
#include <algorithm>
#include <climits>
#include <cmath>
#include <numeric>

#include "geometry/build.h"
#include "geometry/makers.h"
#include "geometry/polygon.h"
#include "geometry/triangulate.h"
#include "geometry/winding_fill.h"

namespace kinora::geometry {

using Imath::V3d;
using Imath::V3f;

namespace {

// What went wrong with faces, told in one message for each kind.
struct Faults {
  size_t index = 0, corners = 0, notFinite = 0, noArea = 0, tangled = 0;
  size_t dropped() const { return index + corners + notFinite + noArea; }
};

// Faces -> mesh.indices, faceOfTriangle, and for each triangle corner the corner of the face list it comes from.
class Cutter {
 public:
  // Faces are cut by the points of `key`.
  Cutter(const PointKeys& points, size_t key, const PolygonFaces& faces, Mesh& mesh)
      : points_(points), key_(key), faces_(faces), mesh_(mesh) {}

  // All faces single loops of `arity` corners: false when some face needs the general way.
  bool cutTriangles();
  bool cutQuads();
  void cutAny();

  std::vector<uint32_t> corners;  // empty: triangle corner i is face corner i
  // Between two face corners: its number as a corner goes on behind those of the faces, as a vertex behind the points.
  struct Between {
    uint32_t from, to;
    double share;
    float mix(float a, float b) const { return float(a + share * (double(b) - a)); }
  };
  std::vector<Between> added;
  int vertexOf(size_t corner) const {
    if (corner >= faces_.cornerCount) return int(points_.count + (corner - faces_.cornerCount));
    return faces_.vertices.empty() ? int(corner) : faces_.vertices[corner];
  }
  Faults faults;

 private:
  V3d at(int vertex) const { return points_.point(key_, size_t(vertex)); }
  bool usable(int vertex) const { return vertex >= 0 && size_t(vertex) < points_.count; }
  void emitTriangle(uint32_t face, size_t a, size_t b, size_t c);
  void cutFace(uint32_t face, size_t firstCorner, std::span<const int> loops);
  bool fillFace(uint32_t face, size_t firstCorner, std::span<const int> loops);

  const PointKeys& points_;
  const size_t key_;
  const PolygonFaces& faces_;
  Mesh& mesh_;
  Triangulator triangulator_;
  std::vector<V3d> scratch_;
  std::vector<uint32_t> cut_;
  WindingFill fill_;
};

bool Cutter::cutTriangles() {
  if (points_.nonFinite) return false;
  const size_t n = faces_.cornerCount;
  if (faces_.vertices.empty()) {
    mesh_.indices.resize(n);
    std::iota(mesh_.indices.begin(), mesh_.indices.end(), 0u);
    return n <= points_.count;
  }
  mesh_.indices.assign(faces_.vertices.begin(), faces_.vertices.begin() + std::ptrdiff_t(n));
  uint32_t highest = 0;
  for (uint32_t i : mesh_.indices) highest = std::max(highest, i);  // negative ones are huge here
  if (highest < points_.count) return true;
  mesh_.indices.clear();
  return false;
}

enum class QuadCut : uint8_t { First, Second, None };

// The better diagonal of a quad: 0-2 or 1-3. The first wherever it gives two triangles that face alike. None: it is
// flat, and crosses itself.
QuadCut quadCut(const V3d& a, const V3d& b, const V3d& c, const V3d& d) {
  const V3d ac = c - a, abc = (b - a).cross(ac), acd = ac.cross(d - a);
  if (abc.dot(acd) > 0) return QuadCut::First;
  const V3d normal = ac.cross(d - b), bd = d - b, bcd = (c - b).cross(bd), abd = (b - a).cross(d - a);
  if (abc.dot(acd) < 0 && bcd.dot(abd) < 0) {
    const double height = std::abs(abc.dot(d - a)) / abc.length();
    if (height <= 1e-3 * std::max(ac.length(), bd.length())) return QuadCut::None;
  }
  return std::min(abc.dot(normal), acd.dot(normal)) >= std::min(bcd.dot(normal), abd.dot(normal)) ? QuadCut::First
                                                                                                  : QuadCut::Second;
}

bool Cutter::cutQuads() {
  if (points_.nonFinite) return false;
  const size_t n = faces_.cornerCount / 4;
  mesh_.indices.resize(n * 6);
  if (faces_.needCorners) corners.resize(n * 6);
  uint32_t* out = mesh_.indices.data();
  for (size_t f = 0; f < n; ++f, out += 6) {
    int v[4];
    for (int k = 0; k < 4; ++k) v[k] = vertexOf(4 * f + k);
    const bool isUsable = usable(v[0]) && usable(v[1]) && usable(v[2]) && usable(v[3]);
    const QuadCut cut = isUsable ? quadCut(at(v[0]), at(v[1]), at(v[2]), at(v[3])) : QuadCut::None;
    if (cut == QuadCut::None) {
      mesh_.indices.clear();
      corners.clear();
      return false;
    }
    // The triangles begin at the diagonal: with the other one the face's parameters are turned by one corner.
    const int s = cut == QuadCut::First ? 0 : 1;
    const int order[6] = {s, s + 1, s + 2, s, s + 2, (s + 3) % 4};
    for (int k = 0; k < 6; ++k) out[k] = uint32_t(v[order[k] % 4]);
    if (faces_.needCorners)
      for (int k = 0; k < 6; ++k) corners[6 * f + k] = uint32_t(4 * f + order[k] % 4);
  }
  mesh_.quads = mesh_.quadPairs = true;
  return true;
}

void Cutter::emitTriangle(uint32_t face, size_t a, size_t b, size_t c) {
  for (size_t k : {a, b, c}) mesh_.indices.push_back(uint32_t(vertexOf(k)));
  mesh_.faceOfTriangle.push_back(face);
  if (faces_.needCorners)
    for (size_t k : {a, b, c}) corners.push_back(uint32_t(k));
}

void Cutter::cutFace(uint32_t face, size_t first, std::span<const int> loops) {
  size_t n = 0;
  for (int l : loops) n += size_t(l);
  for (size_t k = first; k < first + n; ++k) {
    if (!usable(vertexOf(k))) {
      ++faults.index;
      return;
    }
    if (points_.nonFinite && !points_.finite(size_t(vertexOf(k)))) {
      ++faults.notFinite;
      return;
    }
  }
  if (loops.empty() || loops[0] < 3) {
    ++faults.corners;
    return;
  }
  if (loops.size() == 1 && n == 3) {
    emitTriangle(face, first, first + 1, first + 2);
    return;
  }
  scratch_.resize(n);
  for (size_t k = 0; k < n; ++k) scratch_[k] = at(vertexOf(first + k));
  if (loops.size() == 1 && n == 4) {
    const QuadCut cut = quadCut(scratch_[0], scratch_[1], scratch_[2], scratch_[3]);
    if (cut == QuadCut::None && fillFace(face, first, loops)) {
      ++faults.tangled;
      return;
    }
    const size_t s = cut == QuadCut::Second ? 1 : 0;
    emitTriangle(face, first + s, first + s + 1, first + s + 2);
    emitTriangle(face, first + s, first + s + 2, first + (s + 3) % 4);
    mesh_.quads = true;
    return;
  }
  cut_.clear();
  const Triangulator::Outcome outcome = triangulator_.run(scratch_, loops, cut_);
  if (outcome != Triangulator::Outcome::Good) {
    const bool isFilled = fillFace(face, first, loops);
    ++(isFilled || outcome == Triangulator::Outcome::Tangled ? faults.tangled : faults.noArea);
    if (isFilled || outcome == Triangulator::Outcome::NoArea) return;
  }
  for (size_t t = 0; t < cut_.size(); t += 3)
    emitTriangle(face, first + cut_[t], first + cut_[t + 1], first + cut_[t + 2]);
}

bool Cutter::fillFace(uint32_t face, size_t first, std::span<const int> loops) {
  if (!fillByWinding(scratch_, loops, fill_)) return false;
  std::vector<size_t> cornerOf;
  cornerOf.reserve(fill_.points.size());
  for (const EdgePoint& p : fill_.points) {
    if (p.from == p.to) {
      cornerOf.push_back(first + p.from);
      continue;
    }
    cornerOf.push_back(faces_.cornerCount + added.size());
    added.push_back({uint32_t(first + p.from), uint32_t(first + p.to), p.share});
  }
  for (size_t t = 0; t < fill_.triangles.size(); t += 3)
    emitTriangle(face, cornerOf[fill_.triangles[t]], cornerOf[fill_.triangles[t + 1]],
                 cornerOf[fill_.triangles[t + 2]]);
  return true;
}

void Cutter::cutAny() {
  mesh_.indices.reserve(faces_.cornerCount * 3);
  mesh_.faceOfTriangle.reserve(faces_.cornerCount);
  size_t loop = 0, corner = 0;
  for (size_t f = 0; f < faces_.faceCount; ++f) {
    const size_t loops = faces_.loopsPerFace.empty() ? 1 : size_t(faces_.loopsPerFace[f]);
    const std::span<const int> sizes = faces_.verticesPerLoop.subspan(loop, loops);
    cutFace(uint32_t(f), corner, sizes);
    for (int l : sizes) corner += size_t(l);
    loop += loops;
  }
  mesh_.indices.shrink_to_fit();
  bool identity = mesh_.faceOfTriangle.size() == faces_.faceCount;
  for (size_t t = 0; identity && t < mesh_.faceOfTriangle.size(); ++t) identity = mesh_.faceOfTriangle[t] == t;
  if (identity)
    std::vector<uint32_t>().swap(mesh_.faceOfTriangle);
  else
    mesh_.faceOfTriangle.shrink_to_fit();
}

void report(const scene::Primitive& primitive, const Faults& faults, Diagnostics& diagnostics) {
  auto tell = [&](const char* code, size_t n, const char* what, const char* done) {
    if (n)
      diagnostics.warning(code, primitive.pos,
                          std::to_string(n) + (n == 1 ? " face of " : " faces of ") + subject(primitive) + what,
                          done);
  };
  tell("GEOM-INDEX-RANGE", faults.index, ": a vertex number is not one of its points", "left out");
  tell("GEOM-FACE-CORNERS", faults.corners, ": fewer than 3 corners", "left out");
  tell("GEOM-NOT-FINITE", faults.notFinite, ": a corner is not finite", "left out");
  tell("GEOM-FACE-AREA", faults.noArea, ": no area", "left out");
  tell("GEOM-FACE-TANGLED", faults.tangled, ": the outline crosses itself or a hole lies outside",
       "what it goes round is covered");
}

// The first key by which faces can be cut: one that has grown out of a point or a line.
size_t keyWithArea(const PointKeys& points) {
  for (size_t k = 0; k + 1 < points.keys.size(); ++k) {
    const V3d a = points.point(k, 0);
    V3d direction(0);
    for (size_t i = 1; i < points.count; ++i) {
      const V3d d = points.point(k, i) - a;
      if (direction == V3d(0))
        direction = d;
      else if (direction.cross(d) != V3d(0))
        return k;
    }
  }
  return points.keys.size() - 1;
}

void storeKeys(const PointKeys& points, const Cutter& cutter, Mesh& mesh) {
  mesh.vertexCount = uint32_t(points.count + cutter.added.size());
  for (size_t k = 0; k < points.keys.size(); ++k) {
    const float* p = points.keys[k].data();
    if (!points.nonFinite) {
      float lo[3] = {p[0], p[1], p[2]}, hi[3] = {p[0], p[1], p[2]};
      for (size_t i = 0; i < points.count * 3; i += 3)
        for (int c = 0; c < 3; ++c) {
          lo[c] = std::min(lo[c], p[i + c]);
          hi[c] = std::max(hi[c], p[i + c]);
        }
      mesh.bounds.extendBy(V3d(lo[0], lo[1], lo[2]));
      mesh.bounds.extendBy(V3d(hi[0], hi[1], hi[2]));
    } else {
      for (size_t i = 0; i < points.count; ++i)
        if (points.finite(i)) mesh.bounds.extendBy(points.point(k, i));
    }
  }
  mesh.origin = chooseOrigin(mesh.bounds);
  mesh.points.resize(size_t(mesh.vertexCount) * points.keys.size());
  V3f* out = mesh.points.data();
  for (size_t k = 0; k < points.keys.size(); ++k) {
    const V3f* const own = out;
    for (size_t i = 0; i < points.count; ++i, ++out) {
      const V3f p(points.keys[k][3 * i], points.keys[k][3 * i + 1], points.keys[k][3 * i + 2]);
      // A point that is not finite is in no triangle; it only must not poison whoever takes bounds over all points.
      if (points.nonFinite && !points.finite(i))
        *out = V3f(mesh.bounds.center() - mesh.origin);
      else
        *out = mesh.origin == V3d(0) ? p : V3f(V3d(p) - mesh.origin);
    }
    for (const Cutter::Between& b : cutter.added) {
      const V3f &p = own[cutter.vertexOf(b.from)], &q = own[cutter.vertexOf(b.to)];
      *out++ = V3f(b.mix(p.x, q.x), b.mix(p.y, q.y), b.mix(p.z, q.z));
    }
  }
  mesh.times = points.times;
}

}  // namespace

PolygonFaces readFaces(const scene::Primitive& primitive, const std::vector<int>& loopsPerFace,
                       const std::vector<int>& verticesPerLoop, const std::vector<int>& vertices, size_t pointCount,
                       Diagnostics& diagnostics) {
  PolygonFaces out;
  const size_t available = vertices.empty() ? pointCount : vertices.size();
  if (verticesPerLoop.empty() && loopsPerFace.empty() && vertices.empty()) {
    out.ownSizes.push_back(int(std::min<size_t>(pointCount, INT_MAX)));  // Polygon: all points are its one loop
    out.verticesPerLoop = out.ownSizes;
  } else {
    out.verticesPerLoop = verticesPerLoop;
  }
  out.vertices = vertices;
  out.loopsPerFace = loopsPerFace;
  const std::span<const int> sizes = out.verticesPerLoop;
  const size_t faces = loopsPerFace.empty() ? sizes.size() : loopsPerFace.size();
  std::string wrong;
  size_t loop = 0;
  int low = INT_MAX, high = 0;
  for (size_t f = 0; f < faces && wrong.empty(); ++f) {
    const int loops = loopsPerFace.empty() ? 1 : loopsPerFace[f];
    if (loops < 0 || size_t(loops) > sizes.size() - loop) {
      wrong = "face " + std::to_string(f) + " asks for " + std::to_string(loops) + " loops where " +
              std::to_string(sizes.size() - loop) + " are left";
      break;
    }
    size_t corners = 0;
    for (int l = 0; l < loops; ++l) {
      const int size = sizes[loop + l];
      if (size < 0 || size_t(size) > available - out.cornerCount - corners) {
        wrong = "face " + std::to_string(f) + " asks for " + std::to_string(size) + " vertices where " +
                std::to_string(available - out.cornerCount - corners) + " are left";
        break;
      }
      corners += size_t(size);
    }
    if (!wrong.empty()) break;
    low = std::min(low, loops == 1 ? int(corners) : 0);
    high = std::max(high, loops == 1 ? int(corners) : INT_MAX);
    loop += size_t(loops);
    out.cornerCount += corners;
    ++out.faceCount;
  }
  out.arity = low == high ? low : 0;
  if (!wrong.empty())
    diagnostics.warning("GEOM-FACE-LIST", primitive.pos, subject(primitive) + ": " + wrong,
                        "its first " + std::to_string(out.faceCount) + " faces are kept");
  return out;
}

bool makePolygons(const scene::Primitive& primitive, const scene::PolygonMesh& shape, Diagnostics& diagnostics,
                  Mesh& mesh) {
  const std::optional<PointKeys> points = readPoints(primitive, diagnostics);
  if (!points) return false;
  PolygonFaces faces =
      readFaces(primitive, shape.loopsPerFace, shape.verticesPerLoop, shape.vertices, points->count, diagnostics);
  return makePolygons(primitive, *points, faces, diagnostics, mesh);
}

// Of faces with four corners, which go around at (u, v) = (0,0), (1,0), (1,1), (0,1): "st" by the attribute
// TextureCoordinates.
static void addTextureCoordinates(const std::array<float, 8>& c, size_t cornerCount, const Cutter& cutter,
                                  Mesh& mesh) {
  if (mesh.find("st") || mesh.find("s") || mesh.find("t")) return;
  constexpr size_t kAt[] = {0, 2, 6, 4};
  Primvar st;
  st.name = "st";
  st.width = 2;
  st.rate = Primvar::Rate::PerCorner;
  st.data.reserve(2 * cutter.corners.size());
  for (const uint32_t corner : cutter.corners)
    for (size_t i = 0; i < 2; ++i) {
      if (corner < cornerCount) {
        st.data.push_back(c[kAt[corner % 4] + i]);
        continue;
      }
      const Cutter::Between& b = cutter.added[corner - cornerCount];
      st.data.push_back(b.mix(c[kAt[b.from % 4] + i], c[kAt[b.to % 4] + i]));
    }
  mesh.primvars.push_back(std::move(st));
}

bool makePolygons(const scene::Primitive& primitive, const PointKeys& points, PolygonFaces& faces,
                  Diagnostics& diagnostics, Mesh& mesh) {
  if (points.count >= UINT32_MAX || faces.cornerCount >= UINT32_MAX / 3) {
    diagnostics.error("GEOM-TOO-LARGE", primitive.pos, subject(primitive) + " has more than 1.4 billion face corners",
                      "the primitive is left out", "cut it into several");
    return false;
  }
  size_t named = 0;  // highest vertex number + 1: the count that the RIB asks of vertex primvars
  if (!faces.vertices.empty())
    for (size_t i = 0; i < faces.cornerCount; ++i)
      named = std::max(named, size_t(std::max(-1, faces.vertices[i]) + 1));
  else
    named = faces.cornerCount;
  named = std::min(named, points.count);
  ClassCounts counts{faces.faceCount, points.count, points.count, faces.cornerCount};
  const size_t uniformFaces = faces.uniformCount ? faces.uniformCount : faces.faceCount;
  counts.uniform = uniformFaces;
  if (faces.faceVaryingCount) counts.faceVarying = faces.faceVaryingCount;
  for (const scene::Parameter& p : primitive.primvars) {
    // A list may carry more points than faces name; primvars may then have either count.
    const size_t n = p.elementFloats() ? p.size() / p.elementFloats() : 0;
    if ((p.storage == scene::StorageClass::Vertex || p.storage == scene::StorageClass::Varying) && p.name != "P" &&
        n == named && named < points.count)
      counts.vertex = counts.varying = named;
  }
  const std::vector<SourcePrimvar> sources = readPrimvars(primitive, counts, diagnostics);
  bool perFace = false;
  for (const SourcePrimvar& s : sources) {
    faces.needCorners |=
        s.storage == scene::StorageClass::FaceVarying || s.storage == scene::StorageClass::FaceVertex;
    perFace |= s.storage == scene::StorageClass::Uniform;
  }

  const bool spreads = faces.arity == 4 && primitive.attributes &&
                       std::holds_alternative<scene::PolygonMesh>(primitive.shape) &&
                       primitive.attributes->textureCoordinates != scene::Attributes().textureCoordinates;
  faces.needCorners |= spreads;

  Cutter cutter(points, keyWithArea(points), faces, mesh);
  const bool straight = faces.arity == 3 && cutter.cutTriangles();
  if (!straight && !(faces.arity == 4 && cutter.cutQuads())) cutter.cutAny();
  report(primitive, cutter.faults, diagnostics);
  if (mesh.indices.empty()) {
    diagnostics.warning("GEOM-ZERO-AREA", primitive.pos, subject(primitive) + " has no face that could be used",
                        "the primitive is left out");
    return false;
  }
  storeKeys(points, cutter, mesh);
  bool hasArea = false;  // in doubles: floats may underflow
  for (size_t k = 0; k < size_t(mesh.keyCount()) && !hasArea; ++k)
    for (uint32_t t = 0; t < mesh.triangleCount() && !hasArea; ++t) hasArea = geometricNormal(mesh, t, k) != V3d(0);
  if (!hasArea) {
    diagnostics.warning("GEOM-ZERO-AREA", primitive.pos, subject(primitive) + " has no area",
                        "the primitive is left out");
    return false;
  }
  if (mesh.quadPairs && perFace) {
    mesh.faceOfTriangle.resize(mesh.triangleCount());
    for (uint32_t t = 0; t < mesh.triangleCount(); ++t) mesh.faceOfTriangle[t] = t / 2;
  }
  if (!faces.originalFace.empty()) {
    std::vector<uint32_t> original(mesh.triangleCount());
    for (uint32_t t = 0; t < mesh.triangleCount(); ++t) original[t] = faces.originalFace[mesh.faceOf(t)];
    mesh.faceOfTriangle = std::move(original);
  }

  for (const SourcePrimvar& s : sources) {
    using scene::StorageClass;
    const bool isNormal = s.parameter->name == "N";
    switch (s.storage) {
      case StorageClass::Constant: {
        Primvar p = emptyPrimvar(s, Primvar::Rate::Constant);
        p.data = s.values;
        mesh.primvars.push_back(std::move(p));
        break;
      }
      case StorageClass::Uniform: {
        Primvar p = emptyPrimvar(s, uniformFaces == 1 ? Primvar::Rate::Constant : Primvar::Rate::PerFace);
        p.data = s.values;
        mesh.primvars.push_back(std::move(p));
        break;
      }
      case StorageClass::Varying:
      case StorageClass::Vertex: {
        Primvar p = emptyPrimvar(s, Primvar::Rate::PerVertex);
        const size_t keys = isNormal ? size_t(mesh.keyCount()) : 1, width = size_t(p.width);
        p.data.resize(keys * mesh.vertexCount * width);
        for (size_t k = 0; k < keys; ++k) {
          std::span<const float> v = valuesAtKey(primitive, s, k);
          if (v.empty()) v = s.values;
          float* const own = p.data.data() + k * mesh.vertexCount * width;
          std::copy(v.begin(), v.begin() + std::ptrdiff_t(std::min(v.size(), points.count * width)), own);
          float* out = own + points.count * width;
          for (const Cutter::Between& b : cutter.added) {
            const float *from = own + size_t(cutter.vertexOf(b.from)) * width,
                        *to = own + size_t(cutter.vertexOf(b.to)) * width;
            for (size_t i = 0; i < width; ++i) *out++ = b.mix(from[i], to[i]);
          }
        }
        mesh.primvars.push_back(std::move(p));
        break;
      }
      case StorageClass::FaceVarying:
      case StorageClass::FaceVertex: {
        Primvar p = emptyPrimvar(s, Primvar::Rate::PerCorner);
        if (straight) {
          p.data = s.values;
        } else {
          p.data.reserve(cutter.corners.size() * p.width);
          const auto valuesOf = [&](uint32_t c) {
            return s.values.data() + (faces.originalCorner.empty() ? c : faces.originalCorner[c]) * size_t(p.width);
          };
          for (const uint32_t c : cutter.corners) {
            if (c < faces.cornerCount) {
              p.data.insert(p.data.end(), valuesOf(c), valuesOf(c) + p.width);
              continue;
            }
            const Cutter::Between& b = cutter.added[c - faces.cornerCount];
            for (int i = 0; i < p.width; ++i) p.data.push_back(b.mix(valuesOf(b.from)[i], valuesOf(b.to)[i]));
          }
        }
        mesh.primvars.push_back(std::move(p));
        break;
      }
    }
  }
  repairNormals(primitive, mesh, diagnostics);
  if (!mesh.find("N") && primitive.attributes && primitive.attributes->getInt("polygon:smoothnormals", 0) != 0)
    addSmoothNormals(mesh);
  joinTextureCoordinates(mesh);
  if (spreads) addTextureCoordinates(primitive.attributes->textureCoordinates, faces.cornerCount, cutter, mesh);
  return true;
}

}  // namespace kinora::geometry
