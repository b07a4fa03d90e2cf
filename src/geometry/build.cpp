#include "geometry/build.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace kinora::geometry {

using Imath::V3d;
using Imath::V3f;
using scene::Parameter;
using scene::StorageClass;

std::string subject(const scene::Primitive& primitive) {
  std::string name = primitive.name();
  // The message begins with the position already.
  const std::string where = " at " + primitive.pos.str();
  if (name.size() > where.size() && name.ends_with(where)) name.resize(name.size() - where.size());
  return name;
}

bool PointKeys::finite(size_t i) const {
  for (const auto& k : keys)
    if (!std::isfinite(k[3 * i]) || !std::isfinite(k[3 * i + 1]) || !std::isfinite(k[3 * i + 2])) return false;
  return true;
}

// ---- points ----

static bool allFinite(std::span<const float> values) {
  // A sum of x * 0 is NaN as soon as one x is not finite; it vectorises, a test for each value does not.
  float sum[8] = {};
  size_t i = 0;
  for (; i + 8 <= values.size(); i += 8)
    for (int j = 0; j < 8; ++j) sum[j] += values[i + j] * 0.f;
  for (; i < values.size(); ++i) sum[0] += values[i] * 0.f;
  float all = 0;
  for (float s : sum) all += s;
  return all == 0.f;
}

std::vector<Imath::V4d> homogeneousPoints(const scene::Primitive& primitive, size_t key) {
  const scene::ParameterList& list =
      key == 0 || key > primitive.motion.size() ? primitive.primvars : primitive.motion[key - 1];
  std::vector<Imath::V4d> out;
  if (const Parameter* p = list.find("Pw")) {
    for (size_t i = 0; i + 4 <= p->floats.size(); i += 4)
      out.emplace_back(p->floats[i], p->floats[i + 1], p->floats[i + 2], p->floats[i + 3]);
  } else if (const Parameter* q = list.find("P")) {
    for (size_t i = 0; i + 3 <= q->floats.size(); i += 3)
      out.emplace_back(q->floats[i], q->floats[i + 1], q->floats[i + 2], 1.0);
  }
  return out;
}

// Points of one key: false when the list has none.
static bool pointsOf(const scene::ParameterList& list, PointKeys& out) {
  if (const Parameter* p = list.find("P"); p && p->floats.size() >= 3) {
    out.keys.push_back(std::span<const float>(p->floats.data(), p->floats.size() / 3 * 3));
    return true;
  }
  if (const Parameter* p = list.find("Pw"); p && p->floats.size() >= 4) {
    std::vector<float> projected;
    projected.reserve(p->floats.size() / 4 * 3);
    for (size_t i = 0; i + 4 <= p->floats.size(); i += 4)
      for (int c = 0; c < 3; ++c) projected.push_back(float(double(p->floats[i + c]) / double(p->floats[i + 3])));
    out.owned.push_back(std::move(projected));
    out.keys.push_back(out.owned.back());
    return true;
  }
  return false;
}

