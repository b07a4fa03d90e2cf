// The axes of a light that shines from all around: of its placement rotation and mirroring count, scale and shear do not.
#pragma once
#include <kinora/light_setup.h>

#include <cmath>

namespace kinora::lightParts {

// In render space: orthonormal, perhaps left-handed. False: the placement leaves it no directions.
inline bool setSkyAxes(const LocalFrame& f, Float3 axis[3]) {
  const Double3 z = normalized(f.z), y = normalized(normalized(f.y) - z * dot(normalized(f.y), z));
  Double3 x = cross(y, z);
  if (dot(x, f.x) < 0) x = x * -1;
  axis[0] = Float3(x);
  axis[1] = Float3(y);
  axis[2] = Float3(z);
  return length(z) > 0.5 && length(y) > 0.5 && std::fabs(dot(x, normalized(f.x))) > 1e-6;
}

inline Double3 inRender(const Float3 axis[3], Double3 local) {
  const double by[3] = {local.x, local.y, local.z};
  Double3 r;
  for (int c = 0; c < 3; ++c) r = r + Double3{axis[c].x, axis[c].y, axis[c].z} * by[c];
  return r;
}

}  // namespace kinora::lightParts
