// Proves limit surfaces against limit masks and against an independent uniform refinement, that meshes close without
// cracks whatever their faces and rates, and what tags and broken cages do. Semi-sharp creases are only bracketed.
#include <chrono>
#include <random>

#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;
using scene::SubdivisionMesh;

struct CageData {
  std::vector<int> sizes, vertices;
  std::vector<V3d> points;
};

CageData cube() {
  CageData c;
  c.sizes.assign(6, 4);
  c.vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  for (int i = 0; i < 8; ++i) c.points.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  return c;
}
CageData octahedron() {
  CageData c;
  c.sizes.assign(8, 3);
  c.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  c.vertices = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  return c;
}
// A prism over an n-gon: caps of n corners, quads around.
CageData prism(int n) {
  CageData c;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < n; ++i)
      c.points.emplace_back(float(std::cos(6.2831853 * i / n)), float(std::sin(6.2831853 * i / n)), j ? 1.0 : -1.0);
  c.sizes = {n, n};
  for (int i = 0; i < n; ++i) c.vertices.push_back(n - 1 - i);
  for (int i = 0; i < n; ++i) c.vertices.push_back(n + i);
  for (int i = 0; i < n; ++i) {
    c.sizes.push_back(4);
    for (int v : {i, (i + 1) % n, n + (i + 1) % n, n + i}) c.vertices.push_back(v);
  }
  return c;
}
// (n x n) quads over the unit square, or random heights.
CageData sheet(int n, double bumps = 0) {
  CageData c;
  std::mt19937 random(5);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) c.points.emplace_back(float(i) / n, float(j) / n, bumps * (random() / 4294967295.0));
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      for (int v : {a, a + 1, a + n + 2, a + n + 1}) c.vertices.push_back(v);
      c.sizes.push_back(4);
    }
  return c;
}

scene::Primitive subdivision(const CageData& c, const char* scheme = "catmull-clark",
                             std::vector<SubdivisionMesh::Tag> tags = {}) {
  SubdivisionMesh s;
  s.scheme = scheme;
  s.verticesPerFace = c.sizes;
  s.vertices = c.vertices;
  s.tags = std::move(tags);
  scene::Primitive p = primitive(std::move(s));
  std::vector<float> f;
  for (const V3d& v : c.points) f.insert(f.end(), {float(v.x), float(v.y), float(v.z)});
  p.primvars.set(points(std::move(f)));
  return p;
}
SubdivisionMesh::Tag tag(const char* name, std::vector<int> ints = {}, std::vector<float> floats = {},
                         std::vector<std::string> strings = {}) {
  return {name, std::move(ints), std::move(floats), std::move(strings)};
}
double nearest(const Mesh& m, const V3d& p) {
  double best = 1e9;
  for (uint32_t i = 0; i < m.vertexCount; ++i) best = std::min(best, (vertex(m, i) - p).length());
  return best;
}
void expectUnitNormals(const Mesh& m) {
  const Primvar* n = m.find("N");
  ASSERT_NE(n, nullptr);
  for (size_t i = 0; i < n->data.size(); i += 3)
    ASSERT_NEAR(V3d(n->data[i], n->data[i + 1], n->data[i + 2]).length(), 1, 1e-5);
}