std::optional<PointKeys> readPoints(const scene::Primitive& primitive, Diagnostics& diagnostics) {
  PointKeys out;
  out.owned.reserve(primitive.motion.size() + 1);  // spans into the inner vectors stay valid
  if (!pointsOf(primitive.primvars, out)) {
    diagnostics.error("GEOM-NO-POINTS", primitive.pos, subject(primitive) + " has no points (P)",
                      "the primitive is left out");
    return std::nullopt;
  }
  out.count = out.keys[0].size() / 3;
  if (!primitive.motion.empty()) {
    bool good = primitive.times.size() == primitive.motion.size() + 1;
    for (size_t i = 1; good && i < primitive.times.size(); ++i) good = primitive.times[i] > primitive.times[i - 1];
    std::string why = good ? "" : "its motion times do not increase or do not match its keys";
    bool moves = false;
    for (size_t k = 0; good && k < primitive.motion.size(); ++k) {
      if (!pointsOf(primitive.motion[k], out)) {
        out.keys.push_back(out.keys[0]);  // this key says nothing new about the points
      } else if (out.keys.back().size() != out.keys[0].size()) {
        good = false;
        why = "motion key " + std::to_string(k + 2) + " has " + std::to_string(out.keys.back().size() / 3) +
              " points and the first " + std::to_string(out.count);
      } else {
        moves |= std::memcmp(out.keys.back().data(), out.keys[0].data(), out.keys[0].size_bytes()) != 0;
      }
      // curves and points may grow in place
      for (const char* name : {"width", "constantwidth"}) {
        const Parameter *a = primitive.primvars.find(name), *b = primitive.motion[k].find(name);
        moves |= a && b && a->floats != b->floats;
      }
    }
    if (!good)
      diagnostics.warning("GEOM-MOTION-MISMATCH", primitive.pos, subject(primitive) + ": " + why,
                          "only the first key is used");
    if (good && moves)
      out.times = primitive.times;
    else
      out.keys.resize(1);
  }
  for (const auto& k : out.keys) out.nonFinite |= !allFinite(k);
  return out;
}

V3d chooseOrigin(const Imath::Box3d& bounds) {
  if (bounds.isEmpty()) return V3d(0);
  const V3d size = bounds.size(), centre = bounds.center();
  const double extent = std::max({size.x, size.y, size.z});
  const double far = std::max({std::abs(centre.x), std::abs(centre.y), std::abs(centre.z)});
  // Within 16 sizes of zero floats lose at most 4 bits against the object's own size: not worth an offset.
  if (!(far > 16 * extent) || !(extent > 0) || !std::isfinite(far)) return V3d(0);
  const double grid = std::exp2(std::floor(std::log2(extent)));
  return V3d(std::round(centre.x / grid) * grid, std::round(centre.y / grid) * grid,
             std::round(centre.z / grid) * grid);
}

void storePoints(const std::vector<V3d>& points, size_t keys, Mesh& mesh) {
  mesh.vertexCount = uint32_t(points.size() / keys);
  for (const V3d& p : points) mesh.bounds.extendBy(p);
  mesh.origin = chooseOrigin(mesh.bounds);
  mesh.points.reserve(points.size());
  for (const V3d& p : points) mesh.points.emplace_back(V3f(p - mesh.origin));
}

// ---- primvars ----

static size_t elementsFor(StorageClass storage, const ClassCounts& counts) {
  switch (storage) {
    case StorageClass::Constant:
      return 1;
    case StorageClass::Uniform:
      return counts.uniform;
    case StorageClass::Varying:
      return counts.varying;
    case StorageClass::Vertex:
      return counts.vertex;
    case StorageClass::FaceVarying:
    case StorageClass::FaceVertex:
      return counts.faceVarying;
  }
  return 1;
}

