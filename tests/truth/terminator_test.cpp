// Proves: softened shadow lines (geomShadowTermBias) leave rooms as they are: furniture whose normals were averaged
// over hard edges, bevelled and rounded furniture, lamps close under ceilings; and what lies between a facet and the
// surface that its normals mean keeps its shadow. What they are for, the shadow line of a coarse ball, is in
// masks_test.cpp.
#include <gtest/gtest.h>

#include <Imath/ImathVec.h>

#include <cmath>
#include <sstream>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

using Imath::V3d;

// Faces with normals at vertices, each the mean of its faces' as modellers export them.
struct Furniture {
  std::vector<V3d> points;
  std::vector<std::vector<int>> faces;

  // Turned so that it winds about the outward direction.
  void face(std::vector<int> f, const V3d& outward) {
    if (normalOf(f).dot(outward) < 0) std::reverse(f.begin(), f.end());
    faces.push_back(std::move(f));
  }
  V3d normalOf(const std::vector<int>& f) const {
    return (points[size_t(f[1])] - points[size_t(f[0])])
        .cross(points[size_t(f[2])] - points[size_t(f[0])])
        .normalized();
  }
  std::string rib() const {
    std::vector<V3d> normals(points.size(), V3d(0));
    std::ostringstream counts, indices, p, n;
    for (const auto& f : faces) {
      counts << f.size() << " ";
      for (int v : f) {
        indices << v << " ";
        normals[size_t(v)] += normalOf(f);
      }
    }
    for (size_t i = 0; i < points.size(); ++i) {
      const V3d m = normals[i].normalized();
      p << points[i].x << " " << points[i].y << " " << points[i].z << " ";
      n << m.x << " " << m.y << " " << m.z << " ";
    }
    return "PointsPolygons [" + counts.str() + "] [" + indices.str() + "] \"vertex point P\" [" + p.str() +
           "] \"vertex normal N\" [" + n.str() + "]\n";
  }
};

// Corners of a box in -1..1 by bits: 1 x, 2 y, 4 z.
V3d cornerOf(int bits) { return {bits & 1 ? 1. : -1., bits & 2 ? 1. : -1., bits & 4 ? 1. : -1.}; }

Furniture box() {
  Furniture m;
  for (int c = 0; c < 8; ++c) m.points.push_back(cornerOf(c));
  for (int axis = 0; axis < 3; ++axis)
    for (int far = 0; far < 2; ++far) {
      const int a = 1 << axis, b = 1 << (axis + 1) % 3, c = 1 << (axis + 2) % 3, first = far * a;
      V3d outward(0);
      outward[axis] = far ? 1 : -1;
      m.face({first, first + b, first + b + c, first + c}, outward);
    }
  return m;
}

// A box whose edges and corners are cut off: vertex 3 * corner + axis lies on the side that the axis looks along.
Furniture bevelledBox(double cut) {
  Furniture m;
  for (int c = 0; c < 8; ++c)
    for (int axis = 0; axis < 3; ++axis) {
      V3d p = cornerOf(c) * (1 - cut);
      p[axis] /= 1 - cut;
      m.points.push_back(p);
    }
  for (int axis = 0; axis < 3; ++axis) {
    const int axis1 = (axis + 1) % 3, axis2 = (axis + 2) % 3, a = 1 << axis, b = 1 << axis1, c = 1 << axis2;
    for (int far = 0; far < 2; ++far) {
      V3d outward(0);
      outward[axis] = far ? 1 : -1;
      const auto at = [&](int bits) { return 3 * (far * a + bits) + axis; };
      m.face({at(0), at(b), at(b + c), at(c)}, outward);
    }
    for (int k = 0; k < 4; ++k) {  // the edge along this axis
      const int bits = (k & 1 ? b : 0) + (k & 2 ? c : 0);
      V3d outward = cornerOf(bits);
      outward[axis] = 0;
      m.face({3 * bits + axis1, 3 * (bits + a) + axis1, 3 * (bits + a) + axis2, 3 * bits + axis2}, outward);
    }
  }
  for (int c = 0; c < 8; ++c) m.face({3 * c, 3 * c + 1, 3 * c + 2}, cornerOf(c));
  return m;
}