// One step of Catmull-Clark on a closed mesh, straight from the rules (E. Catmull, J. Clark 1978).
CageData refine(const CageData& in) {
  CageData out;
  out.points = in.points;
  const size_t n = in.points.size();
  std::vector<V3d> facePoints;
  std::map<std::pair<int, int>, std::pair<V3d, int>> edgeSum;  // sum of face points, then id
  std::vector<V3d> faceSum(n, V3d(0)), midSum(n, V3d(0));
  std::vector<int> valence(n, 0);
  size_t at = 0;
  for (int size : in.sizes) {
    V3d f(0);
    for (int k = 0; k < size; ++k) f += in.points[in.vertices[at + k]];
    f /= size;
    facePoints.push_back(f);
    for (int k = 0; k < size; ++k) {
      const int a = in.vertices[at + k], b = in.vertices[at + (k + 1) % size];
      edgeSum.try_emplace(std::minmax(a, b), V3d(0), 0).first->second.first += f;
      faceSum[a] += f;
      ++valence[a];
    }
    at += size;
  }
  for (auto& [e, value] : edgeSum) {
    const V3d a = in.points[e.first], b = in.points[e.second];
    midSum[e.first] += (a + b) / 2.0;
    midSum[e.second] += (a + b) / 2.0;
    value.second = int(out.points.size());
    out.points.push_back((a + b + value.first) / 4.0);
  }
  for (size_t v = 0; v < n; ++v) {
    const double k = valence[v];
    out.points[v] = (faceSum[v] / k + midSum[v] / k * 2.0 + in.points[v] * (k - 3)) / k;
  }
  at = 0;
  for (size_t f = 0; f < in.sizes.size(); ++f) {
    const int size = in.sizes[f], centre = int(out.points.size());
    out.points.push_back(facePoints[f]);
    for (int k = 0; k < size; ++k) {
      const int a = in.vertices[at + k], b = in.vertices[at + (k + 1) % size],
                p = in.vertices[at + (k + size - 1) % size];
      for (int v : {a, edgeSum[std::minmax(a, b)].second, centre, edgeSum[std::minmax(a, p)].second})
        out.vertices.push_back(v);
      out.sizes.push_back(4);
    }
    at += size;
  }
  return out;
}
double cageVolume(const CageData& c) {
  double sum = 0;
  size_t at = 0;
  for (int size : c.sizes) {
    for (int k = 1; k + 1 < size; ++k)
      sum += c.points[c.vertices[at]].dot(c.points[c.vertices[at + k]].cross(c.points[c.vertices[at + k + 1]])) / 6;
    at += size;
  }
  return sum;
}

TEST(Subdivision, CatmullClarkVolumesMatchIndependentRefinement) {
  for (const CageData& cage : {cube(), prism(5), prism(3), octahedron()}) {
    CageData c = cage;
    double previous = 0, now = 0;
    for (int level = 0; level < 6; ++level) {
      c = refine(c);
      previous = now;
      now = cageVolume(c);
    }
    const double exact = now + (now - previous) / 3;  // both converge with the square of the edge
    const Mesh m = made(subdivision(cage), edge(0.002));
    EXPECT_NEAR(volume(m) / exact, 1, 2e-3) << cage.sizes.size();
    EXPECT_LT(volume(m), exact);
    expectUnitNormals(m);
  }
}

TEST(Subdivision, LimitMasks) {
  // Cube corner, valence 3: (9 v + 4 sum of edge neighbours + sum of face neighbours) / 24.
  const Mesh c = made(subdivision(cube()));
  EXPECT_LT(nearest(c, (V3d(1, 1, 1) * 9.0 + V3d(1, 1, 1) * 4.0 + V3d(-1, -1, -1)) / 24.0), 1e-6);
  // Loop, valence 4 (C. Loop 1987): beta = (5/8 - (3/8)^2) / 4, limit = (w v + sum of neighbours) / (w + 4), w = 3 /
  // (8 beta).
  const double beta = (5 / 8.0 - 9 / 64.0) / 4, w = 3 / (8 * beta);
  const Mesh o = made(subdivision(octahedron(), "loop"));
  EXPECT_LT(nearest(o, V3d(w / (w + 4), 0, 0)), 1e-6);
  EXPECT_GT(volume(o), 0);
  // Bilinear leaves a cube a cube, and needs two triangles a face.
  const Mesh b = made(subdivision(cube(), "bilinear"));
  EXPECT_NEAR(volume(b), 8, 1e-6);
  EXPECT_EQ(b.triangleCount(), 12u);
  EXPECT_TRUE(b.quadPairs && b.faceOfTriangle.empty() && b.cornerUV.empty());
  for (uint32_t t = 0; t < 12; ++t) EXPECT_EQ(b.faceOf(t), t / 2);
}