std::vector<SourcePrimvar> readPrimvars(const scene::Primitive& primitive, const ClassCounts& counts,
                                        Diagnostics& diagnostics) {
  std::vector<SourcePrimvar> out;
  for (const Parameter& p : primitive.primvars) {
    if (p.name == "P" || p.name == "Pw" || p.name == "Pz") continue;
    auto drop = [&](const std::string& why) {
      diagnostics.warning("GEOM-PRIMVAR", p.pos.line ? p.pos : primitive.pos,
                          "primvar \"" + p.name + "\" of " + subject(primitive) + " " + why,
                          "the primvar is left out");
    };
    if (p.isReference) {
      drop("is a reference to a pattern, which a primitive cannot have");
      continue;
    }
    const size_t width = p.elementFloats();
    const bool isString = p.type == scene::ValueType::String;
    const size_t values = isString                          ? p.strings.size()
                          : p.type == scene::ValueType::Int ? p.ints.size()
                                                            : p.floats.size();
    if (width == 0 || values == 0 || (!isString && !scene::isFloatBased(p.type) && p.type != scene::ValueType::Int)) {
      drop("has no values that could be used");
      continue;
    }
    SourcePrimvar s;
    s.parameter = &p;
    s.storage = p.storage;
    s.elements = elementsFor(p.storage, counts);
    const size_t given = values / width;
    if (given < s.elements || (given != s.elements && s.storage != StorageClass::Constant)) {
      // One value is meant for all; otherwise the class whose count fits exactly was probably meant.
      const StorageClass candidates[] = {StorageClass::Constant, StorageClass::Vertex, StorageClass::Varying,
                                         StorageClass::FaceVarying, StorageClass::Uniform};
      const std::string said = std::string(nameOf(p.storage)) + " primvar \"" + p.name + "\" of " +
                               subject(primitive) + " has " + std::to_string(given) + " values where " +
                               std::to_string(s.elements) + " belong";
      const StorageClass* fit = std::find_if(std::begin(candidates), std::end(candidates),
                                             [&](StorageClass c) { return elementsFor(c, counts) == given; });
      if (fit != std::end(candidates)) {
        s.storage = *fit;
        s.elements = given;
        diagnostics.warning("GEOM-PRIMVAR-COUNT", p.pos.line ? p.pos : primitive.pos, said,
                            std::string("it is taken as ") + nameOf(*fit));
      } else if (given > s.elements) {
        diagnostics.warning("GEOM-PRIMVAR-COUNT", p.pos.line ? p.pos : primitive.pos, said, "the surplus is ignored");
      } else {
        diagnostics.warning("GEOM-PRIMVAR-COUNT", p.pos.line ? p.pos : primitive.pos, said,
                            "the primvar is left out");
        continue;
      }
    }
    if (isString && s.storage != StorageClass::Constant && s.storage != StorageClass::Uniform) {
      drop("holds strings, which cannot be interpolated");
      continue;
    }
    const size_t used = s.elements * width;
    if (p.type == scene::ValueType::Int)
      s.values.assign(p.ints.begin(), p.ints.begin() + std::ptrdiff_t(used));
    else if (!isString)
      s.values.assign(p.floats.begin(), p.floats.begin() + std::ptrdiff_t(used));
    out.push_back(std::move(s));
  }
  return out;
}

Primvar emptyPrimvar(const SourcePrimvar& source, Primvar::Rate rate) {
  Primvar out;
  out.name = source.parameter->name;
  out.type = source.parameter->type;
  out.width = int(source.parameter->elementFloats());
  out.rate = rate;
  if (source.parameter->type == scene::ValueType::String)
    out.strings.assign(source.parameter->strings.begin(),
                       source.parameter->strings.begin() + std::ptrdiff_t(source.elements * out.width));
  return out;
}

std::span<const float> valuesAtKey(const scene::Primitive& primitive, const SourcePrimvar& source, size_t key) {
  if (key == 0) return source.values;
  if (key > primitive.motion.size()) return {};
  const Parameter* p = primitive.motion[key - 1].find(source.parameter->name);
  if (!p || p->floats.size() < source.values.size()) return {};
  return std::span<const float>(p->floats.data(), source.values.size());
}

void joinTextureCoordinates(Mesh& mesh) {
  const Primvar *s = mesh.find("s"), *t = mesh.find("t");
  if (!s || !t || mesh.find("st") || s->width != 1 || t->width != 1 || s->rate != t->rate) return;
  Primvar st;
  st.name = "st";
  st.width = 2;
  st.rate = s->rate;
  st.data.reserve(s->data.size() * 2);
  for (size_t i = 0; i < s->data.size() && i < t->data.size(); ++i) {
    st.data.push_back(s->data[i]);
    st.data.push_back(t->data[i]);
  }
  mesh.primvars.push_back(std::move(st));
}

