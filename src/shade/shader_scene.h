// What shaders may ask of the scene beyond the arrays of shading: attributes of objects, the camera, dictionaries.
// Made with the world where it has shaders; read by ShaderServices on any thread.
#pragma once
#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "language/library/dictionary.h"
#include "scene/scene.h"

namespace kinora {
class Diagnostics;
namespace shade {

struct ShaderScene {
  explicit ShaderScene(Diagnostics& diagnostics);
  // By kind of placement; null: none. They live as long as the scene is not edited.
  std::vector<const scene::Attributes*> ofPlacement;
  scene::ParameterList camera;  // "camera:fov" and its kin
  language::Dictionary dictionary;
  // Says once for all threads that shaders may not trace.
  void refuseTrace();
  // Says once a name that nothing calls a coordinate system so.
  void tellOfSpace(const char* name);
  // Surface of an object, by instance and geometry; -1: not known yet.
  double areaOf(uint64_t object) const;
  void setArea(uint64_t object, double area);

 private:
  Diagnostics& diagnostics_;
  std::atomic<bool> told_{false};
  mutable std::mutex mutex_;
  std::map<uint64_t, double> areas_;
  std::set<std::string, std::less<>> toldSpaces_;
};

}  // namespace shade
}  // namespace kinora