TEST(Subdivision, ClosesWithoutCracks) {
  DiceRate uneven;  // every edge has another rate
  uneven.edgeLength = [](const V3d& p) { return 0.02 + 0.05 * std::abs(std::sin(7 * p.x + 3 * p.y + 5 * p.z)); };
  const CageData cages[] = {cube(), octahedron(), prism(3), prism(5), prism(8)};
  for (const CageData& c : cages)
    for (const char* scheme : {"catmull-clark", "bilinear", "loop"}) {
      if (std::string(scheme) == "loop" && c.sizes[0] != 3) continue;
      if (std::string(scheme) == "loop" && c.sizes[2] != 3) continue;
      for (const DiceRate& rate : {DiceRate{}, uneven, edge(0.05), edge(10)}) {
        const Mesh m = made(subdivision(c, scheme), rate);
        const EdgeCount e = edges(m);
        EXPECT_EQ(e.open, 0u) << scheme << ' ' << c.sizes[0];
        EXPECT_EQ(e.wrong, 0u) << scheme << ' ' << c.sizes[0];
        EXPECT_GT(volume(m), 0);
        expectUnitNormals(m);
        for (const Imath::V2f& uv : m.cornerUV) {
          ASSERT_GE(std::min(uv.x, uv.y), 0);
          ASSERT_LE(std::max(uv.x, uv.y), 1);
        }
      }
    }
}

TEST(Subdivision, SharpCreases) {
  // Every edge of the cube infinitely sharp: the cube itself, flat faces with their own normals, still closed.
  std::vector<SubdivisionMesh::Tag> tags;
  for (const auto& e : std::vector<std::array<int, 2>>{
           {0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}})
    tags.push_back(tag("crease", {e[0], e[1]}, {10}));
  const Mesh sharp = made(subdivision(cube(), "catmull-clark", tags), edge(0.1));
  EXPECT_NEAR(volume(sharp), 8, 1e-5);
  EXPECT_EQ(edges(sharp).open + edges(sharp).wrong, 0u);
  const Primvar* n = sharp.find("N");
  for (uint32_t t = 0; t < sharp.triangleCount(); ++t) {
    const auto c = corners(sharp, t);
    const V3d face = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
    for (int k = 0; k < 3; ++k) {
      const float* v = &n->data[size_t(sharp.indices[3 * t + k]) * 3];
      ASSERT_GT(V3d(v[0], v[1], v[2]).dot(face), 0.9999);
    }
  }
  // Semi-sharp lies between round and sharp; as one chain it says the same as edge by edge.
  const double round = volume(made(subdivision(cube()), edge(0.02)));
  const Mesh chain =
      made(subdivision(cube(), "catmull-clark", {tag("crease", {0, 1, 3, 2, 0}, {2, 2, 2, 2})}), edge(0.02));
  const Mesh single = made(subdivision(cube(), "catmull-clark",
                                       {tag("crease", {0, 1}, {2}), tag("crease", {1, 3}, {2}),
                                        tag("crease", {3, 2}, {2}), tag("crease", {2, 0}, {2})}),
                           edge(0.02));
  EXPECT_GT(volume(chain), round + 0.1);
  EXPECT_LT(volume(chain), 8 - 0.1);
  EXPECT_EQ(volume(chain), volume(single));
  EXPECT_EQ(edges(chain).open, 0u);
  // A sharp corner is a point of the surface.
  EXPECT_LT(nearest(made(subdivision(cube(), "catmull-clark", {tag("corner", {7}, {10})})), V3d(1, 1, 1)), 1e-5);
}

