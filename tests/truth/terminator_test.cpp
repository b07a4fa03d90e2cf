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

// A closed room around the camera with a lamp close under its ceiling: the means of Ci with softened shadow lines
// over those without, where anything is seen; `seen`: whether the camera sees the walls.
double softenedOverPlain(const std::string& furniture, bool seen) {
  double mean[2];
  for (int on = 0; on < 2; ++on) {
    RenderRequest r;
    r.rib =
        "Format 32 32 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [256] \"int "
        "geomShadowTermBias\" [" +
        std::to_string(on) + "]\nProjection \"perspective\" \"fov\" [60]\n" + unbiased(3) +
        "WorldBegin\nAttributeBegin Translate 0.2 1.15 3 Rotate -90 1 0 0 Scale 1.5 1.5 1 Light \"PxrRectLight\" "
        "\"lamp\" \"float intensity\" [10] AttributeEnd\n" +
        white() + "AttributeBegin Attribute \"visibility\" \"int camera\" [" + (seen ? "1" : "0") +
        "]\nTranslate 0 0 2 Scale 2 1.2 3\n";
    // walls are flat: no normals of their own
    for (const auto& f : box().faces) {
      r.rib += "Polygon \"vertex point P\" [";
      for (int v : f) {
        const V3d p = cornerOf(v);
        r.rib += std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + " ";
      }
      r.rib += "]\n";
    }
    r.rib += "AttributeEnd\n" + furniture + "WorldEnd\n";
    SceneRender render(r);
    mean[on] = overPixels(render.channel("Ci")).mean();
  }
  EXPECT_GT(mean[0], 0);
  fprintf(stderr, "RATIO %.5f\n", mean[1] / mean[0]);
  return mean[1] / mean[0];
}

TEST(ShadowTerminator, FurnishedRoomStays) {
  EXPECT_NEAR(softenedOverPlain(stand(box(), -0.9, 3.4, 20, {0.5, 0.6, 0.5}) +
                                    stand(bevelledBox(0.1), 0.9, 3.2, -30, {0.6, 0.4, 0.4}) +
                                    stand(column(), 0.1, 3.9, 0, {0.3, 0.9, 0.3}),
                                true),
              1, 0.01);
}

TEST(ShadowTerminator, AveragedNormalsStay) {
  const struct {
    const char* what;
    std::string furniture;
  } cases[] = {
      {"box", stand(box(), 0, 3, 25, {0.6, 0.6, 0.6})},
      {"box close to the lamp", stand(box(), 0, 3, 25, {0.5, 1.1, 0.5})},
      {"box against a wall", stand(box(), 1.4, 3, 0, {0.59, 0.8, 0.8})},
      {"bevelled box", stand(bevelledBox(0.1), 0, 3, 25, {0.6, 0.6, 0.6})},
      {"plank with narrow bevels", stand(bevelledBox(0.02), 0, 3, 25, {1.2, 0.1, 0.3})},
      {"column", stand(column(), 0, 3, 0, {0.4, 0.8, 0.4})},
  };
  for (const auto& c : cases) EXPECT_NEAR(softenedOverPlain(c.furniture, false), 1, 0.05) << c.what;
}

// One square whose normals mean a dome, lit from just below its plane, so that only its lifted points see the light:
// .1 is how far the dome's tangents stand over its middle. A sheet over it that the camera does not see is passed by
// no lift, below the dome or in the light's way; one above the dome and its light is.
TEST(ShadowTerminator, NothingIsLiftedThroughOtherGeometry) {
  const double lean = 10, pi = 3.14159265358979;
  const auto brightness = [&](int on, double above) {
    std::ostringstream dome;
    dome << "PointsPolygons [4] [0 1 2 3] \"vertex point P\" [";
    for (const V3d& p : {V3d(-1, -1, 0), V3d(-1, 1, 0), V3d(1, 1, 0), V3d(1, -1, 0)})
      dome << p.x << " " << p.y << " 0 ";
    dome << "] \"vertex normal N\" [";
    for (const V3d& p : {V3d(-1, -1, 0), V3d(-1, 1, 0), V3d(1, 1, 0), V3d(1, -1, 0)})
      dome << p.x * std::sin(lean * pi / 180) << " " << p.y * std::sin(lean * pi / 180) << " "
           << -std::cos(lean * pi / 180) << " ";
    dome << "]\n";
    RenderRequest r;
    r.rib =
        "Format 16 16 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64] \"int "
        "geomShadowTermBias\" [" +
        std::to_string(on) + "]\nScreenWindow -1 1 -1 1\nProjection \"orthographic\"\n" + unbiased(0) +
        "Translate 0 0 5\nWorldBegin\nAttributeBegin Rotate 92 0 1 0\nLight \"PxrDistantLight\" \"l\" \"float "
        "intensity\" [1000] \"float angleExtent\" [0.1]\nAttributeEnd\n" +
        white() + dome.str();
    if (above > 0)
      r.rib += "Attribute \"visibility\" \"int camera\" [0]\nTranslate 0 0 " + std::to_string(-above) +
               "\nPolygon \"vertex point P\" [-1 -1 0 -1 1 0 1 1 0 1 -1 0]\n";
    r.rib += "WorldEnd\n";
    SceneRender render(r);
    return overPixels(render.channel("Ci")).mean();
  };
  const double free = brightness(1, 0);
  fprintf(stderr, "off %g free", brightness(0, 0));
  for (double x : {0., 0.01,0.02, 0.04,.06,.08, 0.1,.12, 0.15,.2, 0.5}) fprintf(stderr, " %g:%g", x, brightness(1, x));
  ASSERT_GT(free, 0);
}

}  // namespace
}  // namespace kinora::tests
