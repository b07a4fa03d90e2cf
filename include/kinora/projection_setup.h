// Set-up shared by the projections with a lens: fov, depth of field, shift and roll from their parameters. Plain code
// that runs once, before rendering; included before <kinora/simd/foreach_target.h>. It makes no rays
// (projection_author.h does).
#pragma once
#include <kinora/named_values.h>
#include <kinora/projection.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace kinora {

// The raster's place on the screen plane.
struct ScreenMap {
  float left = -1, top = 1, stepX = 0, stepY = 0;  // x = left + stepX * raster x, y = top - stepY * raster y
  float width = 1, height = 1;                     // of the raster, pixels
  float cosRoll = 1, sinRoll = 0;                  // the screen, turned about the view axis

  // Throws for guardedCreate where no picture is possible.
  static ScreenMap of(const ProjectionInfo* info) {
    if (!info) throw "a projection needs to know the picture's resolution";
    ScreenMap m;
    if (info->resolution[0] == 0 || info->resolution[1] == 0) throw "the picture has no pixels";
    m.width = float(info->resolution[0]);
    m.height = float(info->resolution[1]);
    double l = info->screenWindow[0], r = info->screenWindow[1], b = info->screenWindow[2], t = info->screenWindow[3];
    if (!info->screenWindowGiven) {
      // the shorter side spans -1 to 1
      const double aspect = info->frameAspect;
      if (!(aspect > 0) || !(aspect < 1e9)) throw "the frame's aspect ratio is not a positive number";
      r = aspect > 1 ? aspect : 1;
      t = aspect > 1 ? 1 : 1 / aspect;
      l = -r;
      b = -t;
    }
    if (!(l != r) || !(b != t) || !(l - l == 0) || !(r - r == 0) || !(b - b == 0) || !(t - t == 0))
      throw "the screen window has no area";
    m.left = float(l);
    m.top = float(t);
    m.stepX = float((r - l) / m.width);
    m.stepY = float((t - b) / m.height);
    return m;
  }
  // Screen area of a pixel.
  float pixelArea() const { return stepX * stepY < 0 ? -stepX * stepY : stepX * stepY; }
};

// The shape and density of a lens that is no even disk, as tables of its inverse distributions. In polar coordinates
// (rho R(angle), angle) the two are drawn apart: the angle by R^2, which is the area of a slice, rho by rho times the
// density 1 + slope (2 rho - 1).
struct Aperture {
  static constexpr int kSteps = 1024;
  bool isShaped = false;                      // false: an even disk, stretched by `stretch`
  float sides = 0, angle = 0, roundness = 1;  // radians to the middle of the first side
  float inset = 1;                            // of a straight side from the middle: cos(pi / sides)
  float stretch = 1;                          // of x
  float side[kSteps + 2] = {};                // angle off a side's middle, by its share of the side
  float rho[kSteps + 2] = {};                 // by the root of its share: straight near 0 for an even density

  // Distance of the edge in units of the lens's radius.
  double edge(double off) const { return sides < 3 ? 1 : 1 + (inset / std::cos(off) - 1) * (1 - double(roundness)); }

  static Aperture of(const ProjectionInfo& info) {
    constexpr double kPi = 3.14159265358979323846;
    const auto within = [](float x, double least, double most) {
      return x == x ? std::fmin(most, std::fmax(least, double(x))) : 0;
    };
    Aperture a;
    if (info.apertureAspect > 0 && std::isfinite(info.apertureAspect)) a.stretch = 1 / info.apertureAspect;
    const double slope = within(info.apertureDensity, -1, 1);
    a.sides = float(std::floor(within(info.apertureSides, 0, 1000)));
    a.roundness = float(within(info.apertureRoundness, -1, 1));
    const bool hasSides = a.sides >= 3 && a.roundness < 1;
    a.isShaped = hasSides || slope != 0;
    if (!a.isShaped) return a;
    if (!hasSides) {
      a.sides = 1;
    } else {
      a.inset = float(std::cos(kPi / a.sides));
      a.angle = float(within(info.apertureAngle, -1e6, 1e6) * kPi / 180 + kPi / a.sides);
    }
    const double half = kPi / a.sides;
    constexpr int kFine = 16;  // of the integral, in each step of the tables
    std::vector<double> sum(kSteps * kFine + 1, 0.0);
    const auto invert = [&](double low, double high, const auto& density, const auto& shareAt, float* out) {
      const int n = kSteps * kFine;
      for (int i = 0; i < n; ++i) sum[size_t(i) + 1] = sum[size_t(i)] + density(low + (high - low) * (i + 0.5) / n);
      int k = 0;
      for (int i = 0; i <= kSteps; ++i) {
        const double want = sum.back() * shareAt(double(i) / kSteps);
        while (k + 1 < n && sum[size_t(k) + 1] < want) ++k;
        const double step = sum[size_t(k) + 1] - sum[size_t(k)];
        const double part = step > 0 ? std::fmin(1, std::fmax(0, (want - sum[size_t(k)]) / step)) : 0;
        out[i] = float(low + (high - low) * (k + part) / n);
      }
      out[kSteps + 1] = out[kSteps];  // read beside the last one, with weight 0
    };
    invert(
        -half, half, [&](double off) { return a.edge(off) * a.edge(off); }, [](double s) { return s; }, a.side);
    invert(
        0, 1, [&](double r) { return r * (1 + slope * (2 * r - 1)); }, [](double s) { return s * s; }, a.rho);
    return a;
  }
};

