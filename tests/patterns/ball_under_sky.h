// The scene that tests of layered materials look at: a ball of the material under a bright sky.
#pragma once
#include <string>

#include "support/render_scene.h"

namespace kinora::tests {

inline RenderRequest ballUnderSky(const std::string& material) {
  RenderRequest r;
  r.rib = R"(Format 24 16 1
Hider "raytrace" "int maxsamples" [4]
Projection "perspective" "float fov" [40]
WorldBegin
Light "PxrDomeLight" "sky" "color lightColor" [0.8 0.9 1]
Translate 0 0 3
)" + material +
          "Sphere 1 -1 1 360\nWorldEnd\n";
  return r;
}

}  // namespace kinora::tests