TEST(Subdivision, BoundaryModesAndHoles) {
  const CageData c = sheet(3);
  const Mesh none = made(subdivision(c));  // no tag: faces at the boundary have no limit surface
  EXPECT_NEAR(area(none), 1 / 9.0, 1e-6);
  for (uint32_t t = 0; t < none.triangleCount(); ++t) EXPECT_EQ(none.faceOf(t), 4u);
  const Mesh sharp = made(subdivision(c, "catmull-clark", {tag("interpolateboundary", {1})}));
  EXPECT_LT(nearest(sharp, V3d(0, 0, 0)), 1e-6);
  EXPECT_NEAR(area(sharp), 1, 1e-6);
  EXPECT_NEAR(area(made(subdivision(c, "catmull-clark", {tag("interpolateboundary")}))), 1, 1e-6);
  const Mesh rounded = made(subdivision(c, "catmull-clark", {tag("interpolateboundary", {2})}));
  EXPECT_GT(nearest(rounded, V3d(0, 0, 0)), 0.01);
  EXPECT_LT(area(rounded), 0.995);
  EXPECT_GT(area(rounded), 0.95);
  const Mesh hole = made(subdivision(c, "catmull-clark", {tag("interpolateboundary", {1}), tag("hole", {4})}));
  EXPECT_NEAR(area(hole), 8 / 9.0, 1e-6);
  for (uint32_t t = 0; t < hole.triangleCount(); ++t) EXPECT_NE(hole.faceOf(t), 4u);
  // Everything vanishes: said, not silent.
  Quiet d;
  EXPECT_FALSE(tessellate(subdivision(sheet(1)), {}, d).has_value());
  EXPECT_EQ(d.count("GEOM-ZERO-AREA"), 1u);
}

// Facevertex data without seams is vertex data, whatever the rule for the boundaries of facevarying data.
TEST(Subdivision, FaceVertexDataIsSubdividedAsVertexData) {
  const CageData c = sheet(4, 0.3);
  for (const int mode : {0, 1, 2, 3}) {
    scene::Primitive p = subdivision(
        c, "catmull-clark", {tag("interpolateboundary", {2}), tag("facevaryinginterpolateboundary", {mode})});
    std::vector<float> vertex, corner, cut;
    for (const V3d& v : c.points) vertex.push_back(float(v.x * v.y + v.z));
    for (int v : c.vertices) corner.push_back(vertex[size_t(v)]);
    cut = corner;
    cut[0] += 1;
    cut[2] += 1;
    p.primvars.set(parameter("vertex", StorageClass::Vertex, ValueType::Float, vertex));
    p.primvars.set(parameter("corner", StorageClass::FaceVertex, ValueType::Float, corner));
    p.primvars.set(parameter("cut", StorageClass::FaceVertex, ValueType::Float, cut));
    const Mesh m = made(p, edge(0.1));
    ASSERT_TRUE(m.find("vertex") && m.find("corner") && m.find("cut"));
    EXPECT_EQ(m.find("vertex")->data, m.find("corner")->data) << mode;
    EXPECT_NE(m.find("vertex")->data, m.find("cut")->data) << mode;
  }
}

