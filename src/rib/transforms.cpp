#include <ImathMatrixAlgo.h>
#include <ImathQuat.h>

#include <algorithm>
#include <cmath>

#include "rib/interpreter.h"

namespace kinora::rib {

using Imath::V3d;
using scene::Matrix;

namespace {

constexpr double kRadians = 3.14159265358979323846 / 180;

bool isFinite(const Matrix& m) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (!std::isfinite(m[i][j])) return false;
  return true;
}

// Judged against the rows' lengths, so that a small scene is not taken for a flat one.
bool isSingular(const Matrix& m) {
  double volume = 1;
  for (int i = 0; i < 4; ++i)
    volume *= std::sqrt(m[i][0] * m[i][0] + m[i][1] * m[i][1] + m[i][2] * m[i][2] + m[i][3] * m[i][3]);
  return !(std::abs(m.determinant()) > 1e-14 * volume);
}

bool isAffine(const Matrix& m) { return m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1; }

Matrix rotation(double radians, const V3d& axis) {
  Matrix m;
  m.setAxisAngle(axis, radians);
  return m;
}

// M = S * Q * T: a stretch, a rotation and a translation (polar decomposition by Newton's iteration, Higham 1986).
// False where the matrix has no rotation of its own: singular, mirrored or projective.
struct Parts {
  Matrix stretch;
  Imath::Quatd rotation;
  V3d translation;
};
bool decompose(const Matrix& m, Parts& out) {
  if (!isAffine(m)) return false;
  Matrix q = m;
  q[3][0] = q[3][1] = q[3][2] = 0;
  if (!(q.determinant() > 0)) return false;
  const Matrix linear = q;
  for (int i = 0; i < 40; ++i) {
    const Matrix next = (q + q.inverse().transposed()) * 0.5;
    double change = 0;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) change = std::max(change, std::abs(next[r][c] - q[r][c]));
    q = next;
    if (change < 1e-14) break;
  }
  out.stretch = linear * q.transposed();
  out.rotation = Imath::extractQuat(q).normalized();
  out.translation = V3d(m[3][0], m[3][1], m[3][2]);
  return isFinite(out.stretch);
}

// Keys between two rotations `angle` apart: a chord misses its arc by angle^2 / 8 of the radius, 1e-4 is what
// Transform promises.
int piecesFor(double angle) {
  constexpr double kLargestStep = 0.028;
  constexpr double kStep =
      0.02;  // below it, so that keys that were cut once and scaled are not cut again when read back
  if (!(std::abs(angle) > kLargestStep)) return 1;
  constexpr double kMost = double(scene::Transform::kMostKeys) - 1;
  return int(std::max(1.0, std::min(kMost, std::ceil(std::abs(angle) / kStep))));
}

}  // namespace

bool Interpreter::matrixOf(const Request& request, Matrix& m, bool& replaces) {
  Request& r = const_cast<Request&>(request);  // a cursor may take arrays away; numbers only read
  Cursor c(r);
  replaces = r.name == "Transform" || r.name == "Identity";
  m = Matrix();
  double v[16];
  const auto get = [&](size_t n, const char* wanted) {
    if (c.numbers(n, v)) return true;
    badArguments(r, wanted);
    return false;
  };
  if (r.name == "Identity") return true;
  if (r.name == "Transform" || r.name == "ConcatTransform") {
    if (!get(16, "16 numbers")) return false;
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = v[i];
  } else if (r.name == "Translate") {
    if (!get(3, "3 numbers")) return false;
    m.setTranslation(V3d(v[0], v[1], v[2]));
  } else if (r.name == "Scale") {
    if (!get(3, "3 numbers")) return false;
    m.setScale(V3d(v[0], v[1], v[2]));
  } else if (r.name == "Rotate") {
    if (!get(4, "an angle and an axis")) return false;
    const V3d axis(v[1], v[2], v[3]);
    if (axis.length() == 0 && v[0] == 0) return true;
    if (axis.length() == 0) {
      report(Severity::Error, "RIB-TRANSFORM", r.pos, "Rotate has no axis: it is (0 0 0)", "the identity is used",
             "three numbers behind the angle say which way the axis points");
      return true;
    }
    m = rotation(v[0] * kRadians, axis);
  } else if (r.name == "Skew") {
    if (!get(7, "an angle and two directions")) return false;
    // moves points along d2 so that d1 leans towards it by the angle
    V3d d1(v[1], v[2], v[3]), d2(v[4], v[5], v[6]);
    d1.normalize();
    d2.normalize();
    const double between = std::acos(std::max(-1.0, std::min(1.0, d1.dot(d2))));
    const double angle = v[0] * kRadians, rest = between - angle;
    V3d ortho = d1 - d2 * d1.dot(d2);  // the part of d1 across d2
    if (!std::all_of(v, v + 7, [](double x) { return std::isfinite(x); })) {
      m[0][0] = NAN;
    } else if (!(ortho.length() > 1e-9) || !(std::sin(rest) > 1e-9)) {
      if (v[0] == 0) return true;
      report(Severity::Error, "RIB-TRANSFORM", r.pos,
             !(ortho.length() > 1e-9) ? "Skew has no two directions: one is (0 0 0), or both are along one line"
                                      : "Skew leans its direction up to the other one or beyond",
             "the identity is used",
             "behind the angle stand the direction that leans and the one along which it does");
    } else {
      ortho.normalize();
      // d1 = cos(between) d2 + sin(between) ortho becomes, at the same height over d2, of angle `rest` to it
      const double shear = std::cos(rest) / std::sin(rest) - std::cos(between) / std::sin(between);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) m[i][j] += ortho[i] * d2[j] * shear;
    }
  } else {  // Perspective
    if (!get(1, "a field of view")) return false;
    const double f = std::tan(v[0] * 0.5 * kRadians);
    // z goes to 1 - 1/z, as the camera of the classic pipeline has it with near at 1 and far at infinity
    m = Matrix(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, f, f, 0, 0, -f, 0);
  }
  if (!isFinite(m) || isSingular(m)) {
    report(Severity::Error, "RIB-TRANSFORM", r.pos,
           r.name + (isFinite(m) ? " cannot be inverted (a scale of 0, or rows that depend on each other)"
                                 : " holds nan or infinity"),
           "the identity is used");
    m = Matrix();
  }
  return true;
}

