// All seven quadrics as surfaces of revolution: a profile (x, y, z)(v) in a half-plane, turned about z by
// theta = u * thetamax. Exact normals; a closed one is watertight because its seam and poles have the same floats.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "geometry/build.h"
#include "geometry/dice.h"
#include "geometry/makers.h"

namespace kinora::geometry {

using Imath::V3d;
using scene::Quadric;

namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kDegrees = kPi / 180;
// Rows of a disk or cone: flat or straight in v, but the triangles at the tip cannot carry u, so they are kept small.
constexpr int kTipRows = 16;

struct Row {
  double v = 0;
  V3d p;  // at theta = 0
  V3d n;  // direction of dPdu x dPdv at theta = 0 for thetamax > 0; any length
  bool tip() const { return p.x == 0 && p.y == 0; }
};

struct Profile {
  double thetaMax = 0;             // radians
  double radius = 0, vRadius = 0;  // largest distance from the axis; radius of curvature along v (0: straight)
  double vAngle = 0;               // angle that the profile turns through
  double vLength = 0;
  int leastRows = 1;
  bool closedV = false;              // the last row is the first one again (torus)
  std::function<Row(double t)> row;  // t in [0, 1]
};

// cos and sin of an angle in degrees that are exact at multiples of 90, so that poles lie on the axis.
void exactTurn(double degrees, double& c, double& s) {
  const double quarter = degrees / 90;
  if (quarter == std::floor(quarter)) {
    const int q = int(std::fmod(std::fmod(quarter, 4) + 4, 4));
    c = q == 0 ? 1 : q == 2 ? -1 : 0;
    s = q == 1 ? 1 : q == 3 ? -1 : 0;
  } else {
    c = std::cos(degrees * kDegrees);
    s = std::sin(degrees * kDegrees);
  }
}

double sign(double x) { return x < 0 ? -1 : 1; }

// Empty string when the profile can be built, else what is wrong.
std::string profileOf(const Quadric& q, Profile& out, double& thetaDegrees) {
  const auto& a = q.args;
  auto lerp = [](double x, double y, double t) { return x + (y - x) * t; };
  switch (q.kind) {
    case Quadric::Kind::Sphere: {
      const double r = a[0];
      thetaDegrees = a[3];
      if (r == 0) return "its radius is 0";
      auto latitude = [&](double z) {
        const double s = std::clamp(z / r, -1.0, 1.0);
        return s == 1 ? 90.0 : s == -1 ? -90.0 : std::asin(s) / kDegrees;
      };
      const double p0 = latitude(a[1]), p1 = latitude(a[2]);
      if (p0 == p1) return "its zmin and zmax cut away everything";
      out.radius = out.vRadius = std::abs(r);
      out.vAngle = std::abs(p1 - p0) * kDegrees;
      out.row = [=](double t) {
        double c, s;
        exactTurn(t == 1 ? p1 : lerp(p0, p1, t), c, s);
        return Row{t, V3d(r * c, 0, r * s), V3d(c, 0, s) * sign(p1 - p0)};
      };
      break;
    }
    case Quadric::Kind::Cone: {
      const double h = a[0], r = a[1];
      thetaDegrees = a[2];
      if (r == 0) return "its radius is 0";
      out.radius = std::abs(r);
      out.vLength = std::hypot(h, r);
      out.leastRows = kTipRows;
      out.row = [=](double t) { return Row{t, V3d(r * (1 - t), 0, t * h), V3d(h, 0, r) * sign(r)}; };
      break;
    }
    case Quadric::Kind::Cylinder: {
      const double r = a[0], z0 = a[1], z1 = a[2];
      thetaDegrees = a[3];
      if (r == 0) return "its radius is 0";
      if (z0 == z1) return "its zmin and zmax are the same";
      out.radius = std::abs(r);
      out.vLength = std::abs(z1 - z0);
      out.row = [=](double t) { return Row{t, V3d(r, 0, lerp(z0, z1, t)), V3d(sign(r * (z1 - z0)), 0, 0)}; };
      break;
    }
    case Quadric::Kind::Hyperboloid: {
      const V3d p1(a[0], a[1], a[2]), p2(a[3], a[4], a[5]), d = p2 - p1;
      thetaDegrees = a[6];
      const double r1 = std::hypot(p1.x, p1.y), r2 = std::hypot(p2.x, p2.y);
      if (p1 == p2) return "its two points are the same";
      if (r1 == 0 && r2 == 0) return "its line lies on the axis";
      out.radius = std::max(r1, r2);
      out.vLength = d.length();
      // A skew line sweeps a curved profile: it turns by the angle between the two ends as seen along the axis.
      const double skew = std::atan2(std::abs(p1.x * p2.y - p1.y * p2.x), p1.x * p2.x + p1.y * p2.y);
      out.vAngle = 2 * skew;
      out.vRadius = skew > 0 ? out.radius : 0;
      out.leastRows = r1 == 0 || r2 == 0 ? kTipRows : 1;
      out.row = [=](double t) {
        const V3d p = t == 1 ? p2 : p1 + d * t;
        V3d n(p.x * d.z, p.y * d.z, -(p.x * d.x + p.y * d.y));
        // On the axis the cross product vanishes; its limit is taken from the side on which the surface is.
        if (p.x == 0 && p.y == 0) n = V3d(d.x * d.z, d.y * d.z, -(d.x * d.x + d.y * d.y)) * (t > 0.5 ? -1 : 1);
        return Row{t, p, n};
      };
      break;
    }
    case Quadric::Kind::Paraboloid: {
      const double r = a[0], z0 = a[1], z1 = a[2];
      thetaDegrees = a[3];
      if (r == 0) return "its radius is 0";
      if (z1 == 0) return "its zmax is 0";
      if (z0 == z1) return "its zmin and zmax are the same";
      if (z0 / z1 < 0) return "its zmin and zmax lie on both sides of 0";
      const double s0 = std::sqrt(z0 / z1), k = r * r / (2 * z1);
      out.radius = std::abs(r) * std::max(1.0, s0);
      out.vAngle = std::abs(std::atan(std::abs(r / k)) - std::atan(std::abs(r * s0 / k)));
      out.vRadius = std::max(std::abs(k), out.radius);
      out.row = [=](double t) {
        // Even steps of the radius, not of v: near the tip v runs with its square.
        const double s = lerp(s0, 1, t), z = t == 0 ? z0 : t == 1 ? z1 : z1 * s * s;
        return Row{t == 1 ? 1.0 : (z - z0) / (z1 - z0), V3d(r * s, 0, z),
                   V3d(std::abs(r) * s, 0, -k) * sign(z1 - z0)};
      };
      break;
    }
    case Quadric::Kind::Disk: {
      const double h = a[0], r = a[1];
      thetaDegrees = a[2];
      if (r == 0) return "its radius is 0";
      out.radius = std::abs(r);
      out.vLength = std::abs(r);
      out.leastRows = kTipRows;
      out.row = [=](double t) { return Row{t, V3d(r * (1 - t), 0, h), V3d(0, 0, 1)}; };
      break;
    }
    case Quadric::Kind::Torus: {
      const double major = a[0], minor = a[1];
      double p0 = a[2], p1 = a[3];
      thetaDegrees = a[4];
      if (minor == 0) return "its minor radius is 0";
      if (p0 == p1) return "its phimin and phimax are the same";
      if (std::abs(p1 - p0) > 360) p1 = p0 + 360 * sign(p1 - p0);
      out.radius = std::abs(major) + std::abs(minor);
      out.vRadius = std::abs(minor);
      out.vAngle = std::abs(p1 - p0) * kDegrees;
      out.closedV = std::abs(p1 - p0) == 360;
      out.row = [=, closed = out.closedV](double t) {
        double c, s;
        exactTurn(t == 1 ? (closed ? p0 : p1) : lerp(p0, p1, t), c, s);
        const double x = major + minor * c;
        return Row{t, V3d(x, 0, minor * s), V3d(c, 0, s) * sign(x) * sign(minor) * sign(p1 - p0)};
      };
      break;
    }
  }
  return {};
}

// The finest edge over a few points of the surface.
double finestEdge(const Profile& profile, const DiceRate& rate) {
  double edge = std::numeric_limits<double>::infinity();
  for (int j = 0; j <= 4; ++j) {
    const Row row = profile.row(j / 4.0);
    for (int i = 0; i <= 8; ++i) {
      const double theta = profile.thetaMax * i / 8, c = std::cos(theta), s = std::sin(theta);
      edge = std::min(edge, rate.at(V3d(row.p.x * c - row.p.y * s, row.p.x * s + row.p.y * c, row.p.z)));
    }
  }
  return edge;
}

// The arguments at every deformation key: those of the request, then those that the keys say (see scene::Quadric).
std::vector<Quadric> quadricKeys(const scene::Primitive& primitive, const Quadric& first, Diagnostics& diagnostics) {
  std::vector<Quadric> keys{first};
  bool moves = false, good = primitive.times.size() == primitive.motion.size() + 1;
  for (size_t k = 1; good && k < primitive.times.size(); ++k) {
    good = primitive.times[k] > primitive.times[k - 1];
    Quadric q = first;
    if (const scene::Parameter* p = primitive.motion[k - 1].find("__quadric"))
      std::copy_n(p->floats.begin(), std::min(p->floats.size(), q.args.size()), q.args.begin());
    moves |= q.args != first.args;
    keys.push_back(q);
  }
  if (!good && !primitive.motion.empty())
    diagnostics.warning("GEOM-MOTION-MISMATCH", primitive.pos,
                        subject(primitive) + ": its motion times do not increase or do not match its keys",
                        "only the first key is used");
  if (!moves || !good) keys.resize(1);
  return keys;
}

// One key, ready to be laid out: its profile cut into rows and its sweep into columns.
struct Key {
  Profile profile;
  double degrees = 0;
  std::vector<Row> rows;
};

}  // namespace