TEST(Subdivision, PrimvarsOfEveryClass) {
  // Vertex data that equals P must come out as P; varying data is bilinear; facevarying follows its boundary rule.
  const CageData c = sheet(4, 0.3);
  auto make = [&](int faceVaryingMode) {
    scene::Primitive p =
        subdivision(c, "catmull-clark",
                    {tag("interpolateboundary", {1}), tag("facevaryinginterpolateboundary", {faceVaryingMode})});
    std::vector<float> xyz, st, face;
    for (const V3d& v : c.points) xyz.insert(xyz.end(), {float(v.x), float(v.y), float(v.z)});
    for (int v : c.vertices) st.insert(st.end(), {float(c.points[v].x), float(c.points[v].y)});
    for (size_t i = 0; i < c.sizes.size(); ++i) face.push_back(float(i));
    p.primvars.set(parameter("copy", StorageClass::Vertex, ValueType::Point, xyz));
    p.primvars.set(parameter("linear", StorageClass::Varying, ValueType::Point, xyz));
    p.primvars.set(parameter("st", StorageClass::FaceVarying, ValueType::Float, st, 2));
    p.primvars.set(parameter("part", StorageClass::Uniform, ValueType::Float, face));
    p.primvars.set(parameter("all", StorageClass::Constant, ValueType::Float, {9}));
    return made(p, edge(0.02));
  };
  const Mesh m = make(0);
  const Primvar *copy = m.find("copy"), *linear = m.find("linear"), *st = m.find("st");
  ASSERT_TRUE(copy && linear && st);
  EXPECT_EQ(st->rate, Primvar::Rate::PerVertex);
  EXPECT_EQ(m.find("part")->rate, Primvar::Rate::PerFace);
  EXPECT_EQ(m.find("all")->data[0], 9);
  bool bent = false;
  for (uint32_t t = 0; t < m.triangleCount(); ++t)
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = m.indices[3 * t + k];
      const V3d p = vertex(m, v);
      for (int i = 0; i < 3; ++i) ASSERT_NEAR(copy->data[3 * v + i], p[i], 1e-5);
      // Over face f the bilinear x and y are known from (u, v).
      const Imath::V2f uv = m.cornerUV[3 * t + k];
      const double x = (m.faceOf(t) % 4 + uv.x) / 4, y = (m.faceOf(t) / 4 + uv.y) / 4;
      ASSERT_NEAR(linear->data[3 * v], x, 1e-5);
      ASSERT_NEAR(linear->data[3 * v + 1], y, 1e-5);
      ASSERT_NEAR(st->data[2 * v], x, 1e-5);
      bent |= std::abs(linear->data[3 * v + 2] - p.z) > 0.02;
    }
  EXPECT_TRUE(bent);  // the limit surface leaves the cage, the varying data does not
  // Smooth rule, no seams: s and t follow the surface's own x and y.
  const Mesh smooth = make(1);
  for (uint32_t v = 0; v < smooth.vertexCount; ++v) {
    ASSERT_NEAR(smooth.find("st")->data[2 * v], vertex(smooth, v).x, 1e-5);
    ASSERT_NEAR(smooth.find("st")->data[2 * v + 1], vertex(smooth, v).y, 1e-5);
  }
}

TEST(Subdivision, SeamsSplitVerticesButNotPositions) {
  scene::Primitive p = subdivision(cube());
  std::vector<float> st;
  for (int f = 0; f < 6; ++f) st.insert(st.end(), {float(f), 0, f + 1.f, 0, f + 1.f, 1, float(f), 1});
  p.primvars.set(parameter("st", StorageClass::FaceVarying, ValueType::Float, st, 2));
  const Mesh m = made(p);
  EXPECT_EQ(edges(m).open + edges(m).wrong, 0u);
  const Primvar* v = m.find("st");
  for (uint32_t t = 0; t < m.triangleCount(); ++t)
    for (int k = 0; k < 3; ++k) {
      const uint32_t i = m.indices[3 * t + k];
      ASSERT_NEAR(v->data[2 * i], m.faceOf(t) + m.cornerUV[3 * t + k].x, 1e-4);
    }
  const Mesh plain = made(subdivision(cube()));
  EXPECT_GT(m.vertexCount, plain.vertexCount);
  EXPECT_EQ(m.triangleCount(), plain.triangleCount());
}