struct ThinLens {
  ScreenMap screen;
  Aperture aperture;
  float halfFov[2] = {0.7853981634f, 0.7853981634f};  // radians, at shutter open and close
  float scale = 1;                                    // screen units at unit distance: tan(halfFov[0])
  bool zooms = false;
  float lensRadius = 0;
  float sharp[3] = {0, 0, 1};       // the plane of focus: points X of camera space with dot(sharp, X) = 1
  float nearClip = 0, farClip = 0;  // z; 0 0: none
};

// ProjectionTraits::ndcMatrix of a screen that lies `perScreen` units of camera space a screen unit wide: at distance
// 1 of a perspective, anywhere of parallel rays.
inline void screenToNdc(const ScreenMap& m, double perScreen, bool isPerspective, double out[16]) {
  for (int i = 0; i < 16; ++i) out[i] = 0;
  const double width = double(m.stepX) * double(m.width), height = double(m.stepY) * double(m.height);
  const double c = double(m.cosRoll) / perScreen, s = double(m.sinRoll) / perScreen;
  out[0] = c / width;
  out[4] = s / width;
  out[1] = s / height;
  out[5] = -c / height;
  const int corner = isPerspective ? 8 : 12;  // the row of z, by which x and y are divided, or that of 1
  out[corner] = -double(m.left) / width;
  out[corner + 1] = double(m.top) / height;
  out[10] = 1;
  out[isPerspective ? 11 : 15] = 1;
}
inline void perspectiveMatrix(const ThinLens& k, double out[16]) {
  screenToNdc(k.screen, std::tan(0.5 * (double(k.halfFov[0]) + double(k.halfFov[1]))), true, out);
  out[14] = k.nearClip > 0 ? -double(k.nearClip) : -1;  // depth 1 - near / z: no far plane
}

// The lens of PxrPerspective and PxrCamera; values by the names of projectionParams::kLens.
inline void setLens(ThinLens& k, const NamedValues& v, const ProjectionInfo& info) {
  constexpr double kRadians = 3.14159265358979323846 / 180;
  const auto fovOf = [&](const char* name, double otherwise) {
    const double fov = v.number(name);
    if (fov > 0 && fov < 179.9) return fov;
    v.warn("PROJECTION-FOV", std::string(name) + " lies outside 0 to 180 degrees", "another value is used");
    return otherwise;
  };
  const double fov = fovOf("fov", 90), end = v.number("fovEnd") == 0 ? fov : fovOf("fovEnd", fov);
  k.halfFov[0] = float(fov * kRadians / 2);
  k.halfFov[1] = float(end * kRadians / 2);
  k.scale = float(std::tan(fov * kRadians / 2));
  k.zooms = end != fov;
  // each value given here replaces that of the DepthOfField request; without a request the defaults fill the others
  const bool requested = info.fStop > 0;
  const auto value = [&](const char* name, float fromRequest) {
    return v.given(name) || !requested ? v.number(name) : double(fromRequest);
  };
  const double fStop = value("fStop", info.fStop), length = value("focalLength", info.focalLength);
  const double distance = value("focalDistance", info.focalDistance);
  const double radius = fStop > 0 ? length / (2 * fStop) : 0;  // an infinite fStop is a pinhole
  if (radius > 0 && std::isfinite(radius) && distance > 1e-9 && distance < 1e30) {
    k.lensRadius = float(radius);
    k.sharp[2] = float(1 / distance);
  } else if (!(radius >= 0 && std::isfinite(radius)) || (radius > 0 && !(distance > 1e-9))) {
    v.warn("PROJECTION-LENS", "depth of field needs positive numbers for fStop, focalLength and focalDistance",
           "everything is sharp");
  }
  if (k.lensRadius > 0) k.aperture = Aperture::of(info);
  k.nearClip = info.clipping[0];
  k.farClip = info.clipping[1];
}

// The plane of focus through three points of world space (three of three numbers), instead of one that faces the
// camera. False: they lie on a line, in a plane through the lens, or the camera's place is not known.
inline bool setPlaneOfFocus(ThinLens& k, const double points[9], const ProjectionInfo& info) {
  double p[3][3];
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 3; ++c) {
      p[i][c] = info.worldToCamera[12 + c];
      for (int r = 0; r < 3; ++r) p[i][c] += points[3 * i + r] * info.worldToCamera[4 * r + c];
    }
  double a[3], b[3], n[3];
  for (int c = 0; c < 3; ++c) {
    a[c] = p[1][c] - p[0][c];
    b[c] = p[2][c] - p[0][c];
  }
  double size = 0, along = 0;
  for (int c = 0; c < 3; ++c) {
    n[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
    size += n[c] * n[c];
    along += n[c] * p[0][c];
  }
  const auto square = [](const double* v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
  if (!(size > 1e-12 * square(a) * square(b)) || !(along * along > 1e-12 * size)) return false;
  // where the plane cuts the lens, a point of the picture has no one direction
  const double farthest = double(k.lensRadius) * std::fmax(1, k.aperture.stretch);
  if (!(std::hypot(n[0], n[1]) * farthest < 0.99 * std::abs(along))) return false;
  for (int c = 0; c < 3; ++c) k.sharp[c] = float(n[c] / along);
  return true;
}

}  // namespace kinora

namespace kinora::projectionParams {
inline constexpr std::array kLens = {
    param::number("fov", 90.f).range(1, 170).help("Degrees over the shorter side of the default screen window."),
    param::number("fovEnd", 0.f).range(0, 170).help("fov when the shutter closes, degrees; 0 is no zoom."),
    param::number("fStop", 16.f).range(0.5f, 64).help("Focal length over the diameter of the lens."),
    param::number("focalLength", 0.f).help("Of the lens, in units of camera space; 0 is a pinhole."),
    param::number("focalDistance", 1.f)
        .range(0.1f, 100)
        .help("Distance of the plane of focus along the view axis, in units of camera space."),
};
}  // namespace kinora::projectionParams