void Interpreter::transformRequest(Request& r) {
  Matrix m;
  bool replaces;
  if (!matrixOf(r, m, replaces)) return;
  const scene::Transform before = state_.ctm;
  if (replaces)
    state_.ctm = scene::Transform::fixed(m);
  else
    state_.ctm = concat(scene::Transform::fixed(m), state_.ctm);
  for (const Matrix& k : std::as_const(state_.ctm.matrices))
    if (!isFinite(k)) {
      report(Severity::Error, "RIB-TRANSFORM", r.pos,
             "the transforms up to this " + r.name + " multiply beyond all numbers", "it is ignored");
      state_.ctm = before;
      return;
    }
}

void Interpreter::applyTransforms(std::vector<Request>& keys, const std::vector<double>& times) {
  std::vector<Matrix> matrices(keys.size());
  bool replaces = false;
  for (size_t k = 0; k < keys.size(); ++k)
    if (!matrixOf(keys[k], matrices[k], replaces)) return;
  scene::Transform t;
  t.times.clear();
  t.matrices.clear();
  for (size_t k = 0; k < keys.size(); ++k) {
    t.times.push_back(times[k]);
    t.matrices.push_back(matrices[k]);
    if (k + 1 == keys.size()) break;
    const auto insert = [&](int pieces, auto&& at) {
      for (int i = 1; i < pieces; ++i) {
        const double f = double(i) / pieces, time = times[k] + (times[k + 1] - times[k]) * f;
        if (!(time > t.times.back()) || !(time < times[k + 1])) continue;
        t.times.push_back(time);
        t.matrices.push_back(at(f));
      }
    };
    double a[4], b[4];
    Cursor ca(keys[k]), cb(keys[k + 1]);
    if (keys[k].name == "Rotate" && ca.numbers(4, a) && cb.numbers(4, b)) {
      const V3d axis(a[1], a[2], a[3]);
      const V3d other(b[1], b[2], b[3]);
      const V3d shared = axis.length() > 0 ? axis : other;
      const bool same = (axis.length() == 0 || axis.normalized().equalWithAbsError(shared.normalized(), 1e-9)) &&
                        (other.length() == 0 || other.normalized().equalWithAbsError(shared.normalized(), 1e-9));
      if (same && shared.length() > 0 && std::isfinite(a[0]) &&
          std::isfinite(b[0])) {  // turns as often as it says, not the short way
        insert(piecesFor((b[0] - a[0]) * kRadians),
               [&](double f) { return rotation((a[0] + (b[0] - a[0]) * f) * kRadians, shared); });
        continue;
      }
    }
    if (keys[k].name == "Translate" || keys[k].name == "Scale" || keys[k].name == "Identity") continue;
    Parts p, q;
    if (!decompose(matrices[k], p) || !decompose(matrices[k + 1], q)) continue;
    if ((p.rotation ^ q.rotation) < 0) q.rotation = -q.rotation;
    const double angle = 2 * std::acos(std::min(1.0, std::abs(p.rotation ^ q.rotation)));
    if (angle < 1e-6) continue;
    insert(piecesFor(angle), [&](double f) {
      Matrix m = (p.stretch * (1 - f) + q.stretch * f);
      m = m * Imath::slerp(p.rotation, q.rotation, f).toMatrix44();
      const V3d move = p.translation * (1 - f) + q.translation * f;
      m[3][0] = move.x;
      m[3][1] = move.y;
      m[3][2] = move.z;
      m[0][3] = m[1][3] = m[2][3] = 0;
      m[3][3] = 1;
      return m;
    });
  }
  const size_t before = state_.ctm.matrices.size();
  state_.ctm = replaces ? t : concat(t, state_.ctm);
  if (!replaces && before > 1 && before < scene::Transform::kMostKeys &&
      state_.ctm.matrices.size() == scene::Transform::kMostKeys)
    report(Severity::Warning, "RIB-MOTION", keys[0].pos,
           "motion blocks in one another have more than " + std::to_string(scene::Transform::kMostKeys) + " keys",
           "as many of them are used");
}