TEST(Subdivision, DeformationKeysShareTheirPoints) {
  scene::Primitive p = subdivision(cube());
  p.times = {0, 1};
  p.motion.resize(1);
  std::vector<float> moved;
  for (const V3d& v : cube().points) moved.insert(moved.end(), {float(v.x) * 2, float(v.y) + 3, float(v.z)});
  p.motion[0].set(points(moved));
  const Mesh m = made(p);
  ASSERT_EQ(m.keyCount(), 2);
  for (uint32_t i = 0; i < m.vertexCount; ++i) {
    const V3d a = vertex(m, i, 0), b = vertex(m, i, 1);
    ASSERT_LT((b - V3d(2 * a.x, a.y + 3, a.z)).length(), 2e-6);
  }
  EXPECT_EQ(m.find("N")->data.size(), size_t(m.vertexCount) * 6);
}

// Vertices come apart where normals differ at any time: what is flat at first may be folded later.
TEST(Subdivision, CreasesThatAreFlatAtFirstStaySharp) {
  CageData flat, folded;
  flat.points = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {-1, 1, 0}, {0, 1, 0}, {1, 1, 0}};
  flat.sizes = {4, 4};
  flat.vertices = {0, 1, 4, 3, 1, 2, 5, 4};
  folded = flat;
  for (const size_t i : {0u, 2u, 3u, 5u}) folded.points[i].z = 0.6;
  const std::vector<SubdivisionMesh::Tag> tags{tag("interpolateboundary", {1}), tag("crease", {1, 4}, {10})};
  scene::Primitive p = subdivision(flat, "catmull-clark", tags);
  p.times = {0, 1};
  p.motion.resize(1);
  p.motion[0].set(*subdivision(folded).primvars.find("P"));
  const Mesh m = made(p, edge(0.3)), still = made(subdivision(folded, "catmull-clark", tags), edge(0.3));
  ASSERT_EQ(m.keyCount(), 2);
  const std::vector<float>&n = m.find("N")->data, &of = still.find("N")->data;
  const auto normal = [](const std::vector<float>& all, size_t v) {
    return V3d(all[3 * v], all[3 * v + 1], all[3 * v + 2]);
  };
  size_t onCrease = 0;
  for (uint32_t v = 0; v < m.vertexCount; ++v) {
    const V3d here = vertex(m, v, 1);
    if (std::abs(here.x) > 1e-6) continue;
    ++onCrease;
    double best = -1;
    for (uint32_t w = 0; w < still.vertexCount; ++w)
      if ((vertex(still, w) - here).length() < 1e-5)
        best = std::max(best, normal(of, w).dot(normal(n, m.vertexCount + v)));
    EXPECT_GT(best, 0.9999);
    EXPECT_GT(std::abs(normal(n, m.vertexCount + v).x), 0.1);
  }
  EXPECT_GE(onCrease, 4u);
  std::array<int, 2> sides{};
  for (uint32_t v = 0; v < m.vertexCount; ++v)
    if (std::abs(vertex(m, v, 1).x) < 1e-6) ++sides[size_t(normal(n, m.vertexCount + v).x > 0)];
  EXPECT_EQ(sides[0], sides[1]);
}

TEST(Subdivision, OrientationTurnsNormalsAndSides) {
  scene::Primitive p = subdivision(cube());
  const Mesh out = made(p);
  edit(p, [](scene::Attributes& a) { a.reverseOrientation = true; });
  const Mesh in = made(p);
  EXPECT_FALSE(out.flipNormals);
  EXPECT_TRUE(in.flipNormals);
  EXPECT_EQ(out.indices, in.indices);
  for (uint32_t i = 0; i < out.vertexCount; ++i) {
    const float *a = &out.find("N")->data[3 * i], *b = &in.find("N")->data[3 * i];
    ASSERT_GT(V3d(a[0], a[1], a[2]).dot(vertex(out, i)), 0);
    ASSERT_EQ(a[0], -b[0]);
  }
}

