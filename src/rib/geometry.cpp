#include <algorithm>
#include <cmath>
#include <utility>

#include "rib/interpreter.h"
#include "rib/primvar_counts.h"
#include "scene/bytes.h"

namespace kinora::rib {

using namespace scene;

namespace {

struct QuadricForm {
  const char* name;
  Quadric::Kind kind;
  size_t args;
};
constexpr QuadricForm kQuadrics[] = {
    {"Sphere", Quadric::Kind::Sphere, 4},         {"Cone", Quadric::Kind::Cone, 3},
    {"Cylinder", Quadric::Kind::Cylinder, 4},     {"Hyperboloid", Quadric::Kind::Hyperboloid, 7},
    {"Paraboloid", Quadric::Kind::Paraboloid, 4}, {"Disk", Quadric::Kind::Disk, 3},
    {"Torus", Quadric::Kind::Torus, 5},
};

size_t positionsIn(const ParameterList& p) {
  if (const Parameter* P = p.find("P")) return P->floats.size() / 3;
  if (const Parameter* Pw = p.find("Pw")) return Pw->floats.size() / 4;
  return 0;
}

Parameter arrayOf(const char* name, std::vector<float> v, const SourcePos& pos) {
  Parameter p;
  p.name = name;
  p.isArray = true;
  p.arrayLength = int(std::min<size_t>(v.size(), INT32_MAX));
  p.floats = std::move(v);
  p.storage = StorageClass::Constant;
  p.pos = pos;
  return p;
}
Parameter arrayOf(const char* name, std::vector<int> v, const SourcePos& pos) {
  Parameter p = arrayOf(name, std::vector<float>(), pos);
  p.type = ValueType::Int;
  p.arrayLength = int(std::min<size_t>(v.size(), INT32_MAX));
  p.ints = std::move(v);
  return p;
}
Parameter arrayOf(const char* name, std::vector<std::string> v, const SourcePos& pos) {
  Parameter p = arrayOf(name, std::vector<float>(), pos);
  p.type = ValueType::String;
  p.arrayLength = int(std::min<size_t>(v.size(), INT32_MAX));
  p.strings = std::move(v);
  return p;
}

bool sameTopology(const Shape& a, const Shape& b) {
  if (a.index() != b.index()) return false;
  if (const auto* m = std::get_if<PolygonMesh>(&a)) {
    const auto& n = std::get<PolygonMesh>(b);
    return m->loopsPerFace == n.loopsPerFace && m->verticesPerLoop == n.verticesPerLoop && m->vertices == n.vertices;
  }
  if (const auto* m = std::get_if<SubdivisionMesh>(&a)) {
    const auto& n = std::get<SubdivisionMesh>(b);
    return m->scheme == n.scheme && m->verticesPerFace == n.verticesPerFace && m->vertices == n.vertices;
  }
  if (const auto* m = std::get_if<scene::Curves>(&a)) {
    const auto& n = std::get<scene::Curves>(b);
    return m->cubic == n.cubic && m->periodic == n.periodic && m->verticesPerCurve == n.verticesPerCurve;
  }
  if (const auto* m = std::get_if<PatchMesh>(&a)) {
    const auto& n = std::get<PatchMesh>(b);
    return m->bicubic == n.bicubic && m->nu == n.nu && m->nv == n.nv && m->uPeriodic == n.uPeriodic &&
           m->vPeriodic == n.vPeriodic;
  }
  if (const auto* m = std::get_if<Patch>(&a)) return m->bicubic == std::get<Patch>(b).bicubic;
  if (const auto* m = std::get_if<NuPatch>(&a)) {
    const auto& n = std::get<NuPatch>(b);
    return m->nu == n.nu && m->nv == n.nv && m->uOrder == n.uOrder && m->vOrder == n.vOrder &&
           m->uKnots == n.uKnots && m->vKnots == n.vKnots;
  }
  if (const auto* m = std::get_if<Points>(&a)) return m->count == std::get<Points>(b).count;
  if (const auto* m = std::get_if<Quadric>(&a)) return m->kind == std::get<Quadric>(b).kind;
  return std::get<OtherPrimitive>(a).request == std::get<OtherPrimitive>(b).request;
}

// The faces of a mesh that Attribute "shade" "int[] faceset", or a primitive variable of that name, leaves. The others
// of a subdivision mesh become holes, so that its limit surface stays what it is. False: none is left.
// reportFace(face, faces) is told of those that the mesh has not.
template <class F>
bool keepFaces(Primitive& p, const std::vector<int>& chosen, F&& reportFace) {
  auto* polygons = std::get_if<PolygonMesh>(&p.shape);
  auto* subdivision = std::get_if<SubdivisionMesh>(&p.shape);
  // without a list of loops each face has one
  const auto loopsOf = [&](size_t face) { return polygons->loopsPerFace.empty() ? 1 : polygons->loopsPerFace[face]; };
  const size_t faces = subdivision                      ? subdivision->verticesPerFace.size()
                       : polygons->loopsPerFace.empty() ? polygons->verticesPerLoop.size()
                                                        : polygons->loopsPerFace.size();
  std::vector<char> stays(faces);
  for (const int f : chosen) {
    if (f >= 0 && size_t(f) < faces) {
      stays[size_t(f)] = 1;
      continue;
    }
    reportFace(f, faces);
  }
  const size_t kept = size_t(std::count(stays.begin(), stays.end(), 1));
  if (kept == faces) return true;
  if (kept == 0) return false;
  if (subdivision) {
    SubdivisionMesh::Tag holes{"hole", {}, {}, {}};
    for (size_t f = 0; f < faces; ++f)
      if (!stays[f]) holes.ints.push_back(int(f));
    subdivision->tags.push_back(std::move(holes));
    return true;
  }
  PolygonMesh m;
  std::vector<char> cornerStays;
  size_t loop = 0, corner = 0;
  for (size_t f = 0; f < faces; ++f) {
    if (stays[f] && !polygons->loopsPerFace.empty()) m.loopsPerFace.push_back(loopsOf(f));
    for (int l = 0; l < loopsOf(f); ++l, ++loop) {
      const int count = polygons->verticesPerLoop[loop];
      if (stays[f]) m.verticesPerLoop.push_back(count);
      for (int k = 0; k < count; ++k, ++corner) {
        cornerStays.push_back(stays[f]);
        // without a list each corner is the next point, and all points stay
        if (stays[f]) m.vertices.push_back(polygons->vertices.empty() ? int(corner) : polygons->vertices[corner]);
      }
    }
  }
  *polygons = std::move(m);
  const auto keepIn = [&](ParameterList& list) {
    std::vector<std::string> names;
    for (const Parameter& v : std::as_const(list))
      if (v.storage == StorageClass::Uniform || v.storage == StorageClass::FaceVarying ||
          v.storage == StorageClass::FaceVertex)
        names.push_back(v.name);
    for (const std::string& name : names) {
      Parameter& v = *list.find(name);
      const std::vector<char>& which = v.storage == StorageClass::Uniform ? stays : cornerStays;
      const auto keep = [&](auto& values) {
        const size_t each = values.size() / which.size();
        if (values.size() != which.size() * each) return;
        size_t to = 0;
        for (size_t i = 0; i < values.size(); ++i)
          if (which[i / each]) std::swap(values[to++], values[i]);
        values.resize(to);
      };
      keep(v.floats);
      keep(v.ints);
      keep(v.strings);
    }
  };
  keepIn(p.primvars);
  for (ParameterList& key : p.motion) keepIn(key);
  return true;
}

bool isMesh(const Primitive& p) {
  return std::holds_alternative<PolygonMesh>(p.shape) || std::holds_alternative<SubdivisionMesh>(p.shape);
}

// RISpec's Np, one normal a face, is N of that class.
void faceNormalsToNormals(ParameterList& primvars) {
  const Parameter* np = std::as_const(primvars).find("Np");
  if (!np || std::as_const(primvars).find("N")) return;
  Parameter n = *np;
  n.name = "N";
  primvars.erase("Np");
  primvars.set(std::move(n));
}

// Heights over the unit square become points (the reference's "Pz").
void heightsToPoints(ParameterList& primvars, const Shape& shape) {
  const Parameter* z = std::as_const(primvars).find("Pz");
  if (!z || primvars.find("P")) return;
  size_t nu = 2, nv = 2;
  if (const auto* p = std::get_if<Patch>(&shape))
    nu = nv = p->bicubic ? 4 : 2;
  else if (const auto* m = std::get_if<PatchMesh>(&shape))
    nu = size_t(std::max(1, m->nu)), nv = size_t(std::max(1, m->nv));
  else
    return;
  Parameter p = *z;
  p.name = "P";
  p.type = ValueType::Point;
  p.floats.clear();
  p.floats.reserve(3 * z->floats.size());
  for (size_t i = 0; i < z->floats.size(); ++i) {
    p.floats.push_back(nu > 1 ? float(i % nu) / float(nu - 1) : 0.f);
    p.floats.push_back(nv > 1 ? float(i / nu) / float(nv - 1) : 0.f);
    p.floats.push_back(z->floats[i]);
  }
  primvars.erase("Pz");
  primvars.set(std::move(p));
}

// Tags of both forms of subdivision mesh: counts per tag are 2 (ints, floats) or 3 (and strings).
std::string readTags(SubdivisionMesh& m, const std::vector<std::string>& names, const std::vector<int>& counts,
                     const std::vector<int>& ints, const std::vector<float>& floats,
                     const std::vector<std::string>& strings) {
  if (names.empty()) return {};
  const size_t per = counts.size() == 3 * names.size() ? 3 : 2;
  if (counts.size() != per * names.size())
    return std::to_string(names.size()) + " tags with " + std::to_string(counts.size()) + " argument counts";
  size_t atInt = 0, atFloat = 0, atString = 0;
  for (size_t i = 0; i < names.size(); ++i) {
    const int n[3] = {counts[per * i], counts[per * i + 1], per == 3 ? counts[per * i + 2] : 0};
    if (n[0] < 0 || n[1] < 0 || n[2] < 0 || size_t(n[0]) > ints.size() - atInt ||
        size_t(n[1]) > floats.size() - atFloat || size_t(n[2]) > strings.size() - atString)
      return "the tag '" + names[i].substr(0, 40) + "' with more arguments than there are";
    SubdivisionMesh::Tag t;
    t.name = names[i];
    t.ints.assign(ints.begin() + long(atInt), ints.begin() + long(atInt) + n[0]);
    t.floats.assign(floats.begin() + long(atFloat), floats.begin() + long(atFloat) + n[1]);
    t.strings.assign(strings.begin() + long(atString), strings.begin() + long(atString) + n[2]);
    atInt += size_t(n[0]);
    atFloat += size_t(n[1]);
    atString += size_t(n[2]);
    m.tags.push_back(std::move(t));
  }
  return {};
}

}  // namespace

// The shape and its primitive variables, checked; empty when the primitive cannot be used (a message says why).
std::optional<Primitive> Interpreter::primitive(Request& r) {
  Cursor c(r);
  Primitive p;
  p.pos = r.pos;
  const auto bad = [&](const std::string& wanted) {
    report(Severity::Error, "RIB-ARGUMENTS", r.pos, r.name + " needs " + wanted, "the primitive is left out");
    return std::nullopt;
  };
  const auto other = [&](OtherPrimitive o) {
    reportKept(r);
    p.shape = std::move(o);
  };
  bool known = false;
  for (const QuadricForm& form : kQuadrics)
    if (r.name == form.name) {
      double v[7] = {};
      if (!c.numbers(form.args, v)) return bad(std::to_string(form.args) + " numbers");
      Quadric q{form.kind, {}};
      for (size_t i = 0; i < form.args; ++i) q.args[i] = float(v[i]);
      p.shape = q;
      known = true;
    }
  std::string text;
  std::vector<std::string> tagNames, tagStrings;
  std::vector<int> tagCounts, tagInts;
  std::vector<float> tagFloats;
  if (known) {
  } else if (r.name == "Polygon") {
    p.shape = PolygonMesh();  // the count follows from P
  } else if (r.name == "GeneralPolygon") {
    PolygonMesh m;
    if (!c.integers(m.verticesPerLoop)) return bad("an array of vertex counts");
    m.loopsPerFace = {int(std::min<size_t>(m.verticesPerLoop.size(), INT32_MAX))};
    p.shape = std::move(m);
  } else if (r.name == "PointsPolygons" || r.name == "PointsGeneralPolygons") {
    PolygonMesh m;
    if (r.name == "PointsGeneralPolygons" && !c.integers(m.loopsPerFace.edit())) return bad("three arrays of whole numbers");
    if (!c.integers(m.verticesPerLoop) || !c.integers(m.vertices))
      return bad("arrays of whole numbers: vertex counts and indices");
    // the general form with one loop a face is the plain form
    if (std::all_of(m.loopsPerFace.begin(), m.loopsPerFace.end(), [](int n) { return n == 1; }) &&
        m.loopsPerFace.size() == m.verticesPerLoop.size())
      m.loopsPerFace.clear();
    if (m.vertices.empty()) return bad("vertex indices");
    p.shape = std::move(m);
  } else if (r.name == "SubdivisionMesh" || r.name == "HierarchicalSubdivisionMesh") {
    SubdivisionMesh m;
    if (!c.string(m.scheme) || !c.integers(m.verticesPerFace) || !c.integers(m.vertices))
      return bad("a scheme and two arrays of whole numbers");
    if (m.scheme == "catmark") m.scheme = "catmull-clark";
    if (m.scheme != "catmull-clark" && m.scheme != "loop" && m.scheme != "bilinear") {
      report(Severity::Warning, "RIB-SCHEME", r.pos,
             "no subdivision scheme is called '" + m.scheme.substr(0, 40) + "'", "catmull-clark is used");
      m.scheme = "catmull-clark";
    }
    // tags are there when an array follows; a parameter list begins with a bare string
    if (c.at < r.count && r.args[c.at].isArray) {
      if (!c.strings(tagNames) || !c.integers(tagCounts) || !c.integers(tagInts) || !c.floats(tagFloats))
        return bad("tags as an array of names, of counts, of integers and of floats");
      if (c.at < r.count && r.args[c.at].isArray) c.strings(tagStrings);
    }
    if (const std::string why = readTags(m, tagNames, tagCounts, tagInts, tagFloats, tagStrings); !why.empty()) {
      report(Severity::Error, "RIB-TAGS", r.pos, r.name + " has " + why, "this tag and those after it are ignored");
    }
    p.shape = std::move(m);
  } else if (r.name == "Curves") {
    scene::Curves k;
    std::string wrap;
    if (!c.string(text) || (text != "linear" && text != "cubic")) return bad("\"linear\" or \"cubic\"");
    if (!c.integers(k.verticesPerCurve)) return bad("an array of vertex counts");
    if (!c.string(wrap) || (wrap != "periodic" && wrap != "nonperiodic"))
      return bad("\"periodic\" or \"nonperiodic\"");
    k.cubic = text == "cubic";
    k.periodic = wrap == "periodic";
    p.shape = std::move(k);
  } else if (r.name == "Points") {
    // an older form has the count first
    if (c.at < r.count && r.args[c.at].kind == Argument::Kind::Numbers) c.array(Argument::Kind::Numbers);
    p.shape = Points();
  } else if (r.name == "Patch") {
    if (!c.string(text) || (text != "bilinear" && text != "bicubic")) return bad("\"bilinear\" or \"bicubic\"");
    p.shape = Patch{text == "bicubic"};
  } else if (r.name == "PatchMesh") {
    PatchMesh m;
    std::string wrap[2];
    double n[2];
    // "wrap" and "nowrap" are the words of the oldest files
    const auto isWrap = [](std::string& w) {
      if (w == "wrap") w = "periodic";
      if (w == "nowrap") w = "nonperiodic";
      return w == "periodic" || w == "nonperiodic";
    };
    if (!c.string(text) || (text != "bilinear" && text != "bicubic")) return bad("\"bilinear\" or \"bicubic\"");
    if (!c.number(n[0]) || !c.string(wrap[0]) || !c.number(n[1]) || !c.string(wrap[1]) || !isWrap(wrap[0]) ||
        !isWrap(wrap[1]))
      return bad("a count and \"periodic\" or \"nonperiodic\" for u and for v");
    for (const double v : n)
      if (!(v >= 1 && v <= 1e9)) return bad("counts of at least 1");
    m = {text == "bicubic", wrap[0] == "periodic", wrap[1] == "periodic", int(n[0]), int(n[1])};
    p.shape = m;
  } else if (r.name == "NuPatch") {
    NuPatch m;
    for (int i = 0; i < 2; ++i) {
      double n[2], range[2];
      std::vector<float>& knots = (i ? m.vKnots : m.uKnots).edit();
      if (!c.numbers(2, n) || !c.floats(knots) || !c.numbers(2, range))
        return bad("count, order, knots and range for u and for v");
      for (const double v : n)
        if (!(v >= 1 && v <= 1e9)) return bad("counts of at least 1");
      (i ? m.nv : m.nu) = int(n[0]);
      (i ? m.vOrder : m.uOrder) = int(n[1]);
      (i ? m.vMin : m.uMin) = float(range[0]);
      (i ? m.vMax : m.uMax) = float(range[1]);
    }
    if (state_.trim) m.trim = *state_.trim;
    p.shape = std::move(m);
  } else if (r.name == "Blobby") {
    OtherPrimitive o{r.name, {}};
    double leaves;
    std::vector<int> code;
    std::vector<float> floats;
    std::vector<std::string> strings;
    if (!c.number(leaves) || !c.integers(code) || !c.floats(floats) || !c.strings(strings))
      return bad("a leaf count, opcodes, floats and strings");
    if (!(leaves >= 0 && leaves <= 1e9)) return bad("a leaf count of at least 0");
    o.args.set(arrayOf("nleaf", std::vector<int>{int(leaves)}, r.pos));
    o.args.set(arrayOf("code", std::move(code), r.pos));
    o.args.set(arrayOf("floats", std::move(floats), r.pos));
    o.args.set(arrayOf("strings", std::move(strings), r.pos));
    p.shape = std::move(o);
  } else if (r.name == "Volume") {
    OtherPrimitive o{r.name, {}};
    double bound[6], dims[3];
    if (!c.string(text) || !c.numbers(6, bound) || !c.numbers(3, dims)) return bad("a shape, 6 bounds and 3 sizes");
    for (const double d : dims)
      if (!(d >= 0 && d <= 1e6)) return bad("sizes of at least 0");
    o.args.set(arrayOf("type", std::vector<std::string>{text}, r.pos));
    o.args.set(arrayOf("bound", std::vector<float>(bound, bound + 6), r.pos));
    o.args.set(arrayOf("dimensions", std::vector<int>{int(dims[0]), int(dims[1]), int(dims[2])}, r.pos));
    p.shape = std::move(o);
  } else if (r.name == "Geometry") {
    OtherPrimitive o{r.name, {}};
    if (!c.string(text)) return bad("a name");
    o.args.set(arrayOf("type", std::vector<std::string>{text}, r.pos));
    p.shape = std::move(o);  // which names there are is known to who makes them
  } else {                   // Procedural, Procedural2: a kind, its data, its bound
    OtherPrimitive o{r.name, {}};
    std::vector<std::string> data;
    if (!c.string(text)) return bad("a kind");
    o.args.set(arrayOf("type", std::vector<std::string>{text}, r.pos));
    if (c.nextIsString() && (r.name == "Procedural" || !r.args[c.at].isArray) && c.strings(data))
      o.args.set(arrayOf("data", std::move(data), r.pos));
    double bound[6];
    if (r.name == "Procedural" && c.numbers(6, bound))
      o.args.set(arrayOf("bound", std::vector<float>(bound, bound + 6), r.pos));
    other(std::move(o));
  }

  p.primvars = parameters(r, c.at, Use::Primitive);
  heightsToPoints(p.primvars, p.shape);
  if (std::holds_alternative<PolygonMesh>(p.shape)) faceNormalsToNormals(p.primvars);
  const size_t positions = positionsIn(p.primvars);
  if (auto* m = std::get_if<PolygonMesh>(&p.shape); m && r.name == "Polygon")
    m->verticesPerLoop = {int(std::min<size_t>(positions, INT32_MAX))};
  if (auto* points = std::get_if<Points>(&p.shape)) points->count = int(std::min<size_t>(positions, INT32_MAX));
  const bool needsPositions =
      !std::holds_alternative<Quadric>(p.shape) && !std::holds_alternative<OtherPrimitive>(p.shape);
  if (needsPositions && positions == 0) {
    report(Severity::Error, "RIB-MISSING-P", r.pos, r.name + " has no usable \"P\"", "the primitive is left out");
    return std::nullopt;
  }
  if (const std::string why = checkShape(p.shape, positions); !why.empty()) {
    const bool index = why.find("vertex index") != std::string::npos;
    report(Severity::Error, index ? "RIB-INDEX" : "RIB-SHAPE", r.pos, r.name + " " + why,
           "the primitive is left out");
    return std::nullopt;
  }
  if (std::holds_alternative<OtherPrimitive>(p.shape)) return p;

  const PrimvarCounts counts = countsOf(p.shape, positions, *state_.attributes);
  std::vector<std::string> dropped;
  for (const Parameter& v : std::as_const(p.primvars)) {
    if (v.name == "P" || v.name == "Pw") continue;  // checked with the shape
    const size_t elements = v.size() / v.elementFloats(), wanted = counts.of(v.storage);
    const bool isVertex = v.storage == StorageClass::Vertex || v.storage == StorageClass::Varying;
    if (elements == wanted || (isVertex && counts.vertexMost && elements == counts.vertexMost)) continue;
    const std::string what = "\"" + v.name + "\" of " + r.name + " has " + std::to_string(elements) + " values; " +
                             nameOf(v.storage) + " takes " + std::to_string(wanted) + " here";
    if (elements == 1) {
      report(Severity::Warning, "RIB-PRIMVAR-ONE", v.pos, what, "its one value is used everywhere",
             "declare it constant");
      continue;
    }
    report(Severity::Error, "RIB-PRIMVAR-COUNT", v.pos, what, "the variable is left out");
    dropped.push_back(v.name);
  }
  for (const std::string& name : dropped) p.primvars.erase(name);
  std::vector<std::string> ones;
  for (const Parameter& v : std::as_const(p.primvars))
    if (v.name != "P" && v.name != "Pw" && v.storage != StorageClass::Constant && v.size() == v.elementFloats() &&
        counts.of(v.storage) != 1)
      ones.push_back(v.name);
  for (const std::string& name : ones) p.primvars.find(name)->storage = StorageClass::Constant;
  if (!isMesh(p)) return p;
  const Parameter* set = std::as_const(p.primvars).find("shade:faceset");
  if (!set) set = std::as_const(*state_.attributes).named.find("shade:faceset");
  if (!set || set->ints.empty()) return p;
  const std::vector<int> chosen = set->ints;
  const bool isLeft = keepFaces(p, chosen, [&](int face, size_t faces) { reportNoFace(face, faces, r.name, r.pos); });
  if (!isLeft) return std::nullopt;
  return p;
}

void Interpreter::geometryRequest(Request& r) {
  if (!inWorldOrObject()) {  // nothing to put it into: do not even look at its values
    ++outsideWorld_;
    return;
  }
  if (auto p = primitive(r)) emit(std::move(*p));
}

void Interpreter::applyGeometry(std::vector<Request>& keys, const std::vector<double>& times) {
  if (!inWorldOrObject()) {
    ++outsideWorld_;
    return;
  }
  auto first = primitive(keys[0]);
  if (!first) return;
  if (std::holds_alternative<OtherPrimitive>(first->shape)) {  // Blobby, Volume, Geometry: made once
    report(Severity::Warning, "RIB-MOTION-STATIC", keys[0].pos, keys[0].name + " does not move",
           "its first value is used", "its transform may move");
    emit(std::move(*first));
    return;
  }
  first->times.push_back(times[0]);
  for (size_t k = 1; k < keys.size(); ++k) {
    auto next = primitive(keys[k]);
    if (!next || !sameTopology(first->shape, next->shape) ||
        positionsIn(next->primvars) != positionsIn(first->primvars)) {
      report(Severity::Error, "RIB-MOTION", keys[k].pos,
             keys[k].name + " of a motion block does not match the first in faces, counts or points",
             "this and later times are ignored");
      break;
    }
    if (auto* q = std::get_if<Quadric>(&next->shape); q && q->args != std::get<Quadric>(first->shape).args)
      next->primvars.set(arrayOf("__quadric", std::vector<float>(q->args.begin(), q->args.end()), keys[k].pos));
    first->times.push_back(times[k]);
    first->motion.push_back(std::move(next->primvars));
  }
  if (first->motion.empty()) first->times.clear();
  emit(std::move(*first));
}

void Interpreter::emit(Primitive p) {
  if (read_.checkOnly) return;
  p.id = nextId_++;
  p.toWorld = state_.ctm;
  p.attributes = attributesInUse();
  const bool saysFaces = isMesh(p) && (std::as_const(p.primvars).find("shade:faceset") ||
                                       std::as_const(*p.attributes).named.find("shade:faceset"));
  if (saysFaces) {
    p.primvars.erase("shade:faceset");
    for (ParameterList& key : p.motion) key.erase("shade:faceset");
    p.attributes = withoutFaceSet(p.attributes);
  }
  p.solid = solidHere(p.pos);
  bool isLamp = false;
  if (state_.emitter) {
    scene::Light l = *state_.emitter;
    // a mesh light's geometry belongs to the light alone, and in objects that of older ones too
    isLamp = l.node->kind == "Light" || !openObjects_.empty();
    l.toWorld = p.toWorld;
    l.attributes = p.attributes;
    l.geometry = p;
    addLight(std::move(l));
  }
  if (isLamp) return;
  held_.add(scene::bytesHeld(p));
  auto shared = std::make_shared<const Primitive>(std::move(p));
  if (openObjects_.empty()) {
    world_->primitives.push_back(std::move(shared));
    return;
  }
  if (saysFaces) ownFaceSets_.insert(shared);
  prototypes_[openObjects_.back()].primitives.push_back(std::move(shared));
}

void Interpreter::reportNoFace(int face, size_t faces, const std::string& request, const SourcePos& pos) {
  report(Severity::Error, "RIB-INDEX", pos,
         "\"shade:faceset\" names face " + std::to_string(face) + ", and " + request + " has " +
             std::to_string(faces) + " faces",
         "that face is left out");
}

// It is done, and not to be done again to a scene that is written and read.
AttributesPtr Interpreter::withoutFaceSet(const AttributesPtr& attributes) {
  auto& [of, without] = lastWithoutFaceSet_;
  if (of != attributes) {
    auto done = std::make_shared<scene::Attributes>(*attributes);
    done->named.erase("shade:faceset");
    of = attributes;
    without = std::move(done);
  }
  return without;
}

uint32_t Interpreter::withFaces(uint32_t object, const std::vector<int>& faces, const Request& r) {
  const auto known = withFaces_.find({object, faces});
  if (known != withFaces_.end()) return known->second;
  Prototype cut = prototypeAt(object);
  const std::vector<PrimitivePtr> shapes = std::move(cut.primitives);
  const InstanceList instances = std::move(cut.instances);
  cut.primitives.clear();
  cut.instances.clear();
  bool isCut = false;
  for (const PrimitivePtr& shape : shapes) {
    if (!isMesh(*shape) || ownFaceSets_.contains(shape)) {
      cut.primitives.push_back(shape);
      continue;
    }
    isCut = true;
    Primitive p = *shape;
    const std::string request = requestName(p.shape);
    const bool isLeft =
        keepFaces(p, faces, [&](int face, size_t count) { reportNoFace(face, count, request, r.pos); });
    if (!isLeft) continue;
    p.id = nextId_++;
    held_.add(scene::bytesHeld(p));
    auto shared = std::make_shared<const Primitive>(std::move(p));
    ownFaceSets_.insert(shared);  // chosen: sets of instances further out no longer do
    cut.primitives.push_back(std::move(shared));
  }
  for (size_t k = 0; k < instances.size(); ++k) {
    Instance i = instances[k];
    const uint32_t inner = withFaces(i.prototype, faces, r);
    if (inner != i.prototype) {
      isCut = true;
      i.prototype = inner;
      i.id = nextId_++;
    }
    cut.instances.push_back(std::move(i));
  }
  uint32_t made = object;
  if (isCut) {
    made = uint32_t(prototypes_.size());
    prototypes_.push_back(std::move(cut));
    surroundings_ = nullptr;
  }
  return withFaces_[{object, faces}] = made;
}

}  // namespace kinora::rib