void applyTextureCoordinates(const scene::Primitive& primitive, Mesh& mesh) {
  if (!primitive.attributes || mesh.find("st") || mesh.vertexUV.empty()) return;
  const std::array<float, 8>& c = primitive.attributes->textureCoordinates;
  if (c == std::array<float, 8>{0, 0, 1, 0, 0, 1, 1, 1}) return;
  Primvar st;
  st.name = "st";
  st.width = 2;
  st.rate = Primvar::Rate::PerVertex;
  for (const Imath::V2f& uv : mesh.vertexUV)
    for (int i = 0; i < 2; ++i)
      st.data.push_back((1 - uv.y) * ((1 - uv.x) * c[i] + uv.x * c[2 + i]) +
                        uv.y * ((1 - uv.x) * c[4 + i] + uv.x * c[6 + i]));
  mesh.primvars.push_back(std::move(st));
}

// ---- normals ----

V3d geometricNormal(const Mesh& mesh, uint32_t triangle, size_t key) {
  const V3f* p = mesh.points.data() + key * mesh.vertexCount;
  const uint32_t* i = &mesh.indices[size_t(triangle) * 3];
  const V3d a(p[i[0]]), n = (V3d(p[i[1]]) - a).cross(V3d(p[i[2]]) - a);
  return mesh.flipNormals ? -n : n;
}

static double cornerAngle(const V3d& at, const V3d& b, const V3d& c) {
  const V3d x = b - at, y = c - at;
  return std::atan2(x.cross(y).length(), x.dot(y));
}

void addSmoothNormals(Mesh& mesh) {
  Primvar n = Primvar::normals();
  n.data.reserve(mesh.points.size() * 3);
  std::vector<V3d> sum;
  for (size_t key = 0; key < size_t(mesh.keyCount()); ++key) {
    const V3f* p = mesh.points.data() + key * mesh.vertexCount;
    sum.assign(mesh.vertexCount, V3d(0));
    for (uint32_t t = 0; t < mesh.triangleCount(); ++t) {
      const uint32_t* i = &mesh.indices[size_t(t) * 3];
      const V3d c[3] = {V3d(p[i[0]]), V3d(p[i[1]]), V3d(p[i[2]])};
      const V3d face = geometricNormal(mesh, t, key);
      for (int k = 0; k < 3; ++k) sum[i[k]] += face * cornerAngle(c[k], c[(k + 1) % 3], c[(k + 2) % 3]);
    }
    for (const V3d& s : sum) {
      const double length = s.length();
      const V3d unit = length > 0 ? s / length : V3d(0, 0, 1);  // a vertex without area is never interpolated from
      n.data.insert(n.data.end(), {float(unit.x), float(unit.y), float(unit.z)});
    }
  }
  mesh.primvars.push_back(std::move(n));
}

static size_t normalIndex(const Mesh& mesh, const Primvar& n, uint32_t t, int corner) {
  switch (n.rate) {
    case Primvar::Rate::Constant:
      return 0;
    case Primvar::Rate::PerFace:
      return mesh.faceOf(t);
    case Primvar::Rate::PerVertex:
      return mesh.indices[size_t(t) * 3 + corner];
    case Primvar::Rate::PerCorner:
      return size_t(t) * 3 + corner;
  }
  return 0;
}