TEST(Subdivision, RatesFollowTheSizeOnScreenAndTheCap) {
  const scene::Primitive p = subdivision(cube());
  EXPECT_LE(made(p, edge(2)).triangleCount(), 24u);  // about a pixel a face
  EXPECT_GT(made(p, edge(0.01)).triangleCount(), 1000u);
  DiceRate capped = edge(1e-7);
  capped.maxTriangles = 20000;
  const uint32_t n = made(p, capped).triangleCount();
  EXPECT_LE(n, 20000u);
  EXPECT_GT(n, 8000u);
  // A dense flat cage stays as it is: two triangles a face.
  EXPECT_EQ(
      made(subdivision(sheet(20), "catmull-clark", {tag("interpolateboundary", {1})}), edge(1e-3)).triangleCount(),
      800u);
}

TEST(Subdivision, NonManifoldCagesStillSubdivide) {
  // Three sheets that share an edge.
  CageData c;
  c.points = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 0, 1}, {-1, 1, 0}, {-1, 1, 1}, {-1, -1, 0}, {-1, -1, 1}};
  c.sizes = {4, 4, 4};
  c.vertices = {0, 2, 3, 1, 0, 4, 5, 1, 0, 6, 7, 1};
  const Mesh m = made(subdivision(c, "catmull-clark", {tag("interpolateboundary", {1})}));
  EXPECT_NEAR(area(m), 1 + 2 * std::sqrt(2.0), 1e-3);
}

TEST(Subdivision, BrokenCagesBecomePolygons) {
  auto with = [](auto change) {
    scene::Primitive p = subdivision(cube());
    change(p, std::get<SubdivisionMesh>(p.shape));
    return p;
  };
  using P = scene::Primitive&;
  using S = SubdivisionMesh&;
  const struct {
    scene::Primitive p;
    uint32_t triangles;
  } table[] = {
      {with([](P, S s) { s.vertices[5] = 99; }), 10},
      {with([](P, S s) { s.vertices[5] = -7; }), 10},
      {with([](P, S s) { s.verticesPerFace[5] = 5; }), 10},
      {with([](P, S s) { s.verticesPerFace[5] = 2000000000; }), 10},
      {with([](P, S s) { s.verticesPerFace[5] = -4; }), 10},
      {with([](P, S s) { s.vertices.resize(11); }), 4},
      {with([](P, S s) { s.scheme = "nonsense"; }), 12},
      {with([](P, S s) { s.scheme = "loop"; }), 12},
      {with([](P p, S) { p.primvars.find("P")->floats[4] = std::nanf(""); }), 6},
      {with([](P, S s) {
         s.scheme = "loop";
         s.tags.push_back(tag("hole", {1, 3, 77}));
       }),
       8},
      {with([](P, S s) { s.vertices[1] = s.vertices[0]; }), 12},
  };
  for (const auto& row : table) {
    SCOPED_TRACE("row " + std::to_string(&row - table));
    Quiet d;
    const auto m = tessellate(row.p, {}, d);
    ASSERT_TRUE(m.has_value());
    EXPECT_EQ(d.count("GEOM-SUBDIVISION-CAGE"), 1u);
    EXPECT_EQ(m->triangleCount(), row.triangles);
    EXPECT_NE(m->find("N"), nullptr);
  }
  const scene::Primitive empty = with([](P, S s) { s.verticesPerFace.clear(), s.vertices.clear(); });
  Quiet d;
  EXPECT_FALSE(tessellate(empty, {}, d).has_value());
  EXPECT_EQ(d.count("GEOM-ZERO-AREA"), 1u);
}

