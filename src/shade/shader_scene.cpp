#include "shade/shader_scene.h"

#include "base/diagnostics.h"

namespace kinora::shade {

ShaderScene::ShaderScene(Diagnostics& diagnostics)
    : dictionary([&diagnostics](const std::string& what) {
        diagnostics.warning("SHADER-DICTIONARY", {}, what, "nothing is found in it");
      }),
      diagnostics_(diagnostics) {}

void ShaderScene::refuseTrace() {
  if (told_.load(std::memory_order_relaxed) || told_.exchange(true)) return;
  diagnostics_.warning("SHADER-CALL", {}, "a shader calls trace(), which no integrator grants",
                       "it hits nothing and returns 0");
}

// Shaders make names while they run: of a shader that makes ever new ones the first few are told.
void ShaderScene::tellOfSpace(const char* name) {
  constexpr size_t kMost = 16;
  {
    const std::lock_guard lock(mutex_);
    if (toldSpaces_.size() >= kMost || !toldSpaces_.insert(name).second) return;
  }
  diagnostics_.warning(
      "SHADER-COORDSYS", {},
      "a shader asks for the coordinate system '" + std::string(name).substr(0, 60) + "', which nothing names",
      "what it transforms stays as it is, and getmatrix() returns 0",
      "a CoordinateSystem in the world gives the name");
}

double ShaderScene::areaOf(uint64_t object) const {
  const std::lock_guard lock(mutex_);
  const auto it = areas_.find(object);
  return it == areas_.end() ? -1 : it->second;
}
void ShaderScene::setArea(uint64_t object, double area) {
  const std::lock_guard lock(mutex_);
  areas_[object] = area;
}

}  // namespace kinora::shade