// A column of 12 sides with its ends in the same mesh: normals at its rims lean by 45 degrees.
Furniture column() {
  constexpr int kSides = 12;
  Furniture m;
  std::vector<int> low, high;
  for (int i = 0; i < kSides; ++i) {
    const double a = 2 * 3.14159265358979 * i / kSides;
    low.push_back(2 * i);
    high.push_back(2 * i + 1);
    for (double y : {-1., 1.}) m.points.push_back({std::cos(a), y, std::sin(a)});
  }
  for (int i = 0; i < kSides; ++i) {
    const int j = (i + 1) % kSides;
    m.face({2 * i, 2 * i + 1, 2 * j + 1, 2 * j}, m.points[size_t(2 * i)] + m.points[size_t(2 * j + 1)]);
  }
  m.face(low, V3d(0, -1, 0));
  m.face(high, V3d(0, 1, 0));
  return m;
}

// Placed at x, z on the floor.
std::string stand(const Furniture& m, double x, double z, double turn, const V3d& size) {
  std::ostringstream s;
  s << "AttributeBegin Translate " << x << " " << size.y - 1.2 << " " << z << " Rotate " << turn << " 0 1 0 Scale "
    << size.x << " " << size.y << " " << size.z << "\n"
    << m.rib() << "AttributeEnd\n";
  return s.str();
}

std::string white() { return "Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [.7 .7 .7]\n"; }

// Rooms around the camera: closed with a lamp close under the ceiling, or with the sun and the sky through a wall
// that is left out. Lights are not seen themselves.
enum class Room { Lamp, Window };

// Means of Ci with softened shadow lines over those without; `walls`: whether the camera sees them.
double softenedOverPlain(Room room, const std::string& furniture, bool walls) {
  double mean[2];
  for (int on = 0; on < 2; ++on) {
    RenderRequest r;
    r.rib =
        "Format 32 32 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [256] \"int "
        "geomShadowTermBias\" [" +
        std::to_string(on) + "]\nProjection \"perspective\" \"fov\" [60]\n" + unbiased(3) +
        "WorldBegin\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\n";
    r.rib += room == Room::Lamp ? "AttributeBegin Translate 0.2 1.15 3 Rotate 90 1 0 0 Scale 1.5 1.5 1 Light "
                                  "\"PxrRectLight\" \"lamp\" \"float intensity\" [10] AttributeEnd\n"
                                : "AttributeBegin Rotate 70 0 1 0 Rotate 30 1 0 0 Light \"PxrDistantLight\" \"sun\" "
                                  "\"float intensity\" [5] \"int areaNormalize\" [1] \"float angleExtent\" [0.5] "
                                  "AttributeEnd\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n";
    r.rib += "AttributeEnd\n" + white() + "AttributeBegin Attribute \"visibility\" \"int camera\" [" +
             (walls ? "1" : "0") + "]\nTranslate 0 0 2 Scale 2 1.2 3\n";
    const Furniture around = box();
    for (const auto& f : around.faces) {
      const V3d outward = cornerOf(f[0]) + cornerOf(f[2]);
      if (room == Room::Window && outward.x < 0) continue;
      // walls are flat: no normals of their own
      std::ostringstream p;
      for (int v : f) p << cornerOf(v).x << " " << cornerOf(v).y << " " << cornerOf(v).z << " ";
      r.rib += "Polygon \"vertex point P\" [" + p.str() + "]\n";
    }
    r.rib += "AttributeEnd\n" + furniture + "WorldEnd\n";
    SceneRender render(r);
    mean[on] = overPixels(render.channel("Ci")).mean();
  }
  EXPECT_GT(mean[0], 0);
  return mean[1] / mean[0];
}

std::string lockers() {
  std::string out;
  for (int i = 0; i < 6; ++i) out += stand(box(), -1.5 + 0.6 * i, 3.6, 0, {0.29, 0.9, 0.4});
  return out;
}
std::string shelf(double x, double z) {
  std::string out;
  for (int i = 0; i < 6; ++i)
    out += "AttributeBegin Translate 0 " + std::to_string(0.3 * i) + " 0\n" +
           stand(box(), x, z, 0, {0.7, 0.02, 0.4}) + "AttributeEnd\n";
  return out;
}

TEST(ShadowTerminator, FurnishedRoomsStay) {
  for (const Room room : {Room::Lamp, Room::Window}) {
    const std::string of = room == Room::Lamp ? "lamp" : "window";
    EXPECT_NEAR(softenedOverPlain(room, lockers() + shelf(0, 2.6), true), 1, 0.01) << of;
    EXPECT_NEAR(softenedOverPlain(room,
                                  stand(box(), -0.9, 3.4, 20, {0.5, 0.6, 0.5}) +
                                      stand(bevelledBox(0.1), 0.9, 3.2, -30, {0.6, 0.4, 0.4}) +
                                      stand(column(), 0.1, 3.9, 0, {0.3, 0.9, 0.3}),
                                  true),
                1, 0.01)
        << of;
  }
}

