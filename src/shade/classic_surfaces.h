// Surface shaders of the shading-language age as networks of stock plug-ins: the standard surfaces of the RenderMan
// Interface by one table, shaders that nobody here knows by words in their names and by parameters that many share
// (Kd, Ks, roughness, specularcolor, texturename ...). Called by render/materials.cpp. It runs no shader.
#pragma once
#include <array>
#include <string>

#include "scene/scene.h"

namespace kinora::shade {

// What decides an object's material where no Bxdf is bound.
struct ClassicLook {
  const scene::Node* surface = nullptr;     // null: none is bound
  const scene::Node* atmosphere = nullptr;  // fog or depthcue; see isAtmosphere()
  std::array<float, 2> clipping{0, 0};      // of the camera: depth 0 and 1
  std::array<float, 3> opacity{1, 1, 1};
  bool hasColor = false;                  // Color, or a primitive variable Cs
  bool hasOpacities = false;              // a primitive variable Os
  std::array<float, 3> ambient{0, 0, 0};  // sum of the ambient lights that shine on it
};

struct ClassicMaterial {
  scene::NetworkPtr network;
  std::string standIn;  // what stands in for a shader that is not one of the standard ones; empty: it is one
};

// Color, and Cs of primitives, reach the network as the primitive variable Cs.
ClassicMaterial classicMaterial(const ClassicLook& look);

// Whether a shader is one of the Atmosphere shaders that classic materials know: they fade a surface by
// the length of the ray that meets it, not what stands behind it.
bool isAtmosphere(const scene::Node& shader);

}  // namespace kinora::shade
