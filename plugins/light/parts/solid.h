// What lights have in common that are the closed surface of a body, placed by any affine map: how they are placed, and
// what is said of them.
#pragma once
#include <kinora/light_setup.h>

#include <cmath>

namespace kinora::lightParts {

struct SolidFrame {
  Double3 rows[3];     // local to render, linear part
  Double3 inverse[3];  // render to local: rows of the inverse
  Double3 normals[3];  // local normal to render: rows of the inverse transpose
  double lengths[3], longest, determinant;
  bool isDegenerate;  // then the inverse means nothing

  explicit SolidFrame(const LocalFrame& f)
      : rows{f.x, f.y, f.z}, lengths{length(f.x), length(f.y), length(f.z)}, determinant(f.determinant()) {
    longest = std::fmax(lengths[0], std::fmax(lengths[1], lengths[2]));
    // thinner than a millionth of its size, single precision no longer tells its sides apart
    isDegenerate =
        !(std::fabs(determinant) > 1e-36) || !(std::fabs(determinant) > 1e-6 * longest * longest * longest);
    if (isDegenerate) return;
    normals[0] = cross(f.y, f.z) * (1 / determinant);
    normals[1] = cross(f.z, f.x) * (1 / determinant);
    normals[2] = cross(f.x, f.y) * (1 / determinant);
    inverse[0] = {normals[0].x, normals[1].x, normals[2].x};
    inverse[1] = {normals[0].y, normals[1].y, normals[2].y};
    inverse[2] = {normals[0].z, normals[1].z, normals[2].z};
  }
  // Whether the placement keeps the shape, but for its size.
  bool keepsShape() const {
    return std::fabs(lengths[0] - lengths[1]) < 1e-6 * lengths[0] &&
           std::fabs(lengths[0] - lengths[2]) < 1e-6 * lengths[0] &&
           std::fabs(dot(rows[0], rows[1])) + std::fabs(dot(rows[1], rows[2])) + std::fabs(dot(rows[2], rows[0])) <
               1e-6 * lengths[0] * lengths[0];
  }
  // Into a light's own members.
  template <class Data>
  void place(Data& light) const {
    for (int i = 0; i < 3; ++i) {
      light.rows[i] = Float3(rows[i]);
      light.inverse[i] = Float3(inverse[i]);
      light.normalRows[i] = Float3(normals[i]);
    }
    light.determinant = float(std::fabs(determinant));
    light.axis = Float3(normalized(rows[2]));
  }
  // `units` of a local direction's last digits, after it went to render space and back.
  float rounding(double units) const {
    const double shrink = std::fmax(length(inverse[0]), std::fmax(length(inverse[1]), length(inverse[2])));
    return float(units * std::fmin(longest * shrink, 100));
  }
};

// With the area known: what the light's parameters say, or that it has no volume.
template <class Data>
void setSolidLight(const NamedValues& values, const SolidFrame& frame, Data& light) {
  light.common = LightCommon::of(values, light.area);
  light.shaping = Shaping::of(values, true);
  values.warnNoEffect();
  if (frame.isDegenerate)
    values.warn("LIGHT-DEGENERATE", "the light's transformation leaves it no volume", "the light is black");
  else
    light.isBlack = light.common.isBlack();
}
template <class Data>
void describeSolidLight(const void* data, LightDescription* d) {
  const Data& k = *static_cast<const Data*>(data);
  *d = describeSurfaceLight(k.common, k.shaping, k.isBlack, k.center, k.boundingRadius * (1 + 1e-6), k.area);
  describeClosedEmission(*d, k.shaping, {k.axis.x, k.axis.y, k.axis.z});
}

}  // namespace kinora::lightParts
