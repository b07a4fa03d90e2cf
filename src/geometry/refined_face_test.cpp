// Faces that fold over each other at a vertex, which OpenSubdiv's own patches do not take where something is sharp
// near: against the limits of an independent refinement of the whole cage, for points and facevarying values. What is
// read beyond arrays shows under a memory checker alone.
#include "geometry/refined_face.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include "geometry/test_support.h"

namespace kinora::geometry {
namespace {

using namespace testing;
namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

struct Crease {
  int a, b;
  float sharpness;
};
struct Folded {
  const char* name;
  Sdc::SchemeType scheme;
  std::vector<int> sizes, vertices;
  std::vector<Crease> creases;
  std::vector<int> values;  // facevarying, by corner; empty: the vertices
  bool needs;               // refinement, on the first face
};

// The first face of each has two edges in common with the second, but the last two.
const Folded kFolded[] = {
    {"two quads", Sdc::SCHEME_CATMARK, {4, 4}, {0, 1, 2, 3, 1, 0, 5, 2}, {}, {}, false},
    {"one edge creased", Sdc::SCHEME_CATMARK, {4, 4}, {0, 1, 2, 3, 1, 0, 5, 2}, {{1, 2, 3.5f}}, {}, true},
    {"an end of an infinite crease", Sdc::SCHEME_CATMARK, {4, 4}, {0, 1, 2, 3, 1, 0, 5, 2}, {{1, 2, 10}}, {}, true},
    {"both edges creased",
     Sdc::SCHEME_CATMARK,
     {4, 4},
     {0, 1, 2, 3, 1, 0, 5, 2},
     {{1, 2, 2.3f}, {0, 1, 10}},
     {},
     true},
    {"with a seam",
     Sdc::SCHEME_CATMARK,
     {4, 4},
     {0, 1, 2, 3, 1, 0, 5, 2},
     {{0, 1, 1.5f}},
     {0, 1, 2, 3, 4, 0, 5, 2},
     true},
    {"a triangle and a quad", Sdc::SCHEME_CATMARK, {3, 4}, {0, 1, 2, 1, 0, 5, 2}, {{1, 2, 2}}, {}, true},
    {"a pentagon and a quad", Sdc::SCHEME_CATMARK, {5, 4}, {0, 1, 2, 3, 4, 1, 0, 5, 2}, {{1, 2, 10}}, {}, true},
    {"triangles of Loop", Sdc::SCHEME_LOOP, {3, 3, 3}, {0, 1, 2, 1, 0, 2, 0, 2, 4}, {{1, 2, 2.5f}}, {}, true},
    {"with a neighbour",
     Sdc::SCHEME_CATMARK,
     {4, 4, 4},
     {0, 1, 2, 3, 1, 0, 5, 2, 0, 3, 4, 5},
     {{0, 1, 10}, {0, 3, 2.f}},
     {},
     true},
    {"an edge in common", Sdc::SCHEME_CATMARK, {4, 4}, {0, 1, 2, 3, 1, 0, 5, 4}, {{0, 1, 3.5f}}, {}, false},
    {"bilinear", Sdc::SCHEME_BILINEAR, {4, 4}, {0, 1, 2, 3, 1, 0, 5, 2}, {{1, 2, 3.5f}}, {}, false},
};
const std::vector<double> kPoints = {-.8, -.8, 0,   -.5, -.8, .3, -.5, -.5, 0,
                                     -.8, -.5, -.2, -.2, -.8, .1, -.3, -.5, .2};

std::unique_ptr<Far::TopologyRefiner> refinerOf(const Folded& f) {
  Far::TopologyDescriptor d;
  std::vector<int> pairs;
  std::vector<float> weights;
  for (const Crease& c : f.creases) {
    pairs.insert(pairs.end(), {c.a, c.b});
    weights.push_back(c.sharpness);
  }
  d.numVertices = int(kPoints.size() / 3);
  d.numFaces = int(f.sizes.size());
  d.numVertsPerFace = f.sizes.data();
  d.vertIndicesPerFace = f.vertices.data();
  d.numCreases = int(weights.size());
  d.creaseVertexIndexPairs = pairs.data();
  d.creaseWeights = weights.data();
  Far::TopologyDescriptor::FVarChannel channel;
  channel.numValues = 6;
  channel.valueIndices = f.values.empty() ? f.vertices.data() : f.values.data();
  d.numFVarChannels = 1;
  d.fvarChannels = &channel;
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
  options.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  return std::unique_ptr<Far::TopologyRefiner>(Factory::Create(d, Factory::Options(f.scheme, options)));
}

struct Points {
  std::vector<V3d> p;
  struct At {
    V3d* p;
    void Clear() { *p = V3d(0); }
    void AddWithWeight(const At& other, double w) { *p += *other.p * w; }
  };
  At operator[](int i) const { return {const_cast<V3d*>(&p[size_t(i)])}; }
};

// Limits of all points of the cage after some steps of refinement, or of its facevarying values.
std::vector<V3d> limitsOf(const Folded& f, bool isFaceVarying) {
  const auto refiner = refinerOf(f);
  constexpr int kLevels = 5;
  Far::TopologyRefiner::UniformOptions options(kLevels);
  options.fullTopologyInLastLevel = true;
  refiner->RefineUniform(options);
  const Far::PrimvarRefinerReal<double> interpolation(*refiner);
  Points now;
  for (size_t i = 0; i < kPoints.size(); i += 3) now.p.emplace_back(kPoints[i], kPoints[i + 1], kPoints[i + 2]);
  for (int level = 1; level <= kLevels; ++level) {
    const Far::TopologyLevel& l = refiner->GetLevel(level);
    Points next;
    next.p.resize(size_t(isFaceVarying ? l.GetNumFVarValues(0) : l.GetNumVertices()));
    if (isFaceVarying)
      interpolation.InterpolateFaceVarying(level, now, next, 0);
    else
      interpolation.Interpolate(level, now, next);
    now = next;
  }
  Points limit = now;
  if (isFaceVarying)
    interpolation.LimitFaceVarying(now, limit, 0);
  else
    interpolation.Limit(now, limit);
  return limit.p;
}

double nearestOf(const std::vector<V3d>& all, const V3d& p) {
  double best = INFINITY;
  for (const V3d& q : all) best = std::min(best, (p - q).length());
  return best;
}

TEST(RefinedFace, IsNeededWhereFacesFoldNearWhatIsSharp) {
  for (const Folded& f : kFolded) EXPECT_EQ(needsRefinement(*refinerOf(f), 0), f.needs) << f.name;
}

TEST(RefinedFace, GoesThroughTheLimitsOfTheWholeCage) {
  for (const Folded& f : kFolded) {
    if (!f.needs) continue;
    const auto refiner = refinerOf(f);
    const std::vector<CageValues> values = {{CageValues::Kind::Vertex, 0, 3, kPoints.data()},
                                            {CageValues::Kind::FaceVarying, 0, 3, kPoints.data()}};
    const RefinedFace face(*refiner, 0, values);
    const int n = f.sizes[0];
    for (const bool isFaceVarying : {false, true}) {
      const std::vector<V3d> limits = limitsOf(f, isFaceVarying);
      // steps of the refinement: a 32nd of a quad or triangle, of the quads that other faces are cut into a 16th
      constexpr int kSteps = 32;
      double worst = 0, length = 0;
      const OpenSubdiv::Bfr::Parameterization whole(f.scheme, n);
      for (int part = 0; part < (n == 4 || f.scheme == Sdc::SCHEME_LOOP ? 1 : n); ++part)
        for (int j = 0; j <= kSteps; ++j)
          for (int i = 0; i <= kSteps; ++i) {
            double uv[2] = {double(i) / kSteps, double(j) / kSteps};
            if (f.scheme == Sdc::SCHEME_LOOP) {
              if (i + j > kSteps) continue;
            } else if (n != 4) {
              if (i % 2 || j % 2) continue;
              const double local[2] = {uv[0], uv[1]};
              whole.ConvertNormalizedSubFaceToCoord(part, local, uv);
            }
            V3d p, du, dv;
            face.evaluate(uv, isFaceVarying, &p.x, &du.x, &dv.x);
            worst = std::max(worst, nearestOf(limits, p));
            length = std::max(length, (p - limits[0]).length());
            if (isFaceVarying || i == 0 || j == 0 || i == kSteps || j == kSteps || i + j == kSteps) continue;
            // derivatives point where the surface goes
            const double along[2] = {uv[0] + 1e-5, uv[1]};
            V3d q;
            face.evaluate(along, 0, &q.x);
            if (n == 4) {
              EXPECT_GT((q - p).normalized().dot(du.normalized()), .99) << f.name << uv[0] << " " << uv[1];
            }
          }
      // what patches at vertices of other valences miss by, as they are without all this
      EXPECT_LT(worst, 4e-3) << f.name << (isFaceVarying ? " facevarying" : "");
      EXPECT_GT(length, 0.2);
    }
  }
}

// Alone on its patches: the ring says all that the cage says.
TEST(RefinedFace, OfAPlainFaceIsItsPatch) {
  const Folded& f = kFolded[9];
  const auto refiner = refinerOf(f);
  const RefinedFace face(*refiner, 0, {{CageValues::Kind::Vertex, 0, 3, kPoints.data()}});
  const std::vector<V3d> limits = limitsOf(f, false);
  for (const double u : {0., .25, .5, 1.})
    for (const double v : {0., .75, 1.}) {
      const double uv[2] = {u, v};
      V3d p;
      face.evaluate(uv, 0, &p.x);
      EXPECT_LT(nearestOf(limits, p), 1e-3) << u << ' ' << v;
    }
}

scene::Primitive meshOf(const Folded& f, int boundary) {
  scene::SubdivisionMesh s;
  s.scheme = f.scheme == Sdc::SCHEME_LOOP ? "loop" : f.scheme == Sdc::SCHEME_BILINEAR ? "bilinear" : "catmull-clark";
  s.verticesPerFace = f.sizes;
  s.vertices = f.vertices;
  s.tags.push_back({"interpolateboundary", {boundary}, {}, {}});
  for (const Crease& c : f.creases) s.tags.push_back({"crease", {c.a, c.b}, {c.sharpness}, {}});
  scene::Primitive p = primitive(std::move(s));
  p.primvars.set(points(std::vector<float>(kPoints.begin(), kPoints.end())));
  std::vector<float> st;
  for (const int v : f.values.empty() ? f.vertices : f.values)
    for (int k = 0; k < 2; ++k) st.push_back(float(kPoints[size_t(3 * v + k)]));
  p.primvars.set(parameter("st", scene::StorageClass::FaceVarying, scene::ValueType::Float, std::move(st), 2));
  return p;
}

TEST(RefinedFace, MeshesThatFoldAreWhole) {
  for (const Folded& f : kFolded)
    for (const double e : {1., .05}) {
      const Mesh m = made(meshOf(f, 1), edge(e));
      ASSERT_GT(m.triangleCount(), 1u) << f.name;
      for (const V3f& p : m.points) {
        ASSERT_TRUE(std::isfinite(p.x + p.y + p.z)) << f.name;
        ASSERT_LT(p.length(), 2) << f.name;
      }
      const Primvar *st = m.find("st"), *n = m.find("N");
      ASSERT_TRUE(st && n) << f.name;
      for (const float x : st->data) ASSERT_LE(std::abs(x), 1.f) << f.name;
      for (const float x : n->data) ASSERT_LE(std::abs(x), 1.001f) << f.name;
      if (f.scheme != Sdc::SCHEME_LOOP) {  // there an edge has three faces
        EXPECT_EQ(edges(m).wrong, 0u) << f.name;
      }
    }
}

// A crease that is hardly sharp is no crease: what is refined here meets the patches that are used without.
TEST(RefinedFace, MeetsThePatchesAsCreasesVanish) {
  Folded f = kFolded[1];
  f.creases[0].sharpness = 1e-4f;
  const Mesh a = made(meshOf(f, 1), edge(.05)), b = made(meshOf(kFolded[0], 1), edge(.05));
  ASSERT_EQ(a.vertexCount, b.vertexCount);
  for (uint32_t v = 0; v < a.vertexCount; ++v) EXPECT_LT((vertex(a, v) - vertex(b, v)).length(), 1e-3) << v;
}

// Faces twice, in all ways to name the same vertices, with what is sharp and seams.
TEST(RefinedFace, FacesTwiceAreEachByItself) {
  const std::vector<int> ways[] = {{0, 1, 2, 3, 0, 1, 2, 3},
                                   {0, 1, 2, 3, 1, 2, 3, 0},
                                   {0, 1, 2, 3, 3, 2, 1, 0},
                                   {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3},
                                   {0, 1, 2, 3, 0, 1, 2, 3, 3, 2, 1, 0},
                                   {0, 1, 2, 3, 0, 2, 1, 3},
                                   {0, 1, 2, 3, 1, 0, 5, 2, 0, 1, 2, 3},
                                   {0, 1, 2, 3, 1, 0, 5, 2, 1, 0, 5, 2},
                                   {0, 1, 2, 1, 0, 1, 2, 3},
                                   {0, 1, 0, 1, 1, 0, 5, 2}};
  const std::vector<Crease> sharp[] = {{}, {{1, 2, 3.5f}}, {{0, 1, 10}}, {{0, 1, 10}, {1, 2, 2}, {2, 3, .5f}}};
  for (const auto& way : ways)
    for (const auto& creases : sharp)
      for (const int boundary : {0, 1, 2}) {
        Folded f{"twice", Sdc::SCHEME_CATMARK, std::vector<int>(way.size() / 4, 4), way, creases, {}, false};
        Quiet d;
        const std::optional<Mesh> m = tessellate(meshOf(f, boundary), edge(.1), d);
        if (!m) continue;
        for (const V3f& p : m->points) ASSERT_LT(p.length(), 2);
        const Primvar* st = m->find("st");
        ASSERT_NE(st, nullptr);
        for (const float x : st->data) ASSERT_LE(std::abs(x), 1.5f);
      }
}

}  // namespace
}  // namespace kinora::geometry