TEST(ShadowTerminator, AveragedNormalsStay) {
  const struct {
    const char* what;
    std::string furniture;
  } cases[] = {
      {"box", stand(box(), 0, 3, 25, {0.6, 0.6, 0.6})},
      {"box close to the ceiling", stand(box(), 0, 3, 25, {0.5, 1.1, 0.5})},
      {"box against a wall", stand(box(), 1.4, 3, 0, {0.59, 0.8, 0.8})},
      {"lockers side by side", lockers()},
      {"boards of a shelf", shelf(0, 3.6)},
      {"bevelled box", stand(bevelledBox(0.1), 0, 3, 25, {0.6, 0.6, 0.6})},
      {"plank with narrow bevels", stand(bevelledBox(0.02), 0, 3, 25, {1.2, 0.1, 0.3})},
      {"column", stand(column(), 0, 3, 0, {0.4, 0.8, 0.4})},
  };
  for (const Room room : {Room::Lamp, Room::Window})
    for (const auto& c : cases)
      EXPECT_NEAR(softenedOverPlain(room, c.furniture, false), 1, 0.05)
          << c.what << (room == Room::Lamp ? ", lamp" : ", window");
}

// A square in z = 0 that looks along -z, whose normals mean a dome over it: its corners' lean by 14 degrees, and
// points are lifted by up to a third.
constexpr double kRadian = 3.14159265358979 / 180;
constexpr double kSlope = 0.17632698;  // tangent of 10 degrees: per unit of x and of y
std::string dome(double slope = kSlope, double length = 1) {
  std::ostringstream p, n;
  for (const auto& [x, y] : {std::pair{-1, -1}, {-1, 1}, {1, 1}, {1, -1}}) {
    p << x << " " << y << " 0 ";
    n << x * slope * length << " " << y * slope * length << " " << -length << " ";
  }
  return white() + "PointsPolygons [4] [0 1 2 3] \"vertex point P\" [" + p.str() + "] \"vertex normal N\" [" +
         n.str() + "]\n";
}
double brightnessOfDome(int on, const std::string& light, const std::string& other,
                        const std::string& shape = dome()) {
  RenderRequest r;
  r.rib =
      "Format 32 32 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64] \"int "
      "geomShadowTermBias\" [" +
      std::to_string(on) + "]\nScreenWindow -1 1 -1 1\nProjection \"orthographic\"\n" + unbiased(0) +
      "Translate 0 0 5\nWorldBegin\n" + light + shape + "Attribute \"visibility\" \"int camera\" [0]\n" + other +
      "WorldEnd\n";
  SceneRender render(r);
  return overPixels(render.channel("Ci")).mean();
}

// From 2 degrees below the square, so that lifted points alone see it.
std::string lightFromBelow() {
  return "AttributeBegin Rotate 92 0 1 0\nLight \"PxrDistantLight\" \"l\" \"float intensity\" [1] \"int "
         "areaNormalize\" [1] \"float angleExtent\" [0.05]\nAttributeEnd\n";
}
std::string sheetOver(double height) {
  return "Translate 0 0 " + std::to_string(-height) + "\nPolygon \"vertex point P\" [-2 -2 0 -2 2 0 2 2 0 2 -2 0]\n";
}

// No sheet over the square is in that light's way: what one at some height takes are the points that would be lifted
// through it.
TEST(ShadowTerminator, NothingIsLiftedThroughOtherGeometry) {
  const std::string light = lightFromBelow();
  const double all = brightnessOfDome(1, light, "");
  ASSERT_GT(all, 0);
  EXPECT_EQ(brightnessOfDome(0, light, ""), 0) << "the scene needs the correction";
  const double normal = std::sqrt(1 + 2 * kSlope * kSlope);  // length of the corners' normals as given
  for (double height : {0.01, 0.1, 0.2, 0.3, 0.4}) {
    double below = 0, sum = 0;
    constexpr int kSteps = 400;
    for (int j = 0; j < kSteps; ++j)
      for (int i = 0; i < kSteps; ++i) {
        // of one triangle; the other is its mirror
        const double x = (i + 0.5) / kSteps * 2 - 1, y = (j + 0.5) / kSteps * 2 - 1;
        if (y > x) continue;
        const double b[3] = {(1 - x) / 2, (x - y) / 2, (1 + y) / 2};
        const double corner[3][2] = {{-1, -1}, {1, -1}, {1, 1}};
        double lift = 0;
        for (int k = 0; k < 3; ++k)
          lift += b[k] / (normal * normal) * kSlope *
                  ((corner[k][0] - x) * corner[k][0] + (corner[k][1] - y) * corner[k][1]);
        for (double side : {x, y}) {  // here, and mirrored at the diagonal
          const double cosine = (side * kSlope * std::cos(2 * kRadian) - std::sin(2 * kRadian)) /
                                std::sqrt(1 + kSlope * kSlope * (x * x + y * y));
          if (cosine > 0) (lift < height ? below : sum) += cosine;
        }
      }
    sum += below;
    const double got = brightnessOfDome(1, light, sheetOver(height)) / all;
    EXPECT_NEAR(got, below / sum, 0.02) << height;
  }
}

