// Blobbies: an octree finds the cells that the surface may pass through, by bounds of the field over each; the cells
// of the last level become six tetrahedra each, and the surface a piece of plane in each tetrahedron. All cells cut
// their shared faces along the same diagonals, so the mesh is closed. Vertices are found on the edges to the last
// bits that matter, normals are gradients.
#include <ImathBox.h>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "geometry/build.h"
#include "geometry/implicit.h"
#include "geometry/makers.h"

namespace kinora::geometry {

using Imath::V3d;

namespace {

constexpr int kLeastDepth = 3, kMostDepth = 9;
// Nodes evaluated for one primitive; beyond it the cells are made coarser.
constexpr uint64_t kMostWork = 3'000'000'000;

class Polygoniser {
 public:
  Polygoniser(const ImplicitField& field, const Imath::Box3d& box, int depth, size_t maxTriangles)
      : depth_(depth), maxTriangles_(maxTriangles), corner_(box.min), cell_(box.size() / double(1 << depth)) {
    levels_.resize(size_t(depth) + 1);
    levels_[0] = field;
  }
  // False: too many triangles, or too much work.
  bool run() { return visit(0, 0, 0, 0); }

  std::vector<V3d> points, normals;
  std::vector<uint32_t> indices;

 private:
  V3d at(int x, int y, int z) const { return corner_ + cell_ * V3d(x, y, z); }

  // The cell at (x, y, z) of 2^level, with the field that holds in its parent.
  bool visit(int level, int x, int y, int z) {
    const int size = 1 << (depth_ - level);
    const V3d half = cell_ * (0.5 * size);
    const V3d centre = at(x * size, y * size, z * size) + half;
    const ImplicitField& outer = levels_[size_t(std::max(level - 1, 0))];
    work_ += outer.nodes.size();
    if (work_ > kMostWork) return false;
    ImplicitField inner;
    // a little larger, so that rounding at shared faces loses nothing
    const FieldBounds b = outer.boundsOver(centre, half * (1 + 1e-9), inner, scratch_);
    if (b.high < kBlobbyThreshold || b.low > kBlobbyThreshold) return true;
    ImplicitField& mine = levels_[size_t(level)];
    mine = std::move(inner);
    if (level == depth_) return cell(mine, x, y, z);
    for (int i = 0; i < 8; ++i)
      if (!visit(level + 1, 2 * x + (i & 1), 2 * y + (i >> 1 & 1), 2 * z + (i >> 2))) return false;
    return true;
  }

  bool cell(const ImplicitField& field, int x, int y, int z) {
    double value[8];
    uint32_t inside = 0;
    for (int i = 0; i < 8; ++i) {
      value[i] = field.valueAt(at(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)), scratch_) - kBlobbyThreshold;
      inside |= uint32_t(value[i] >= 0) << i;
    }
    work_ += field.nodes.size() * 8;
    if (inside == 0 || inside == 255) return true;
    // paths from corner 0 to corner 7 along the axes; odd orders of the axes turn the other way
    static constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                              {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
    for (const auto& t : kTetrahedra) {
      int in[4], out[4], ins = 0, outs = 0;
      for (const int c : t) (inside >> c & 1 ? in[ins++] : out[outs++]) = c;
      const auto edge = [&](int a, int b) { return vertex(field, x, y, z, a, b, value[a], value[b]); };
      const V3d outwards = middle(out, outs) - middle(in, ins);
      if (ins == 1 || ins == 3) {
        const int* many = ins == 1 ? out : in;
        const int one = ins == 1 ? in[0] : out[0];
        triangle(edge(one, many[0]), edge(one, many[1]), edge(one, many[2]), outwards);
      } else if (ins == 2) {
        const uint32_t q[4] = {edge(in[0], out[0]), edge(in[0], out[1]), edge(in[1], out[1]), edge(in[1], out[0])};
        triangle(q[0], q[1], q[2], outwards);
        triangle(q[0], q[2], q[3], outwards);
      }
    }
    return indices.size() / 3 <= maxTriangles_;
  }

  V3d middle(const int* corners, int n) const {
    V3d sum(0);
    for (int i = 0; i < n; ++i) sum += cell_ * V3d(corners[i] & 1, corners[i] >> 1 & 1, corners[i] >> 2);
    return n ? sum / n : sum;
  }

  void triangle(uint32_t a, uint32_t b, uint32_t c, const V3d& outwards) {
    if (a == b || b == c || a == c) return;
    const V3d n = (points[b] - points[a]).cross(points[c] - points[a]);
    if (n.dot(outwards) < 0) std::swap(b, c);
    indices.insert(indices.end(), {a, b, c});
  }

  uint32_t vertex(const ImplicitField& field, int x, int y, int z, int a, int b, double va, double vb) {
    if (a > b) std::swap(a, b), std::swap(va, vb);
    // the lower corner and the direction name the edge, whichever cell asks
    const auto coordinate = [](int cell, int corner, int axis) { return uint64_t(cell + (corner >> axis & 1)); };
    const uint64_t key =
        coordinate(x, a, 0) | coordinate(y, a, 1) << 20 | coordinate(z, a, 2) << 40 | uint64_t(a ^ b) << 60;
    const auto [found, isNew] = vertices_.try_emplace(key, uint32_t(points.size()));
    if (!isNew) return found->second;
    V3d p = at(x + (a & 1), y + (a >> 1 & 1), z + (a >> 2)), q = at(x + (b & 1), y + (b >> 1 & 1), z + (b >> 2));
    // regula falsi with halved weights of the end that stays (Dowell and Jarratt 1971, "Illinois")
    V3d m = p;
    int side = 0;
    for (int i = 0; i < 24 && va != 0 && vb != 0; ++i) {
      const double t = va / (va - vb);
      m = p + (q - p) * t;
      const double v = field.valueAt(m, scratch_) - kBlobbyThreshold;
      work_ += field.nodes.size();
      if (std::abs(v) < 1e-12) break;
      if ((v >= 0) == (va >= 0)) {
        p = m, va = v;
        if (side == -1) vb *= 0.5;
        side = -1;
      } else {
        q = m, vb = v;
        if (side == 1) va *= 0.5;
        side = 1;
      }
    }
    if (va == 0) m = p;
    if (vb == 0) m = q;
    const V3d g = field.gradientAt(m, scratch_);
    points.push_back(m);
    const double length = g.length();
    normals.push_back(length > 0 ? -g / length : V3d(0));
    return found->second;
  }