void repairNormals(const scene::Primitive& primitive, Mesh& mesh, Diagnostics& diagnostics) {
  auto found =
      std::find_if(mesh.primvars.begin(), mesh.primvars.end(), [](const Primvar& p) { return p.name == "N"; });
  if (found == mesh.primvars.end()) return;
  if (found->width != 3) {
    diagnostics.warning("GEOM-PRIMVAR", primitive.pos, "N of " + subject(primitive) + " is not a normal",
                        "the primvar is left out");
    mesh.primvars.erase(found);
    return;
  }
  Primvar& n = *found;
  size_t bad = 0;
  for (size_t i = 0; i + 3 <= n.data.size(); i += 3) {
    const V3d v(n.data[i], n.data[i + 1], n.data[i + 2]);
    const double length = v.length();
    const bool good = length > 0 && std::isfinite(length);
    bad += !good;
    for (int c = 0; c < 3; ++c) n.data[i + c] = good ? float(v[c] / length) : 0.f;
  }
  // A few thousand triangles, evenly spread, decide which side the normals are meant for.
  const uint32_t triangles = mesh.triangleCount(), step = std::max(1u, triangles / 4096);
  size_t with = 0, against = 0;
  for (uint32_t t = 0; t < triangles; t += step) {
    const V3d face = geometricNormal(mesh, t);
    V3d sum(0);
    for (int c = 0; c < 3; ++c) {
      const float* v = &n.data[normalIndex(mesh, n, t, c) * 3];
      sum += V3d(v[0], v[1], v[2]);
    }
    const double side = sum.dot(face);
    with += side > 0;
    against += side < 0;
  }
  if (against > with) {
    for (float& v : n.data) v = -v;
    Message m;
    m.severity = Severity::Info;
    m.code = "GEOM-NORMALS-TURNED";
    m.pos = primitive.pos;
    m.what = "the normals of " + subject(primitive) + " point to the back that its orientation gives it";
    m.done = "they are turned to the front";
    diagnostics.report(std::move(m));
  }
  if (bad == 0) return;
  diagnostics.warning("GEOM-NORMAL", primitive.pos,
                      std::to_string(bad) + " normals of " + subject(primitive) + " are zero or not finite",
                      "geometric normals take their place");
  const size_t perKey = n.rate == Primvar::Rate::PerVertex ? size_t(mesh.vertexCount) * 3 : n.data.size();
  for (uint32_t t = 0; t < triangles; ++t) {
    const V3d face = geometricNormal(mesh, t);
    const double length = face.length();
    if (!(length > 0)) continue;
    for (int c = 0; c < 3; ++c)
      for (size_t base = 0; base < n.data.size(); base += perKey) {
        float* v = &n.data[base + normalIndex(mesh, n, t, c) * 3];
        if (v[0] == 0 && v[1] == 0 && v[2] == 0)
          for (int k = 0; k < 3; ++k) v[k] = float(face[k] / length);
      }
  }
  for (size_t i = 0; i + 3 <= n.data.size(); i += 3)
    if (n.data[i] == 0 && n.data[i + 1] == 0 && n.data[i + 2] == 0)
      n.data[i + 2] = 1;  // only on triangles without area
}

static void addCornerPrimvars(const scene::Primitive& primitive, Diagnostics& diagnostics, Mesh& mesh) {
  for (const SourcePrimvar& s : readPrimvars(primitive, {1, 4, 4, 4}, diagnostics)) {
    const bool single = s.storage == scene::StorageClass::Constant || s.storage == scene::StorageClass::Uniform;
    Primvar p = emptyPrimvar(s, single ? Primvar::Rate::Constant : Primvar::Rate::PerVertex);
    if (single) {
      p.data = s.values;
    } else {
      // Four values at (u, v) = (0,0), (1,0), (0,1), (1,1).
      p.data.reserve(mesh.vertexUV.size() * p.width);
      for (const Imath::V2f& uv : mesh.vertexUV)
        for (int k = 0; k < p.width; ++k) {
          const float *d = s.values.data() + k, u = uv.x, v = uv.y;
          p.data.push_back((1 - v) * ((1 - u) * d[0] + u * d[p.width]) +
                           v * ((1 - u) * d[2 * p.width] + u * d[3 * p.width]));
        }
    }
    mesh.primvars.push_back(std::move(p));
  }
}

void finishSurface(const scene::Primitive& primitive, Primvar normals, Diagnostics& diagnostics, Mesh& mesh) {
  addCornerPrimvars(primitive, diagnostics, mesh);
  if (mesh.find("N"))
    repairNormals(primitive, mesh, diagnostics);
  else
    mesh.primvars.push_back(std::move(normals));
  joinTextureCoordinates(mesh);
  applyTextureCoordinates(primitive, mesh);
}

}  // namespace kinora::geometry