// A strip whose normals lean along it by 15 degrees would be lifted by two and a half of its widths. What lies within
// half of a width are the ends, beyond .89 of the way out; by the cosines there, 26 % of what the strip would get.
TEST(ShadowTerminator, NothingIsLiftedFarOffThinTriangles) {
  const auto strip = [](double half) {
    const double slope = std::tan(15 * kRadian);
    std::ostringstream p, n;
    for (const auto& [x, y] : {std::pair{-1, -1}, {-1, 1}, {1, 1}, {1, -1}}) {
      p << x << " " << y * half << " 0 ";
      n << x * slope << " 0 -1 ";
    }
    return brightnessOfDome(1, lightFromBelow(), "",
                            white() + "PointsPolygons [4] [0 1 2 3] \"vertex point P\" [" + p.str() +
                                "] \"vertex normal N\" [" + n.str() + "]\n") /
           half;
  };
  const double square = strip(1);
  ASSERT_GT(square, 0);
  EXPECT_LT(strip(0.05), 0.26 * square);
}

// The same dome however it comes: lifts follow from what is rendered, not from how it was described.
TEST(ShadowTerminator, StretchedAndMovingDomes) {
  const double want = brightnessOfDome(1, lightFromBelow(), sheetOver(0.1));
  ASSERT_GT(want, 0);
  const struct {
    const char* what;
    std::string shape;
  } cases[] = {
      {"long normals", dome(kSlope, 3)},
      {"stretched", "AttributeBegin Scale 1 1 4\n" + dome(kSlope / 4) + "AttributeEnd\n"},
      {"flattened", "AttributeBegin Scale 1 1 .25\n" + dome(4 * kSlope) + "AttributeEnd\n"},
      {"moving",
       "AttributeBegin MotionBegin [0 1] Translate 0 0 0 Translate 0 0 1e-6 MotionEnd\n" + dome() + "AttributeEnd\n"},
      {"moving, flattened", "AttributeBegin MotionBegin [0 1] Scale 1 1 .25 Scale 1 1 .250001 MotionEnd\n" +
                                dome(4 * kSlope) + "AttributeEnd\n"},
      {"moving, larger by far", "AttributeBegin MotionBegin [0 1] Scale 1 1 9 Scale 1 1 9.00001 MotionEnd\n" +
                                    dome(kSlope / 9, 3) + "AttributeEnd\n"},
      {"moving, mirrored",
       "AttributeBegin MotionBegin [0 1] Scale -1 1 1 Scale -1.000001 1 1 MotionEnd\n" + dome() + "AttributeEnd\n"},
  };
  for (const auto& c : cases)
    EXPECT_NEAR(brightnessOfDome(1, lightFromBelow(), sheetOver(0.1), c.shape) / want, 1, 0.01) << c.what;
}

// A lamp that grazes the square, with a ceiling close over it: lifted shadow rays still end at the lamp.
TEST(ShadowTerminator, LiftedRaysEndAtTheLight) {
  const std::string lamp =
      "AttributeBegin Translate 4 0 -.2 Light \"PxrRectLight\" \"lamp\" \"float intensity\" [1] "
      "AttributeEnd\n";
  const std::string ceiling = "Polygon \"vertex point P\" [3 -1 -.25 3 1 -.25 5 1 -.25 5 -1 -.25]\n";
  const double plain = brightnessOfDome(0, lamp, ceiling);
  ASSERT_GT(plain, 0);
  EXPECT_NEAR(brightnessOfDome(1, lamp, ceiling), plain, 0.01 * plain);
}

}  // namespace
}  // namespace kinora::tests