  int depth_;
  size_t maxTriangles_;
  V3d corner_, cell_;
  std::vector<ImplicitField> levels_;  // the field that holds in the cell being visited, at each level
  ImplicitField::Scratch scratch_;
  std::unordered_map<uint64_t, uint32_t> vertices_;
  uint64_t work_ = 0;
};

// Each leaf's value, by how much it matters at the vertex.
void blendPrimvars(const scene::Primitive& primitive, const ImplicitField& field, uint32_t leaves,
                   const std::vector<V3d>& points, Diagnostics& diagnostics, Mesh& mesh) {
  const auto sources = readPrimvars(primitive, {1, leaves, leaves, leaves}, diagnostics);
  std::vector<std::pair<const SourcePrimvar*, size_t>> blended;  // and its place in the mesh
  for (const SourcePrimvar& s : sources) {
    if (s.parameter->name == "N") continue;
    const bool each = s.elements == leaves && s.storage != scene::StorageClass::Constant &&
                      s.storage != scene::StorageClass::Uniform && s.parameter->type != scene::ValueType::String;
    if (each) blended.emplace_back(&s, mesh.primvars.size());
    mesh.primvars.push_back(emptyPrimvar(s, each ? Primvar::Rate::PerVertex : Primvar::Rate::Constant));
    if (!each) mesh.primvars.back().data = s.values;
  }
  if (blended.empty()) return;
  std::vector<double> weights(leaves);
  for (const V3d& p : points) {
    std::fill(weights.begin(), weights.end(), 0.0);
    field.leafFields(p, weights);
    double sum = 0;
    for (const double w : weights) sum += w;
    for (const auto& [source, at] : blended) {
      const size_t width = source->parameter->elementFloats();
      for (size_t c = 0; c < width; ++c) {
        double v = 0;
        for (uint32_t i = 0; i < leaves; ++i) v += weights[i] * double(source->values[i * width + c]);
        mesh.primvars[at].data.push_back(float(sum > 0 ? v / sum : double(source->values[c])));
      }
    }
  }
}

}  // namespace

bool makeBlobby(const scene::Primitive& primitive, const scene::OtherPrimitive& blobby, const DiceRate& rate,
                Diagnostics& diagnostics, Mesh& mesh) {
  ImplicitField field;
  uint32_t leaves = 0;
  std::string said;
  const std::string wrong = readBlobby(blobby.args, field, leaves, said);
  if (!wrong.empty()) {
    diagnostics.error("GEOM-BLOBBY", primitive.pos, subject(primitive) + " " + wrong, "the primitive is left out");
    return false;
  }
  if (!said.empty())
    diagnostics.warning("GEOM-BLOBBY", primitive.pos, subject(primitive) + ": " + said,
                        "it adds nothing to the surface");
  Imath::Box3d box = field.reach();
  const V3d size = box.isEmpty() ? V3d(0) : box.size();
  const double side = std::max({size.x, size.y, size.z});
  if (!(side > 0) || !std::isfinite(side)) {
    diagnostics.warning("GEOM-ZERO-AREA", primitive.pos, subject(primitive) + " has no volume",
                        "the primitive is left out");
    return false;
  }
  // a cube, its planes off the round numbers that leaves like to be placed at
  const V3d centre = box.center(), half(side * 0.50031);
  box = {centre - half, centre + half};
  double edge = rate.at(centre);
  for (const ImplicitNode& n : field.nodes) {
    V3d p;
    if (n.kind != ImplicitNode::Kind::Ellipsoid && n.kind != ImplicitNode::Kind::Segment) continue;
    n.toLeaf.inverse().multVecMatrix(n.begin, p);
    edge = std::min(edge, rate.at(p));
  }
  // normals are exact: cells of some edges show no facets but at outlines
  const double cells = std::isfinite(edge) && edge > 0 ? side / (3 * edge) : 64;
  for (int depth = std::clamp(int(std::ceil(std::log2(cells))), 6, kMostDepth); depth >= kLeastDepth; --depth) {
    Polygoniser made(field, box, depth, rate.maxTriangles);
    if (!made.run()) continue;
    if (made.indices.empty()) {
      diagnostics.warning("GEOM-ZERO-AREA", primitive.pos,
                          subject(primitive) + " has no surface: its field stays below " + "the threshold",
                          "the primitive is left out");
      return false;
    }
    mesh.indices = std::move(made.indices);
    storePoints(made.points, 1, mesh);
    blendPrimvars(primitive, field, leaves, made.points, diagnostics, mesh);
    Primvar n = Primvar::normals();
    for (const V3d& v : made.normals)
      for (int c = 0; c < 3; ++c) n.data.push_back(float(mesh.flipNormals ? -v[c] : v[c]));
    mesh.primvars.push_back(std::move(n));
    mesh.faceOfTriangle.assign(mesh.triangleCount(), 0);
    return true;
  }
  diagnostics.error("GEOM-BLOBBY", primitive.pos, subject(primitive) + " is too large to be made into a mesh",
                    "the primitive is left out");
  return false;
}

}  // namespace kinora::geometry