// Values by face corner stay with their corners where holes go; reading them all begins where the holes are.
TEST(Subdivision, CagesWithHolesKeepTheirFaceVaryingValues) {
  CageData c = sheet(2);
  c.points[8].x = NAN;  // a corner of the last face
  scene::Primitive p = subdivision(c, "catmull-clark", {tag("hole", {0})});
  std::vector<float> st;
  for (const int v : c.vertices) st.insert(st.end(), {float(v), float(v) * 0.5f});
  p.primvars.set(parameter("st", StorageClass::FaceVarying, ValueType::Float, std::move(st), 2));
  Quiet d;
  const std::optional<Mesh> m = tessellate(p, {}, d);
  ASSERT_TRUE(m.has_value());
  EXPECT_EQ(d.count("GEOM-SUBDIVISION-CAGE"), 1u);
  EXPECT_EQ(d.count("GEOM-PRIMVAR-COUNT"), 0u);
  const Primvar* read = m->find("st");
  ASSERT_TRUE(read && read->rate == Primvar::Rate::PerCorner);
  ASSERT_EQ(read->data.size(), 6u * m->triangleCount());
  for (uint32_t t = 0; t < m->triangleCount(); ++t) {
    const auto at = corners(*m, t);
    for (size_t k = 0; k < 3; ++k) {
      const float v = float(std::lround(at[k].x * 2) + 3 * std::lround(at[k].y * 2));
      EXPECT_EQ(read->data[6 * t + 2 * k], v);
      EXPECT_EQ(read->data[6 * t + 2 * k + 1], v * 0.5f);
    }
  }
}

TEST(Subdivision, BadTagsAreToldAndLeftOut) {
  for (const auto& t :
       {tag("crease", {0}, {1}), tag("crease", {0, 1, 3}, {}), tag("crease", {0, 99}, {1}),
        tag("crease", {0, 7}, {1}), tag("corner", {-1}, {1}), tag("hole", {6}), tag("vertexedit", {1})}) {
    Quiet d;
    const auto m = tessellate(subdivision(cube(), "catmull-clark", {t}), {}, d);
    ASSERT_TRUE(m.has_value());
    EXPECT_GE(d.count("GEOM-TAG"), 1u) << t.name;
    EXPECT_EQ(edges(*m).open, 0u);
  }
  // Edits of a hierarchical mesh are told once, whatever their number, and its base is the surface.
  std::vector<std::string> lines;
  Diagnostics told([&](const std::string& line, Severity) { lines.push_back(line); });
  const std::vector<scene::SubdivisionMesh::Tag> base{tag("crease", {0, 1}, {10})};
  std::vector<scene::SubdivisionMesh::Tag> edited = base;
  for (int i = 0; i < 300; ++i) edited.push_back(tag(i % 3 ? "vertexedit" : "faceedit", {0, i % 4}, {1, 2, 3}));
  const auto hierarchical = tessellate(subdivision(cube(), "catmull-clark", edited), {}, told);
  ASSERT_TRUE(hierarchical.has_value());
  EXPECT_EQ(volume(*hierarchical), volume(made(subdivision(cube(), "catmull-clark", base))));
  EXPECT_EQ(told.count("GEOM-TAG"), 1u);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("'faceedit' (100 times), 'vertexedit' (200 times)"), std::string::npos) << lines[0];
  // Odd sharpnesses do no harm.
  Quiet d;
  const auto m = tessellate(subdivision(cube(), "catmull-clark",
                                        {tag("crease", {0, 1, 3}, {std::nanf(""), -3}), tag("corner", {7}, {1e30f})}),
                            {}, d);
  ASSERT_TRUE(m.has_value());
  for (const V3f& v : m->points) ASSERT_TRUE(std::isfinite(v.x + v.y + v.z));
}

TEST(Subdivision, TimeAndMemory) {
  const scene::Primitive p =
      subdivision(sheet(200, 0.01), "catmull-clark", {tag("interpolateboundary", {1})});  // 40,000 faces
  const auto start = std::chrono::steady_clock::now();
  const Mesh m = made(p, edge(0.001));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("[ measured ] 40,000 faces: %u triangles, %.2f M triangles/s, %.1f bytes a triangle\n",
              m.triangleCount(), m.triangleCount() / seconds / 1e6, double(m.bytes()) / m.triangleCount());
  EXPECT_GT(m.triangleCount(), 80000u);
  EXPECT_EQ(edges(m).wrong, 0u);
}

}  // namespace
}  // namespace kinora::geometry