bool makeQuadric(const scene::Primitive& primitive, const Quadric& quadric, const DiceRate& rate,
                 Diagnostics& diagnostics, Mesh& mesh) {
  std::vector<Key> keys;
  for (const Quadric& q : quadricKeys(primitive, quadric, diagnostics)) {
    Key key;
    const bool finite = std::all_of(q.args.begin(), q.args.end(), [](float f) { return std::isfinite(f); });
    std::string wrong = finite ? profileOf(q, key.profile, key.degrees) : "an argument is not finite";
    if (wrong.empty() && key.degrees == 0) wrong = "its thetamax is 0";
    if (!wrong.empty() && !keys.empty()) {
      diagnostics.warning("GEOM-MOTION-MISMATCH", primitive.pos,
                          subject(primitive) + " cannot be used at a later motion key: " + wrong,
                          "only the first key is used");
      keys.resize(1);
      break;
    }
    if (!finite) {
      diagnostics.error("GEOM-NOT-FINITE", primitive.pos, subject(primitive) + ": " + wrong,
                        "the primitive is left out");
      return false;
    }
    if (!wrong.empty()) {
      diagnostics.warning("GEOM-ZERO-AREA", primitive.pos, subject(primitive) + " has no area: " + wrong,
                          "the primitive is left out");
      return false;
    }
    // Further turns would cover the first one again.
    if (std::abs(key.degrees) > 360) key.degrees = 360 * sign(key.degrees);
    key.profile.thetaMax = key.degrees * kDegrees;
    keys.push_back(std::move(key));
  }

  const bool displaced = rate.isDisplaced;
  int nu = 1, nv = 1;
  for (const Key& key : keys) {
    const Profile& p = key.profile;
    const double edge = finestEdge(p, rate);
    nu = std::max(nu, arcSegments(p.thetaMax, p.radius, edge, displaced));
    if (p.vRadius > 0) nv = std::max(nv, arcSegments(p.vAngle, p.vRadius, edge, displaced));
    if (displaced && p.vLength > 0) nv = std::max(nv, int(std::clamp(p.vLength / edge, 1.0, 1e6)));
    nv = std::max(nv, std::isfinite(edge) ? std::min(p.leastRows, nu) : p.leastRows);
    if (std::abs(key.degrees) == 360) nu = std::max(nu, 3);
    if (p.closedV) nv = std::max(nv, 3);
  }
  capGrid(nu, nv, rate.maxTriangles);

  std::vector<char> tip(size_t(nv) + 1, 1);
  for (Key& key : keys)
    for (int j = 0; j <= nv; ++j) {
      key.rows.push_back(key.profile.row(j == nv ? 1.0 : double(j) / nv));
      tip[j] &= key.rows[j].tip();
    }

  const size_t columns = size_t(nu) + 1, vertices = columns * (size_t(nv) + 1);
  std::vector<V3d> points;
  points.reserve(vertices * keys.size());
  mesh.vertexUV.reserve(vertices);
  Primvar normals = Primvar::normals();
  normals.data.reserve(vertices * keys.size() * 3);
  std::vector<double> cosines(columns * 2), sines(columns * 2);  // at the columns, then between them
  for (const Key& key : keys) {
    // Column nu of a closed quadric is column 0: its seam has the same floats on both sides.
    const bool closed = std::abs(key.degrees) == 360;
    for (int i = 0; i <= nu; ++i) {
      exactTurn(closed && i == nu ? 0 : key.degrees * i / nu, cosines[i], sines[i]);
      exactTurn(key.degrees * std::min<double>(i + 0.5, nu) / nu, cosines[columns + i], sines[columns + i]);
    }
    const double side = sign(key.degrees) * (mesh.flipNormals ? -1 : 1);
    for (int j = 0; j <= nv; ++j) {
      const Row& row = key.rows[j];
      const V3d n = row.n.normalized() * side;
      for (int i = 0; i <= nu; ++i) {
        // At a tip every wedge has its own vertex, at the middle of its u.
        const size_t turn = tip[j] ? columns + i : i;
        const double c = cosines[turn], s = sines[turn];
        points.emplace_back(row.p.x * c - row.p.y * s, row.p.x * s + row.p.y * c, row.p.z);
        normals.data.push_back(float(n.x * c - n.y * s));
        normals.data.push_back(float(n.x * s + n.y * c));
        normals.data.push_back(float(n.z));
        if (&key == &keys[0])
          mesh.vertexUV.emplace_back(float(tip[j] ? std::min(1.0, (i + 0.5) / nu) : double(i) / nu), float(row.v));
      }
    }
  }
  if (keys.size() > 1) mesh.times = primitive.times;
  storePoints(points, keys.size(), mesh);

  mesh.indices.reserve(size_t(nu) * nv * 6);
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      const uint32_t a = uint32_t(j * columns + i), b = a + 1, d = uint32_t(a + columns), c = d + 1;
      if (!tip[j]) mesh.indices.insert(mesh.indices.end(), {a, b, tip[j + 1] ? d : c});
      if (!tip[j + 1]) mesh.indices.insert(mesh.indices.end(), {a, c, d});
    }
  mesh.faceOfTriangle.assign(mesh.triangleCount(), 0);
  mesh.quads = true;

  finishSurface(primitive, std::move(normals), diagnostics, mesh);
  return true;
}

}  // namespace kinora::geometry