void Interpreter::coordinateSystem(Request& r) {
  // what is read when a ray asks for it must not rename spaces for what others see
  if (!ancestors_.empty()) scopedCoordinateSystem(r);
  Cursor c(r);
  std::string name;
  if (!c.string(name)) return badArguments(r, "a name");
  if (!inWorldOrObject()) {
    frame_.cameraSpaces[name] = state_.ctm;
    return;
  }
  if (world_) {
    world_->coordinateSystems[name] = state_.ctm;
    onlyScoped_.erase(name);
  }
  if (!openObjects_.empty()) addScopedSpace(name);  // each instance has its own
}

void Interpreter::addScopedSpace(const std::string& name) {
  scene::Attributes& a = edit();
  auto spaces = a.coordinateSystems ? std::make_shared<std::map<std::string, scene::Transform>>(*a.coordinateSystems)
                                    : std::make_shared<std::map<std::string, scene::Transform>>();
  (*spaces)[name] = state_.ctm;
  a.coordinateSystems = std::move(spaces);
}

void Interpreter::scopedCoordinateSystem(Request& r) {
  Cursor c(r);
  std::string name;
  if (!c.string(name)) return badArguments(r, "a name");
  addScopedSpace(name);
  if (!openObjects_.empty()) return;
  // Patterns ask for systems by name alone, and exporters give each its own. Before the world, where they stand in
  // camera space, those of the scope that WorldBegin stands in become the world's: see there.
  bool isOther = false;
  if (world_) {
    const auto [it, isNew] = world_->coordinateSystems.try_emplace(name, state_.ctm);
    if (isNew) onlyScoped_.insert(name);
    isOther = !isNew && it->second.matrices != state_.ctm.matrices;
  } else if (const auto it = frame_.cameraSpaces.find(name); it != frame_.cameraSpaces.end()) {
    isOther = it->second.matrices != state_.ctm.matrices;
  }
  if (isOther)
    report(Severity::Warning, "RIB-COORDSYS", r.pos,
           "another coordinate system is called '" + name.substr(0, 60) + "' already",
           "light filters and CoordSysTransform in this scope use this one, patterns the first",
           "give each its own name");
}

void Interpreter::coordSysTransform(Request& r) {
  Cursor c(r);
  std::string name;
  if (!c.string(name)) return badArguments(r, "a name");
  if (const auto& scoped = state_.attributes->coordinateSystems)
    if (const auto it = scoped->find(name); it != scoped->end()) {
      state_.ctm = it->second;
      return;
    }
  if (world_) {
    const auto it = world_->coordinateSystems.find(name);
    if (it != world_->coordinateSystems.end() && !onlyScoped_.contains(name)) {
      state_.ctm = it->second;
      return;
    }
  } else if (const auto it = frame_.cameraSpaces.find(name); it != frame_.cameraSpaces.end()) {
    state_.ctm = it->second;
    return;
  } else if (name == "camera") {
    state_.ctm = scene::Transform();
    return;
  }
  const bool hasEnded = world_ && onlyScoped_.contains(name);
  report(Severity::Error, "RIB-COORDSYS", r.pos,
         "no coordinate system " + std::string(hasEnded ? "of this scope " : "") + "is called '" +
             name.substr(0, 60) + "'",
         "the transform stays as it is",
         hasEnded ? "ScopedCoordinateSystem names it for another scope; CoordinateSystem names it for all"
                  : "name it with CoordinateSystem first; raster, NDC and screen cannot be entered");
}

}  // namespace kinora::rib
